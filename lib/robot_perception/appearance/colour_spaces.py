r"""Colour spaces, and the cells into which a histogram divides them.

Colours are bytes, red, green, blue. A space gives each three coordinates from 0 to 1; the bin of
a coordinate c among b is :math:`\min(\lfloor b c \rfloor, b - 1)`, so that every colour has one.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, no_type_check

import numpy as np
from jaxtyping import Float, Int32, UInt8

from robot_perception import checks
from robot_perception.fields import checked, one_of
from robot_perception.kernels import kernel

__all__ = ["SPACES", "Binning", "ColourSpace"]

NAMES = ("RGB", "normalised rgb", "HSI", "opponent")
"""Names of the spaces, in the order in which the kernels number them."""
ROUNDING = 1e-9
"""Rounding error allowed at the edge of a bin: colours of bytes that do not reach an edge
stay a thousandth of a bin away from it."""


def _bins(name: str, value: tuple[int, int, int]) -> tuple[int, int, int]:
    """Return three numbers from 1 to 256."""
    found = checks.integers(name, value, (3,), 1).tolist()
    if max(found) > 256:
        raise ValueError(f"{name} must be from 1 to 256, got {tuple(found)}")
    return tuple(found)


@dataclass(frozen=True, slots=True)
class ColourSpace:
    r"""A space of colours; use those of `SPACES`.

    ================  ==========================================================================
    RGB               :math:`R/256,\ G/256,\ B/256`
    normalised rgb    :math:`(R, G, B) / (R + G + B)`; of black, a third each
    HSI               hue round the colour hexagon, :math:`1 - 3 \min(R, G, B) / (R + G + B)`,
                      :math:`(R + G + B) / 766`; a grey has hue 0, as red has, and black
                      saturation 0
    opponent          :math:`(B - G + 255)/511,\ (G - R + 255)/511,\ (R + G + B)/766`
    ================  ==========================================================================

    The hexagon's hue, that of `colorsys`, lies within 1.2° of the angle by which other texts define
    it, and its bins are exact.

    Parameters
    ----------
    name
        One of `SPACES`.
    bins
        How many bins along each coordinate a histogram has unless told otherwise, 256 at most; our
        choice.
    """

    name: Annotated[str, one_of(*NAMES)]
    bins: Annotated[tuple[int, int, int], _bins] = (16, 16, 16)
    __post_init__ = checked

    def coordinates(self, colours: UInt8[np.ndarray, "... 3"]) -> Float[np.ndarray, "... 3"]:
        """Return the coordinates of colours in the space, from 0 to 1.

        Parameters
        ----------
        colours : (…, 3)
            Red, green, blue.

        Raises
        ------
        TypeError
            If they are not bytes.
        ValueError
            If the last axis is not 3.
        """
        colours = pixels("colours", colours, (..., 3))
        found = np.empty(colours.shape)
        _coordinates(NAMES.index(self.name), colours.reshape(-1, 3), found.reshape(-1, 3))
        return found


"""Names of the spaces, in the order in which the kernels number them."""


def _space(name: str, value: ColourSpace | str) -> ColourSpace:
    """Return a space of colours, which may be named."""
    if isinstance(value, ColourSpace):
        return value
    return SPACES[checks.one_of(name, value, NAMES, more=" or a ColourSpace")]


@dataclass(frozen=True, slots=True)
class Binning:
    r"""The cells of a colour histogram: bins along each coordinate of a space.

    Parameters
    ----------
    space
        One of `SPACES`, or its name.
    bins
        Along the three coordinates, 256 at most; those of the space if not given.
    """

    space: Annotated[ColourSpace | str, _space] = "opponent"
    bins: Annotated[tuple[int, int, int], _bins] | None = None

    def __post_init__(self) -> None:
        checked(self)
        if self.bins is None:
            object.__setattr__(self, "bins", self.space.bins)

    @property
    def count(self) -> int:
        """Number of bins in all."""
        return int(np.prod(self.bins))

    def index(
        self, image: UInt8[np.ndarray, "height width 3"]
    ) -> Int32[np.ndarray, "height width"]:
        """Return the number of each pixel's bin.

        Parameters
        ----------
        image : (height, width, 3)
            Red, green, blue.

        Raises
        ------
        TypeError
            If the image does not hold bytes.
        ValueError
            If it has another shape or no pixel.
        """
        return self._numbers(picture("image", image))

    def of(
        self, colours: UInt8[np.ndarray, "n 3"] | Float[np.ndarray, "n 3"]
    ) -> Int32[np.ndarray, " n"]:
        """Return the number of each colour's bin.

        Parameters
        ----------
        colours : (n, 3)
            Bytes: red, green, blue. Numbers with a point: coordinates in the space, from 0 to 1.

        Raises
        ------
        TypeError
            If they are no numbers.
        ValueError
            If the shape is another, or a coordinate is not from 0 to 1.
        """
        if isinstance(colours, np.ndarray) and colours.dtype == np.uint8:
            return self._numbers(pixels("colours", colours, ("n", 3)))
        if isinstance(colours, np.ndarray) and colours.dtype.kind in "iu":
            raise TypeError(f"colours must be bytes (uint8) or floats, got {colours.dtype}")
        colours = checks.array("colours", colours, ("n", 3))
        if colours.size and not (colours.min() >= 0 and colours.max() <= 1):
            raise ValueError(
                f"colours must be from 0 to 1, got {colours.min():g} to {colours.max():g}"
            )
        _, b2, b3 = self.bins
        i, j, k = np.minimum(np.floor(colours * self.bins + ROUNDING), np.subtract(self.bins, 1)).T
        return ((i * b2 + j) * b3 + k).astype(np.int32)

    def _numbers(self, colours: np.ndarray) -> np.ndarray:
        """Return the bins of colours of any shape."""
        found = np.empty(colours.shape[:-1], dtype=np.int32)
        code = NAMES.index(self.space.name)
        _index(code, colours.reshape(-1, 3), *self.bins, found.reshape(-1))
        return found


def picture(name: str, image: np.ndarray) -> np.ndarray:
    """Return a picture of bytes, red, green and blue, that has a pixel."""
    image = pixels(name, image, ("height", "width", 3))
    if not image.size:
        raise ValueError(f"{name} must have a pixel, got {image.shape}")
    return image


def pixels(name: str, colours: np.ndarray, shape: tuple) -> np.ndarray:
    """Return colours that are bytes of a shape, in memory as the kernels want them."""
    if not isinstance(colours, np.ndarray) or colours.dtype != np.uint8:
        kind = colours.dtype if isinstance(colours, np.ndarray) else checks.shown(colours)
        raise TypeError(f"{name} must be an array of bytes (uint8), got {kind}")
    checks.shaped(name, colours, shape)
    return np.ascontiguousarray(colours)


SPACES: Mapping[str, ColourSpace] = MappingProxyType(
    {
        name: ColourSpace(name, bins)
        for name, bins in zip(
            NAMES, [(16, 16, 16), (32, 32, 1), (16, 8, 4), (16, 16, 8)], strict=True
        )
    }
)
"""The spaces that the paper names."""


@no_type_check
@kernel(inline="always")
def _convert(code, red, green, blue):
    """Return the coordinates of one colour; see `ColourSpace`."""
    total = red + green + blue
    if code == 0:
        return red / 256, green / 256, blue / 256
    if code == 1:
        if total == 0:
            return 1 / 3, 1 / 3, 1 / 3
        return red / total, green / total, blue / total
    if code == 2:
        low, high = min(red, green, blue), max(red, green, blue)
        spread = 6 * (high - low)
        if spread == 0:
            hue = 0.0
        elif high == red:
            hue = (green - blue) / spread + (1.0 if green < blue else 0.0)
        elif high == green:
            hue = (2 * (high - low) + blue - red) / spread
        else:
            hue = (4 * (high - low) + red - green) / spread
        return hue, 1 - 3 * low / total if total else 0.0, total / 766
    return (blue - green + 255) / 511, (green - red + 255) / 511, total / 766


@no_type_check
@kernel()
def _coordinates(code, colours, found):
    for k in range(len(colours)):
        red, green, blue = np.int32(colours[k, 0]), np.int32(colours[k, 1]), np.int32(colours[k, 2])
        found[k, 0], found[k, 1], found[k, 2] = _convert(code, red, green, blue)


@no_type_check
@kernel()
def _index(code, colours, b1, b2, b3, found):
    for k in range(len(colours)):
        red, green, blue = np.int32(colours[k, 0]), np.int32(colours[k, 1]), np.int32(colours[k, 2])
        x, y, z = _convert(code, red, green, blue)
        i = min(int(b1 * x + ROUNDING), b1 - 1)
        j = min(int(b2 * y + ROUNDING), b2 - 1)
        found[k] = (i * b2 + j) * b3 + min(int(b3 * z + ROUNDING), b3 - 1)
