"""How much of a mesh has the UVs of another mesh of the same shape, and how `seamwright transfer` does on files of levels of detail.

    python tests/bench/transfer.py A_uv.obj B_uv.obj ...              the share of each B within 1, 2 and 8 texels of A at 1024
    python tests/bench/transfer.py --run SEAMWRIGHT A.obj B.obj ...   unwraps A, transfers to each B, checks and measures it

Points are drawn on B by area. Each is compared with the closest point of A; where other faces beside that one are as close to a
ten-thousandth of the diagonal, as at seams, with the nearest of them in UV. Needs numpy and libigl; shares no code with core.
"""
import json, subprocess, sys, tempfile
from pathlib import Path
import igl
import numpy as np

SIZE, POINTS = 1024, 40_000


def load(path):
    """Positions, UVs, and triangles as indices of both."""
    v, t, f, ft = [], [], [], []
    for line in open(path):
        w = line.split()
        if w[:1] == ["v"]:
            v.append([float(x) for x in w[1:4]])
        elif w[:1] == ["vt"]:
            t.append([float(x) for x in w[1:3]])
        elif w[:1] == ["f"]:
            c = [x.split("/") for x in w[1:]]
            for k in range(1, len(c) - 1):
                f.append([int(c[i][0]) - 1 for i in (0, k, k + 1)])
                ft.append([int(c[i][1]) - 1 for i in (0, k, k + 1)])
    return np.array(v), np.array(t), np.array(f), np.array(ft)


def weights(q, p):
    """Barycentric weights of points p in triangles q."""
    e0, e1, e2 = q[:, 1] - q[:, 0], q[:, 2] - q[:, 0], p - q[:, 0]
    a, b, c, d, e = ((x * y).sum(1) for x, y in ((e0, e0), (e0, e1), (e1, e1), (e2, e0), (e2, e1)))
    det = np.maximum(a * c - b * b, 1e-300)
    w1, w2 = (c * d - b * e) / det, (a * e - b * d) / det
    return np.c_[1 - w1 - w2, w1, w2]


def texels_apart(a, b):
    """Distance in texels between what A and B say of points of B."""
    (va, ta, fa, fta), (vb, tb, fb, ftb) = a, b
    corners = vb[fb]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    draw = np.random.default_rng(0)
    k, r = draw.choice(len(fb), POINTS, p=area / area.sum()), draw.random((POINTS, 2))
    s = np.sqrt(r[:, :1])
    w = np.c_[1 - s, s * (1 - r[:, 1:]), s * r[:, 1:]]
    x, ub = (corners[k] * w[:, :, None]).sum(1), (tb[ftb[k]] * w[:, :, None]).sum(1)
    d2, hit, _ = igl.point_mesh_squared_distance(x, va, fa.astype(np.int64))[:3]
    at = [[] for _ in va]
    for i, face in enumerate(fa):
        for v in face:
            at[v].append(i)
    beside = [sorted({g for v in face for g in at[v]}) for face in fa]
    slack = 1e-4 * np.linalg.norm(va.max(0) - va.min(0))
    point = np.repeat(np.arange(POINTS), [len(beside[h]) for h in hit])
    face = np.concatenate([beside[h] for h in hit])
    d, close = closest(x[point], va[fa[face]])
    ok = d <= np.sqrt(np.maximum(d2[point], 0)) + slack
    ua = (ta[fta[face]] * weights(va[fa[face]], close)[:, :, None]).sum(1)
    gap = np.where(ok, np.linalg.norm(ua - ub[point], axis=1), np.inf)
    best = np.full(POINTS, np.inf)
    np.minimum.at(best, point, gap)
    return best * SIZE


def closest(p, q):
    """Distances and closest points of points p and triangles q: inside, or on one of their sides."""
    w = weights(q, p)
    inside = (w >= 0).all(1)
    best = np.where(inside[:, None], (q * w[:, :, None]).sum(1), np.inf)
    d = np.where(inside, np.linalg.norm(p - np.where(inside[:, None], best, p), axis=1), np.inf)
    for i in range(3):
        s, e = q[:, i], q[:, (i + 1) % 3] - q[:, i]
        t = np.clip(((p - s) * e).sum(1) / np.maximum((e * e).sum(1), 1e-300), 0, 1)
        c = s + e * t[:, None]
        own = np.linalg.norm(p - c, axis=1)
        best = np.where((own < d)[:, None], c, best)
        d = np.minimum(own, d)
    return d, best


def shares(gap):
    return " ".join(f"{(gap < n).mean():.4f}" for n in (1, 2, 8))


def run(tool, first, others):
    with tempfile.TemporaryDirectory() as folder:
        atlas = Path(folder) / "a.obj"
        subprocess.run([tool, "unwrap", first, "-o", atlas, "-q"], check=True)
        a = load(atlas)
        for other in others:
            out, report = Path(folder) / "b.obj", Path(folder) / "b.json"
            done = subprocess.run([tool, "transfer", atlas, other, "-o", out, "--json", report, "-q"], capture_output=True, text=True)
            if not out.exists():
                print(f"{Path(other).name:24}", done.stderr.strip())
                continue
            r, told = json.load(open(report)), json.load(open(report))["result"]
            kept = subprocess.run([tool, "check", out, "--input", other], capture_output=True, text=True)
            print(
                f"{Path(other).name:22} within 1, 2, 8: {shares(texels_apart(a, load(out)))} (own 2: {told['within_two_texels']:.4f})"
                f" charts {told['charts']}/{told['source_charts']} pieces {told['regions']} flips {told['flipped_faces']}"
                f" overlaps {told['overlapping_faces']} moved {told['moved_faces']} of {r['input']['polygons']}"
                f" {r['seconds']:.2f} s check {'kept' if kept.returncode == 0 else kept.stdout.strip().splitlines()[-1:]}",
                flush=True,
            )
            out.unlink()


if __name__ == "__main__":
    if sys.argv[1] == "--run":
        run(sys.argv[2], sys.argv[3], sys.argv[4:])
    else:
        a = load(sys.argv[1])
        for path in sys.argv[2:]:
            print(f"{Path(path).name:24} within 1, 2, 8 texels: {shares(texels_apart(a, load(path)))}")
