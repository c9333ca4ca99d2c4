"""Renders a glTF scene by lightmesh and by Blender Cycles with Open Image Denoise, and compares both with a reference.

    python tools/beside_cycles.py SCENE.glb REFERENCE.exr [--samples 16,64] [--ours "--error 0.05" --ours "--quality preview"]

Needs `pip install bpy==5.0.1 numpy OpenEXR` (Python 3.11) and a built `lightmesh`; the reference is linear, in cd/m², of the
file's first camera. A time is the CPU time of the process in seconds: of lightmesh all of it, of Cycles the render alone, without
reading the scene. An error is the root mean square over pixels and channels, relative to the reference's mean, of pictures
clamped at 8 times that mean; `--noise` takes the reference's own noise off. Then, for each picture of lightmesh, how many times as
long Cycles would take for the same error: between its two numbers of samples its error falls as a power of its time.
"""

import argparse
import json
import math
import resource
import subprocess
import sys
import tempfile
from pathlib import Path

# Blender divides candela and lux by so many lumens per watt.
LUMENS_PER_WATT = 683.0
CLAMP = 8.0
BOUNCES = 8


def render_by_cycles(scene: str, output: str, width: int, height: int, samples: int) -> None:
    """Renders one picture in this process, and prints its CPU seconds as JSON."""
    import bpy

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=scene, export_import_convert_lighting_mode="SPEC")
    picture = bpy.context.scene
    for thing in bpy.data.objects:
        if thing.type == "LIGHT":
            thing.data.energy *= LUMENS_PER_WATT
            thing.data.shadow_soft_size = 0.0
            thing.visible_camera = False
        elif thing.type == "CAMERA":
            picture.camera = picture.camera or thing
    if picture.world is None:
        picture.world = bpy.data.worlds.new("dark")
        picture.world.color = (0, 0, 0)

    settings = picture.render
    settings.engine = "CYCLES"
    settings.resolution_x, settings.resolution_y, settings.resolution_percentage = width, height, 100
    settings.filepath, settings.dither_intensity = output, 0.0
    file = settings.image_settings
    file.file_format, file.color_depth, file.color_mode = "OPEN_EXR", "32", "RGB"
    cycles = picture.cycles
    cycles.device, cycles.samples, cycles.use_adaptive_sampling = "CPU", samples, False
    cycles.use_denoising, cycles.use_light_tree = True, True
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = BOUNCES
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.light_sampling_threshold = 0.0
    cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0

    started = resource.getrusage(resource.RUSAGE_SELF).ru_utime
    bpy.ops.render.render(write_still=True)
    print(json.dumps({"seconds": resource.getrusage(resource.RUSAGE_SELF).ru_utime - started}))


def read(path: str):
    """Reads red, green and blue of an EXR file."""
    import numpy
    import OpenEXR

    channels = OpenEXR.File(path).channels()
    if "RGB" in channels or "RGBA" in channels:
        return channels["RGB" if "RGB" in channels else "RGBA"].pixels[..., :3].astype(numpy.float64)
    return numpy.stack([channels[name].pixels for name in "RGB"], axis=-1).astype(numpy.float64)


class Reference:
    """The truth, clamped, and its noise."""

    def __init__(self, path: str, noise: float) -> None:
        import numpy

        truth = read(path)
        self.height, self.width = truth.shape[:2]
        self.most = CLAMP * truth.mean()
        self.truth = numpy.minimum(truth, self.most)
        self.noise = noise

    def error(self, path: str) -> float:
        """How far a picture is from it."""
        import numpy

        square = ((numpy.minimum(read(path), self.most) - self.truth) ** 2).mean() / self.truth.mean() ** 2
        return math.sqrt(max(square - self.noise**2, 0.0))


def seconds_of_children() -> float:
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene")
    parser.add_argument("reference")
    parser.add_argument("--noise", type=float, default=0.0, help="relative error of the reference by its own noise")
    parser.add_argument("--samples", default="16,64", help="of Cycles, two numbers")
    parser.add_argument("--ours", action="append", metavar="ARGS", help="arguments of lightmesh; several times")
    parser.add_argument("--lightmesh", default="target/release/lightmesh", help="the program")
    parser.add_argument("--cycles", nargs=4, metavar=("OUT", "WIDTH", "HEIGHT", "SAMPLES"), help=argparse.SUPPRESS)
    args = parser.parse_args()
    scene = str(Path(args.scene).resolve())
    if args.cycles:
        output, *numbers = args.cycles
        render_by_cycles(scene, output, *map(int, numbers))
        return

    reference = Reference(args.reference, args.noise)
    size = [str(reference.width), str(reference.height)]
    with tempfile.TemporaryDirectory() as folder:
        peers = []
        for samples in args.samples.split(","):
            output = f"{folder}/cycles.exr"
            command = [sys.executable, __file__, scene, args.reference, "--cycles", output, *size, samples]
            done = subprocess.run(command, capture_output=True, text=True)
            told = [line for line in done.stdout.splitlines() if line.startswith('{"seconds"')]
            if not told:
                sys.exit(f"Cycles failed: {done.stderr.strip()[-300:]}")
            seconds, error = json.loads(told[0])["seconds"], reference.error(output)
            peers.append((seconds, error))
            print(f"Cycles, {samples} samples, denoised: {seconds:.1f} CPU s, {error:.2%}", flush=True)
        (t0, e0), (t1, e1) = peers[0], peers[-1]
        power = max(math.log(e0 / e1) / math.log(t1 / t0), 0.05) if t1 > t0 and e1 < e0 else 0.05
        for ours in args.ours or ["", "--quality preview"]:
            output, started = f"{folder}/ours.exr", seconds_of_children()
            command = [args.lightmesh, "render", scene, "-o", output, "--size", "x".join(size), "--quiet"]
            subprocess.run([*command, "--bounces", str(BOUNCES), *ours.split()], check=True)
            seconds, error = seconds_of_children() - started, reference.error(output)
            times = t0 * (e0 / max(error, 1e-4)) ** (1 / power) / seconds
            name = ours or "the default"
            print(f"lightmesh, {name}: {seconds:.1f} CPU s, {error:.2%}; Cycles: {times:.1f} times as long", flush=True)


if __name__ == "__main__":
    main()
