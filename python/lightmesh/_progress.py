"""The bar that ``progress=True`` shows."""

import importlib
from typing import Any


#: What stages count that do not count samples.
UNITS = {"fill": " points", "save": "B"}


class Bar:
    """A callback that shows its reports in one bar after the other, one for each stage."""

    def __init__(self) -> None:
        try:
            self._make: Any = importlib.import_module("tqdm.auto").tqdm
        except ImportError as error:
            message = "progress=True shows a bar of tqdm, which is not installed: pip install 'lightmesh[progress]'"
            raise ImportError(message, name="tqdm") from error
        self._bar: Any = None
        self._stage = ""

    def __call__(self, stage: str, done: int, total: int, rays: int) -> None:
        if self._bar is None or stage != self._stage or total != self._bar.total:
            self.close()
            self._bar = self._make(total=total, desc=stage, unit=UNITS.get(stage, " samples"), unit_scale=True)
            self._stage = stage
        self._bar.set_postfix({"rays": f"{rays:.3g}"}, refresh=False)
        self._bar.update(done - self._bar.n)

    def close(self) -> None:
        """Ends the bar that is shown."""
        if self._bar is not None:
            self._bar.close()
            self._bar = None
