"""Packs the charts of UV-mapped OBJs with other packers and prints how full the unit square is.

    python3 pack_peers.py [--uvunwrap PATH_TO_ITS_unwrap_EXAMPLE] [--ours DIR] FILE.obj...
    blender --background --python pack_peers.py -- --blender FILE.obj...

The same charts and the same measure as `pack_bench`: charts by UV connectivity, scaled to their area in 3D and turned
over where mirrored; the share of texel centres of a square of 1024 that charts cover after fitting their common box into
it; padding 2. Needs numpy, and `pip install xatlas` unless Blender runs it. xatlas: brute force with rotation (it may
also mirror charts). uvunwrap: repacks existing UVs; a chart that it finds unusable it unwraps anew, so its number of
charts is printed. Blender: pack islands with rotation, margin as a fraction of the square, from 3.6 on concave shapes. --ours
measures files of the same name in DIR (`pack_bench --out DIR`).
"""
import argparse, os, resource, subprocess, sys, tempfile, time
import numpy as np

SIZE, PADDING = 1024, 2
UVUNWRAP = None


def load(path):
    pos, tex, fv, ft = [], [], [], []
    with open(path, errors="ignore") as lines:
        for line in lines:
            w = line.split()
            if not w:
                continue
            if w[0] == "v":
                pos.append([float(x) for x in w[1:4]])
            elif w[0] == "vt":
                tex.append([float(x) for x in w[1:3]])
            elif w[0] == "f":
                c = [[int(i) - 1 for i in t.split("/")[:2]] for t in w[1:]]
                for i in range(1, len(c) - 1):
                    fv.append([c[0][0], c[i][0], c[i + 1][0]])
                    ft.append([c[0][1], c[i][1], c[i + 1][1]])
    return np.array(pos), np.array(tex), np.array(fv), np.array(ft)


def charts_of(faces, count):
    parent = np.arange(count)

    def find(x):
        while parent[x] != x:
            parent[x] = parent[parent[x]]
            x = parent[x]
        return x
    for a, b, c in faces:
        parent[find(b)] = find(a)
        parent[find(c)] = find(a)
    _, chart = np.unique([find(f[0]) for f in faces], return_inverse=True)
    return chart


def natural(pos, tex, fv, ft):
    """UVs at equal density, unmirrored."""
    chart = charts_of(ft, len(tex))
    p, q = tex[ft], pos[fv]
    e, g = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
    signed = 0.5 * (e[:, 0] * g[:, 1] - e[:, 1] * g[:, 0])
    solid = 0.5 * np.linalg.norm(np.cross(q[:, 1] - q[:, 0], q[:, 2] - q[:, 0]), axis=1)
    flat = np.bincount(chart, abs(signed))
    scale = np.sqrt(np.bincount(chart, solid) / np.maximum(flat, 1e-300))
    mirror = np.where(np.bincount(chart, signed) < 0, -1.0, 1.0)
    of = np.zeros(len(tex), int)
    of[ft.ravel()] = np.repeat(chart, 3)
    return tex * np.stack([scale * mirror, scale], 1)[of]


def fill(uv, faces):
    t = uv[faces]
    q = t.reshape(-1, 2)
    t = (t - q.min(0)) / np.ptp(q, axis=0).max() * SIZE - 0.5
    cover = np.zeros((SIZE, SIZE), bool)
    for tri in t:
        lo, hi = np.ceil(tri[:, 1].min()), np.ceil(tri[:, 1].max())
        for y in range(max(int(lo), 0), min(int(hi), SIZE)):
            xs = []
            for i in range(3):
                p, r = tri[i], tri[(i + 1) % 3]
                if (p[1] <= y) != (r[1] <= y):
                    xs.append(p[0] + (y - p[1]) / (r[1] - p[1]) * (r[0] - p[0]))
            if xs:
                cover[y, max(int(np.ceil(min(xs))), 0):max(int(np.ceil(max(xs))), 0)] = True
    return cover.mean()


def by_xatlas(pos, uv, fv, ft):
    import xatlas
    e, g = uv[ft][:, 1] - uv[ft][:, 0], uv[ft][:, 2] - uv[ft][:, 0]
    area = 0.5 * abs(e[:, 0] * g[:, 1] - e[:, 1] * g[:, 0]).sum()
    atlas, options = xatlas.Atlas(), xatlas.PackOptions()
    atlas.add_uv_mesh((uv * 700 / np.sqrt(area)).astype(np.float32), ft.astype(np.uint32))
    options.padding, options.resolution, options.bruteForce, options.rotate_charts = PADDING, SIZE, True, True
    atlas.generate(xatlas.ChartOptions(), options)
    _, faces, out = atlas.get_mesh(0)
    return fill(np.asarray(out, float), faces.astype(int)), atlas.chart_count


def by_uvunwrap(pos, uv, fv, ft):
    with tempfile.TemporaryDirectory() as folder:
        before, after = os.path.join(folder, "a.obj"), os.path.join(folder, "b")
        with open(before, "w") as f:
            f.writelines("v {} {} {}\n".format(*p) for p in pos)
            f.writelines("vt {} {}\n".format(*t) for t in uv - uv.min(0))
            f.writelines("f " + " ".join(f"{v + 1}/{t + 1}" for v, t in zip(a, b)) + "\n" for a, b in zip(fv, ft))
        subprocess.run([UVUNWRAP, before, after, "--keep-uvs"], check=True, capture_output=True)
        _, tex, _, faces = load(after + ".obj")
    return fill(tex, faces), len(np.unique(charts_of(faces, len(tex))))


def by_blender(pos, uv, fv, ft):
    import bpy
    bpy.ops.wm.read_factory_settings(use_empty=True)
    mesh = bpy.data.meshes.new("m")
    # Flat geometry split at the charts' borders: islands are then exactly the charts.
    mesh.from_pydata([(x, y, 0.0) for x, y in uv], [], [list(map(int, f)) for f in ft])
    layer = mesh.uv_layers.new(name="uv")
    corners = np.array([l.vertex_index for l in mesh.loops])
    span = np.ptp(uv, axis=0).max()
    layer.data.foreach_set("uv", ((uv[corners] - uv.min(0)) / span).astype(np.float32).ravel())
    thing = bpy.data.objects.new("m", mesh)
    bpy.context.collection.objects.link(thing)
    bpy.context.view_layer.objects.active = thing
    thing.select_set(True)
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.uv.select_all(action="SELECT")
    wanted = {"rotate": True, "rotate_method": "ANY", "scale": True, "margin_method": "FRACTION",
              "margin": PADDING / SIZE, "shape_method": "CONCAVE"}
    known = bpy.ops.uv.pack_islands.get_rna_type().properties.keys()
    bpy.ops.uv.pack_islands(**{k: v for k, v in wanted.items() if k in known})
    bpy.ops.object.mode_set(mode="OBJECT")
    out = np.zeros(len(mesh.loops) * 2, np.float32)
    mesh.uv_layers[0].data.foreach_get("uv", out)
    faces = np.arange(len(mesh.loops)).reshape(-1, 3)
    return fill(out.reshape(-1, 2).astype(float), faces), len(np.unique(charts_of(ft, len(uv))))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+")
    parser.add_argument("--blender", action="store_true")
    parser.add_argument("--uvunwrap")
    parser.add_argument("--ours")
    args = parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:])
    UVUNWRAP = args.uvunwrap
    peers = {"blender": by_blender} if args.blender else {"xatlas": by_xatlas}
    peers |= {"uvunwrap": by_uvunwrap} if UVUNWRAP else {}
    spent = lambda: sum(resource.getrusage(w).ru_utime for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    for path in args.files:
        pos, tex, fv, ft = load(path)
        uv, row = natural(pos, tex, fv, ft), [f"{os.path.basename(path):<28}"]
        for name, run in peers.items():
            start = spent()
            try:
                full, count = run(pos, uv, fv, ft)
                row.append(f"{name} {full:.4f} ({count} charts, {spent() - start:.1f} s)")
            except Exception as error:
                row.append(f"{name} failed: {error}")
        if args.ours:
            _, tex, _, ft = load(os.path.join(args.ours, os.path.basename(path)))
            row.append(f"ours {fill(tex, ft):.4f}")
        print("  ".join(row), flush=True)
