#!/usr/bin/env python3
"""Time and peak memory of `seamwright unwrap` as a mesh grows: a table for docs/RESULTS.md.

    cargo build --release --workspace
    python3 tests/bench/growth.py [--faces 1000,10000,100000,1000000] [--fixture quadruped] [--threads 2] [--runs 1]

Each size is made by the generator of the fixtures (once, into --folder) and unwrapped in a process of its own. Time is the
best of --runs, from start to the written OBJ; user time beside it shows how busy the machine was otherwise. Peak memory is
the largest resident set that the system has seen (Linux), so pages that were reserved and never touched do not count.
"""
import argparse, json, os, subprocess, sys, tempfile, time

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
TARGET = os.path.join(os.environ.get("CARGO_TARGET_DIR", os.path.join(ROOT, "target")), "release")


def generate(folder, fixture, faces):
    """Paths of the meshes, made where they are not there yet."""
    paths = {n: os.path.join(folder, f"{fixture}_{n}.obj") for n in faces}
    missing = [str(n) for n, path in paths.items() if not os.path.exists(path)]
    if missing:
        subprocess.run([os.path.join(TARGET, "fixtures"), folder, "--only", fixture, "--faces", ",".join(missing)], check=True)
    return paths


def run(path, threads):
    """Seconds, user seconds, peak bytes and the report of one unwrap."""
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "out.obj")
        start = time.time()
        child = subprocess.Popen([os.path.join(TARGET, "seamwright"), "unwrap", path, "-o", out,
                                  "--threads", str(threads), "--quiet"])
        _, status, usage = os.wait4(child.pid, 0)
        seconds = time.time() - start
        if not os.path.exists(out):
            sys.exit(f"{path}: seamwright ended with code {os.waitstatus_to_exitcode(status)}")
        measure = [os.path.join(TARGET, "seamwright"), "measure", out, "--json", "--exposure", "none", "--resolution", "0"]
        figures = json.loads(subprocess.run(measure, check=True, stdout=subprocess.PIPE).stdout)
        return seconds, usage.ru_utime, usage.ru_maxrss * 1024, figures


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--faces", default="1000,10000,100000,1000000")
    parser.add_argument("--fixture", default="quadruped")
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--runs", type=int, default=1)
    parser.add_argument("--folder", default=os.path.join(tempfile.gettempdir(), "seamwright-growth"))
    args = parser.parse_args()
    os.makedirs(args.folder, exist_ok=True)
    faces = [int(n) for n in args.faces.split(",")]
    print("| faces | time, s | of it user, s | microseconds a face | peak memory, MB | bytes a face | charts | sd/4 | overlapping |")
    print("|---|---|---|---|---|---|---|---|---|")
    for path in generate(args.folder, args.fixture, faces).values():
        seconds, user, peak, figures = min((run(path, args.threads) for _ in range(args.runs)), key=lambda r: r[0])
        n = figures["faces"]
        energy = figures["symmetric_dirichlet"]
        print(f"| {n} | {seconds:.2f} | {user:.2f} | {1e6 * seconds / n:.0f} | {peak / 1e6:.0f} | {peak / n:.0f} | "
              f"{figures['charts']} | {energy / 4 if energy else float('nan'):.4f} | {figures['overlapping_faces']} |", flush=True)


if __name__ == "__main__":
    main()
