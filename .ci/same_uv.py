"""Whether the UVs of an OBJ are those of a list, to the bit: same_uv.py MESH.obj LIST. The list has a line `u v` for each
corner of the OBJ's faces, in their order. Exit code 0 where they are, else 1 and the first corner that differs."""
import struct
import sys


def corners_of(path):
    lines, corners = [], []
    with open(path) as file:
        for words in (line.split() for line in file):
            if words[:1] == ["vt"]:
                lines.append((float(words[1]), float(words[2])))
            elif words[:1] == ["f"]:
                corners += [lines[int(corner.split("/")[1]) - 1] for corner in words[1:]]
    return corners


def main(mesh, listed):
    ours = corners_of(mesh)
    with open(listed) as file:
        theirs = [tuple(map(float, line.split())) for line in file]
    if len(ours) != len(theirs) or not ours:
        sys.exit(f"{listed}: {len(theirs)} corners, {mesh} has {len(ours)}")
    for c, (a, b) in enumerate(zip(ours, theirs)):
        if struct.pack("<2d", *a) != struct.pack("<2d", *b):
            sys.exit(f"{listed}: corner {c} is {b}, in {mesh} {a}")
    print(f"{len(ours)} corners, the same UVs")


main(*sys.argv[1:])
