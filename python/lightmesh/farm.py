"""``lightmesh farm``: pictures, frames and baked meshes by many machines, with the options of ``lightmesh render``.

Exit codes: 0 done; 1 failed while working; 2 bad input or usage; 130 interrupted.
"""

import argparse
import json
import os
import re
import shutil
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from lightmesh._native import Camera, Image, LightMesh, Scene, _options, _write_file
from lightmesh.cluster import bake, render_frames
from lightmesh.cluster.partition import TASKS_PER_WORKER
from lightmesh.cluster.job import GATHER_BYTES, CameraChoice
from lightmesh.cluster.local import LocalExecutor
from lightmesh.errors import Error, MemoryLimitError, OptionError, SceneError

#: Options of reading the scene, and those that are said otherwise here.
_OF_LOADING = ("scene", "units", "allow_outside")
_ELSEWHERE = ("camera", "threads", "time_limit", *_OF_LOADING)

_UNITS = {"": 1, "KiB": 1 << 10, "MiB": 1 << 20, "GiB": 1 << 30, "TiB": 1 << 40}


def main(arguments: Sequence[str]) -> int:
    """Runs the command with what follows `lightmesh farm`; returns its exit code."""
    try:
        args = _parser().parse_args(arguments)
    except SystemExit as end:
        return int(end.code or 0)
    try:
        _run(args)
    except KeyboardInterrupt:
        return _fail("interrupted" + _resumes(args), 130)
    except (OptionError, SceneError, FileNotFoundError, IsADirectoryError) as error:
        return _fail(str(error), 2)
    except MemoryLimitError as error:
        return _fail(str(error), 2)
    except (Error, OSError) as error:
        return _fail(str(error), 2 if isinstance(error, ImportError) else 1)
    return 0


def _run(args: argparse.Namespace) -> None:
    _check_outputs(args)
    scene = Scene.load(args.scene_file, **_chosen(args, _OF_LOADING), **_chosen(args, ("max_memory",)))
    for warning in scene.warnings:
        _say(args, f"warning: {warning}")
    frames = [0] if args.command != "frames" else range(len(_cameras(scene, args.cameras)))
    outputs = [("--output", file) for frame in frames for file in _files(args, frame)]
    _check_places([*outputs, *_stats(args)], [("a file of the scene,", file) for file in scene.files])
    job = _job(args)
    stats: dict[str, Any] = {}
    chosen = _chosen(args, [option["name"] for option in _options() if option["name"] not in _ELSEWHERE])
    options: dict[str, Any] = {
        **chosen,
        "address": args.address,
        "job": job,
        "threads": args.threads,
        "memory": args.worker_memory,
        "gather_memory": args.gather_memory,
        "tasks_per_worker": args.tasks_per_worker,
        "progress": not args.quiet and sys.stderr.isatty(),
        "stats": stats,
        "executor": LocalExecutor(threads=args.threads) if args.here else None,
    }
    if getattr(args, "mesh", None) is not None:
        options["mesh"] = LightMesh.load(args.mesh, scene, **chosen)
    if args.command == "bake":
        cameras, region = _cameras(scene, args.cameras), args.region
        bake(scene, cameras=cameras, region=region, **options).save(args.output[0])
        _say(args, f"wrote {args.output[0]}")
    else:
        cameras = [args.camera] if args.command == "render" else _cameras(scene, args.cameras)
        for frame, image in render_frames(scene, cameras, **options):
            for file in _files(args, frame):
                _save(args, image, file)
    if args.stats:
        _write_file(args.stats, (json.dumps(stats, indent=1) + "\n").encode())
    _say(args, _workers_in_words(stats))
    if not args.keep_job:
        shutil.rmtree(job)


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="lightmesh farm", description="Pictures, frames and baked meshes by many machines, on a Ray cluster."
    )
    commands = parser.add_subparsers(dest="command", required=True)
    for command, says in (
        ("render", "one picture: that of `lightmesh render`, bit for bit"),
        ("frames", "a picture for each of several cameras, with one light mesh for all"),
        ("bake", "a light mesh with all that pictures by some cameras read"),
    ):
        one = commands.add_parser(command, help=says, description=says, allow_abbrev=False)
        one.add_argument("scene_file", metavar="SCENE", type=Path, help="scene file: .gltf, .glb, .obj or .ply")
        _add_files(one, command)
        _add_farm(one)
        options = one.add_argument_group("options of `lightmesh render`, whose --help says what they are")
        if command == "render":
            options.add_argument("--camera", metavar="VALUE")
        for name in ("scene", "units"):
            options.add_argument("--" + name, metavar="VALUE")
        options.add_argument("--allow-outside", action="store_const", const=True)
        for option in _options():
            if option["name"] in _ELSEWHERE:
                continue
            names = [option["name"], *([option["old_name"]] if option["old_name"] else [])]
            flags = ["--" + name.replace("_", "-") for name in names]
            default = option["default"]
            options.add_argument(*flags, metavar="VALUE", help=f"default: {default}" if default else None)
    return parser


def _add_files(parser: argparse.ArgumentParser, command: str) -> None:
    said = {
        "render": ".png or .exr to write; may be given several times",
        "frames": ".png or .exr to write, with #### where the frame's number goes; may be given several times",
        "bake": "light mesh to write",
    }
    parser.add_argument("-o", "--output", metavar="FILE", action="append", required=True, help=said[command])
    if command != "bake":
        parser.add_argument("--exposure", metavar="EV|auto", default="auto", help="of PNG files (default: auto)")
        parser.add_argument("--half", action="store_true", help="16-bit floats in EXR files")
        parser.add_argument("--mesh", metavar="FILE", type=Path, help="light mesh to begin with, as bake writes it")
    if command == "bake":
        parser.add_argument(
            "--region",
            metavar="X,Y,Z,X,Y,Z",
            type=_region,
            help="least and largest corner of a box, metres, in which all mesh points are filled as well",
        )
    if command != "render":
        parser.add_argument(
            "--cameras",
            metavar="all|NAME,NAME|FILE.json",
            default="all",
            help="cameras of the scene by name or index, or of a file: a list of objects with eye, target and, if need "
            "be, up, yfov and aspect, or with world_from_camera in place of the first three (default: all)",
        )
    parser.add_argument("--stats", metavar="FILE", type=Path, help="write stages, workers and bytes as JSON")
    parser.add_argument("-q", "--quiet", action="store_true", help="say nothing but errors")


def _add_farm(parser: argparse.ArgumentParser) -> None:
    farm = parser.add_argument_group("farm")
    farm.add_argument(
        "--address",
        help="of the cluster's head (default: RAY_ADDRESS, a cluster that runs here, or a new one of this machine's cores)",
    )
    farm.add_argument(
        "--here", action="store_true", help="do the tasks in this process, one after the other, without Ray"
    )
    farm.add_argument(
        "--job",
        metavar="FOLDER",
        type=Path,
        help="keeps what is done, so that the same command goes on where it was ended (default: the first output's, .job)",
    )
    farm.add_argument("--keep-job", action="store_true", help="leave that folder when all is done")
    farm.add_argument(
        "--threads",
        metavar="N",
        type=int,
        help="cores of a worker (default: those of the smallest node that has at least half of the largest one's)",
    )
    farm.add_argument(
        "--tasks-per-worker",
        metavar="N",
        type=int,
        default=TASKS_PER_WORKER,
        help="into how many tasks each stage is cut for each worker (default: 20)",
    )
    farm.add_argument(
        "--worker-memory",
        metavar="BYTES",
        type=_bytes,
        help="that Ray sets aside for each worker, as in 8GiB (default: none)",
    )
    farm.add_argument(
        "--gather-memory",
        metavar="BYTES",
        type=_bytes,
        default=GATHER_BYTES,
        help="for gathered points that a worker keeps between reflections (default: 2GiB)",
    )


def _job(args: argparse.Namespace) -> Path:
    """The job folder. Numbers of frames are no part of its name."""
    return args.job or Path(re.sub("#+", "", args.output[0]).replace("..", ".") + ".job")


def _cameras(scene: Scene, which: str) -> list[CameraChoice]:
    """The cameras that --cameras names."""
    if which == "all":
        return list(range(len(scene.cameras))) or [None]
    if not which.endswith(".json"):
        return list(which.split(","))
    described = json.loads(Path(which).read_text(encoding="utf-8"))
    try:
        return [
            Camera.from_matrix(**camera) if "world_from_camera" in camera else Camera.look_at(**camera)
            for camera in described
        ]
    except TypeError as error:
        raise OptionError(f"--cameras: {which}: {error}") from error


def _files(args: argparse.Namespace, frame: int) -> Iterator[Path]:
    """Where a frame is written."""
    for file in args.output:
        yield Path(
            re.sub("#+", lambda hashes: f"{frame:0{len(hashes[0])}}", file) if args.command == "frames" else file
        )


def _check_outputs(args: argparse.Namespace) -> None:
    """Before hours of work."""
    for file in args.output:
        if args.command == "frames" and "#" not in file:
            raise OptionError(f"--output: {file} has no # for the number of the frame: write frame.####.exr")
        if args.command != "bake" and Path(file).suffix.lower() not in (".png", ".exr"):
            raise OptionError(f"--output: {file} is neither .png nor .exr")
        if not Path(file).parent.is_dir():
            raise OptionError(f"--output: the folder {Path(file).parent} does not exist")
    read = [("the scene", args.scene_file), ("the light mesh of --mesh,", getattr(args, "mesh", None))]
    read += [("the environment map", args.environment), ("the cameras", getattr(args, "cameras", None))]
    outputs = [("--output", Path(file)) for file in args.output]
    _check_places([*outputs, *_stats(args)], [(what, Path(file)) for what, file in read if file is not None])


def _stats(args: argparse.Namespace) -> list[tuple[str, Path]]:
    """The file for statistics, if there is one."""
    return [("--stats", args.stats)] if args.stats else []


def _check_places(outputs: Sequence[tuple[str, Path]], read: Sequence[tuple[str, Path]]) -> None:
    """Refuses outputs that are files which are read, or other outputs, whatever they are called."""
    for option, file in outputs:
        for what, other in read:
            if _is_same(file, other):
                raise OptionError(f"{option}: {file} would replace {what} {other}; name another file")
    real: dict[str, Path] = {}
    for option, file in outputs:
        other = real.setdefault(os.path.realpath(file), file)
        if other is not file and not _is_device(file):
            same = "" if str(other) == str(file) else f": it is the same file as {other}"
            raise OptionError(f"{option}: {file} is named twice as an output{same}")


def _is_same(file: Path, other: Path) -> bool:
    return file.exists() and other.exists() and file.samefile(other)


def _is_device(file: Path) -> bool:
    """Whether many outputs may go there, as to /dev/null."""
    return file.is_char_device()


def _save(args: argparse.Namespace, image: Image, file: Path) -> None:
    image.save(file, exposure=args.exposure, half=args.half)
    _say(args, f"wrote {file}")


def _chosen(args: argparse.Namespace, names: Sequence[str]) -> dict[str, Any]:
    """Options that were given."""
    return {name: value for name in names if (value := getattr(args, name, None)) is not None}


def _region(text: str) -> list[list[float]]:
    numbers = [float(number) for number in text.split(",")]
    if len(numbers) != 6:
        raise argparse.ArgumentTypeError(
            f"{text!r} is no box: write its least and its largest corner, as in -1,0,-1,1,2,1"
        )
    return [numbers[:3], numbers[3:]]


def _bytes(text: str) -> int:
    found = re.fullmatch(r"(\d+)(|KiB|MiB|GiB|TiB)", text)
    if found is None:
        raise argparse.ArgumentTypeError(f"{text!r} is no number of bytes: write 8GiB, 512MiB or 1000000")
    return int(found[1]) * _UNITS[found[2]]


def _workers_in_words(stats: dict[str, Any]) -> str:
    workers = stats["workers"]
    most = max((worker["peak_bytes"] for worker in workers), default=0)
    return f"{stats['wall_seconds']:.1f} s, {len(workers)} workers, at most {most / (1 << 30):.2f} GiB each"


def _resumes(args: argparse.Namespace) -> str:
    return f"; the same command goes on from {_job(args)}"


def _say(args: argparse.Namespace, message: str) -> None:
    if not args.quiet:
        print(message, file=sys.stderr)


def _fail(message: str, code: int) -> int:
    print(f"error: {message}", file=sys.stderr)
    return code
