"""How far a picture is from a reference: in linear values (relrmse, bias, max) and to the eye (flip).

Pictures are images, or arrays of linear light of the shape (H, W, 3), cd/m².
"""

from numpy.typing import ArrayLike

from lightmesh._native import Image, _compare

__all__ = ["compare", "flip", "relrmse"]


def relrmse(a: Image | ArrayLike, b: Image | ArrayLike) -> float:
    """The square root of the mean over pixels and channels of (a - b)², over the mean of the reference b."""
    return _compare(a, b, linear=True)[0]


def flip(a: Image | ArrayLike, b: Image | ArrayLike) -> float:
    """The mean FLIP error of a to the reference b, 0 to 1, at 67 pixels per degree.

    Light of a scene is exposed and tone mapped first, as the reference would be by exposure="auto"; a picture that was read
    from a PNG is taken as it is.
    """
    return compare(a, b)["flip"]


def compare(a: Image | ArrayLike, b: Image | ArrayLike) -> dict[str, float]:
    """All of ``lightmesh compare``: relrmse, bias (mean(a) / mean(b) - 1), max (the largest |a - b|) and flip."""
    relrmse, bias, largest, flip = _compare(a, b)
    # Only what is linear alone leaves it out.
    assert flip is not None
    return {"relrmse": relrmse, "bias": bias, "max": largest, "flip": flip}
