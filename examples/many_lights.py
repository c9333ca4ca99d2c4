# %% [markdown]
# # A hundred lights: error against time
#
# How far is each method from the truth, after how many seconds? This study renders `scenes/room_100.glb`, a room with a
# hundred lights. It makes reference pictures, then renders the same picture by every method with several settings:
# first direct light, then all light.
#
#     python examples/many_lights.py --out examples/out
#
# Run it as a script, or cell by cell in Jupyter or VS Code. It needs `pip install '.[plot]'`, in the repository.

# %%
import argparse
import os
import time
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib.pyplot as plt
import numpy
from numpy.typing import NDArray

from lightmesh import Image, Scene, metrics, plot

parser = argparse.ArgumentParser(description="Error against time of every method, in a room with a hundred lights.")
parser.add_argument("--out", type=Path, default=Path("examples/out"), help="folder for figures (default: examples/out)")
parser.add_argument("--quick", action="store_true", help="small and coarse, to see that it runs")
# parse_known_args, because a notebook passes arguments of its own.
options = parser.parse_known_args()[0]
options.out.mkdir(parents=True, exist_ok=True)

folder = Path(__file__).parent if "__file__" in globals() else Path.cwd()
scene = Scene.load(folder.parent / "scenes" / "room_100.glb")
size = (36, 24) if options.quick else (120, 80)
print(f"{len(scene.lights)} lights, {scene.triangle_count} triangles, {size[0]} x {size[1]} pixels")
print(f"{time.strftime('%Y-%m-%d')}, {os.cpu_count()} cores")

# %% [markdown]
# ## References, and their noise
#
# `standard` is exact for direct light: a shadow ray to every light. `path` is exact for all light. Each reference is
# the average of two pictures with different seeds. Half of their difference is the noise of the average; a smaller
# error than this cannot be measured.

# %%
Light = NDArray[numpy.float32]


class Reference(NamedTuple):
    """A picture (H, W, 3), cd/m², and the relrmse of the noise in it."""

    light: Light
    noise: float


def reference(spp: int, **how: Any) -> Reference:
    """The mean of two pictures of spp samples per pixel each."""
    one, other = (numpy.asarray(scene.render(size=size, spp=spp, seed=seed, **how)) for seed in (101, 202))
    return Reference((one + other) / 2, metrics.relrmse(one, other) / 2)


bounces = 1 if options.quick else 3
direct = reference(16 if options.quick else 128, method="standard")
full = reference(12 if options.quick else 48, method="path", bounces=bounces)
print(f"noise of the references: direct light {100 * direct.noise:.2f}%, all light {100 * full.noise:.2f}%")

# %% [markdown]
# ## Runs
#
# Each picture starts with an empty mesh, so its time includes filling the mesh. A mesh that is kept makes the second
# frame of the same place cheaper: only shading is left.

# %%
Settings = dict[str, list[dict[str, Any]]]
rungs = slice(0, 2) if options.quick else slice(None)
#: Coarse indirect meshes, for --quick.
coarse: dict[str, Any] = {"indirect_spacing": 1.0, "gather_rays": 32} if options.quick else {}
spacings = ["1/20", "1/40", "1/80", "1/160"][rungs]
of_direct_light: Settings = {
    "standard": [{"method": "standard", "spp": spp} for spp in [1, 4, 16, 64][rungs]],
    "mesh": [{"spacing": spacing, "spp": 16} for spacing in spacings],
    "hybrid": [{"method": "hybrid", "spacing": spacing, "spp": 16} for spacing in spacings[:3]],
    "unbiased": [{"method": "unbiased", "rays": rays, "spp": 16} for rays in [1, 4, 16][rungs]],
    "mesh, error=": [{"error": error, "spp": 16} for error in ([0.1] if options.quick else [0.1, 0.05, 0.025])],
}
of_all_light: Settings = {
    "path": [{"method": "path", "spp": spp} for spp in [1, 4, 16][rungs]],
    "mesh": [{"spacing": spacing, "spp": 16, **coarse} for spacing in spacings],
    "hybrid": [{"method": "hybrid", "spacing": spacing, "spp": 16, **coarse} for spacing in spacings[: 1 if options.quick else 3]],
    "unbiased": [{"method": "unbiased", "rays": rays, "spp": 16, **coarse} for rays in ([1] if options.quick else [1, 4])],
}
if not options.quick:
    # The pilot of indirect light costs more than the small picture of --quick.
    of_all_light["mesh, error="] = [{"error": error, "spp": 16} for error in [0.1, 0.05]]


class Run(NamedTuple):
    """Seconds of a picture, its relrmse, and the picture."""

    seconds: float
    error: float
    image: Image


def run(settings: Settings, truth: Reference, bounces: int) -> dict[str, list[Run]]:
    """Renders all pictures and prints a table of them."""
    print(f"\n{'method':<14}{'settings':<62}{'time (s)':>9}{'rays (k)':>10}{'relRMSE':>9}{'bias':>8}")
    found: dict[str, list[Run]] = {}
    for method, rows in settings.items():
        for row in rows:
            image = scene.render(size=size, bounces=bounces, **row)
            off = metrics.compare(image, truth.light)
            seconds = image.stats["seconds"]["render"]
            found.setdefault(method, []).append(Run(seconds, off["relrmse"], image))
            said = ", ".join(f"{name}={value}" for name, value in row.items() if name != "method")
            rays = sum(image.stats["rays"].values()) / 1000
            print(f"{method:<14}{said:<62}{seconds:>9.3f}{rays:>10.0f}", end="")
            print(f"{100 * off['relrmse']:>8.2f}%{100 * off['bias']:>+7.2f}%", flush=True)
    return found


print("\nDirect light, against standard")
direct_runs = run(of_direct_light, direct, bounces=0)
reflections = f"{bounces} reflection{'s' if bounces > 1 else ''}"
print(f"\nAll light, {reflections}, against path")
full_runs = run(of_all_light, full, bounces)

# %% [markdown]
# ## Error against time
#
# Good methods are at the lower left. The error of random samples falls along the dashed slope; that of a mesh falls
# until its spacing resolves the shadows.

# %%
figure, panels = plt.subplots(1, 2, figsize=(12, 5), layout="constrained")
for ax, runs, truth, title in (
    (panels[0], direct_runs, direct, "Direct light"),
    (panels[1], full_runs, full, f"All light, {reflections}"),
):
    plot.convergence({name: ([one.seconds for one in row], [one.error for one in row]) for name, row in runs.items()}, ax=ax)
    ax.set_title(f"{title}: {len(scene.lights)} lights, noise of the reference {100 * truth.noise:.1g}%")
figure.savefig(options.out / "convergence.png", dpi=110)

# %% [markdown]
# ## Where the mesh is wrong
#
# Red is too bright, blue too dark: soft shadows of objects thinner than the spacing.

# %%
figure, panels = plt.subplots(1, 2, figsize=(12, 3.9), layout="constrained")
shown = direct_runs["mesh"][-1].image
plot.picture(full_runs["mesh"][-1].image, ax=panels[0])
panels[0].set_title("mesh, all light")
plot.error_map(shown, direct.light, ax=panels[1])
panels[1].set_title(f"mesh {spacings[-1]}, direct light: {panels[1].get_title()}")
figure.savefig(options.out / "many_lights.png", dpi=110)

# %% [markdown]
# ## What must hold
#
# `standard` converges with more samples, and a finer mesh has less error. Times depend on the machine and are not checked.

# %%
for method in ("standard", "mesh"):
    errors = [one.error for one in direct_runs[method]]
    assert errors[-1] < errors[0], f"{method}: more work made no better picture: {errors}"
    print(f"{method}: {100 * errors[0]:.2f}% to {100 * errors[-1]:.2f}%, the last is the best")
