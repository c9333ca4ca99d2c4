"""What is said where Ray is not installed."""

import sys

import pytest

from lightmesh import Scene
from lightmesh.cluster import RayMissingError, render
from lightmesh.farm import main


@pytest.fixture(autouse=True)
def no_ray(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ray", None)
    monkeypatch.delitem(sys.modules, "lightmesh.cluster.ray_backend", raising=False)


def test_a_cluster_needs_ray(scene: Scene) -> None:
    with pytest.raises(
        ImportError, match=r"needs Ray, which is not installed: pip install 'lightmesh\[ray\]'"
    ) as raised:
        render(scene)
    assert raised.type is RayMissingError


def test_so_does_the_command_line(scene_file: str, tmp_path: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", str(scene_file), "-o", f"{tmp_path}/a.png", "--quiet"]) == 2
    assert capsys.readouterr().err == (
        "error: rendering on a cluster needs Ray, which is not installed: pip install 'lightmesh[ray]'\n"
    )
