#!/usr/bin/env python3
"""Seams of folders of meshes over several seeds, beside peers and artists: the tables of docs/RESULTS.md.

    cargo build --release --workspace
    python3 tests/bench/seams.py FOLDER... [--seeds 0,1,2] [--each] [--uvunwrap PATH] [--peers FILE.json] [--judge eval_uv.py]
        [-- OPTIONS OF unwrap]

A row a folder: means over its meshes and seeds. Every atlas is measured by `seamwright measure`, or by the Python file given as
--judge (a module with `evaluate(path)`). An atlas with a flip, an overlap, a face without UVs or an exit code other than 0 counts
as bad. --uvunwrap is the `unwrap` example of the crate uvunwrap 0.3; with it each mesh is also unwrapped by uvunwrap and, where
its Python package is installed, by xatlas, and the geometric mean of noticed seam length over the better of the two is given, with the
meshes where it is above 1; --peers keeps what they reached. Where a folder holds `artists.tsv` (columns mesh, noticed), the
ratio of the means and the meshes below the artist's are given. --each prints every mesh. Figures of time are left to compare.py.
"""
import argparse, csv, glob, importlib.util, json, math, os, subprocess, sys, tempfile
from concurrent.futures import ThreadPoolExecutor

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
args = None
OURS = os.path.join(os.environ.get("CARGO_TARGET_DIR", os.path.join(ROOT, "target")), "release", "seamwright")
FIGURES = [("noticed", "noticed_seam_len_norm"), ("visible", "visible_seam_len_norm"), ("SL", "seam_len_norm"), ("charts", "charts"),
           ("fill", "utilisation"), ("sd/4", "symmetric_dirichlet"), ("flat", "seam_flat_share"), ("sharp", "seam_sharp_share")]


def measured(path, judge):
    """Figures of a mapped OBJ."""
    if judge:
        record = judge.evaluate(path)
    else:
        out = subprocess.run([args.binary, "measure", path, "--json"], capture_output=True, text=True, check=True).stdout
        record = json.loads(out)
        record = record[0] if isinstance(record, list) else record
    figures = {name: record[key] or 0.0 for name, key in FIGURES}
    figures["sd/4"] /= 4
    figures["bad"] = bool(record["flipped_faces"] or record["overlap_frac"] > 1e-9 or record["faces_without_vt"])
    return figures


def name_of(path):
    return os.path.splitext(os.path.basename(path))[0]


def unwrapped(job):
    """Ours of one mesh at one seed."""
    path, seed = job
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, name_of(path) + ".obj")
        command = [args.binary, "unwrap", path, "-o", out, "-q", "--threads", "1", "--seed", seed] + args.options
        done = subprocess.run(command, capture_output=True, text=True)
        if not os.path.exists(out):
            return path, seed, None
        figures = measured(out, args.judge)
        figures["bad"] |= done.returncode != 0
        return path, seed, figures


def bare(path):
    """Positions and triangles of an OBJ."""
    positions, triangles = [], []
    for line in open(path, errors="ignore"):
        words = line.split()
        if words[:1] == ["v"]:
            positions.append([float(w) for w in words[1:4]])
        elif words[:1] == ["f"]:
            corners = [int(w.split("/")[0]) for w in words[1:]]
            corners = [c - 1 if c > 0 else c + len(positions) for c in corners]
            triangles += [[corners[0], a, b] for a, b in zip(corners[1:], corners[2:])]
    return positions, triangles


def write(path, positions, triangles, uv=None, uv_of=None):
    with open(path, "w") as out:
        out.writelines("v {!r} {!r} {!r}\n".format(*p) for p in positions)
        out.writelines("vt {!r} {!r}\n".format(*p) for p in uv or [])
        for t, f in enumerate(triangles):
            out.write("f " + " ".join(str(v + 1) if uv is None else f"{v + 1}/{uv_of[t][k] + 1}" for k, v in enumerate(f)) + "\n")


def peers_of(path):
    """Noticed seam length by peer; one that fails is left out."""
    positions, triangles = bare(path)
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        plain, prefix = os.path.join(folder, "plain.obj"), os.path.join(folder, "peer")
        write(plain, positions, triangles)
        done = subprocess.run([args.uvunwrap, "--page-size", "1024", "--padding", "2", plain, prefix], capture_output=True)
        if done.returncode == 0:
            found["uvunwrap"] = measured(prefix + ".obj", args.judge)
        if importlib.util.find_spec("xatlas"):
            import numpy, xatlas
            try:
                vertex, uv_of, uv = xatlas.parametrize(numpy.array(positions), numpy.array(triangles))
            except RuntimeError:
                return path, found
            corners = [[int(vertex[i]) for i in t] for t in uv_of]
            write(plain, positions, corners, [[float(x) for x in p] for p in uv], uv_of)
            found["xatlas"] = measured(plain, args.judge)
    return path, found


def beside_peers(paths, noticed):
    """Geometric mean over the better peer, and how many are above it."""
    kept = json.load(open(args.peers)) if args.peers and os.path.exists(args.peers) else {}
    with ThreadPoolExecutor(args.jobs) as pool:
        for path, found in pool.map(peers_of, [p for p in paths if name_of(p) not in kept]):
            kept[name_of(path)] = found
    if args.peers:
        json.dump(kept, open(args.peers, "w"), indent=1)
    ratio = {}
    for path in paths:
        best = min((f["noticed"] for f in kept[name_of(path)].values() if not f["bad"]), default=0)
        if best > 0:
            ratio[name_of(path)] = noticed[path] / best
    mean = math.exp(sum(math.log(max(r, 1e-3)) for r in ratio.values()) / len(ratio))
    above = sorted(f"{n} {r:.2f}" for n, r in ratio.items() if r > 1)
    return f"over the better peer {mean:.3f} on {len(ratio)}, above it on {len(above)}" + (": " + ", ".join(above) if above else "")


def beside_artists(folder, paths, noticed):
    """Ratio of the means, and how many are below."""
    artist = {r["mesh"]: float(r["noticed"]) for r in csv.DictReader(open(os.path.join(folder, "artists.tsv")), delimiter="\t")}
    theirs = [artist[name_of(p)] for p in paths]
    below = sum(noticed[p] < t for p, t in zip(paths, theirs))
    return f"over the artists' {sum(noticed[p] for p in paths) / sum(theirs):.3f}, below them on {below} of {len(paths)}"


def table(folder):
    paths = sorted(p for p in glob.glob(os.path.join(folder, "*")) if p.endswith((".obj", ".off", ".ply")) and name_of(p) not in args.skip)
    jobs = [(p, s) for p in paths for s in args.seeds]
    with ThreadPoolExecutor(args.jobs) as pool:
        rows = list(pool.map(unwrapped, jobs))
    good = [r for r in rows if r[2]]
    bad = [f"{name_of(p)} (seed {s})" for p, s, f in rows if not f or f["bad"]]
    mean = lambda key, of: sum(f[key] for _, _, f in of) / max(1, len(of))
    cells = lambda of: " | ".join(f"{mean(n, of):.{4 if n == 'sd/4' else 1 if n == 'charts' else 3}f}" for n, _ in FIGURES)
    if args.each:
        for path in paths:
            print(f"| {name_of(path)} | {cells([r for r in good if r[0] == path])} |")
    print(f"| **{os.path.basename(os.path.normpath(folder))}**, {len(paths)} meshes | {cells(good)} |")
    noticed = {p: mean("noticed", [r for r in good if r[0] == p]) for p in paths}
    notes = [f"bad: {', '.join(bad) or 'none'}"]
    if args.uvunwrap:
        notes.append(beside_peers(paths, noticed))
    if os.path.exists(os.path.join(folder, "artists.tsv")):
        notes.append(beside_artists(folder, paths, noticed))
    return notes


def main():
    global args
    words = sys.argv[1:]
    at = words.index("--") if "--" in words else len(words)
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="+")
    parser.add_argument("--seeds", default="0,1,2", type=lambda s: s.split(","))
    parser.add_argument("--each", action="store_true")
    parser.add_argument("--uvunwrap")
    parser.add_argument("--peers")
    parser.add_argument("--judge")
    parser.add_argument("--binary", default=OURS)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--skip", default="", type=lambda s: s.split(","))
    args = parser.parse_args(words[:at])
    args.options = words[at + 1:]
    if args.judge:
        spec = importlib.util.spec_from_file_location("judge", args.judge)
        args.judge = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(args.judge)
    print("| meshes | " + " | ".join(n for n, _ in FIGURES) + " |\n|" + "---|" * (len(FIGURES) + 1))
    notes = [(folder, table(folder)) for folder in args.folders]
    for folder, words in notes:
        print(f"\n{os.path.basename(os.path.normpath(folder))}: " + "; ".join(words))


main()
