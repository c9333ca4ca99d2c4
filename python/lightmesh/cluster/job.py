"""What is rendered or baked: all that a worker has to know, fit to travel."""

import hashlib
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy

from lightmesh._native import Camera, LightMesh, PictureJob, Scene, __version__
from lightmesh.cluster.task import Array

#: A camera, the name or index of one of the scene's, or None: its first.
CameraChoice: TypeAlias = Camera | str | int | None

#: Bytes of gathered points that a worker keeps from one reflection to the next, unless it is told otherwise.
GATHER_BYTES = 2 << 30

#: Methods that fill no mesh.
_WITHOUT_MESH = ("standard", "exact", "path")

#: Options for which the whole picture is looked at before it is made.
_LOOKS_AT_ALL = ("error", "refine", "lod_distance", "graded")


@dataclass(frozen=True)
class Job:
    """Pictures of one scene."""

    version: str
    """Of lightmesh. Workers refuse another one: its pictures may differ."""
    scene: Array
    """`Scene.to_bytes`, uint8."""
    cameras: tuple[str | int | None, ...]
    """One for each frame: its name or index in the scene."""
    options: Mapping[str, Any]
    """Those of `Scene.render` that were given; what is not said here is the mesh's, where there is one to begin
    with."""
    mesh: Array | None
    """The file of the light mesh that the pictures begin with, uint8; None: an empty one."""
    threads: int | None
    """Of each worker; None: one for each core."""
    gather_bytes: int
    """Memory for gathered points that a worker keeps from one reflection to the next."""

    @property
    def has_mesh(self) -> bool:
        """Whether there is a light mesh to fill."""
        return self.options.get("method") not in _WITHOUT_MESH

    @property
    def bytes(self) -> int:
        """What travels."""
        return self.scene.nbytes + (0 if self.mesh is None else self.mesh.nbytes)

    def fingerprint(self, first: PictureJob) -> str:
        """Tells this job from others; `first` is its first picture."""
        digest = hashlib.sha256(f"{first.fingerprint} {self.cameras!r} {first.options_json}".encode())
        digest.update(self.scene.data)
        return digest.hexdigest()


def describe(
    scene: Scene,
    cameras: Sequence[CameraChoice],
    options: Mapping[str, Any],
    mesh: LightMesh | None = None,
    gather_bytes: int = GATHER_BYTES,
) -> Job:
    """The job of these pictures, for workers with a thread for each core. Cameras that are not the scene's go into a
    copy of it."""
    theirs = scene
    if any(isinstance(camera, Camera) for camera in cameras):
        theirs = Scene.from_bytes(scene.to_bytes())
    names = tuple(theirs.add_camera(camera) if isinstance(camera, Camera) else camera for camera in cameras)
    data = numpy.frombuffer(theirs.to_bytes(), dtype=numpy.uint8)
    chosen = {name: value for name, value in options.items() if value is not None}
    return Job(__version__, data, names, chosen, None if mesh is None else mesh_to_bytes(mesh), None, gather_bytes)


class Pictures:
    """The pictures of a job in one process, with the light mesh that they share."""

    def __init__(
        self,
        job: Job,
        scene: Scene | None = None,
        cameras: Sequence[CameraChoice] | None = None,
        mesh: LightMesh | None = None,
    ) -> None:
        """scene, cameras, mesh: what the job was made of, where that is at hand."""
        self.job = job
        self._scene = scene or Scene.from_bytes(job.scene.tobytes())
        self._cameras = job.cameras if cameras is None else cameras
        if mesh is None and job.mesh is not None:
            mesh = mesh_from_bytes(self._scene, job.mesh, {**job.options, "threads": job.threads})
        if mesh is None and job.has_mesh:
            # No method: that of a picture.
            options = {"method": None, **job.options}
            mesh = LightMesh(self._scene, cameras=list(self._cameras), threads=job.threads, **options)
        self.mesh = mesh
        self._last: tuple[int, int | None, PictureJob] | None = None

    def __len__(self) -> int:
        return len(self._cameras)

    def __getitem__(self, frame: int) -> PictureJob:
        """One of them. The mesh is ready for one at a time, so only the last that was asked for is kept."""
        return self._picture(frame, None)

    def sketch(self, frame: int) -> PictureJob:
        """The same with a sample per pixel, which reads nearly the same mesh points. Itself, where all samples decide
        about the mesh."""
        options = self.job.options
        decides = options.get("method", "auto") == "auto" or any(options.get(name) for name in _LOOKS_AT_ALL)
        return self._picture(frame, None if decides else 1)

    def any(self) -> PictureJob:
        """The last one that was asked for, or the first."""
        return self._last[2] if self._last else self[0]

    def _picture(self, frame: int, spp: int | None) -> PictureJob:
        if self._last is None or self._last[:2] != (frame, spp):
            options = {**self.job.options, **({} if spp is None else {"spp": spp})}
            camera, threads = self._cameras[frame], self.job.threads
            picture = PictureJob(self._scene, camera=camera, mesh=self.mesh, threads=threads, **options)
            self._last = (frame, spp, picture)
        return self._last[2]


def mesh_to_bytes(mesh: LightMesh) -> Array:
    """The file that `LightMesh.save` writes."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "mesh"
        mesh.save(file)
        return numpy.fromfile(file, dtype=numpy.uint8)


def mesh_from_bytes(scene: Scene, data: Array, options: Mapping[str, Any]) -> LightMesh:
    """The mesh of such a file, with the file's settings where options do not say otherwise."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "mesh"
        data.tofile(file)
        return LightMesh.load(file, scene, **options)
