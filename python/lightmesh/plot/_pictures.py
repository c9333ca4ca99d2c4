"""Pictures, and where they are wrong."""

import io
import tempfile
from pathlib import Path
from typing import Any, Literal

import numpy
from matplotlib.axes import Axes
from matplotlib.image import imread
from matplotlib.ticker import FuncFormatter
from numpy.typing import ArrayLike, NDArray

from lightmesh import metrics, units
from lightmesh._native import Image
from lightmesh.plot._axes import axes_or_new, colour_bar, round_up

#: Luminance below this part of the reference's mean counts as this part, or black pixels would have errors without end.
DARKEST = 0.01


def picture(image: Image, *, exposure: float | Literal["auto"] = "auto", ax: Axes | None = None) -> Axes:
    """The picture as Image.save writes it into a PNG, pixel by pixel: exposed, tone mapped, sRGB.

    exposure: EV, or "auto", as for Image.save.
    """
    # Before a figure is opened that would stay empty.
    pixels = _png_pixels(image, exposure)
    ax = axes_or_new(ax, 6.0, 6.0 * pixels.shape[0] / pixels.shape[1])
    ax.imshow(pixels)
    ax.set_axis_off()
    return ax


def error_map(
    image: Image | ArrayLike, reference: Image | ArrayLike, *, limit: float | None = None, ax: Axes | None = None
) -> Axes:
    """The signed relative error of each pixel's luminance, (L - L_reference) / L_reference: red where the picture is too bright,
    blue where it is too dark. The title has the relrmse of metrics, which is over all channels, and the bias.

    image, reference: images or arrays of the shape (H, W, 3), cd/m². Where the reference is darker than a hundredth of its mean,
    the error is relative to that.
    limit: the error that has the strongest colour, 0.1 for ±10%; None takes the one that 95% of the pixels keep to, rounded up.
    """
    found = metrics.compare(image, reference)
    luminance = units.luminance(numpy.asarray(image, numpy.float64))
    truth = units.luminance(numpy.asarray(reference, numpy.float64))
    floor = max(DARKEST * float(truth.mean()), float(numpy.finfo(numpy.float64).tiny))
    error = (luminance - truth) / numpy.maximum(truth, floor)
    if limit is None:
        # A part in a million is the rounding of float32.
        limit = round_up(max(float(numpy.quantile(numpy.abs(error), 0.95)), 1e-6))

    height, width = error.shape
    ax = axes_or_new(ax, 6.5, 0.8 + 5.0 * height / width)
    shown = ax.imshow(error, cmap="RdBu_r", vmin=-limit, vmax=limit)
    beyond = "both" if float(numpy.abs(error).max()) > limit else "neither"
    signed = FuncFormatter(lambda value, _: f"{100 * value:+.4g}".replace("-", "\N{MINUS SIGN}") if value else "0")
    colour_bar(ax, shown, "relative error of luminance (%)", beyond, format=signed)
    ax.set(xlabel="column (pixels)", ylabel="row (pixels)")
    ax.set_title(f"relRMSE {100 * found['relrmse']:.3g}%, bias {100 * found['bias']:+.2g}%".replace("-", "\N{MINUS SIGN}"))
    return ax


def _png_pixels(image: Image, exposure: float | Literal["auto"]) -> NDArray[Any]:
    """(H, W, 3) in [0, 1], by the library's own tone map."""
    if not isinstance(image, Image):
        raise TypeError(f"image: expected a lightmesh.Image, whose light has a tone map, not {type(image).__name__}")
    if exposure == "auto":
        png = image._repr_png_()
    else:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "picture.png"
            image.save(file, exposure=exposure)
            png = file.read_bytes()
    return numpy.asarray(imread(io.BytesIO(png), format="png"))
