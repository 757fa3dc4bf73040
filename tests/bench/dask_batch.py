"""docs/dask_batch.py on two local workers, one of which is killed on the way: the outputs are those of one plain run.

    python tests/bench/dask_batch.py MESHES... [--program target/release/seamwright] [--shares 16] [--after 3]

Needs `distributed` from PyPI.
"""

import argparse
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, str(pathlib.Path(__file__).parents[2] / "docs"))
from dask.distributed import Client, LocalCluster, as_completed  # noqa: E402
from dask_batch import share  # noqa: E402


def outputs(folder):
    paths = pathlib.Path(folder).rglob("*")
    names = {p.relative_to(folder): p for p in paths if p.is_file() and ".seamwright" not in p.parts}
    return {str(name): path.read_bytes() for name, path in names.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("meshes", nargs="+")
    parser.add_argument("--program", default="target/release/seamwright")
    parser.add_argument("--shares", type=int, default=16)
    parser.add_argument("--after", type=float, default=3.0, help="seconds until a worker is killed")
    args = parser.parse_args()
    program = str(pathlib.Path(args.program).resolve())
    with tempfile.TemporaryDirectory() as folder:
        client = Client(LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None))
        given = (args.shares, program, args.meshes, f"{folder}/dask", [])
        tasks = [client.submit(share, rank, *given, pure=False, retries=3) for rank in range(args.shares)]
        time.sleep(args.after)
        unfinished = sum(not task.done() for task in tasks)
        victim = client.run(os.getpid)
        os.kill(sorted(victim.values())[0], signal.SIGKILL)
        lines = [line for task in as_completed(tasks) for line in task.result().splitlines()]
        client.close()
        plain = subprocess.run([program, "batch", *args.meshes, "-o", f"{folder}/plain"], stdout=subprocess.PIPE, check=False)
        ours, theirs = outputs(f"{folder}/dask"), outputs(f"{folder}/plain")
        same = ours == theirs
        print(f"{unfinished} of {args.shares} shares unfinished when a worker was killed; {len(lines)} lines for "
              f"{len(plain.stdout.splitlines())}; {len(ours)} outputs, {'the same bytes' if same else 'OTHER BYTES'}")
        sys.exit(not same)


if __name__ == "__main__":
    main()
