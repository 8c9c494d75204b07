"""A map seen from above as a picture that any browser shows."""

from collections.abc import Iterable
from html import escape
from pathlib import Path

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from studies.files import destination, written

SIDE, MARGIN = 1000, 40  # of the picture, px
STEPS = 1, 2, 5  # times a power of ten: from one line of the grid to the next, m
LINES = 12  # of the grid, at most
GRID, INK, WAY, MARK = "#dddddd", "#222222", "#005ac8", "#c85a00"  # colours


def write_plan(
    path: str | Path,
    *,
    walls: Float[np.ndarray, "n 2 2"] | None = None,
    way: Float[np.ndarray, "k 2"] | None = None,
    marks: Float[np.ndarray, "m 2"] | None = None,
    names: Iterable[str] | None = None,
    overwrite: bool = False,
) -> None:
    """Write a plan as SVG: walls black, a way blue, marks orange, on a grid that says its metres.

    x points to the right, y up.

    Parameters
    ----------
    path
        The file, in a folder that exists.
    walls : (n, 2, 2)
        Their two ends, m.
    way : (k, 2)
        Places one after the other, m; a circle stands at the first.
    marks : (m, 2)
        Places, m.
    names : (m,)
        What stands beside the marks.
    overwrite
        Whether the file may be there already.

    Raises
    ------
    ValueError
        If a shape is another, a number is not finite, or there is not a name for each mark.
    FileNotFoundError
        If there is no such folder.
    FileExistsError
        If the file is there and must not be.
    """
    path = destination(path, overwrite=overwrite)
    none = np.zeros((0, 2))
    walls = checks.array("walls", none.reshape(0, 2, 2) if walls is None else walls, ("n", 2, 2))
    way = checks.array("way", none if way is None else way, ("k", 2))
    marks = checks.array("marks", none if marks is None else marks, ("m", 2))
    names = [""] * len(marks) if names is None else checks.instances("names", names, str)
    if len(names) != len(marks):
        raise ValueError(f"names must be one for each of {len(marks)} marks, got {len(names)}")
    places = np.concatenate([walls.reshape(-1, 2), way, marks])
    low, high = (f(places, axis=0) if len(places) else np.zeros(2) for f in (np.min, np.max))
    span = max(float((high - low).max()), 1.0)
    scale = (SIDE - 2 * MARGIN) / span
    width, height = np.ceil(scale * (high - low) + 2 * MARGIN).astype(int).tolist()

    def pixels(points: np.ndarray) -> np.ndarray:
        return MARGIN + scale * (points - [low[0], high[1]]) * [1, -1]

    step = _step(span)
    text = f'<text font-size="14" font-family="sans-serif" fill="{INK}"'
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}"'
        f' width="{width}" height="{height}">',
        '<rect width="100%" height="100%" fill="white"/>',
    ]
    for axis in (0, 1):
        for value in step * np.arange(np.ceil(low[axis] / step), high[axis] / step + 1e-9):
            at = float(pixels(np.full(2, value))[axis])
            ends = ("x1", "x2", "y1", "y2") if axis == 0 else ("y1", "y2", "x1", "x2")
            far = (height, width)[axis]
            where = dict(zip(ends, (at, at, 0, far), strict=True))
            line = " ".join(f'{name}="{place:.1f}"' for name, place in where.items())
            parts.append(f'<line {line} stroke="{GRID}"/>')
            x, y = (at + 3, height - 6) if axis == 0 else (3, at - 3)
            unit = " m" if value == 0 or value == step else ""
            parts.append(f'{text} x="{x:.1f}" y="{y:.1f}">{value:.10g}{unit}</text>')
    for ends in walls:
        parts.append(_line(pixels(ends), INK, 2))
    if len(way):
        u, v = pixels(way[0])
        parts += [_line(pixels(way), WAY, 1.5), _dot(u, v, 6, "none", WAY)]
    for (u, v), name in zip(pixels(marks).tolist(), names, strict=True):
        parts.append(_dot(u, v, 4, MARK, "none"))
        parts.append(
            f'{text} x="{u + 6:.1f}" y="{v - 6:.1f}">{escape(name)}</text>' if name else ""
        )
    with written(path) as beside:
        beside.write_text("\n".join(filter(None, [*parts, "</svg>"])) + "\n", "utf-8")


def _step(span: float) -> float:
    """Return the distance between lines of a grid, m."""
    power = 10.0 ** np.floor(np.log10(span / LINES))
    return next(float(k * power) for k in (*STEPS, 10, 20) if span / (k * power) <= LINES)


def _line(points: np.ndarray, colour: str, width: float) -> str:
    places = " ".join(f"{u:.1f},{v:.1f}" for u, v in points)
    style = f'fill="none" stroke="{colour}" stroke-width="{width}" stroke-linecap="round"'
    return f'<polyline points="{places}" {style}/>'


def _dot(u: float, v: float, radius: float, fill: str, stroke: str) -> str:
    style = f'fill="{fill}" stroke="{stroke}" stroke-width="2"'
    return f'<circle cx="{u:.1f}" cy="{v:.1f}" r="{radius}" {style}/>'
