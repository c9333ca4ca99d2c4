"""Job folders outlive the process that fills them."""

from pathlib import Path
from typing import Any

import numpy
import pytest

from lightmesh.cluster import JobInUseError, JobMismatchError
from lightmesh.cluster.job_store import JobStore
from lightmesh.cluster.task import Task

MANIFEST: dict[str, Any] = {"version": "1", "fingerprint": "abc", "what": "a picture", "tasks_per_stage": 40}
TASK = Task("waves", "frame 0 waves 0-3", "waves-0-0-4", (0, 0, 4), 4, 4)


def test_results_and_the_first_manifest_stay(tmp_path: Path) -> None:
    folder = JobStore(tmp_path / "job")
    assert folder.open(MANIFEST)["tasks_per_stage"] == 40
    assert not folder.has(TASK)
    folder.write(TASK, {"values": numpy.arange(3, dtype=numpy.float32), "first": 5, "stats": '{"rays": 1}'})
    folder.close()

    again = JobStore(tmp_path / "job")
    assert again.open(MANIFEST | {"tasks_per_stage": 20})["tasks_per_stage"] == 40
    found = again.read(TASK)
    assert found is not None
    assert found["values"].tolist() == [0, 1, 2]
    assert (found["first"], found["stats"]) == (5, '{"rays": 1}')


def test_half_a_file_is_none(tmp_path: Path) -> None:
    folder = JobStore(tmp_path)
    folder.open(MANIFEST)
    folder.write(TASK, {"values": numpy.zeros(1000)})
    (file,) = (tmp_path / "waves").iterdir()
    file.write_bytes(file.read_bytes()[:-500])
    assert folder.has(TASK)
    assert folder.read(TASK) is None
    assert not folder.has(TASK)


def test_another_job_is_refused(tmp_path: Path) -> None:
    folder = JobStore(tmp_path)
    folder.open(MANIFEST)
    with pytest.raises(JobMismatchError, match=r"another job \(a picture, by lightmesh 1\)"):
        folder.open(MANIFEST | {"fingerprint": "def"})


def test_one_process_at_a_time(tmp_path: Path) -> None:
    folder = JobStore(tmp_path)
    with pytest.raises(JobInUseError):
        JobStore(tmp_path)
    folder.close()
    JobStore(tmp_path).close()


def test_a_folder_of_something_else_is_refused(tmp_path: Path) -> None:
    (tmp_path / "holiday.txt").write_text("")
    with pytest.raises(JobMismatchError, match="no job folder"):
        JobStore(tmp_path)
