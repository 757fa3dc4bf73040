"""PLY, OFF and OBJ through `seamwright unwrap` to their own format, read by trimesh before and after.

    python3 tests/bench/text_roundtrip.py SEAMWRIGHT MESH...

Everything but the UVs must be bit-equal. Of a PLY: the header without the list `texcoord`, and every property of every
element as trimesh parses it. Of an OBJ: positions, colours, normals, polygons by their positions, materials and groups, as
trimesh and a few lines of our own here read them. OFF is written with --without-uvs and compared by its arrays. Needs trimesh
and numpy. Prints a line a file and a sum; exit code 1 where one differs.
"""

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy
import trimesh
from trimesh.exchange import ply


def ply_elements(path):
    """Elements and their data by trimesh's own parser."""
    with open(path, "rb") as file:
        elements, is_ascii, _ = ply._parse_header(file)
        (ply._ply_ascii if is_ascii else ply._ply_binary)(elements, file)
    return elements


def listed(data):
    """A property's values as bytes, whatever trimesh made of them."""
    parts = lambda row: row if isinstance(row, (numpy.void, tuple)) else [row]
    return b"".join(numpy.asarray(part).tobytes() for row in data for part in parts(row))


def by_property(element):
    data = element.get("data")
    if data is None:
        return {}
    if isinstance(data, dict):
        return {name: listed(values) for name, values in data.items()}
    if getattr(data, "dtype", None) is not None and data.dtype.names:
        return {name: listed(data[name]) for name in data.dtype.names}
    return {"": listed(data)}


UVS = {"texcoord", "s", "t", "u", "v", "texture_u", "texture_v"}


def ply_differs(before, after):
    head = lambda path: [
        line
        for line in path.read_bytes().split(b"end_header")[0].splitlines()
        if not (line.startswith(b"property") and line.split()[-1].decode() in UVS)
    ]
    if head(before) != head(after):
        return "header"
    a, b = ply_elements(before), ply_elements(after)
    for name, element in a.items():
        old, new = by_property(element), by_property(b[name])
        for key in old:
            if key.split("_count")[0] in UVS or name == "tristrips":
                continue
            if old[key] != new.get(key):
                return f"{key} of {name}"
    if a.get("face", {}).get("length", 0) < 2:
        return ""  # trimesh reads no text of one face with two lists
    meshes = [trimesh.load(path, process=False, maintain_order=True) for path in (before, after)]
    if hasattr(meshes[0], "faces") and "face" in a and not numpy.array_equal(
        meshes[0].vertices[meshes[0].faces], meshes[1].vertices[meshes[1].faces]
    ):
        return "trimesh's triangles"
    return ""


def obj_wedges(path):
    """Every statement of an OBJ but `vt`, its indices counted from 1 and without those of UVs."""
    out, count = [], {"v": 0, "vn": 0}
    normals = sum(line.split()[:1] == [b"vn"] for line in path.read_bytes().splitlines())
    lines = path.read_bytes().replace(b"\\\r\n", b" ").replace(b"\\\n", b" ").splitlines()
    for words in (line.split(b"#")[0].split() for line in lines):
        if not words or words[0] == b"vt":
            continue
        key = words[0].decode("latin1")
        if key in count:
            count[key] += 1
        if key in ("f", "fo", "l"):
            corners = []
            for word in words[1:]:
                fields = (word.split(b"/") + [b"", b""])[:3]
                whole = lambda text, n: (int(text) if int(text) > 0 else n + int(text) + 1) if text else 0
                normal = whole(fields[2], count["vn"])
                normal = normal if normal <= normals else 0  # what is not there is left out, with a warning
                corners.append((whole(fields[0], count["v"]), normal))
            out.append((key, tuple(corners)))
        else:
            out.append((key, tuple(words[1:])))
    return out


def obj_triangles(path):
    """The triangles of each of the pieces that trimesh makes of a file."""
    loaded = trimesh.load(path, process=False, maintain_order=True, skip_materials=True)
    pieces = loaded.geometry.values() if hasattr(loaded, "geometry") else [loaded]
    return [piece.vertices[piece.faces] for piece in pieces]


def obj_differs(before, after):
    if obj_wedges(before) != obj_wedges(after):
        return "statements"
    a, b = (obj_triangles(path) for path in (before, after))
    same = len(a) == len(b) and all(numpy.array_equal(x, y) for x, y in zip(a, b))
    return "" if same else "trimesh's triangles"


def off_differs(before, after):
    a, b = (trimesh.load(path, process=False) for path in (before, after))
    same = numpy.array_equal(a.vertices, b.vertices) and numpy.array_equal(a.faces, b.faces)
    return "" if same else "arrays"


JUDGES = {".ply": ply_differs, ".obj": obj_differs, ".off": off_differs}


def main():
    program, files = sys.argv[1], [Path(name) for name in sys.argv[2:]]
    total = {"files": len(files), "same": 0, "refused": 0, "unjudged": 0, "differing": 0}
    with tempfile.TemporaryDirectory() as folder:
        for file in files:
            out = Path(folder) / ("out" + file.suffix.lower())
            flags = ["--without-uvs"] if file.suffix.lower() == ".off" else []
            command = [program, "unwrap", str(file), "-o", str(out), "-q", "--rays", "16", *flags]
            run = subprocess.run(command, capture_output=True, text=True)
            if not out.exists():
                total["refused"] += 1
                print(f"{file}: refused ({run.returncode}): {run.stderr.strip().splitlines()[-1:]}")
                continue
            judge = JUDGES[file.suffix.lower()]
            try:
                judge(file, file)
            except Exception as e:
                total["unjudged"] += 1
                print(f"{file}: written, but trimesh cannot read the input: {type(e).__name__} {e}")
                out.unlink()
                continue
            problem = judge(file, out)
            total["differing" if problem else "same"] += 1
            print(f"{file}: {'DIFFERS: ' + problem if problem else 'same'}")
            out.unlink()
    print(json.dumps(total))
    sys.exit(1 if total["differing"] else 0)


main()
