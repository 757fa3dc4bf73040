#!/usr/bin/env python3
"""Compares our figures with an independent evaluator, key by key.

    python tests/judge_agreement.py --judge EVAL_UV.py --command SEAMWRIGHT [--xatlas | --unwrap] MESH.obj ...
    python tests/judge_agreement.py --judge EVAL_UV.py --runner MEASURE_PLAIN [--xatlas] MESH.obj ...
    python tests/judge_agreement.py --judge EVAL_UV.py --record fixtures/judge

The evaluator is a Python module with load_obj, weld_positions, ambient and evaluate. With --command the whole command is
compared, `seamwright measure --json`, each side with 512 uniform rays a vertex of its own. With --runner, the binary
`measure_plain` of this package, exposure is the evaluator's, given to both, so that the figures over it are compared
exactly (--no-ao: a formula of the position instead of rays; no exposure at all with --command).

With --xatlas every mesh is first unwrapped by xatlas (pip install xatlas) and written as an OBJ that refers to the original
vertices; with --unwrap by `seamwright unwrap`. --record writes small hostile OBJ files and the evaluator's figures of them;
tests/judge_agreement.rs reads them.

Counts must be equal, reals agree to 1e-6 relative (1e-9 absolute near zero), exposure from different rays to 1 %. Exit
code 1 where anything does not.
"""
import argparse, importlib.util, json, math, os, subprocess, sys, tempfile, time

import numpy as np

RELATIVE, ABSOLUTE = 1e-6, 1e-9
# One set of 512 directions against another, averaged over the vertices of seams: 0.3 % at most on eight atlases of four
# meshes; a seam of a few dozen vertices may differ by more.
SAMPLED = 1e-2
RAYS = 512
NOT_FIGURES = {"obj", "eval_seconds", "ao_samples", "error"}


def load_judge(path):
    spec = importlib.util.spec_from_file_location("eval_uv", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def formula_exposure(v):
    """Some smooth exposure in (0, 1] that both sides can compute; f32 as the runner reads it."""
    return (1 / (1 + v[:, 0] ** 2 + 2 * v[:, 1] ** 2 + 3 * v[:, 2] ** 2)).astype(np.float32)


def judge_figures(judge, path, resolution, rays):
    """The evaluator's figures, and the exposure (of each vertex of the file) that they are based on; 0 rays: a formula."""
    raw, _, faces, _ = judge.load_obj(path)
    welded, welded_faces = judge.weld_positions(raw, faces)
    _, inverse = np.unique(raw, axis=0, return_inverse=True)
    if rays:
        exposure = judge.ambient(welded, welded_faces, rays).astype(np.float32)
    else:
        exposure = formula_exposure(welded)
    cache = dict(V=welded, A=exposure.astype(float))
    with np.errstate(all="ignore"):
        figures = judge.evaluate(path, resolution, ao_cache=cache)
    return figures, exposure[inverse.reshape(-1)]


def run_command(command, path, resolution, rays):
    exposure = ["--exposure", "uniform", "--rays", str(rays)] if rays else ["--exposure", "none"]
    start = time.time()
    call = [command, "measure", path, "--json", "--resolution", str(resolution), *exposure]
    done = subprocess.run(call, check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(done.stdout), f"{time.time() - start:.3f} s"


def run_plain(runner, path, resolution, exposure):
    with tempfile.NamedTemporaryFile(suffix=".f32") as file:
        file.write(exposure.astype("<f4").tobytes())
        file.flush()
        done = subprocess.run([runner, path, str(resolution), file.name], check=True, capture_output=True, text=True)
    return json.loads(done.stdout), done.stderr.strip()


def difference(theirs, ours):
    """Relative difference of two figures; infinity where they are of different kinds or counts differ."""
    if isinstance(theirs, list):
        if not isinstance(ours, list) or len(theirs) != len(ours):
            return math.inf
        return max(difference(a, b) for a, b in zip(theirs, ours))
    if theirs is None or not math.isfinite(theirs):
        return 0.0 if ours is None else math.inf
    if ours is None or isinstance(theirs, int) and theirs != ours:
        return math.inf
    gap = abs(theirs - ours)
    return gap / max(abs(theirs), ABSOLUTE / RELATIVE)


def unwrap_with_xatlas(judge, path, out):
    import xatlas
    positions, _, faces, _ = judge.load_obj(path)
    mapping, indices, uvs = xatlas.parametrize(positions.astype(np.float32), faces.astype(np.uint32))
    with open(out, "w") as file:
        file.writelines("v %.17g %.17g %.17g\n" % tuple(p) for p in positions)
        file.writelines("vt %.9g %.9g\n" % tuple(uv) for uv in uvs)
        for triangle in indices:
            file.write("f " + " ".join("%d/%d" % (mapping[c] + 1, c + 1) for c in triangle) + "\n")


def of_exposure(key):
    return "_ao_" in key or key.startswith(("visible", "noticed"))


def compare(judge, args, path, worst):
    """Prints one line; returns whether all figures agree. `worst` keeps the largest difference of each key."""
    if args.command:
        theirs, _ = judge_figures(judge, path, args.resolution, 0 if args.no_ao else RAYS)
        ours, seconds = run_command(args.command, path, args.resolution, 0 if args.no_ao else RAYS)
        if args.no_ao:
            theirs = {key: value for key, value in theirs.items() if not of_exposure(key)}
    else:
        # The runner is given the evaluator's exposure, so few rays compare as well as many.
        theirs, exposure = judge_figures(judge, path, args.resolution, 0 if args.no_ao else 64)
        ours, seconds = run_plain(args.runner, path, args.resolution, exposure)
    gaps = {}
    for key, value in theirs.items():
        if key not in NOT_FIGURES:
            gaps[key] = difference(value, ours.get(key))
            worst[key] = max(worst.get(key, 0.0), gaps[key])
    allowed = lambda key: SAMPLED if args.command and of_exposure(key) else RELATIVE
    key = max(gaps, key=lambda k: gaps[k] / allowed(k))
    bad = {k: (theirs[k], ours.get(k)) for k, g in gaps.items() if not g <= allowed(k)}
    print(f"{os.path.basename(path):32} {theirs['faces']:8} faces  {len(gaps)} figures  largest difference "
          f"{gaps[key]:.1e} ({key})  judge {theirs.get('eval_seconds', 0):.2f} s  ours {seconds}"
          f"  exact overlapping {ours['overlapping_faces']} flipped {ours['exact_flipped_faces']}")
    for k, (a, b) in bad.items():
        print(f"    {k}: judge {a}, ours {b}")
    return not bad


def write_obj(path, positions, uvs, faces):
    """`faces` are lists of (vertex, uv or None), from 0."""
    with open(path, "w") as file:
        file.writelines("v %.17g %.17g %.17g\n" % tuple(p) for p in positions)
        file.writelines("vt %.17g %.17g\n" % tuple(t) for t in uvs)
        for face in faces:
            file.write("f " + " ".join(f"{v + 1}" if t is None else f"{v + 1}/{t + 1}" for v, t in face) + "\n")


def hostile_maps():
    """(name, positions, uvs, faces): small maps that have all the faults there are."""
    rng = np.random.default_rng(1)
    n = 9
    grid = np.array([(i, j) for j in range(n) for i in range(n)], float)
    hill = np.c_[grid, 2 * np.exp(-((grid - 4) ** 2).sum(1) / 6)] + rng.normal(0, 0.02, (n * n, 3))
    quads = [[j * n + i, j * n + i + 1, (j + 1) * n + i + 1, (j + 1) * n + i] for j in range(n - 1) for i in range(n - 1)]
    same = lambda faces: [[(v, v) for v in f] for f in faces]
    yield "hill", hill, grid / 16 + 0.1, same(quads)

    # Four charts: shifted, mirrored, turned and scaled onto another one.
    uvs, faces = [], []
    for q in quads:
        part = (q[0] % n >= 4) + 2 * (q[0] // n >= 4)
        t = grid[q] / n
        t = [t, t + 1.25, t * [-1, 1] + [2, 0], (t @ [[0, 1], [-1, 0]]) * 1.5 + [1.2, 0.1]][part]
        faces.append([(v, len(uvs) + k) for k, v in enumerate(q)])
        uvs += list(t)
    yield "four_charts", hill, uvs, faces

    # Noise that flips faces, a fin on an inner edge, faces without UV, on a line, on a point, and split vertices.
    noisy = grid / n + rng.normal(0, 0.05, grid.shape)
    positions = np.r_[hill, [[4, 4, 5]], hill[:3], [[9, 9, 9]]]
    uvs = np.r_[noisy, [[1.5, 1.5]], noisy[:3], [[2, 2]]]
    tris = [t for q in quads for t in (q[:3], [q[0], q[2], q[3]])]
    faces = same(tris) + same([[40, 41, 81], [40, 40, 41], [12, 12, 12], [82, 83, 10]])
    faces[7] = [(v, None) for v, _ in faces[7]]
    faces[9] = [(v, None if k == 1 else t) for k, (v, t) in enumerate(faces[9])]
    faces[20] = [(v, faces[20][0][1]) for v, _ in faces[20]]
    yield "faults", positions, uvs, faces

    # A closed surface pressed flat, one UV a vertex: no cut at all.
    theta, phi = np.meshgrid(np.linspace(0.3, 2.8, 7), np.arange(12) * np.pi / 6, indexing="ij")
    ball = np.c_[(np.sin(theta) * np.cos(phi)).ravel(), (np.sin(theta) * np.sin(phi)).ravel(), np.cos(theta).ravel()]
    ring = [[r * 12 + i, r * 12 + (i + 1) % 12, (r + 1) * 12 + (i + 1) % 12, (r + 1) * 12 + i] for r in range(6) for i in range(12)]
    caps = [list(range(12))[::-1], list(range(72, 84))]
    yield "pressed_ball", ball, ball[:, :2] * 50 - 3, same(ring + caps)

    yield "half_collapsed", hill, np.c_[grid[:, 0], np.maximum(grid[:, 1] - 4, 0)], same(quads)
    yield "no_uv", hill, [], [[(v, None) for v, _ in f] for f in same(quads)]
    yield ("cut_box", *cut_box(rng))


def cut_box(rng):
    """A box of 3 x 3 squares a side that turn by about a degree, cut along its edges but one and in all ways across its sides, a
    square of it wound the other way; and a torus with a hole, in one chart."""
    positions, uvs, faces, number = [], [], [], {}

    def vertex(place):
        if place not in number:
            number[place] = len(positions)
            positions.append(np.array(place) + rng.normal(0, 0.01, 3))
        return number[place]

    def face(places, uv):
        faces.append([(vertex(p), len(uvs) + k) for k, p in enumerate(places)])
        uvs.extend(uv)
    for side in range(6):
        axis, far = side // 2, side % 2
        for i, j in np.ndindex(3, 3):
            cell = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            if (far == 0) != (axis == 1):                    # seen from outside, all are counter-clockwise
                cell.reverse()
            places = [p[:axis] + (3 * far,) + p[axis:] for p in cell]
            uv = np.array(cell, float) + [side * 4, 0]
            apart = [side == 1 and (i, j) == (1, 1),         # a hole
                     side == 3 and i > 0,                    # a cut across
                     side == 5 and (i, j) in ((0, 0), (1, 1))]  # a hole and a corner that touch
            if any(apart):
                uv = uv * 0.5 + [20 * i, 10 + 5 * j * (side != 3)]
            if side in (0, 2):                               # unfolded along the edge that both have
                uv = np.array([(p[0] - p[1], p[2] + 20) for p in places], float)
            if side == 4 and (i, j) == (2, 1):
                places, uv = places[::-1], uv[::-1]
            face(places, uv)
    ring = lambda i, j: (6 + (2 + (j % 4 < 2)) * math.cos(i % 5 * 1.2), (2 + (j % 4 < 2)) * math.sin(i % 5 * 1.2), 1.0 * (j % 4 in (1, 2)))
    for i, j in np.ndindex(5, 4):
        if (i, j) != (0, 0):
            corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
            face([ring(*c) for c in corners], [(30 + c[0] % 5, c[1] % 4) for c in corners])
    return positions, uvs, faces


def record(judge, folder):
    os.makedirs(folder, exist_ok=True)
    for name, positions, uvs, faces in hostile_maps():
        path = os.path.join(folder, name + ".obj")
        write_obj(path, positions, uvs, faces)
        figures, _ = judge_figures(judge, path, 256, rays=0)
        finite = lambda x: [finite(y) for y in x] if isinstance(x, list) else x if x is None or math.isfinite(x) else None
        figures = {k: finite(v) for k, v in figures.items() if k not in NOT_FIGURES}
        with open(os.path.join(folder, name + ".json"), "w") as file:
            json.dump(figures, file, indent=1)
            file.write("\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("obj", nargs="*")
    parser.add_argument("--judge", required=True)
    parser.add_argument("--command", metavar="SEAMWRIGHT")
    parser.add_argument("--runner", metavar="MEASURE_PLAIN")
    parser.add_argument("--resolution", type=int, default=2048)
    parser.add_argument("--xatlas", action="store_true")
    parser.add_argument("--unwrap", action="store_true")
    parser.add_argument("--no-ao", action="store_true")
    parser.add_argument("--record", metavar="FOLDER")
    args = parser.parse_args()
    if not args.record and bool(args.command) == bool(args.runner) or args.unwrap and not args.command:
        parser.error("one of --command and --runner, and --unwrap with --command alone")
    judge = load_judge(args.judge)
    if args.record:
        return record(judge, args.record)
    good, worst = True, {}
    with tempfile.TemporaryDirectory() as folder:
        for path in args.obj:
            if args.xatlas:
                mapped = os.path.join(folder, os.path.basename(path))
                unwrap_with_xatlas(judge, path, mapped)
                path = mapped
            elif args.unwrap:
                mapped = os.path.join(folder, os.path.basename(path))
                subprocess.run([args.command, "unwrap", path, "-o", mapped, "--quiet"], check=True)
                path = mapped
            good &= compare(judge, args, path, worst)
    print("largest relative differences: "
          + ", ".join(f"{k} {g:.1e}" for k, g in sorted(worst.items(), key=lambda x: -x[1]) if g > 0))
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
