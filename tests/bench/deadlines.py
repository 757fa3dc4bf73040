#!/usr/bin/env python3
"""How well `seamwright unwrap --time-limit` keeps its limit.

Unwraps every OBJ of the folders and files given, each in a process of its own, and has `seamwright check` decide whether the atlas is valid.
With --again each atlas is made once more by the counted work that the run named, on one thread, and compared byte for byte.
Meshes that are refused as unreadable (code 3) are left out. Prints a line for each folder and names what is late or wrong.

    cargo build --release --workspace
    python3 tests/bench/deadlines.py --limit 2 MESHES...
"""
import argparse
import os
import subprocess
import sys
import tempfile
import time

TARGET = os.environ.get("CARGO_TARGET_DIR", "target")
SEAMWRIGHT = os.path.join(TARGET, "release", "seamwright")
# How much longer than its limit a run may take.
SLACK = 1.3


def run(*words):
    return subprocess.run([SEAMWRIGHT, *words], capture_output=True, text=True)


def unwrap(path, limit, folder, again):
    """Seconds, whether the run ended early, and what is wrong; nothing for what is no mesh."""
    out, other = os.path.join(folder, "a.obj"), os.path.join(folder, "b.obj")
    start = time.perf_counter()
    made = run("unwrap", path, "-o", out, "--time-limit", str(limit))
    seconds = time.perf_counter() - start
    if made.returncode == 3:
        return None
    wrong = [] if made.returncode == 0 else [f"code {made.returncode}: {made.stderr.splitlines()[-1]}"]
    works = [line.split("--work ")[1].split()[0] for line in made.stderr.splitlines() if "--work " in line]
    if made.returncode == 0:
        checked = run("check", out, "--input", path)
        if checked.returncode != 0:
            wrong.append("check: " + (checked.stdout.splitlines() or ["?"])[0])
        if again and works:
            run("unwrap", path, "-o", other, "--work", works[0], "--threads", "1")
            with open(out, "rb") as a, open(other, "rb") as b:
                if a.read() != b.read():
                    wrong.append(f"--work {works[0]} gives another atlas")
    if seconds > SLACK * limit:
        wrong.append(f"late: {seconds:.2f} s")
    return seconds, bool(works), wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--limit", type=float, default=2.0)
    parser.add_argument("--again", action="store_true")
    parser.add_argument("meshes", nargs="+")
    args = parser.parse_args()
    failed = False
    with tempfile.TemporaryDirectory() as folder:
        for given in args.meshes:
            paths = [given]
            if os.path.isdir(given):
                paths = sorted(os.path.join(given, name) for name in os.listdir(given) if name.endswith(".obj"))
            runs = []
            for path in paths:
                result = unwrap(path, args.limit, folder, args.again)
                if result is not None:
                    runs.append(result)
                    for text in result[2]:
                        print(f"{path}: {text}", flush=True)
            early = sum(early for _, early, _ in runs)
            good = sum(not wrong for _, _, wrong in runs)
            worst = max((seconds for seconds, _, _ in runs), default=0.0)
            print(f"{given}: {good} of {len(runs)} valid and in time, {early} ended early, slowest {worst:.2f} s", flush=True)
            failed |= good < len(runs)
    sys.exit(failed)


main()
