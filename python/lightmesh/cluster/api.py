"""The functions for users: a picture, frames, a baked mesh."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path
from typing import Any, TypeAlias

from numpy.typing import ArrayLike

from lightmesh._native import Image, LightMesh, Scene, __version__
from lightmesh.cluster.partition import TASKS_PER_WORKER
from lightmesh.cluster.job_store import JobStore
from lightmesh.cluster.job import GATHER_BYTES, CameraChoice, Pictures, describe
from lightmesh.cluster.plan import Plan
from lightmesh.cluster.progress import reporter
from lightmesh.cluster.task import Executor

Progress: TypeAlias = bool | Callable[[str, int, int, int], object] | None


@dataclass(frozen=True)
class Farm:
    """How a job is run. The pictures do not depend on it."""

    address: str | None = None
    """Of the cluster's head; None: RAY_ADDRESS, a cluster that runs on this machine, or a new one of its cores
    alone."""
    job: str | PathLike[str] | None = None
    """A folder that keeps what is done: the same job goes on there after its process has ended. None: nothing is
    kept."""
    threads: int | None = None
    """Of each worker; None: as many as the smallest node that takes part has cores."""
    memory: int | None = None
    """Bytes that Ray sets aside for each worker; None: none. A worker takes the scene, the mesh (max_memory at most)
    and gather_memory."""
    gather_memory: int = GATHER_BYTES
    """Bytes for gathered points that a worker keeps from one reflection to the next; those that do not fit are
    gathered for again."""
    tasks_per_worker: int = TASKS_PER_WORKER
    """Into how many tasks each stage is cut for each worker: more even out what they take, fewer are handed out
    sooner."""
    progress: Progress = None
    """True shows a bar (needs tqdm); or a function of (stage, done, total, rays): tasks of the whole job, as far as
    they are known."""
    stats: dict[str, Any] | None = None
    """A dict that is filled with statistics of the job: stages, workers with their memory, bytes."""
    executor: Executor | None = None
    """Does the tasks in place of a Ray cluster."""


def render(scene: Scene, address: str | None = None, *, camera: CameraChoice = None, **options: Any) -> Image:
    """Renders a picture on a cluster; the same, bit for bit, as `scene.render(camera=camera, ...)` with the same number of samples of
    every pixel: spp, or 4.

    options: those of `Scene.render`, and the fields of `Farm`.
    """
    ((_, image),) = render_frames(scene, [camera], address, **options)
    return image


def render_frames(
    scene: Scene, cameras: Sequence[CameraChoice], address: str | None = None, **options: Any
) -> Iterator[tuple[int, Image]]:
    """Renders a picture for each camera, with one light mesh for all; yields (number, picture) as they are done.

    options: as for `render`. Work begins when the first picture is asked for.
    """
    with _plan(scene, cameras, "frames", address, options) as plan:
        plan.fill()
        yield from plan.pictures()


def bake(
    scene: Scene,
    address: str | None = None,
    *,
    cameras: Sequence[CameraChoice] = (None,),
    region: ArrayLike | None = None,
    **options: Any,
) -> LightMesh:
    """Fills a light mesh with all that pictures by these cameras read, and returns it.

    region: the least and the largest corner of a box, (2, 3), metres, in which all mesh points are filled as well; by
    this process alone, when the cameras are done.
    options: as for `render`, with a method that has a mesh; "mesh" if none is given, as of `LightMesh`.
    """
    if not options.keys() & {"method", "error", "quality"}:
        options = {**options, "method": "mesh"}
    with _plan(scene, cameras, "bake", address, options) as plan:
        plan.fill()
        plan.absorb()
        if region is not None:
            plan.mesh.fill(region=region)
        return plan.mesh


@contextmanager
def _plan(
    scene: Scene, cameras: Sequence[CameraChoice], what: str, address: str | None, options: dict[str, Any]
) -> Iterator[Plan]:
    """Prepares a job. Yields its plan, and releases everything at the end."""
    farm_options = {name: options.pop(name) for name in list(options) if name in Farm.__dataclass_fields__}
    farm = Farm(address=address, **farm_options)
    mesh: LightMesh | None = options.pop("mesh", None)
    with ExitStack() as ends:
        report, close_bar = reporter(farm.progress)
        ends.callback(close_bar)
        # What is wrong with the picture is said before a cluster is looked for
        job = describe(scene, cameras, options, mesh, gather_bytes=farm.gather_memory)
        pictures = Pictures(job, scene, cameras, mesh)
        first = pictures.any()
        executor = farm.executor or _ray(farm)
        ends.callback(executor.close)
        job = replace(job, threads=executor.threads)
        tasks = farm.tasks_per_worker * executor.workers
        folder = None
        if farm.job is not None:
            folder = JobStore(Path(farm.job))
            ends.callback(folder.close)
            manifest = {
                "version": __version__,
                "fingerprint": job.fingerprint(first),
                "what": f"{what}, {len(cameras)} cameras, {first.options_json}",
                "tasks_per_stage": tasks,
            }
            # Cut as it was, so that what is done fits
            tasks = folder.open(manifest)["tasks_per_stage"]
        plan = Plan(
            pictures, executor.share(job, job.bytes), executor, tasks_per_stage=tasks, folder=folder, report=report
        )
        yield plan
        if mesh is not None:
            plan.absorb()
        if farm.stats is not None:
            farm.stats.update(plan.timings.summary())


def _ray(farm: Farm) -> Executor:
    from lightmesh.cluster.ray_backend import RayExecutor

    return RayExecutor(farm.address, threads=farm.threads, memory=farm.memory)
