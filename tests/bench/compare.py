#!/usr/bin/env python3
"""seamwright beside uvunwrap on the same meshes in one run: the tables of docs/RESULTS.md.

    cargo build --release --workspace
    python3 tests/bench/compare.py [--distortion 1.025] [--parts auto] [--uvunwrap PATH] MESH.obj...

PATH is the `unwrap` example of the crate uvunwrap 0.3, built with `cargo build --release --example unwrap`. Both atlases
are measured by `seamwright measure` (uniform exposure, as libigl samples it). uvunwrap gets the mesh without normals and
UVs, so that it does not split vertices there. Seconds are user time of the whole process, wall time in brackets.
"""
import argparse, json, os, resource, subprocess, sys, tempfile, time

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
OURS = os.path.join(os.environ.get("CARGO_TARGET_DIR", os.path.join(ROOT, "target")), "release", "seamwright")
HEAD = ["charts", "conf", "equi", "sd/4", "fill", "SL", "VSL", "noticed", "flat", "sharp", "ratio", "flips", "overlap", "not disks",
        "s"]


def timed(command):
    """User and wall seconds of a command; what it prints is kept for an error."""
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime, time.time()
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode not in (0, 5):  # 5: the atlas is there, its distortion is above the bound; the table shows it
        sys.exit(f"{' '.join(command)}: exit {done.returncode}\n{done.stderr}")
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before, time.time() - start


def measured(path):
    """The record of one mapped OBJ."""
    out = subprocess.run([OURS, "measure", path, "--json"], capture_output=True, text=True, check=True).stdout
    record = json.loads(out)
    return record[0] if isinstance(record, list) else record


def bare(path, to):
    """Positions and faces alone."""
    with open(path, errors="ignore") as source, open(to, "w") as out:
        for line in source:
            if line.startswith("v "):
                out.write(" ".join(line.split()[:4]) + "\n")
            elif line.startswith("f "):
                out.write("f " + " ".join(word.split("/")[0] for word in line.split()[1:]) + "\n")


def row(record, seconds):
    return [record["charts"], 1 - record["angle_err_rad"], 1 - record["area_ln"], record["symmetric_dirichlet"] / 4,
            record["utilisation"], record["seam_len_norm"], record["visible_seam_len_norm"], record["noticed_seam_len_norm"],
            record["seam_flat_share"], record["seam_sharp_share"], record["seam_ao_ratio"], record["flipped_faces"],
            record["overlap_frac"], record["non_disk_charts"], *seconds]


def line(name, values):
    c, conf, equi, sd, fill, sl, vsl, noticed, flat, sharp, ratio, flips, overlap, disks, user, wall = values
    return (f"| {name} | {c:.4g} | {conf:.3f} | {equi:.3f} | {sd:.4f} | {fill:.3f} | {sl:.2f} | {vsl:.2f} | {noticed:.2f} "
            f"| {flat:.2f} | {sharp:.2f} | {ratio:.2f} | {flips:.3g} | {overlap:.2g} | {disks:.3g} | {user:.2f} ({wall:.2f}) |")


def table(title, rows):
    print(f"\n{title}\n\n| mesh | " + " | ".join(HEAD) + " |\n|" + "---|" * (len(HEAD) + 1))
    for name, values in rows:
        print(line(name, values))
    mean = [sum(v[i] for _, v in rows) / len(rows) for i in range(len(rows[0][1]))]
    print(line("**mean**", mean), flush=True)
    return mean


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs="+")
    parser.add_argument("--distortion", default="1.025")
    parser.add_argument("--threads", default="2")
    parser.add_argument("--parts", default="off")
    parser.add_argument("--sheets", help="a folder for a picture of each atlas")
    parser.add_argument("--uvunwrap")
    args = parser.parse_args()
    ours, theirs = [], []
    with tempfile.TemporaryDirectory() as folder:
        for path in args.meshes:
            name = os.path.splitext(os.path.basename(path))[0]
            out = os.path.join(folder, name + ".obj")
            command = [OURS, "unwrap", path, "-o", out, "--distortion", args.distortion, "--parts", args.parts, "--threads", args.threads,
                       "--quiet"]
            if args.sheets:
                command += ["--sheet", os.path.join(args.sheets, name + ".png")]
            ours.append((name, row(*measured_after(command, out))))
            if args.uvunwrap:
                plain = os.path.join(folder, name + "_bare.obj")
                bare(path, plain)
                prefix = os.path.join(folder, name + "_peer")
                command = [args.uvunwrap, "--page-size", "1024", "--padding", "2", plain, prefix]
                theirs.append((name, row(*measured_after(command, prefix + ".obj"))))
    mean = table(f"seamwright, --distortion {args.distortion} --parts {args.parts}", ours)
    if theirs:
        peer = table("uvunwrap 0.3.0", theirs)
        names = ["charts", "SL", "VSL", "noticed", "user seconds", "wall seconds"]
        ratios = [mean[i] / peer[i] for i in (0, 5, 6, 7, 14, 15)]
        print("\nMeans, ours over uvunwrap's: " + ", ".join(f"{n} {r:.3f}" for n, r in zip(names, ratios)))


def measured_after(command, out):
    seconds = timed(command)
    return measured(out), seconds


if __name__ == "__main__":
    main()
