#!/usr/bin/env python3
"""Learned maps on meshes, a run after the other: the tables of docs/RESULTS.md.

    cargo build --release
    python3 tests/bench/learned.py [--method neural] [FLAG OF unwrap]... -- MESH.obj...

Atlases are measured by `seamwright measure` (uniform exposure, as libigl samples it). Own: figures of the network's map before
anything was done to it (sd/4, conformality, equiareality, faces turned over); moved: how far one point in twenty was moved afterwards
at the least, in texels of 1024. Seconds are user time of the whole process, wall time in brackets. The last line has the means.
"""
import json, os, resource, subprocess, sys, tempfile, time

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
OURS = os.environ.get("SEAMWRIGHT") or os.path.join(ROOT, "target", "release", "seamwright")
HEAD = ["charts", "conf", "equi", "sd/4", "SL", "VSL", "noticed", "flat", "sharp", "seam exposure", "flips", "overlap", "own sd/4", "own conf", "own equi", "own flips", "moved", "s"]


def run(mesh, flags, folder):
    out, report = os.path.join(folder, "out.obj"), os.path.join(folder, "out.json")
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime, time.time()
    done = subprocess.run([OURS, "unwrap", mesh, "-o", out, "--json", report, "-q", *flags], capture_output=True, text=True)
    if done.returncode not in (0, 5):  # 5: the atlas is there, and the table shows what it lacks
        sys.exit(f"{mesh}: exit {done.returncode}\n{done.stderr}")
    seconds = [resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, time.time() - start]
    learned = (json.load(open(report)).get("learning") or {}).get("map") or {}
    own = [learned.get(key, float("nan")) for key in ("own_distortion", "own_conformality", "own_equiareality", "own_flipped")]
    m = json.loads(subprocess.run([OURS, "measure", out, "--json"], capture_output=True, text=True, check=True).stdout)
    return [m["charts"], m["conformality"], m["equiareality"], m["symmetric_dirichlet"] / 4, m["seam_len_norm"],
            m["visible_seam_len_norm"], m["noticed_seam_len_norm"], m["seam_flat_share"], m["seam_sharp_share"], m["seam_ao_mean"],
            m["flipped_faces"], m["overlap_frac"], *own, learned.get("moved_texels", [0, float("nan")])[1], *seconds]


def line(name, v):
    return (f"| {name} | {v[0]:.4g} | {v[1]:.3f} | {v[2]:.3f} | {v[3]:.3f} | {v[4]:.2f} | {v[5]:.2f} | {v[6]:.2f} | {v[7]:.2f} "
            f"| {v[8]:.2f} | {v[9]:.3f} | {v[10]:.3g} | {v[11]:.3f} | {v[12]:.4f} | {v[13]:.3f} | {v[14]:.3f} | {v[15]:.3g} | {v[16]:.2f} "
            f"| {v[17]:.1f} ({v[18]:.1f}) |")


def main():
    at = sys.argv.index("--") if "--" in sys.argv else 0
    flags, meshes = sys.argv[1:at], sys.argv[at + 1:]
    print(f"{' '.join(flags)}\n\n| mesh | " + " | ".join(HEAD) + " |\n|" + "---|" * (len(HEAD) + 1), flush=True)
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for mesh in meshes:
            rows.append(run(mesh, flags, folder))
            print(line(os.path.splitext(os.path.basename(mesh))[0], rows[-1]), flush=True)
    if rows:
        print(line("**mean**", [sum(r[i] for r in rows) / len(rows) for i in range(len(rows[0]))]))


main()
