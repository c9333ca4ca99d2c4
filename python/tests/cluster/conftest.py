"""A small picture, and a cluster of three raylets on the loopback."""

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy
import pytest

from lightmesh import Image, Scene

# Before Ray is imported: no telemetry, no tokens that would outlive the test, and the last one keeps it to the loopback
os.environ["RAY_USAGE_STATS_ENABLED"] = "0"
os.environ["RAY_AUTH_MODE"] = "disabled"
os.environ["RAY_ENABLE_WINDOWS_OR_OSX_CLUSTER"] = "0"

#: Five waves, and a mesh that is filled in a second.
OPTIONS: dict[str, Any] = {
    "method": "mesh",
    # What short rays meet is found while the picture is drawn.
    "near_rays": 0,
    "size": (320, 256),
    "spp": 4,
    "bounces": 2,
    "spacing": "1/32",
    "indirect_spacing": "1/12",
    "gather_rays": 32,
}


@pytest.fixture(scope="session")
def scene_file() -> Path:
    return Path(__file__).parents[3] / "scenes" / "cornell.glb"


@pytest.fixture
def scene(scene_file: Path) -> Scene:
    return Scene.load(scene_file)


@pytest.fixture(scope="session")
def cluster() -> Iterator[str]:
    """The address of a head without workers and of two nodes with a core each."""
    pytest.importorskip("ray", reason="needs Ray: pip install 'lightmesh[ray]'")
    from ray.cluster_utils import Cluster

    node = {"object_store_memory": 100 << 20, "include_dashboard": False, "node_ip_address": "127.0.0.1"}
    made = Cluster(initialize_head=True, head_node_args={"num_cpus": 0, **node})
    for _ in range(2):
        made.add_node(num_cpus=1, **node)
    yield made.address
    made.shutdown()


def assert_same(image: Image, other: Image) -> None:
    """Bit for bit."""
    assert numpy.array_equal(numpy.asarray(image).view(numpy.uint32), numpy.asarray(other).view(numpy.uint32))
