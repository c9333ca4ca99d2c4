"""Job folders: they keep the results of tasks when the process that wanted them ends.

    manifest.json    which job it is, and how it was cut into tasks
    tasks.jsonl      time, memory and bytes of each task, one a line
    KIND/REST.npz    the result of the task with the key KIND-REST

Files appear whole or not at all.
"""

import fcntl
import json
import os
import shutil
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import IO, Any

import numpy

from lightmesh.cluster.errors import JobInUseError, JobMismatchError
from lightmesh.cluster.task import Result, Task

#: Of the folder's files; one with another is not read.
_FORMAT = 1


class JobStore:
    """A folder that holds one job, for one process at a time."""

    def __init__(self, path: Path) -> None:
        """path: is made if it does not exist. A folder that holds something else is refused."""
        self.path = path
        path.mkdir(parents=True, exist_ok=True)
        if not self._manifest.exists() and any(entry.name not in ("lock", "tasks.jsonl") for entry in path.iterdir()):
            raise JobMismatchError(f"{path} is no job folder, and not empty: choose another one")
        self._lock = self._lock_or_raise()
        self._log: IO[str] = (path / "tasks.jsonl").open("a", encoding="utf-8")

    def open(self, manifest: Mapping[str, Any]) -> dict[str, Any]:
        """Goes on with a job or begins it; returns the manifest of the folder, which is this one if it is new.

        manifest: "fingerprint" says which job it is, "what" says it in words.
        """
        manifest = {"format": _FORMAT, **manifest}
        try:
            found: dict[str, Any] = json.loads(self._manifest.read_text(encoding="utf-8"))
        except FileNotFoundError:
            self._write(self._manifest, json.dumps(manifest, indent=1).encode())
            return dict(manifest)
        if any(found.get(key) != manifest[key] for key in ("format", "version", "fingerprint")):
            was = f"{found.get('what')}, by lightmesh {found.get('version')}"
            now = f"{manifest['what']}, by lightmesh {manifest['version']}"
            raise JobMismatchError(
                f"{self.path} holds another job ({was}) than this one ({now}): its scene, options or cameras are others. "
                "Choose another folder, or delete it to begin anew"
            )
        return found

    def has(self, task: Task) -> bool:
        """Whether the task has been done."""
        return self._file(task).exists()

    def read(self, task: Task) -> Result | None:
        """Reads the result of a task. None if its file cannot be read; the file is deleted then."""
        file = self._file(task)
        try:
            with numpy.load(file, allow_pickle=False) as arrays:
                return {name: value if value.ndim else value.item() for name, value in arrays.items()}
        except (OSError, ValueError, EOFError, zipfile.BadZipFile):
            file.unlink(missing_ok=True)
            return None

    def write(self, task: Task, result: Result) -> None:
        """Writes the result of a task."""
        file = self._file(task)
        file.parent.mkdir(exist_ok=True)
        temporary = file.with_suffix(".tmp")
        with temporary.open("wb") as out:
            arrays: dict[str, Any] = {name: numpy.asarray(value) for name, value in result.items()}
            numpy.savez(out, **arrays)
        temporary.replace(file)

    def note(self, entry: Mapping[str, Any]) -> None:
        """Adds a line to tasks.jsonl."""
        self._log.write(json.dumps(entry) + "\n")
        self._log.flush()

    def close(self) -> None:
        """Releases the folder for other processes."""
        self._log.close()
        os.close(self._lock)

    def remove(self) -> None:
        """Deletes the folder, after it is closed."""
        shutil.rmtree(self.path)

    @property
    def _manifest(self) -> Path:
        return self.path / "manifest.json"

    def _file(self, task: Task) -> Path:
        kind, rest = task.key.split("-", 1)
        return self.path / kind / f"{rest}.npz"

    @staticmethod
    def _write(file: Path, data: bytes) -> None:
        temporary = file.with_suffix(".tmp")
        temporary.write_bytes(data)
        temporary.replace(file)

    def _lock_or_raise(self) -> int:
        lock = os.open(self.path / "lock", os.O_RDWR | os.O_CREAT, 0o666)
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(lock)
            raise JobInUseError(f"another process works in {self.path}") from error
        return lock
