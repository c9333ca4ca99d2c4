"""Whether two builds of the program make the same pictures, bit for bit.

    python tools/same_pictures.py OLD/lightmesh NEW/lightmesh [SCENE ...]

Renders each scene by all methods with layers, and scenes/room_15.glb with the options that take other ways through the
code. Compares the bytes of the EXR files: all pixels and layers, and all attributes but `renderSeconds`. Needs no packages.
Exit status 1 if any picture differs.
"""

from __future__ import annotations

import argparse
import struct
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
OWN = ["cornell.glb", "room_15.glb", "room_100.glb", "room_1000.glb"]
METHODS = ["auto", "mesh", "paper", "standard", "hybrid", "unbiased", "path"]
LAYERS = "albedo,normal,depth,direct,indirect"
SPECIAL = [
    "--error 0.05",
    "--error 0.05 --refine 2",
    "--error 0.05 --bounces 0 --seed 7",
    "--refine 2 --aov mesh_level,mesh_valid,points",
    "--graded 4 --method hybrid",
    "--method hybrid --seed 4294967295",
    "--method unbiased --rays 2 --bounces 8",
    "--light-radius 0.1 --method path",
    "--light-radius 0.1",
    "--method paper --interpolation sphere:2 --weight gaussian",
    "--method paper --paper-scale constant --field-falloff 0.5+r",
    "--interpolation nearest",
    "--interpolation trilinear:mirror",
    "--environment 1,2,3 --depth 2",
]


def read_exr(path: Path) -> tuple[dict[bytes, bytes], bytes]:
    """Returns the attributes of an EXR file and all bytes behind them."""
    data = path.read_bytes()
    attributes, at = {}, 8
    while data[at]:
        name_end = data.index(0, at)
        type_end = data.index(0, name_end + 1)
        (size,) = struct.unpack_from("<i", data, type_end + 1)
        attributes[data[at:name_end]] = data[name_end + 1 : type_end + 5 + size]
        at = type_end + 5 + size
    attributes.pop(b"renderSeconds", None)
    return attributes, data[at:]


def pictures(scenes: list[Path]) -> Iterator[tuple[Path, str]]:
    """Yields each scene with the options of its pictures."""
    for scene in scenes:
        for method in METHODS:
            yield scene, f"--method {method} --size 160x100 --spp 2 --aov {LAYERS}"
    for options in SPECIAL:
        yield ROOT / "scenes/room_15.glb", f"--size 120x80 {options}"
    for method in ["hybrid", "unbiased"]:
        yield ROOT / "scenes/room_1000.glb", f"--size 96x64 --method {method}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("old", type=Path)
    parser.add_argument("new", type=Path)
    parser.add_argument("scenes", nargs="*", type=Path, default=[ROOT / "scenes" / name for name in OWN])
    arguments = parser.parse_args()
    count = different = 0
    with tempfile.TemporaryDirectory() as folder:
        for scene, options in pictures(arguments.scenes):
            files = []
            for name, program in (("old", arguments.old), ("new", arguments.new)):
                picture = Path(folder) / f"{name}.exr"
                picture.unlink(missing_ok=True)
                command = [program, "render", scene, "-o", picture, "--quiet", *options.split()]
                subprocess.run(command, check=True, stderr=subprocess.DEVNULL)
                files.append(read_exr(picture))
            count += 1
            (old, old_pixels), (new, new_pixels) = files
            names = sorted(name.decode() for name in old.keys() | new.keys() if old.get(name) != new.get(name))
            if old_pixels != new_pixels:
                names.insert(0, "pixels")
            if names:
                different += 1
                print(f"differ in {', '.join(names)}: {scene.name} {options}", flush=True)
    print(f"{count} pictures, {different} differ")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
