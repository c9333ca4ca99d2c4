"""How far a job is."""

import importlib
from collections.abc import Callable
from typing import Any

from lightmesh.cluster.plan import Report


def reporter(progress: bool | Report | None) -> tuple[Report | None, Callable[[], object]]:
    """Who hears of the progress, and what ends that."""
    if progress is True:
        bar = _JobBar()
        return bar, bar.close
    return progress or None, lambda: None


class _JobBar:
    """One bar for the whole job. It may step back, where tasks become known."""

    def __init__(self) -> None:
        try:
            make: Any = importlib.import_module("tqdm.auto").tqdm
        except ImportError as error:
            message = "progress=True shows a bar of tqdm, which is not installed: pip install 'lightmesh[progress]'"
            raise ImportError(message, name="tqdm") from error
        self._bar: Any = make(total=0, unit=" tasks")

    def __call__(self, stage: str, done: int, total: int, rays: int) -> None:
        self._bar.total = total
        self._bar.set_description(stage, refresh=False)
        self._bar.set_postfix({"rays": f"{rays:.3g}"}, refresh=False)
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """Leaves the bar as it is."""
        self._bar.close()
