#!/usr/bin/env python3
"""Unwraps every OBJ of some folders and names the atlases that an evaluator would not pass.

    cargo build --release
    python3 tests/bench/validity.py [--packing tight] [--charts few] [--judge EVAL_UV.py] FOLDER_OR_MESH...

An atlas passes where every face has UVs, no face is flipped in its chart, no texel of 2048 x 2048 is covered twice, a plane
can hold every chart (a disk, or one with holes) and none is mirrored. Faces are what a reader makes of the polygons that knows nothing better: fans from
their first corners. A mesh without a single triangle passes where it is refused with exit code 3 and a message that names
it. Figures come from `seamwright measure`; with --judge from that Python module as well, which the same counts must pass.
Exit code 1 where anything fails.
"""
import argparse, importlib.util, json, os, subprocess, sys, tempfile, time

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
OURS = os.path.join(os.environ.get("CARGO_TARGET_DIR", os.path.join(ROOT, "target")), "release", "seamwright")
ZERO = ["faces_without_vt", "flipped_faces", "overlap_frac", "closed_or_handled_charts", "mirrored_charts"]


def meshes(paths):
    for path in paths:
        if os.path.isdir(path):
            yield from (os.path.join(path, name) for name in sorted(os.listdir(path)) if name.endswith(".obj"))
        else:
            yield path


def faults_of(record):
    return [f"{key} {record.get(key)}" for key in ZERO if record.get(key) != 0]


def check(path, out, args, judge):
    """(kind, faults): atlas, bound missed or refused, and what is wrong with it."""
    if os.path.exists(out):
        os.remove(out)
    command = [args.command, "unwrap", path, "-o", out, "--quiet", "--packing", args.packing, "--charts", args.charts]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode == 3:
        clear = os.path.basename(path) in done.stderr and not os.path.exists(out)
        return "refused", [] if clear else [f"the message does not name the file, or there is output: {done.stderr}"]
    if done.returncode not in (0, 5) or not os.path.exists(out):
        return "failed", [f"exit {done.returncode}: {done.stderr.strip()[-200:]}"]
    kind = "atlas" if done.returncode == 0 else "bound missed"
    measured = subprocess.run([args.command, "measure", out, "--json", "--exposure", "none"], capture_output=True, text=True)
    if measured.returncode:
        return kind, [f"measure: exit {measured.returncode}: {measured.stderr.strip()}"]
    faults = faults_of(json.loads(measured.stdout))
    if judge:
        try:
            faults += [f"judge: {fault}" for fault in faults_of(judge.evaluate(out, ao=False))]
        except Exception as error:
            faults.append(f"judge: {error!r}")
    return kind, faults


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("paths", nargs="+")
    parser.add_argument("--command", default=OURS)
    parser.add_argument("--packing", default="tight")
    parser.add_argument("--charts", default="few")
    parser.add_argument("--judge")
    args = parser.parse_args()
    judge = None
    if args.judge:
        spec = importlib.util.spec_from_file_location("judge", args.judge)
        judge = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(judge)
    counts, failed, start = {}, 0, time.time()
    with tempfile.TemporaryDirectory() as folder:
        for path in meshes(args.paths):
            kind, faults = check(path, os.path.join(folder, "out.obj"), args, judge)
            counts[kind] = counts.get(kind, 0) + 1
            failed += bool(faults)
            if faults or kind not in ("atlas", "refused"):
                print(f"{path}: {kind}: {', '.join(faults) or 'valid'}", flush=True)
    parts = ", ".join(f"{kind} {count}" for kind, count in sorted(counts.items()))
    print(f"{sum(counts.values())} meshes ({parts}), {failed} not valid, {time.time() - start:.0f} s")
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
