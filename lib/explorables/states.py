"""The pictures of an explorer: one frame, and all frames packed for a page without a kernel."""

from __future__ import annotations

import base64
import gzip
import json
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from explorables.figures.output import image_element
from explorables.figures.svg import Marks, to_html, to_svg
from explorables.figures.webp import to_webp

SVG = "image/svg+xml"
WEBP = "image/webp"


@dataclass(frozen=True, slots=True)
class Frame:
    """One drawing of an explorer: what it shows for one setting of its controls."""

    mime: str
    data: bytes
    alt: str
    size: tuple[int, int] = (0, 0)
    """Width and height in pixels; zero for SVG, which scales."""

    def element(self, *, inline: bool) -> str:
        """Return the HTML element that shows the frame.

        Inline SVG follows the theme; an `<img>` passes sanitisers, and can hold one drawing.
        """
        if inline and self.mime == SVG:
            return self.data.decode()
        return image_element(self.data, self.mime, self.size, self.alt)


def render(
    drawing: object,
    alt: str,
    *,
    effort: int = 4,
    lossless: bool = False,
    together: bool = False,
    marks: Marks | None = None,
    letters: bool = False,
) -> Frame:
    """Encode the figure or the 8-bit image that an explorer's `draw` has returned.

    The columns of a figure are kept `together` in one drawing where an `<img>` is to show it; the
    `marks` of a point that can be dragged and the `letters` of columns are for the others.
    """
    if isinstance(drawing, Figure):
        options = {"alt": alt, "prefix": "x", "effort": effort}
        apart = {"marks": marks, "letters": letters}
        text = to_svg(drawing, **options) if together else to_html(drawing, **apart, **options)
        return Frame(SVG, text.encode(), alt)
    if isinstance(drawing, np.ndarray):
        data = to_webp(drawing, effort=effort, lossless=lossless)
        return Frame(WEBP, data, alt, drawing.shape[1::-1])
    raise TypeError(f"draw must return a Figure or a uint8 array, got {type(drawing).__name__}")


def pack(frames: Sequence[Frame]) -> str:
    """Pack the frames of a whole grid into one short text.

    SVG frames share most of their lines: they are stored as a table of the distinct lines and, for
    each frame, the numbers of its lines; JSON, gzip, base64. Pictures stay WebP files in base64.
    """
    if len({frame.mime for frame in frames}) > 1:
        raise ValueError("draw must return figures always or images always")
    if frames[0].mime == WEBP:
        return json.dumps(
            [[base64.b64encode(frame.data).decode(), frame.alt, *frame.size] for frame in frames]
        )
    table: dict[str, int] = {}
    states = [
        [table.setdefault(line, len(table)) for line in frame.data.decode().split("\n")]
        for frame in frames
    ]
    packed = json.dumps({"lines": list(table), "states": states}, separators=(",", ":"))
    return json.dumps(base64.b64encode(gzip.compress(packed.encode(), 9, mtime=0)).decode())
