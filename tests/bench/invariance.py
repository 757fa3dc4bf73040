#!/usr/bin/env python3
"""How much the figures of an atlas change where its mesh is moved, turned or scaled: the table of docs/RESULTS.md.

    cargo build --release
    python3 tests/bench/invariance.py [--rotations 3] [--packing tight] MESH.obj...

Each mesh is unwrapped as it is, scaled by 1/8 and by 1000, moved by 10,000 and turned at random (seeded, the same turns for
all meshes), written with 17 and with 9 significant digits; the atlases are measured by `seamwright measure`. A change is
relative to the figure of the mesh as it is. Scaling by 1/8 has to give the same UVs to the bit: exit code 1 where it does not.
Needs nothing but Python.
"""
import argparse, json, math, os, random, subprocess, sys, tempfile

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
OURS = os.path.join(os.environ.get("CARGO_TARGET_DIR", os.path.join(ROOT, "target")), "release", "seamwright")
FIGURES = {
    "charts": lambda r: r["charts"],
    "conf": lambda r: 1 - r["angle_err_rad"],
    "equi": lambda r: 1 - r["area_ln"],
    "sd": lambda r: r["symmetric_dirichlet"],
    "fill": lambda r: r["utilisation"],
    "SL": lambda r: r["seam_len_norm"],
    "VSL": lambda r: r["visible_seam_len_norm"],
    "noticed": lambda r: r["noticed_seam_len_norm"],
    "ratio": lambda r: r["seam_ao_ratio"],
}


def rotation(seed):
    """A random rotation matrix from a random unit quaternion."""
    draw = random.Random(seed)
    q = [draw.gauss(0, 1) for _ in range(4)]
    n = math.sqrt(sum(c * c for c in q))
    w, x, y, z = (c / n for c in q)
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]


def placed(path, to, digits, place):
    """The mesh with other positions and without normals and UVs, which would have to change too."""
    with open(path, errors="ignore") as source, open(to, "w") as out:
        for line in source:
            if line.startswith("v "):
                out.write("v " + " ".join(f"{c:.{digits}g}" for c in place([float(c) for c in line.split()[1:4]])) + "\n")
            elif line.startswith("f "):
                out.write("f " + " ".join(word.split("/")[0] for word in line.split()[1:]) + "\n")


def unwrapped(path, args):
    out = path[:-4] + "_atlas.obj"
    command = [args.command, "unwrap", path, "-o", out, "--packing", args.packing, "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 5):
        sys.exit(f"{' '.join(command)}: exit {done.returncode}\n{done.stderr}")
    record = json.loads(subprocess.run([args.command, "measure", out, "--json"], capture_output=True, text=True, check=True).stdout)
    with open(out) as file:
        uv = [line for line in file if line.startswith(("vt ", "f "))]
    return {name: figure(record) for name, figure in FIGURES.items()}, uv


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs="+")
    parser.add_argument("--command", default=OURS)
    parser.add_argument("--rotations", type=int, default=3)
    parser.add_argument("--packing", default="tight")
    args = parser.parse_args()
    turned = lambda m: lambda p: [sum(a * b for a, b in zip(row, p)) for row in m]
    ways = [("x 1/8", 17, lambda p: [c * 0.125 for c in p]), ("x 1000", 17, lambda p: [c * 1000 for c in p]),
            ("moved", 17, lambda p: [c + 1e4 for c in p])]
    for digits in (17, 9):
        ways += [(f"turned, {digits} digits", digits, turned(rotation(k))) for k in range(args.rotations)]
    print("| mesh | way | " + " | ".join(FIGURES) + " |\n|" + "---|" * (len(FIGURES) + 2))
    worst, exact = {}, True
    with tempfile.TemporaryDirectory() as folder:
        for path in args.meshes:
            name = os.path.splitext(os.path.basename(path))[0]
            file = os.path.join(folder, name + ".obj")
            placed(path, file, 17, lambda p: p)
            at_home, uv = unwrapped(file, args)
            of_mesh = {}
            for way, digits, place in ways:
                placed(path, file, digits, place)
                there, other = unwrapped(file, args)
                exact &= way != "x 1/8" or uv == other
                change = {k: abs(there[k] / at_home[k] - 1) if at_home[k] else abs(there[k] or 0) for k in FIGURES}
                for table in (of_mesh.setdefault(way, {}), worst.setdefault(way, {})):
                    for k, c in change.items():
                        table[k] = max(table.get(k, 0), c)
            for way, change in of_mesh.items():
                print(f"| {name} | {way} | " + " | ".join(f"{100 * c:.2g} %" for c in change.values()) + " |", flush=True)
    for way, change in worst.items():
        print(f"| **largest** | {way} | " + " | ".join(f"{100 * c:.2g} %" for c in change.values()) + " |")
    if not exact:
        sys.exit("scaling by a power of two changed a UV")


if __name__ == "__main__":
    main()
