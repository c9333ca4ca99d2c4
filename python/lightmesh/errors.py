"""What lightmesh raises; files that cannot be read or written raise Python's own, such as FileNotFoundError."""


class Error(Exception):
    """Anything that lightmesh cannot do."""


class SceneError(Error, ValueError):
    """A scene, an array or a picture is not what it should be."""


class OptionError(Error, ValueError):
    """An option does not exist, is outside its range or contradicts another."""


class MemoryLimitError(Error, MemoryError):
    """The work would take more memory than max_memory; nothing was allocated."""
