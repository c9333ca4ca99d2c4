"""The examples, as scripts, quick: they end well, say what they check, and write their figures."""

import os
import re
import subprocess
import sys
from pathlib import Path

import matplotlib.image
import pytest

from conftest import REPOSITORY


def run(name: str, out: Path) -> str:
    """What examples/NAME.py --quick prints."""
    command = [sys.executable, str(REPOSITORY / "examples" / f"{name}.py"), "--quick", "--out", str(out)]
    # From another folder than the repository's, and without a display.
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=300, cwd=out, env={**os.environ, "MPLBACKEND": "Agg"}
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Warning" not in done.stderr, done.stderr
    return done.stdout


def seen(folder: Path) -> dict[str, tuple[int, ...]]:
    """Figures that can be read, with their height and width."""
    return {file.name: matplotlib.image.imread(file).shape[:2] for file in sorted(folder.iterdir())}


def test_light_study(tmp_path: Path) -> None:
    said = run("light_study", tmp_path)
    figures = seen(tmp_path)
    assert list(figures) == ["isolines.png", "light_study.jpg", "slice.png"]
    assert all(min(size) >= 300 for size in figures.values())
    # EN 12464-1: 6.2 m x 4.4 m need points 0.2 * 5^(log10 6.2) = 0.72 m apart, at most.
    assert "p = 0.72 m at most, 9 x 7 points" in said
    alone, reflected = (
        [float(value) for value in re.findall(rf"^{name} +(\d+) +(\d+) +([\d.]+)$", said, re.MULTILINE)[0]]
        for name in ("lamps alone", "with reflected light")
    )
    assert reflected[0] > alone[0] > alone[1] > 0
    for mean, least, uniformity in (alone, reflected):
        assert uniformity == pytest.approx(least / mean, abs=0.01)
    # F / 4 pi / h^2 for 4400 lm at 2 m.
    assert "87.54 lx below the lamp, measured 87.54 lx" in said
    assert "path tracer: 7 of 7 points" in said


def test_many_lights(tmp_path: Path) -> None:
    said = run("many_lights", tmp_path)
    assert list(seen(tmp_path)) == ["convergence.png", "many_lights.png"]
    assert said.startswith("100 lights, 5014 triangles")
    for method in ("standard", "mesh", "hybrid", "unbiased", "path"):
        assert len(re.findall(rf"^{method} .*%$", said, re.MULTILINE)) >= 2
    assert re.search(r"^mesh, error= +error=0.1", said, re.MULTILINE)
    assert len(re.findall("the last is the best", said)) == 2


@pytest.mark.parametrize("name", ["light_study", "many_lights"])
def test_cells_are_marked(name: str) -> None:
    """Jupyter and VS Code tell cells of text and of code apart, and text is comments."""
    cells = re.split(r"^# %%", (REPOSITORY / "examples" / f"{name}.py").read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert cells[0] == "" and cells[1].startswith(" [markdown]")
    for cell in cells[1:]:
        head, *lines = cell.split("\n")
        if head.strip() == "[markdown]":
            assert all(not line or line.startswith("#") for line in lines), head
        else:
            compile("\n".join(lines), name, "exec")
