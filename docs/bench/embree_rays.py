#!/usr/bin/env python3
"""Rays a second of Embree through libigl, for comparison with our own exposure.

    pip install numpy libigl
    taskset -c 0 python3 docs/bench/embree_rays.py MESH.obj [RAYS] [PROGRAM]

RAYS a vertex, 512 by default. PROGRAM is our `rays` bench (target/release/rays, built by
`cargo build --release -p seamwright-tests --bin rays`); where given, the two run in turn and the best of three counts.
Both scale the mesh to a largest coordinate of 1, use area-weighted normals and uniform directions, and include the
building of the hierarchy. libigl starts its rays on the surface with a near limit of 1e-4 and draws directions at
random; we start 1e-4 above it and use a lattice.
"""
import re, subprocess, sys, time
import numpy as np, igl, igl.embree


def load(path):
    points, faces = [], []
    for line in open(path, errors="ignore"):
        if line.startswith("v "):
            points.append([float(x) for x in line.split()[1:4]])
        elif line.startswith("f "):
            c = [int(w.split("/")[0]) for w in line.split()[1:]]
            c = [i - 1 if i > 0 else len(points) + i for i in c]
            faces += [[c[0], c[i], c[i + 1]] for i in range(1, len(c) - 1)]
    unique, inverse = np.unique(np.array(points), axis=0, return_inverse=True)
    unique -= (unique.max(0) + unique.min(0)) / 2
    return np.ascontiguousarray(unique / np.abs(unique).max()), inverse.reshape(-1)[np.array(faces, np.int64)]


def main():
    path, rays = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 512
    program = sys.argv[3] if len(sys.argv) > 3 else None
    V, F = load(path)
    N = igl.per_vertex_normals(V, F)
    N[~np.isfinite(N).all(1)] = [0, 0, 1]
    theirs, ours, mean, own_mean = 0, {}, 0, {}
    for _ in range(3):
        start = time.process_time()
        exposure = 1 - igl.embree.ambient_occlusion(V, F, V, N, rays)
        theirs = max(theirs, len(V) * rays / (time.process_time() - start) / 1e6)
        mean = exposure.mean()
        if program:
            text = subprocess.run([program, path, str(rays)], capture_output=True, text=True, check=True).stdout
            for who, rate, e in re.findall(r"(\w+ Uniform): ([\d.]+) Mrays/s.*mean exposure ([\d.]+)", text):
                ours[who], own_mean[who] = max(ours.get(who, 0), float(rate)), float(e)
    print(f"{path}: {len(V)} vertices, {len(F)} faces, {rays} rays a vertex")
    print(f"  Embree through libigl {theirs:6.2f} Mrays/s, mean exposure {mean:.4f}")
    for who, rate in ours.items():
        print(f"  {who:21s} {rate:6.2f} Mrays/s, mean exposure {own_mean[who]:.4f}, ratio {rate / theirs:.2f}")


if __name__ == "__main__":
    main()
