# %% [markdown]
# # Is there enough light to work by?
#
# This study builds an office of 7.2 m x 5.4 m x 2.8 m with eight opal globes from arrays. It computes the illuminance on
# the work plane, 0.85 m above the floor, as EN 12464-1 defines it: average, minimum and uniformity U0, with and without
# the light that surfaces reflect. Then it checks the result twice: against the closed form of a point light, and
# against the path tracer.
#
#     python examples/light_study.py --out examples/out
#
# Run it as a script, or cell by cell in Jupyter or VS Code. It needs `pip install '.[plot]'`, in the repository.

# %%
import argparse
import math
import os
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter
from typing import Any

import matplotlib.pyplot as plt
import numpy
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle
from numpy.typing import NDArray

from lightmesh import Camera, LightMesh, Material, Scene, plot, units

Floats = NDArray[numpy.float64]

parser = argparse.ArgumentParser(description="Illuminance on the work plane of an office.")
parser.add_argument("--out", type=Path, default=Path("examples/out"), help="folder for figures (default: examples/out)")
parser.add_argument("--quick", action="store_true", help="coarse and fast, to see that it runs")
# parse_known_args, because a notebook passes arguments of its own.
options = parser.parse_known_args()[0]
options.out.mkdir(parents=True, exist_ok=True)

# %% [markdown]
# ## The room
#
# Y is up, the origin is a corner of the floor, lengths are metres. Reflectances are the usual ones of a light study:
# ceiling 0.7, walls 0.5, floor 0.2 (oak). All surfaces are Lambertian (`specular=0`).
#
# The lamps are opal globes of 20 cm with the same intensity in every direction: a flux F (lm) is an intensity
# I = F / 4 pi (cd). They are point lights with a radius (`light_radius`), which gives soft shadows.

# %%
WIDTH, DEPTH, HEIGHT = 7.2, 5.4, 2.8
FLUX_LM = 4400.0
#: Sixteen light samples per lamp.
GLOBES: Any = {"light_radius": 0.1, "light_samples": 16}
LAMPS = numpy.array([[x, 2.3, z] for z in (1.35, 4.05) for x in (0.9, 2.7, 4.5, 6.3)])

#: The corners of a box, and its twelve triangles with their front outside.
CORNERS = numpy.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
SIDES = numpy.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
TRIANGLES = SIDES[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)

#: Lower corner, upper corner, colour.
DESK, SHELF, SCREEN = (0.55, 0.38, 0.22), (0.45, 0.47, 0.5), (0.18, 0.35, 0.55)
FURNITURE: list[tuple[Sequence[float], Sequence[float], Sequence[float]]] = [
    *[((x, 0.68, z), (x + 1.6, 0.72, z + 0.8), DESK) for x in (0.9, 2.9) for z in (0.95, 3.65)],
    *[((x, 0.0, z + 0.1), (x + 0.05, 0.68, z + 0.7), DESK) for x in (1.0, 2.35, 3.0, 4.35) for z in (0.95, 3.65)],
    ((5.28, 0.0, 0.02), (5.32, 1.6, 2.6), SCREEN),
    ((1.0, 0.0, 5.05), (5.0, 1.2, 5.38), SHELF),
]


def box(scene: Scene, low: Sequence[float], high: Sequence[float], colour: Any) -> None:
    """Adds a box between two corners (metres)."""
    corners = numpy.asarray(low) + CORNERS * (numpy.asarray(high) - numpy.asarray(low))
    scene.add_mesh(corners, TRIANGLES, material=Material(base_color=colour, specular=0.0))


def office() -> Scene:
    """The room and its furniture, without lamps."""
    scene = Scene()
    room = CORNERS * (WIDTH, HEIGHT, DEPTH)
    # Its luminance is 0.2.
    oak = (0.28, 0.19, 0.13)
    for reflectance, sides in ((0.5, SIDES[[0, 1, 4, 5]]), (oak, SIDES[[2]]), (0.7, SIDES[[3]])):
        # The room is the inside of this box, so its triangles face inward.
        triangles = sides[:, [2, 1, 0, 3, 2, 0]].reshape(-1, 3)
        scene.add_mesh(room, triangles, material=Material(base_color=reflectance, specular=0.0))
    for low, high, colour in FURNITURE:
        box(scene, low, high, colour)
    return scene


intensity = units.candela_from_lumen(FLUX_LM)
scene = office()
for lamp in LAMPS:
    scene.add_point_light(lamp, intensity)
print(f"{len(LAMPS)} lamps of {FLUX_LM:.0f} lm, {intensity:.1f} cd in every direction")

# %% [markdown]
# ## Where to measure
#
# EN 12464-1 (2021, the clause on the illuminance grid) requires a grid whose points are at most p = 0.2 x 5^(log10 d)
# metres apart, and at most 10 m. d is the longer side of the area, or the shorter one if the longer is twice as long or
# more. A strip of 0.5 m along the walls does not count. The points are the centres of equal cells.

# %%
PLANE_M, MARGIN_M = 0.85, 0.5
UP = (0.0, 1.0, 0.0)


def largest_step(width: float, depth: float) -> float:
    """The largest distance between grid points, metres, for an area with these sides (metres)."""
    longer, shorter = max(width, depth), min(width, depth)
    d = shorter if longer >= 2 * shorter else longer
    return min(0.2 * 5 ** math.log10(d), 10.0)


def middles(low: float, high: float, step: float) -> Floats:
    """The centres of equal cells, no longer than step, from low to high (metres)."""
    count = math.ceil((high - low) / step)
    return low + (numpy.arange(count) + 0.5) * (high - low) / count


def grid(step: float) -> tuple[Floats, Floats, Floats]:
    """The work plane's x (W,), z (H,) and points (H, W, 3), metres, cells no longer than step."""
    x, z = middles(MARGIN_M, WIDTH - MARGIN_M, step), middles(MARGIN_M, DEPTH - MARGIN_M, step)
    across, along = numpy.meshgrid(x, z)
    return x, z, numpy.stack([across, numpy.full_like(across, PLANE_M), along], axis=-1)


step = largest_step(WIDTH - 2 * MARGIN_M, DEPTH - 2 * MARGIN_M)
x, z, points = grid(step)
print(f"grid: p = {step:.2f} m at most, {x.size} x {z.size} points, {x[1] - x[0]:.2f} m x {z[1] - z[0]:.2f} m apart")

# %% [markdown]
# ## Illuminance
#
# Reading the mesh evaluates the lattice points that it needs. `direct` is the light of the lamps alone; `irradiance`
# includes reflected light.

# %%
bounces = 2 if options.quick else 8
if options.quick:
    mesh = LightMesh(scene, spacing=0.2, indirect_spacing=0.4, gather_rays=64, bounces=bounces, **GLOBES)
else:
    mesh = LightMesh(scene, spacing=0.1, indirect_spacing=0.15, gather_rays=512, bounces=bounces, **GLOBES)


def lux(rgb: NDArray[Any]) -> Floats:
    """The illuminance (lx) of irradiance per channel, (..., 3)."""
    found: Floats = numpy.asarray(units.luminance(rgb), numpy.float64)
    return found


def row(name: str, values: Floats) -> str:
    """A line of the table: average, minimum, uniformity."""
    return f"{name:<26}{values.mean():>9.0f}{values.min():>10.0f}{values.min() / values.mean():>9.2f}"


started = perf_counter()
straight = lux(mesh.direct(points.reshape(-1, 3), UP)).reshape(points.shape[:2])
total = lux(mesh.irradiance(points.reshape(-1, 3), UP)).reshape(points.shape[:2])
seconds = perf_counter() - started
print(f"\n{'work plane at 0.85 m':<26}{'Eav (lx)':>9}{'Emin (lx)':>10}{'U0':>9}")
print(row("lamps alone", straight))
print(row("with reflected light", total))
print(f"reflected light: {100 * (1 - straight.mean() / total.mean()):.0f}% of the average; {seconds:.1f} s, {os.cpu_count()} cores")
met = total.mean() >= 500 and total.min() >= 0.6 * total.mean()
print(f"writing, typing, reading in offices (EN 12464-1: 500 lx, U0 0.60): {'met' if met else 'not met'}")

# %% [markdown]
# ## Isolines
#
# The same plane with a point every 10 cm, except inside the screen. Reflected light brightens the screen's shadow.

# %%
fine_x, fine_z, fine = grid(0.3 if options.quick else 0.1)
inside = numpy.zeros(fine.shape[:2], bool)
for corner, opposite, _ in FURNITURE:
    inside |= ((fine > corner) & (fine < opposite)).all(axis=-1)
both: list[tuple[str, Floats]] = [
    (name, numpy.where(inside, numpy.nan, lux(measure(fine.reshape(-1, 3), UP)).reshape(inside.shape)))
    for name, measure in (("Lamps alone", mesh.direct), ("With reflected light", mesh.irradiance))
]


def plan(ax: Axes) -> None:
    """Draws walls, furniture and lamps into a plan of the room."""
    for (left, _, near), (right, top, far), _colour in FURNITURE:
        dashed = "-" if top > PLANE_M else ":"
        ax.add_patch(Rectangle((left, near), right - left, far - near, fill=False, color="white", linestyle=dashed, linewidth=0.9))
    ax.plot(LAMPS[:, 0], LAMPS[:, 2], "o", color="white", markeredgecolor="black", markersize=7)
    ax.set(xlim=(0, WIDTH), ylim=(DEPTH, 0), facecolor="#b8b8b8")


LINES, AXES = (100, 150, 200, 250, 300, 400, 500, 550, 600, 650, 700), ("x (m)", "z (m)")
figure, panels = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
highest = max(float(numpy.nanmax(values)) for _, values in both)
for ax, (name, values) in zip(panels, both, strict=True):
    plot.illuminance(fine_x, fine_z, values, levels=LINES, limits=(0.0, highest), labels=AXES, ax=ax)
    ax.set_title(f"{name}: {ax.get_title()}", fontsize=11)
    plan(ax)
figure.savefig(options.out / "isolines.png", dpi=100)

# %% [markdown]
# ## The room, and a slice of its light mesh
#
# A camera does not see a point light. For the picture, each is an emitting sphere: with radius r and luminance
# I / (pi r^2), cd/m², it has the intensity I.

# %%
eye = Camera.look_at((7.05, 1.65, 5.25), (2.7, 1.15, 2.1), yfov=0.95)
size = (120, 80) if options.quick else (600, 400)
seen = office()
for lamp in LAMPS:
    globe = Material(base_color=0.0, emission=intensity / (math.pi * GLOBES["light_radius"] ** 2), specular=0.0)
    seen.add_sphere(lamp, GLOBES["light_radius"], material=globe)
image = seen.render(camera=eye, size=size, spp=4 if options.quick else 16, bounces=bounces, light_samples=16)
figure, (left, right) = plt.subplots(1, 2, figsize=(11, 3.7), width_ratios=(1, 1.05), layout="constrained")
plot.picture(image, ax=left)
plot.illuminance(fine_x, fine_z, both[1][1], levels=LINES, labels=AXES, ax=right)
plan(right)
figure.savefig(options.out / "light_study.jpg", dpi=100, pil_kwargs={"quality": 88})

figure, ax = plt.subplots(figsize=(7, 5), layout="constrained")
plot.slice_of_mesh(mesh, "y", at=PLANE_M, ax=ax)
figure.savefig(options.out / "slice.png", dpi=100)

# %% [markdown]
# ## Check 1: the closed form
#
# One lamp of intensity I at height h over an open floor: E = I cos^3(theta) / h^2. The mesh must be within 1%.

# %%
opening = Scene()
box(opening, (-3, -0.1, -3), (3, 0, 3), 0.2)
height = 2.0
opening.add_point_light((0, height, 0), intensity)
away = numpy.linspace(0, 2.5, 11)
meters = numpy.stack([away, numpy.zeros(11), 0.3 * away], axis=-1)
closed = intensity * numpy.cos(numpy.arctan(numpy.hypot(away, 0.3 * away) / height)) ** 3 / height**2
measured = lux(LightMesh(opening, bounces=0).irradiance(meters, UP))
off = float(numpy.abs(measured / closed - 1).max())
print(f"\nclosed form: {closed[0]:.2f} lx below the lamp, measured {measured[0]:.2f} lx")
print(f"at {away.size} points at most {100 * off:.1g}% off")
assert off < 0.01, "the mesh is more than 1% off the closed form"

# %% [markdown]
# ## Check 2: the path tracer
#
# At some points of the grid, several path-traced runs with different seeds give a mean and its standard error. z is
# the difference between mesh and mean, in standard errors. The mesh interpolates, so the difference may exceed the
# noise of a long run; the table shows by how much.

# %%
chosen = points.reshape(-1, 3)[:: max(1, x.size * z.size // 6)]
runs, spp = (4, 64) if options.quick else (8, 512)
traced = numpy.stack(
    [lux(scene.irradiance(chosen, UP, method="path", spp=spp, bounces=bounces, seed=seed, **GLOBES)) for seed in range(runs)]
)
mean, error = traced.mean(axis=0), traced.std(axis=0, ddof=1) / math.sqrt(runs)
here = lux(mesh.irradiance(chosen, UP))
print(f"\n{'x (m)':>6}{'z (m)':>7}{'path (lx)':>12}{'± (lx)':>8}{'mesh (lx)':>11}{'off':>8}{'z':>7}")
for (at_x, _, at_z), truth, noise, found in zip(chosen, mean, error, here, strict=True):
    away_by = f"{100 * (found / truth - 1):>+7.1f}%{(found - truth) / noise:>+7.1f}"
    print(f"{at_x:>6.2f}{at_z:>7.2f}{truth:>12.1f}{noise:>8.1f}{found:>11.1f}{away_by}")
allowed = 0.10 if options.quick else 0.05
outside = numpy.abs(here - mean) > 3 * error + allowed * mean
within = here.size - int(outside.sum())
print(f"path tracer: {within} of {here.size} points within {100 * allowed:.0f}% and 3 standard errors of it")
assert not outside.any(), "the mesh is further from the path tracer than noise and interpolation explain"
