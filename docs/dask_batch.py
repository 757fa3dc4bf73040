"""Unwraps folders of meshes on a Dask cluster: each task is a share of the files, and prints its lines as it ends."""

import argparse
import subprocess

from dask.distributed import Client, LocalCluster, as_completed


def share(rank, size, program, inputs, output, more):
    ranks = ["--rank", str(rank), "--world-size", str(size)]
    command = [program, "batch", *inputs, "-o", output, "--resume", *ranks, *more]
    return subprocess.run(command, stdout=subprocess.PIPE, check=False).stdout.decode()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("inputs", nargs="+")
    parser.add_argument("output")
    parser.add_argument("--scheduler", help="address; without it two local workers are started")
    parser.add_argument("--shares", type=int, default=64)
    parser.add_argument("--program", default="seamwright")
    args, more = parser.parse_known_args()
    client = Client(args.scheduler or LocalCluster(n_workers=2, threads_per_worker=1))
    given = (args.shares, args.program, args.inputs, args.output, more)
    tasks = [client.submit(share, rank, *given, pure=False, retries=3) for rank in range(args.shares)]
    for task in as_completed(tasks):
        print(task.result(), end="", flush=True)
