#!/usr/bin/env python3
"""The tables of the paper that the project starts from, ours beside theirs: visibility, semantics, ablations, packing, time.

    cargo build --release
    python3 tests/bench/published.py [--labels FOLDER] [--metric FILE.py] [--threads N] MESH.obj...

Runs exact and neural, each without parts, with `--parts auto` and with `--parts published` (three clusters of shape diameter), and exact with
`--packing grid`. Figures are those of `seamwright measure`: visibility is the mean exposure of vertices on seams (published: of vertices whose soft score is
above a half), conformality and equiareality are over all faces as published. --metric is a Python file with `load(path)` and
`judge(v, f, corner_uv, vertex_uv, mode)`, the published definitions; its columns are printed where it is given. --labels is a folder of
segmentations by people, NUMBER_K.seg for meshes NUMBER_name.obj (one number a face): charts are held against them by the Rand index and the Hamming
distance (Chen, Golovinskiy, Funkhouser 2009); meshes without are left out of that table. Times are wall time of the stages, one run each.
"""
import argparse, importlib.util, json, os, subprocess, sys, tempfile
from collections import Counter, defaultdict
from rand_error import error, people

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
OURS = os.environ.get("SEAMWRIGHT") or os.path.join(ROOT, "target", "release", "seamwright")
RUNS = {
    "exact": [], "exact, parts": ["--parts", "auto"], "exact, published parts": ["--parts", "published"],
    "neural": ["--method", "neural"], "neural, parts": ["--method", "neural", "--parts", "auto"],
    "neural, published parts": ["--method", "neural", "--parts", "published"],
}
# Means over their meshes, of which few are public: rows of the paper's tables.
PAPER_VISIBILITY = [("OptCuts", ".7855", ".9341", ".8934", "240"), ("FlexPara, one chart", ".8604", ".9097", ".6759", "2"),
                    ("paper, visibility", ".6065", ".9175", ".6093", "2"), ("paper, parts and visibility", ".6534", ".9153", ".6369", "15")]
PAPER_SEMANTIC = [("xatlas", ".8896", ".7023", ".9792", ".9341"), ("Blender", ".8634", ".7173", ".9289", ".9023"),
                  ("paper, parts", ".3188", ".8151", ".9123", ".6707"), ("paper, parts and visibility", ".3212", ".8087", ".9153", ".6369")]
PAPER_ABLATION = [("paper, neither", ".9097", ".6759"), ("paper, parts", ".9123", ".6707"), ("paper, visibility", ".9175", ".6093"),
                  ("paper, both", ".9153", ".6369"), ("paper, parts by SAMesh", ".8694", ".6270"), ("paper, parts by PartField", ".8999", ".6921")]
PAPER_PACKING = [("Maya on the paper's cow", ".71"), ("Blender on it", ".57"), ("Houdini on it", ".62")]
PAPER_TIME = [("paper, parts (training)", "648"), ("paper, visibility (training)", "31160")]


def measured(path):
    done = subprocess.run([OURS, "measure", path, "--json"], capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def unwrapped(mesh, flags, folder):
    out, report = os.path.join(folder, "out.obj"), os.path.join(folder, "out.json")
    done = subprocess.run([OURS, "unwrap", mesh, "-o", out, "--json", report, "-q", *flags], capture_output=True, text=True)
    if done.returncode not in (0, 5):  # 5: the atlas is there, and the tables show what it lacks
        sys.exit(f"{mesh}: {' '.join(flags)}: exit {done.returncode}\n{done.stderr}")
    return out, json.load(open(report))


def charts_of(path):
    """Chart of each face: what shares an edge with the same UVs on both sides."""
    uvs, faces = [], []
    for line in open(path):
        word = line.split()
        if word and word[0] == "vt":
            uvs.append((word[1], word[2]))
        elif word and word[0] == "f":
            faces.append([(int(v), uvs[int(t) - 1]) for v, t in (corner.split("/")[:2] for corner in word[1:])])
    parent = list(range(len(faces)))

    def find(x):
        while parent[x] != x:
            parent[x] = parent[parent[x]]
            x = parent[x]
        return x

    sides = {}
    for f, face in enumerate(faces):
        for a, b in zip(face, face[1:] + face[:1]):
            parent[find(sides.setdefault((min(a, b), max(a, b)), f))] = find(f)
    return [find(f) for f in range(len(faces))]


def agreement(a, b):
    """Rand index, and the Hamming distance: the mean share of faces outside the largest overlap, both ways."""
    largest = [defaultdict(int), defaultdict(int)]
    for (x, y), count in Counter(zip(a, b)).items():
        largest[0][x], largest[1][y] = max(largest[0][x], count), max(largest[1][y], count)
    return 1 - error(a, b), sum(1 - sum(side.values()) / len(a) for side in largest) / 2


def published(path, metric):
    import numpy as np
    v, t, fv, ft = metric.load(path)
    uv, count = np.zeros((len(v), 2)), np.zeros(len(v))
    np.add.at(uv, fv.ravel(), t[ft].reshape(-1, 2))
    np.add.at(count, fv.ravel(), 1)
    row = metric.judge(v, fv, t[ft], uv / np.maximum(count, 1)[:, None], "c")
    return [float(row[key]) for key in ("ao_s", "conf", "equi")]


def mean(rows, key):
    values = [row[key] for row in rows if row.get(key) is not None]
    return sum(values) / len(values) if values else float("nan")


def table(title, head, rows):
    print(f"\n{title}\n\n| {' | '.join(head)} |\n|{'---|' * len(head)}")
    for row in rows:
        print("| " + " | ".join(cell if isinstance(cell, str) else f"{cell:.4g}" for cell in row) + " |")
    sys.stdout.flush()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs="+")
    parser.add_argument("--labels")
    parser.add_argument("--metric")
    parser.add_argument("--threads", default="2")
    args = parser.parse_args()
    metric = None
    if args.metric:
        spec = importlib.util.spec_from_file_location("metric", args.metric)
        metric = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(metric)
    found, stages, grid = defaultdict(list), defaultdict(list), []
    with tempfile.TemporaryDirectory() as folder:
        for mesh in args.meshes:
            given = people(os.path.basename(mesh), args.labels) if args.labels else []
            for name, flags in RUNS.items():
                out, report = unwrapped(mesh, [*flags, "--threads", args.threads], folder)
                m = measured(out)
                row = {key: m[key] for key in ("charts", "conformality", "equiareality", "seam_ao_mean", "utilisation", "texel_density_variation")}
                row["bad"], row["seconds"] = m["exact_flipped_faces"] + m["overlapping_faces"], report["seconds"]
                if metric:
                    row["p_visibility"], row["p_conf"], row["p_equi"] = published(out, metric)
                if given:
                    labels = charts_of(out)
                    pairs = [agreement(labels, own) for own in given if len(own) == len(labels)]
                    row["rand"], row["hamming"] = (sum(p[k] for p in pairs) / len(pairs) for k in (0, 1)) if pairs else (None, None)
                found[name].append(row)
                stages[name].append({stage["stage"]: stage["seconds"] for stage in report["stages"]})
            grid.append(measured(unwrapped(mesh, ["--packing", "grid", "--threads", args.threads], folder)[0]))
    extra = ["visibility, published", "conf, published", "equi, published"] if metric else []
    own = lambda name: [mean(found[name], key) for key in ("p_visibility", "p_conf", "p_equi")] if metric else []
    blank = [""] * len(extra)
    print(f"{len(args.meshes)} meshes: {' '.join(os.path.splitext(os.path.basename(mesh))[0] for mesh in args.meshes)}")
    table("Visibility (less is better)", ["method", "visibility", "conf", "equi", "s", "faces flipped or overlapping", *extra],
          [[name, *(mean(found[name], key) for key in ("seam_ao_mean", "conformality", "equiareality", "seconds", "bad")), *own(name)] for name in RUNS]
          + [[name, *cells, "", *blank] for name, *cells in PAPER_VISIBILITY])
    if any(row.get("rand") is not None for rows in found.values() for row in rows):
        table("Semantics: charts against people's parts", ["method", "charts", "Hamming", "Rand index", "conf", "equi"],
              [[name, *(mean([r for r in found[name] if r.get("rand") is not None], key) for key in ("charts", "hamming", "rand", "conformality", "equiareality"))]
               for name in RUNS] + [[name, "", *cells] for name, *cells in PAPER_SEMANTIC])
    table("Ablations: parts and who finds them", ["method", "charts", "conf", "equi"],
          [[name, *(mean(found[name], key) for key in ("charts", "conformality", "equiareality"))] for name in RUNS]
          + [[name, "", *cells] for name, *cells in PAPER_ABLATION])
    table("Packing", ["method", "share of the square", "variation of texel density"],
          [["exact, tight", *(mean(found["exact"], key) for key in ("utilisation", "texel_density_variation"))],
           ["exact, grid", *(mean(grid, key) for key in ("utilisation", "texel_density_variation"))]] + [[name, cell, ""] for name, cell in PAPER_PACKING])
    names = ["repair", "parts", "exposure", "seams", "learn", "pack", "check"]
    table("Time, seconds a stage", ["method", *names, "all"],
          [[name, *(sum(run.get(stage, 0.0) for run in stages[name]) / len(stages[name]) for stage in names), mean(found[name], "seconds")] for name in RUNS]
          + [[name, *[""] * len(names), cell] for name, cell in PAPER_TIME])


main()
