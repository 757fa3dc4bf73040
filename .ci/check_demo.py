"""Checks what `seamwright demo -o DIR` wrote: OBJ with a valid atlas, picture, report. Standard library only.

Every face corner has a UV in the unit square, no face with area in space is flipped or flat in UV, and pictures and
reports are whole files. Overlaps are decided by the program's own tests. Usage: check_demo.py DIR
"""

import json
import pathlib
import sys


def fail(message):
    sys.exit(f"check_demo: {message}")


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def check_obj(path):
    """Returns the number of faces of an OBJ whose every face is mapped and turned the right way."""
    positions, uvs, faces = [], [], []
    for number, line in enumerate(path.read_text().splitlines(), 1):
        words = line.split()
        if words[:1] == ["v"]:
            positions.append([float(x) for x in words[1:4]])
        elif words[:1] == ["vt"]:
            uvs.append([float(x) for x in words[1:3]])
        elif words[:1] == ["f"]:
            corners = [word.split("/") for word in words[1:]]
            if any(len(corner) < 2 or not corner[1] for corner in corners):
                fail(f"{path}:{number}: a corner without UV")
            faces.append([(int(corner[0]) - 1, int(corner[1]) - 1) for corner in corners])
    if not faces:
        fail(f"{path}: no faces")
    if not all(0.0 <= x <= 1.0 for uv in uvs for x in uv):
        fail(f"{path}: a UV outside the unit square")
    for face in faces:
        pairs = list(zip(face, face[1:] + face[:1]))
        area = sum(uvs[p[1]][0] * uvs[q[1]][1] - uvs[q[1]][0] * uvs[p[1]][1] for p, q in pairs)
        normal = [sum(x) for x in zip(*(cross(positions[p[0]], positions[q[0]]) for p, q in pairs))]
        if area <= 0.0 and any(abs(x) > 1e-12 for x in normal):
            fail(f"{path}: face {face} is flipped or flat in UV")
    return len(faces)


def main():
    folder = pathlib.Path(sys.argv[1])
    files = {ending: sorted(folder.rglob(f"*.{ending}")) for ending in ("obj", "png", "json")}
    for ending, found in files.items():
        if not found:
            fail(f"no .{ending} file in {folder}")
    mapped = [path for path in files["obj"] if "\nvt " in path.read_text()]
    if not mapped:
        fail(f"no OBJ in {folder} has UVs")
    for path in mapped:
        print(f"{path.name}: {check_obj(path)} faces, all mapped, none flipped")
    for path in files["png"]:
        data = path.read_bytes()
        if not (data.startswith(b"\x89PNG\r\n\x1a\n") and b"IEND" in data[-12:]):
            fail(f"{path}: not a whole PNG")
        print(f"{path.name}: {len(data)} bytes")
    for path in files["json"]:
        json.loads(path.read_text())
        print(f"{path.name}: a report that parses")


main()
