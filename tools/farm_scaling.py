"""How `lightmesh.cluster` scales on one machine: a cluster of raylets with a core each on the loopback, with 1, 2, …
of them.

    python tools/farm_scaling.py scenes/room_15.glb --workers 1,2 --keep jobs -- --size 1280x800 --spp 16

Prints what a task costs that does nothing; then, for each number of workers, the time of the picture beside the local
one with as many threads, medians of --runs, and bytes that a worker gets and gives. --keep leaves a job folder for
each, for `python -m lightmesh.cluster.simulate`.
"""

import argparse
import os
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
os.environ["RAY_AUTH_MODE"] = "disabled"
os.environ["RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"] = "0"

import numpy
import ray
from ray.cluster_utils import Cluster

from lightmesh import Scene
from lightmesh.cluster import render, worker
from lightmesh.cluster.job_store import JobStore
from lightmesh.cluster.ray_backend import RayExecutor
from lightmesh.cluster.task import Outcome, Shared, Task

EMPTY_TASKS = 2000


def nothing(job: Shared, task: Task, fetch: worker.Fetch, node: str) -> Outcome:
    """A task that does nothing."""
    return Outcome({}, node, 0, 0.0, 0.0, 0.0, 0.0, 0, 0, 0)


def seconds_per_task() -> tuple[float, float]:
    """Of tasks that do nothing: from one to the next, and processor time of this process for each."""
    executor = RayExecutor(threads=1, execute=nothing)
    shared = executor.share({}, 0)
    found = []
    for _ in range(2):
        tasks = [Task("waves", "nothing", "waves-0", (), 1, 1)] * EMPTY_TASKS
        started, processor = time.perf_counter(), time.process_time()
        for _ in executor.run(shared, lambda rest=iter(tasks): next(rest, None)):
            pass
        found.append((time.perf_counter() - started, time.process_time() - processor))
    # The first round starts the processes
    wall, processor = found[1]
    return wall / EMPTY_TASKS, processor / EMPTY_TASKS


def seconds_to_keep() -> float:
    """Processor time of this process for the result of a wave of 8192 pixels that goes into a job folder."""
    task, result = Task("waves", "", "waves-0", (), 1, 1), {"values": numpy.zeros(8192 * 3, numpy.float32)}
    with tempfile.TemporaryDirectory() as path:
        folder = JobStore(Path(path))
        started = time.process_time()
        for _ in range(200):
            folder.write(task, result)
            folder.note({"stage": "render"})
        folder.close()
        return (time.process_time() - started) / 200


def picture(scene: Scene, options: dict[str, Any], runs: int, keep: Path | None) -> dict[str, float]:
    """Medians of a picture on the cluster: seconds, and bytes in and out of a worker."""
    found = []
    for run in range(runs):
        stats: dict[str, Any] = {}
        started = time.perf_counter()
        render(scene, stats=stats, job=None if keep is None or run else keep, **options)
        workers = stats["workers"]
        found.append(
            {
                "seconds": time.perf_counter() - started,
                "processor": sum(each["processor_seconds"] for each in workers),
                "tasks": sum(stage["tasks"] for stage in stats["stages"]),
                "in": statistics.mean(each["bytes_in"] for each in workers),
                "out": statistics.mean(each["bytes_out"] for each in workers),
                "setup": statistics.mean(each["setup_seconds"] for each in workers),
                "peak": max(each["peak_bytes"] for each in workers),
            }
        )
    return {name: statistics.median(each[name] for each in found) for name in found[0]}


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__.split("\n")[0], epilog="Options of the picture follow after --."
    )
    parser.add_argument("scene", type=Path)
    parser.add_argument("--workers", default="1,2")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--keep", type=Path)
    given = sys.argv[1:]
    end = given.index("--") if "--" in given else len(given)
    args, words = parser.parse_args(given[:end]), given[end + 1 :]
    options = {name[2:].replace("-", "_"): value for name, value in zip(words[::2], words[1::2], strict=True)}
    scene = Scene.load(args.scene)
    print(
        "workers | local s | its processor s | farm s | its processor s | efficiency | tasks | in MB | out MB | set up s | peak MB | empty task ms | of it driver ms | to keep a result ms"
    )
    alone = 0.0
    for workers in map(int, args.workers.split(",")):
        local, local_processor = [], []
        for _ in range(args.runs):
            started, processor = time.perf_counter(), time.process_time()
            scene.render(threads=workers, **options)
            local.append(time.perf_counter() - started)
            local_processor.append(time.process_time() - processor)
        node = {"object_store_memory": 500 << 20, "include_dashboard": False, "node_ip_address": "127.0.0.1"}
        cluster = Cluster(initialize_head=True, head_node_args={"num_cpus": 0, **node})
        for _ in range(workers):
            cluster.add_node(num_cpus=1, **node)
        ray.init(address=cluster.address, log_to_driver=False, logging_level="ERROR")
        wall, processor = seconds_per_task()
        keep = args.keep / f"workers-{workers}.job" if args.keep else None
        took = picture(scene, options, args.runs, keep)
        ray.shutdown()
        cluster.shutdown()
        alone = alone or took["seconds"] * workers
        print(
            f"{workers} | {statistics.median(local):.2f} | {statistics.median(local_processor):.2f} | {took['seconds']:.2f}"
            f" | {took['processor']:.2f} | {alone / workers / took['seconds']:.0%}"
            f" | {took['tasks']:.0f} | {took['in'] / 1e6:.1f} | {took['out'] / 1e6:.1f} | {took['setup']:.2f}"
            f" | {took['peak'] / 1e6:.0f} | {wall * 1e3:.2f} | {processor * 1e3:.2f}"
            f" | {seconds_to_keep() * 1e3:.2f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
