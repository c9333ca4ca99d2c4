"""What can go wrong with a job, beside what can go wrong with a picture."""

from lightmesh.errors import Error


class ClusterError(Error):
    """A cluster that cannot do the job, or workers that failed."""


class JobMismatchError(ClusterError):
    """The job folder holds another job than the one that was asked for."""


class JobInUseError(ClusterError):
    """Another process works in the job folder."""


class RayMissingError(Error, ImportError):
    """Ray is not installed."""

    def __init__(self) -> None:
        super().__init__(
            "rendering on a cluster needs Ray, which is not installed: pip install 'lightmesh[ray]'", name="ray"
        )
