"""The one style of the book's figures: palette, axes and a few drawing helpers.

Nothing here touches pyplot or matplotlib's global settings. The colours are sentinels: a figure
saved as SVG carries the theme's CSS variables in their place (`explorables.figures.svg`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from typing import Any

import numpy as np
from cycler import cycler
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from matplotlib.patches import Rectangle
from matplotlib.text import Text
from matplotlib.ticker import Formatter
from matplotlib.transforms import Transform

from explorables.figures.ticks import LastingXAxis, LastingYAxis, checked, settings
from explorables.figures.webp import check_image

INK = "#1c1e21"
MUTED = "#5b6470"
FAINT = "#d4d9df"
GROUND = "#fdfefe"
BLUE = "#1f6fb4"
ORANGE = "#b4560a"
GREEN = "#237a3d"
PURPLE = "#7a4fb5"
RED = "#c2302e"
TEAL = "#0e7780"
MAGENTA = "#b3247c"
OLIVE = "#756400"

COLOURS = (BLUE, ORANGE, GREEN, PURPLE, RED, TEAL, MAGENTA, OLIVE)
"""The series colours, in the order in which plots use them."""

MEANING = {
    # a picture of the world: readings blue, walls green, path red, as in Fig. 1b of the first paper
    "truth": INK,
    "readings": BLUE,
    "kept": ORANGE,  # of the readings: vertices and chain
    "walls": GREEN,
    "landmark": GREEN,
    "robot": RED,
    "estimate": RED,  # of all that the filter estimates
    "error": MAGENTA,
    "agreement": GREEN,
    "anchor": PURPLE,
    "position sensor": TEAL,
    "world": MUTED,
    "moved world": BLUE,
    "heading": TEAL,
    "odometry": MUTED,
    # what a picture is compared with
    "expected": MUTED,  # a law, a guide, what chance allows
    "mean": INK,  # over runs, or the line fitted to them
    "paper": OLIVE,  # as it stands in print
    "information": TEAL,
    "unobservable": MAGENTA,
    # filters, side by side
    "plain": ORANGE,
    "anchored": PURPLE,
    "two anchors": TEAL,
    "external": TEAL,
    "first estimates": BLUE,
    "anchored, first estimates": RED,
    "ideal": GREEN,
    "rule": INK,
    "names unknown": ORANGE,
    "names known": TEAL,
    "overconfident": RED,
    "out of order": OLIVE,
    "uncorrelated": BLUE,
    # algorithms, side by side
    "every vertex": ORANGE,
    "path hulls": PURPLE,
    "other hull": TEAL,
    "tag": INK,
    "missed": INK,
    # which landmark is this
    "right": GREEN,
    "wrong": MAGENTA,
    "look-alike": ORANGE,
    "Euclid": INK,
    "raw": RED,
    "floored": PURPLE,
    "shrunk": BLUE,
    "pooled": TEAL,
    # two opinions, one belief
    "first opinion": BLUE,  # the sonar
    "second opinion": GREEN,  # the camera
    "Kalman": ORANGE,
    "intersection": PURPLE,
    "split intersection": TEAL,
    "equation 4": OLIVE,
    # people, by committee; the aggregate is an estimate
    "laser": ORANGE,
    "sonar": BLUE,
    "camera": GREEN,
    "θ": PURPLE,
    "α": TEAL,
    "t_v": BLUE,
    # a head by its colours
    "fixed model": BLUE,
    "adapted model": RED,
    "light": ORANGE,
    "CamShift": TEAL,
    # colour and shape
    "affine snake": BLUE,
    "free snake": MAGENTA,
    "neck": ORANGE,
    "fused": RED,
    "colours adapted": OLIVE,
    "edges alone": PURPLE,
    # tracking a pattern
    "contours": PURPLE,
    "grey vectors": RED,
    "particles": BLUE,
    "no tolerance": OLIVE,
    "left out": ORANGE,
    "at worst": TEAL,
    "not smoothed": OLIVE,
    "smoothed": ORANGE,
    "smoothed, model too": TEAL,
    # a robot that remembers the ceiling
    "ceiling pattern": GREEN,
    "taught path": BLUE,
    "key image": ORANGE,
    "chained": OLIVE,
    "adjusted": TEAL,
    # follow me: brightness that a feature adds, and that it takes off
    "added": ORANGE,
    "taken off": BLUE,
}
"""Colour of each meaning, through the whole book; figures name the meaning, never the colour."""

LEFT, RIGHT = 0.8, 0.2
"""Room at the sides of a panel for its labels, inches."""

Y_PAD = 9.0
"""Between tick labels and the label of the ordinate, points: on a telephone letters are larger."""

TICKS = {
    "color": MUTED,
    "labelcolor": INK,
    "labelsize": 9.5,
    "grid_color": FAINT,
    "grid_linewidth": 0.6,
}
"""Settings of ticks and grid, given to the axes: ticks made later ask matplotlib's own settings."""

LOSSLESS = "rp-lossless"
"""Part of the gid of an image that is stored without loss."""

PIXELATED = "rp-pixelated"
"""Part of the gid of an image that is enlarged without smoothing."""

STYLE: dict[str, Any] = {
    "axes.axisbelow": True,
    "axes.edgecolor": MUTED,
    "axes.facecolor": "none",
    "axes.grid": True,
    "axes.labelcolor": INK,
    "axes.labelpad": 7.0,
    "axes.labelsize": 10.0,
    "axes.linewidth": 0.8,
    "axes.prop_cycle": cycler(color=COLOURS, linewidth=[1.8] * len(COLOURS)),
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlecolor": INK,
    "axes.titlelocation": "left",
    "axes.titlepad": 8.0,
    "axes.titlesize": 10.5,
    "axes.titleweight": "bold",
    "axes.unicode_minus": True,
    "figure.facecolor": "none",
    "font.family": ["DejaVu Sans"],
    "font.size": 10.0,
    "grid.color": FAINT,
    "grid.linewidth": 0.6,
    "image.cmap": "cividis",
    "image.interpolation": "none",  # stored at its own resolution
    "legend.borderaxespad": 0.2,
    "legend.fontsize": 9.5,
    "legend.frameon": False,
    "legend.labelcolor": INK,
    "mathtext.fontset": "dejavusans",
    "path.simplify_threshold": 0.2,
    "text.color": INK,
    "xtick.color": MUTED,
    "xtick.labelcolor": INK,
    "xtick.labelsize": 9.5,
    "xtick.major.size": 3.5,
    "ytick.color": MUTED,
    "ytick.labelcolor": INK,
    "ytick.labelsize": 9.5,
    "ytick.major.size": 3.5,
}

_CHECKED = checked(STYLE)


_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class _Powers(Formatter):
    """Labels powers of ten as text, whose size the page can change; formulas become outlines.

    Where an axis spans less than a factor of ten, the values between are labelled too.
    """

    def __call__(self, value: float, pos: int | None = None) -> str:
        """Return the label of a tick."""
        exponent = round(float(np.log10(value)))
        if np.isclose(value, 10.0**exponent):
            return f"{value:g}" if abs(exponent) <= 2 else "10" + str(exponent).translate(_RAISED)
        low, high = sorted(self.axis.get_view_interval())
        return f"{value:g}" if high < 10 * low else ""


class _Ground(Rectangle):
    """Ground that axes are drawn on and cut off by: all artists share its transformation."""

    def get_transform(self) -> Transform:
        """Return the transformation of the unit square."""
        if (*self.get_xy(), self.get_width(), self.get_height(), self.angle) == (0, 0, 1, 1, 0):
            return Artist.get_transform(self)
        return super().get_transform()


def _styled(method: Callable[..., Any]) -> Callable[..., Any]:
    """Let a method of axes draw in the book's style."""

    @wraps(method)
    def drawn(self: Axes, *args: Any, **kwargs: Any) -> Any:
        with settings(_CHECKED):
            return method(self, *args, **kwargs)

    return drawn


class BookAxes(Axes):
    """Axes that keep the book's style when they are cleared and drawn on again."""

    set_title, text, annotate, legend = map(
        _styled, (Axes.set_title, Axes.text, Axes.annotate, Axes.legend)
    )

    def _ipython_display_(self) -> None:
        """Show nothing: a cell that ends in a drawing call has its figure shown by `show`."""

    def _gen_axes_patch(self) -> Rectangle:
        return _Ground((0.0, 0.0), 1.0, 1.0)

    def _init_axis(self) -> None:
        self.xaxis = LastingXAxis(self, clear=False, style=_CHECKED)
        self.yaxis = LastingYAxis(self, clear=False, style=_CHECKED)
        for side, spine in self.spines.items():
            spine.register_axis(self.xaxis if side in ("bottom", "top") else self.yaxis)

    def clear(self) -> None:
        """Empty the axes and put the style back."""
        with settings(_CHECKED):
            super().clear()
        self.yaxis.labelpad = Y_PAD
        self.tick_params(which="both", **TICKS)

    def set_xscale(self, value: Any, **kwargs: Any) -> None:
        """Set the scale; on a logarithmic one label powers of ten."""
        super().set_xscale(value, **kwargs)
        _label_powers(self.xaxis)

    def set_yscale(self, value: Any, **kwargs: Any) -> None:
        """Set the scale; on a logarithmic one label powers of ten."""
        super().set_yscale(value, **kwargs)
        _label_powers(self.yaxis)

    def imshow(self, X: Any, *args: Any, **kwargs: Any) -> AxesImage:
        """Show an image at its own resolution; data (not 8-bit) without loss, cell by cell."""
        gid = None if np.asarray(X).dtype == np.uint8 else f"{LOSSLESS} {PIXELATED}"
        with settings(_CHECKED):
            return super().imshow(X, *args, **({"gid": gid} | kwargs))


def _label_powers(axis: Axis) -> None:
    if axis.get_scale() == "log":
        axis.set_major_formatter(_Powers())
        axis.set_minor_formatter(_Powers())


class ImageAxes(BookAxes):
    """Axes that fit a picture, in its pixels; cleared, they show the bare picture again."""

    _picture: np.ndarray | None = None

    def clear(self) -> None:
        """Take everything off the picture."""
        super().clear()
        if self._picture is None:  # called by the constructor
            return
        self.imshow(self._picture, aspect="auto")
        self.set_axis_off()
        self.autoscale(False)

    def hold(self, picture: np.ndarray) -> None:
        """Put a picture under whatever is drawn from now on."""
        self._picture = picture
        self.clear()


def image_axes(array: np.ndarray) -> tuple[Figure, ImageAxes]:
    """Make a figure whose axes are a picture: what is drawn on it is measured in its pixels.

    The centre of the first pixel is the origin, columns are x, rows are y, downwards; there are no
    ticks, and what leaves the picture is cut off. To draw again, clear the axes: the picture stays.

    Parameters
    ----------
    array
        Image of type uint8, shape (height, width) or (height, width, 3).

    Returns
    -------
    fig
        As large as fits into 7 × 5.25 inches.
    ax

    Raises
    ------
    ValueError
        If the array is no 8-bit image.

    Examples
    --------
    >>> fig, ax = image_axes(np.zeros((240, 320, 3), dtype=np.uint8))
    >>> [float(limit) for limit in (*ax.get_xlim(), *ax.get_ylim())]
    [-0.5, 319.5, 239.5, -0.5]
    """
    rows, cols = check_image(array, channels=(3,)).shape[:2]
    scale = min(7 / cols, 5.25 / rows)
    with settings(_CHECKED):
        fig = Figure((cols * scale, rows * scale), dpi=100, facecolor="none", layout="none")
        ax = fig.add_axes((0, 0, 1, 1), axes_class=ImageAxes)
    coloured = array if array.ndim == 3 else np.repeat(array[..., None], 3, axis=2)
    ax.hold(coloured)
    return fig, ax


def figure(
    rows: int = 1, cols: int = 1, *, width: float | None = None, height: float = 3.4, **kwargs: Any
) -> tuple[Figure, Any]:
    """Make a figure in the book's style, with fixed margins and no layout engine.

    On a page the columns become drawings of their own, which stand above each other where the page
    is narrow. To draw again, keep the figure and clear its axes (`ax.clear()`): twice as fast as a
    new one.

    Parameters
    ----------
    rows, cols
        Number of axes.
    width, height
        Size in inches. By default one column is 5.6 inches wide, as much as a telephone shows with
        labels that can be read, and several are 7 inches together.
    **kwargs
        Passed to `matplotlib.figure.Figure.subplots`: `sharex`, `sharey`, `width_ratios`,
        `squeeze`, `gridspec_kw` (which may override the margins).

    Returns
    -------
    fig
    axes
        Squeezed as by `matplotlib.pyplot.subplots`.
    """
    width = width or (5.6 if cols == 1 else 7.0)
    left, right, bottom, top = LEFT, RIGHT, 0.56, 0.32
    gap_x, gap_y = 0.98, 0.82
    panel_width = (width - left - right - gap_x * (cols - 1)) / cols
    panel_height = (height - bottom - top - gap_y * (rows - 1)) / rows
    if panel_width <= 0 or panel_height <= 0:
        raise ValueError(
            f"rows × cols: {rows} × {cols} panels do not fit into width × height,"
            f" {width} × {height} inches"
        )
    grid = {
        "left": left / width,
        "right": 1 - right / width,
        "bottom": bottom / height,
        "top": 1 - top / height,
        "wspace": gap_x / panel_width,
        "hspace": gap_y / panel_height,
    } | kwargs.pop("gridspec_kw", {})
    subplot_kw = {"axes_class": BookAxes} | kwargs.pop("subplot_kw", {})
    with settings(_CHECKED):
        fig = Figure(figsize=(width, height), dpi=100, facecolor="none", layout="none")
        axes = fig.subplots(rows, cols, gridspec_kw=grid, subplot_kw=subplot_kw, **kwargs)
    for ax in fig.axes:
        ax.tick_params(labelleft=True)  # also of a shared axis: a column may stand by itself
    return fig, axes


def label(ax: Axes, x: float, y: float, text: str, colour: str, **kwargs: Any) -> Text:
    """Write a direct label at a point, with a halo that keeps lines off it.

    Parameters
    ----------
    ax
        The axes to write on.
    x, y
        Position in data coordinates, or as `transform` says.
    text
        The label.
    colour
        That of the curve it names, from `MEANING`.
    **kwargs
        Passed to `Axes.text`, for instance `ha`, `va`, `transform`.
    """
    options: dict[str, Any] = {"fontsize": 10, "fontweight": "bold", "va": "center"} | kwargs
    return ax.text(x, y, text, color=colour, gid="rp-label", **options)


def band(
    ax: Axes, x: np.ndarray, low: np.ndarray, high: np.ndarray, colour: str, **kwargs: Any
) -> Artist:
    """Fill the band between two curves, for instance ±2σ.

    Parameters
    ----------
    ax
        The axes to draw on.
    x, low, high
        Abscissae and the two curves, each of shape (n,).
    colour
        From `MEANING`.
    **kwargs
        Passed to `Axes.fill_between`.
    """
    options: dict[str, Any] = {"alpha": 0.18, "linewidth": 0} | kwargs
    return ax.fill_between(x, low, high, color=colour, **options)


AxesRow = Sequence[Axes] | np.ndarray
"""Several axes, as `figure` returns them."""


def on_plate(ax: Axes) -> str:
    """Give axes a ground, the same in both themes, for colours that stand for themselves.

    Returns the colour of ink on it.
    """
    ax.set_facecolor("#d3d7dc")
    ax.grid(visible=False)
    return "#1b1d20"


def ellipses(
    ax: Axes,
    means: np.ndarray,
    covs: np.ndarray,
    colour: str,
    *,
    deviations: float = 2.0,
    width: float = 1.4,
    fill: float = 0.0,
    corners: int = 24,
) -> None:
    """Draw the ellipses of covariances (m, 2, 2) round means (m, 2) as one path.

    They reach so many standard deviations; `fill` is the opacity of the inside, and a large one
    needs more corners to look round.
    """
    turn = np.linspace(0, 2 * np.pi, corners + 1)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    values, vectors = np.linalg.eigh(covs)
    axes = vectors * (deviations * np.sqrt(np.maximum(values, 0)))[..., None, :]
    rims = np.full((len(means), len(turn) + 1, 2), np.nan)
    rims[:, :-1] = np.asarray(means)[:, None] + (axes @ circle).mT
    ax.plot(*rims.reshape(-1, 2).T, color=colour, linewidth=width)
    for rim in rims[:, :-1] if fill else ():
        ax.fill(*rim.T, color=colour, alpha=fill, linewidth=0)
