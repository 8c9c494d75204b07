"""Figures as small, repeatable SVG that takes its colours from the page.

Text stays text (formulas become outlines), numbers are rounded, identifiers that nothing refers to
are dropped and the others get a prefix. The palette's sentinel colours become CSS variables with
themselves as fall-back; the ink becomes `currentColor`. A figure whose SVG would be larger than
`HEAVY` characters is saved again with its heavy artists (many vertices) rasterised: their colours
then no longer follow the theme, but the page stays light. An image that matplotlib does not
interpolate is stored as WebP at its own resolution, and does not count as heavy.

On a page each column of a figure is a drawing of its own, with its part of the figure for a window:
where the page is narrow, the row of them wraps.
"""

from __future__ import annotations

import base64
import hashlib
import html
import io
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import pairwise
from string import ascii_lowercase
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib._path import convert_to_string
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backend_bases import GraphicsContextBase
from matplotlib.backends.backend_mixed import MixedModeRenderer
from matplotlib.backends.backend_svg import RendererSVG, _short_float_fmt
from matplotlib.collections import Collection, PathCollection
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.lines import Line2D
from matplotlib.path import Path
from matplotlib.text import Text
from matplotlib.textpath import TextToPath
from matplotlib.transforms import Affine2D, Transform

from explorables.figures import style
from explorables.figures.ticks import checked, settings
from explorables.figures.webp import to_png, to_webp

HEAVY = 400_000
"""Characters, images apart, above which the artists with many vertices are rasterised."""

RASTER_DPI = 144
"""Resolution of embedded pictures, in dots per inch."""

_NAMES = ("MUTED", "FAINT", "GROUND", "BLUE", "ORANGE", "GREEN", "PURPLE", "RED", "TEAL",
          "MAGENTA", "OLIVE")  # fmt: skip
_VARIABLES = {name: getattr(style, name) for name in _NAMES}
_PAINT = {value: f"var(--rp-{name.lower()}, {value})" for name, value in _VARIABLES.items()}
_PAINT |= {style.INK: "currentColor", "#000000": "currentColor"}
_SENTINEL = re.compile("|".join(map(re.escape, _PAINT)))
_EMBEDDED = re.compile(r"data:image/\w+;base64,[^\"]*")
_NUMBER = re.compile(r"-?\d+\.\d\d+")
_GEOMETRY = re.compile(r'(?<= d=")[^"]*(?=")|(?<= (?:x|y)=")[^"]*(?=")|translate\([^)]*\)')
_IDENTIFIER = re.compile(r' id="([^"]*)"')
_REFERENCE = re.compile(r'url\(#([^)]*)\)|xlink:href="#([^"]*)"')
_FAMILY = re.compile(r" ?font-family: 'DejaVu Sans';?")
_SIZE = re.compile(r"font-size: ([\d.]+)px")
_NOTHING = re.compile(
    r"<!--.*?-->\s*"
    r"| transform=\"rotate\(-0 [^)]*\)\""
    r"|<g[^>]*>\s*<path d=\"[^\"]*\" style=\"fill: none\"/>\s*</g>\s*",
    re.S,
)
_SETTINGS = {
    "image.composite_image": False,  # each image by itself, so that it can keep its resolution
    "svg.hashsalt": "explorables",
    "svg.image_inline": True,
    "path.simplify": True,
    "svg.fonttype": "none",
}
_CHECKED = checked(style.STYLE | _SETTINGS)
_FONTS = [name for name in mpl.rcParams if name.startswith(("font.", "mathtext.", "text."))]


def to_svg(
    fig: Figure, *, alt: str | None = None, prefix: str | None = None, effort: int = 4
) -> str:
    """Render a figure as an inline SVG element, the same text for the same figure.

    Parameters
    ----------
    fig
        The figure.
    alt
        Alternative text; it becomes the `aria-label`.
    prefix
        Prefix of identifiers; a hash of the content if not given.
    effort
        Effort of the encoder of images, 0 (fast) to 6 (small).

    Returns
    -------
    str
        One `<svg>` element without a prologue.
    """
    ((raw,), (window,)) = _saved(fig, [_whole(fig)], effort, prefix is not None)
    return _rewrite(raw, window, prefix, _named(alt))


Marks = tuple[int, Sequence[tuple[float, float] | None]]
"""Axes by their number in the figure, and points there, in the coordinates of these axes."""


def to_html(
    fig: Figure,
    *,
    alt: str | None = None,
    prefix: str | None = None,
    effort: int = 4,
    marks: Marks | None = None,
    letters: bool = False,
) -> str:
    """Render a figure as `to_svg` does; several columns as a row of drawings that a page wraps.

    The row, a `<div>`, is one image with one alternative text. A figure whose axes do not stand in
    columns, or that has something of its own beside them, is one drawing. With `letters` each
    drawing of a row has one, (a), (b), …, for the caption: it does not say left and right, since a
    narrow page puts the drawings above each other. Points to be marked are written into their
    drawing, in its units, for a script to read: ``x,y`` or ``-`` for none.
    """
    columns = _columns(fig)
    letters = letters and len(columns) > 1
    with _titles_lettered(columns if letters else ()) as titled:
        raws, windows = _saved(fig, columns, effort, prefix is not None)
    if len(columns) == 1:
        return _marked(_rewrite(raws[0], windows[0], prefix, _named(alt)), fig, marks)
    prefix = prefix or _hashed("".join(raws))
    panels = [
        _rewrite(raw, window, f"{prefix}{place}", ' aria-hidden="true"')
        for place, (raw, window) in enumerate(zip(raws, windows, strict=True))
    ]
    if marks:
        there = [fig.axes[marks[0]] in axes for axes, *_ in columns].index(True)
        panels[there] = _marked(panels[there], fig, marks)
    if letters:
        panels = [
            panel if letter in titled else _lettered(panel, left, letter)
            for panel, (left, _), letter in zip(panels, windows, ascii_lowercase, strict=False)
        ]
    return f'<div class="rp-row"{_named(alt)}>{chr(10).join(panels)}</div>'


@contextmanager
def _titles_lettered(columns: Sequence[Column]) -> Iterator[str]:
    """Put the letter of a column before its title meanwhile; give the letters that had one."""
    titles = [
        next((t for ax in axes for t in (ax.title, ax._left_title) if t.get_text()), None)
        for axes, *_ in columns
    ]
    named = {letter: title for letter, title in zip(ascii_lowercase, titles, strict=False) if title}
    before = {letter: title.get_text() for letter, title in named.items()}
    for letter, title in named.items():
        title.set_text(f"({letter}) {before[letter]}")
    try:
        yield "".join(named)
    finally:
        for letter, title in named.items():
            title.set_text(before[letter])


def _lettered(drawing: str, left: float, letter: str) -> str:
    """Write a letter into the upper left corner of a drawing."""
    start, end = drawing.rsplit("</svg>", 1)
    size = "font-size: calc(9px * var(--rp-text, 1)); font-weight: 600"
    return f'{start}\n<text x="{left:.1f}" y="9" style="{size}">({letter})</text>\n</svg>{end}'


def _marked(drawing: str, fig: Figure, marks: Marks | None) -> str:
    """Write points into a drawing, before its end."""
    if marks is None:
        return drawing
    panel, points = marks
    scale, height = 72 / fig.dpi, 72 * fig.get_figheight()
    words = []
    for point in points:
        if point is None:
            words.append("-")
            continue
        x, y = scale * fig.axes[panel].transData.transform(point)
        words.append(f"{x:.1f},{height - y:.1f}")
    start, end = drawing.rsplit("</svg>", 1)
    return f'{start}\n<metadata class="rp-places">{" ".join(words)}</metadata>\n</svg>{end}'


def _named(alt: str | None) -> str:
    return ' role="img"' + (f' aria-label="{html.escape(alt)}"' if alt else "")


def _hashed(text: str) -> str:
    return "f" + hashlib.sha256(text.encode()).hexdigest()[:8]


Column = tuple[Sequence[Axes], float, float]
"""Axes that make a drawing, and where its window begins and ends, in points."""


def _whole(fig: Figure) -> Column:
    return fig.axes, 0.0, 72 * fig.get_figwidth()


def _columns(fig: Figure) -> list[Column]:
    """Return the columns of a figure, or the whole figure if it cannot be taken apart."""
    own = [artist for artist in fig.get_children() if artist.get_visible()]
    places = [ax.get_subplotspec() for ax in fig.axes]
    if len(own) > 1 + sum(ax.get_visible() for ax in fig.axes) or None in places:
        return [_whole(fig)]
    grids = {place.get_gridspec() for place in places}
    if len(grids) != 1 or any(len(place.colspan) > 1 for place in places):
        return [_whole(fig)]
    *_, lefts, rights = grids.pop().get_grid_positions(fig)
    share = style.RIGHT / (style.LEFT + style.RIGHT)
    cuts = [right + share * (left - right) for right, left in zip(rights, lefts[1:], strict=False)]
    ends = 72 * fig.get_figwidth() * np.array([0.0, *cuts, 1.0])
    return [
        ([ax for ax, place in zip(fig.axes, places, strict=True) if place.colspan.start == column],
         left, right)
        for column, (left, right) in enumerate(pairwise(ends.tolist()))
    ]  # fmt: skip


@dataclass
class Passage:
    """Text of something that is drawn again and again.

    Parameters
    ----------
    text, shortened
        What stands in the drawing, and the paths in it.
    needs
        Identifiers that it refers to and that stand before it.
    markers, glyphs, clips
        What it defines, in the renderer's own books.
    """

    text: str = ""
    shortened: list[Path] = field(default_factory=list)
    needs: set[str] = field(default_factory=set)
    markers: dict[Any, str] = field(default_factory=dict)
    glyphs: dict[str, Any] = field(default_factory=dict)
    clips: dict[Any, Any] = field(default_factory=dict)


@lru_cache(4096)
def _measured(
    text: str, font: FontProperties, ismath: bool | str, fonts: str
) -> tuple[float, float, float]:
    """Return width, height and descent of a text; matplotlib measures anew for each drawing."""
    return TextToPath().get_text_width_height_descent(text, font, ismath)


def _written(path: Path, decimals: int) -> str:
    letters = [b"M", b"L", b"Q", b"C", b"z"]
    return convert_to_string(path, None, None, False, None, decimals, letters, False).decode()


class _Renderer(RendererSVG):
    """Writes text as text, formulas as outlines, and images as they are.

    The letters of formulas are placed one by one. An image with a transformation, which matplotlib
    has not resampled, becomes WebP of its own size; its gid may ask for `style.LOSSLESS` and
    `style.PIXELATED`.
    """

    effort = 4
    keeps = False
    """Passages are kept if true: only where identifiers will be those of the caller's prefix."""

    def __init__(self, width: float, height: float, stream: io.StringIO) -> None:
        nothing = dict.fromkeys(("Date", "Creator", "Format", "Type"))
        super().__init__(width, height, stream, None, RASTER_DPI, metadata=nothing)
        self.stream = stream
        self.fonts = repr([mpl.rcParams[name] for name in _FONTS])
        self.shortened: list[Path] = []

    def get_text_width_height_descent(
        self, s: str, prop: FontProperties, ismath: bool | str
    ) -> tuple[float, float, float]:
        return _measured(s, prop, ismath, self.fonts)

    def _convert_path(
        self,
        path: Path,
        transform: Transform | None = None,
        clip: bool | None = None,
        simplify: bool | None = None,
        sketch: tuple | None = None,
    ) -> str:
        if clip is None or not len(path.vertices):  # to be defined, and drawn elsewhere
            return super()._convert_path(path, transform, clip, simplify, sketch)
        window = (0.0, 0.0, self.width, self.height) if clip else None
        drawn = path.cleaned(transform, True, window, simplify=simplify, curves=True, sketch=sketch)
        # to six decimals and then to one, as matplotlib and `_shorten_path` would
        drawn.vertices = drawn.vertices.round(6)
        self.shortened.append(drawn)
        return _written(drawn, 1)

    @contextmanager
    def kept(self) -> Iterator[Passage]:
        """Keep what is written meanwhile."""
        self.writer._XMLWriter__flush()  # the tag that is open belongs to what stands before
        stream, markers, glyphs = self.stream, set(self._markers), set(self._glyph_map)
        start, paths = stream.tell(), len(self.shortened)
        passage = Passage()
        yield passage
        stream.seek(start)
        passage.text = stream.read()
        passage.shortened = self.shortened[paths:]
        passage.markers = {k: v for k, v in self._markers.items() if k not in markers}
        passage.glyphs = {k: v for k, v in self._glyph_map.items() if k not in glyphs}
        used = {a or b for a, b in _REFERENCE.findall(passage.text)}
        passage.clips = {k: v for k, v in self._clipd.items() if v[1] in used}
        brought = set(_IDENTIFIER.findall(passage.text)) | {
            oid for _, oid in passage.clips.values()
        }
        passage.needs = used - brought

    def has_for(self, passage: Passage) -> bool:
        """Tell whether what a passage refers to is there, and what it brings is not."""
        there = {*self._markers.values(), *map(self._adjust_glyph_repr, self._glyph_map)}
        brought = (*passage.markers, *passage.glyphs)
        known = (*self._markers, *self._glyph_map)
        return passage.needs <= there and not set(brought) & set(known)

    def repeat(self, passage: Passage) -> None:
        """Write a passage again."""
        self.writer._XMLWriter__flush()
        self.stream.write(passage.text)
        self.shortened += passage.shortened
        self._markers |= passage.markers
        self._glyph_map |= passage.glyphs
        self._clipd |= passage.clips

    def draw_image(
        self,
        gc: GraphicsContextBase,
        x: float,
        y: float,
        im: np.ndarray,
        transform: Transform | None = None,
    ) -> None:
        height, width = im.shape[:2]
        gid = gc.get_gid() or ""
        if transform is None:  # drawn by Agg at the resolution of the figure
            self._draw_pixels(gc, x, y, im, gid)
            return
        opaque = im[..., 3].min() == 255
        data = to_webp(
            im[..., :3] if opaque else im, effort=self.effort, lossless=style.LOSSLESS in gid
        )
        place = (
            Affine2D().scale(1 / width, 1 / height)
            + transform
            + Affine2D().translate(x, y).scale(1, -1).translate(0, self.height)
        )
        matrix = ",".join(f"{number:.8g}" for number in place.frozen().to_values())
        attributes = {
            "id": gid,
            "width": str(width),
            "height": str(height),
            "transform": f"matrix({matrix})",
            "style": "image-rendering: pixelated" if style.PIXELATED in gid else "",
            "opacity": "" if gc.get_alpha() == 1 else f"{gc.get_alpha():.4g}",
            "xlink:href": f"data:image/webp;base64,{base64.b64encode(data).decode()}",
        }
        clip = self._get_clip_attrs(gc)
        self.writer.start("g", **clip)  # the transformation must not move the clip path
        self.writer.element("image", attrib=attributes)
        self.writer.end("g")

    def _draw_pixels(
        self, gc: GraphicsContextBase, x: float, y: float, im: np.ndarray, gid: str
    ) -> None:
        """Write an image as matplotlib does, but encode the same pixels once."""
        if not im.size:
            return
        height, width = (72.0 * n / self.image_dpi for n in im.shape[:2])
        data = to_png(im)
        attributes = {
            "xlink:href": f"data:image/png;base64,\n{base64.b64encode(data).decode()}",
            "id": gid or self._make_id("image", data),
            "transform": f"scale(1 -1) translate(0 {_short_float_fmt(-height)})",
            "x": _short_float_fmt(x),
            "y": _short_float_fmt(-(self.height - y - height)),
            "width": _short_float_fmt(width),
            "height": _short_float_fmt(height),
        }
        clip = self._get_clip_attrs(gc)
        if clip:
            self.writer.start("g", **clip)
        self.writer.element("image", attrib=attributes)
        if clip:
            self.writer.end("g")

    def draw_text(
        self,
        gc: GraphicsContextBase,
        x: float,
        y: float,
        s: str,
        prop: FontProperties,
        angle: float,
        ismath: bool | str = False,
        mtext: Text | None = None,
    ) -> None:
        if not ismath:
            super().draw_text(gc, x, y, s, prop, angle, ismath, mtext)
            return
        with settings({"svg.fonttype": "path"}):
            super().draw_text(gc, x, y, s, prop, angle, ismath, mtext)


def _saved(
    fig: Figure, columns: Sequence[Column], effort: int, keeps: bool
) -> tuple[list[str], list[tuple[float, float]]]:
    """Return what matplotlib writes of each column, and the columns' windows."""

    def save() -> list[Raw]:
        return [_save_only(axes, fig, effort, keeps) for axes, *_ in columns]

    raws = save()
    if _is_heavy(raws):
        with _rasterised(_heavy(fig)):
            raws = save()
    return [text for text, _ in raws], [(left, right) for _, left, right in columns]


Raw = tuple[str, list[Path]]
"""Text that matplotlib writes of a drawing, and its paths, written with one decimal."""


def _is_heavy(raws: Sequence[Raw]) -> bool:
    """Tell whether drawings had more than `HEAVY` characters with all six decimals."""
    most = sum(len(text) + 14 * sum(len(path.vertices) for path in paths) for text, paths in raws)
    return (
        most
        > HEAVY
        < sum(
            len(_EMBEDDED.sub("", text))
            + sum(len(_written(path, 6)) - len(_written(path, 1)) for path in paths)
            for text, paths in raws
        )
    )


def _save_only(axes: Sequence[Axes], fig: Figure, effort: int, keeps: bool) -> Raw:
    hidden = [ax for ax in fig.axes if ax not in axes and ax.get_visible()]
    for ax in hidden:
        ax.set_visible(False)
    try:
        return _save(fig, effort, keeps)
    finally:
        for ax in hidden:
            ax.set_visible(True)


def _save(fig: Figure, effort: int, keeps: bool) -> Raw:
    stream = io.StringIO()
    width, height = fig.get_size_inches()
    dpi, ground = fig.dpi, fig.patch.get_visible()
    with settings(_CHECKED):
        writer = _Renderer(72 * width, 72 * height, stream)
        writer.effort, writer.keeps = effort, keeps
        try:
            fig.dpi = 72
            fig.patch.set_visible(False)
            renderer = MixedModeRenderer(fig, width, height, RASTER_DPI, writer)  # reads fig.dpi
            fig.draw(renderer)
        finally:
            fig.dpi = dpi
            fig.patch.set_visible(ground)
        renderer.finalize()
    return stream.getvalue(), writer.shortened


def _vertices(artist: Artist) -> int:
    if isinstance(artist, Line2D):
        return len(artist.get_xydata())
    if isinstance(artist, PathCollection):
        return 4 * len(artist.get_offsets())
    if isinstance(artist, Collection):
        return sum(len(path.vertices) for path in artist.get_paths())
    return 0


def _heavy(fig: Figure) -> list[Artist]:
    return [artist for artist in fig.findobj(include_self=False) if _vertices(artist) > 1000]


@contextmanager
def _rasterised(artists: list[Artist]) -> Iterator[None]:
    before = [artist.get_rasterized() for artist in artists]
    for artist in artists:
        artist.set_rasterized(True)
    try:
        yield
    finally:
        for artist, value in zip(artists, before, strict=True):
            artist.set_rasterized(value)


def _shorten(match: re.Match[str]) -> str:
    return _NUMBER.sub(lambda number: f"{float(number[0]):.2f}".rstrip("0").rstrip("."), match[0])


def _shorten_path(match: re.Match[str]) -> str:
    return _NUMBER.sub(lambda number: f"{float(number[0]):.1f}".removesuffix(".0"), match[0])


def _rewrite(raw: str, window: tuple[float, float], prefix: str | None, attributes: str) -> str:
    body = raw[raw.index(">", raw.index("<svg")) + 1 :]
    height = float(re.search(r'viewBox="[^"]* ([^ "]*)"', raw)[1])
    left, width = window[0], window[1] - window[0]
    body = re.sub(r"\s*<defs>\s*<style.*?</style>\s*</defs>", "", body, count=1, flags=re.S)
    body = _NOTHING.sub("", body)
    body = "".join(
        _GEOMETRY.sub(_shorten if part.startswith("<defs>") else _shorten_path, part)
        for part in re.split(r"(<defs>.*?</defs>)", body, flags=re.S)
    )
    used = {a or b for a, b in _REFERENCE.findall(body)}
    prefix = prefix or _hashed(body)

    def identifier(match: re.Match[str]) -> str:
        name = match[1]
        if name in used:
            return f' id="{prefix}-{name}"'
        return f' class="{name}"' if name.startswith("rp-") else ""

    body = _IDENTIFIER.sub(identifier, body)
    body = _REFERENCE.sub(
        lambda m: f"url(#{prefix}-{m[1]})" if m[1] else f'xlink:href="#{prefix}-{m[2]}"', body
    )
    body = _FAMILY.sub("", body)
    body = _SIZE.sub(r"font-size: calc(\1px * var(--rp-text, 1))", body)
    body = _SENTINEL.sub(lambda m: _PAINT[m[0]], body)
    return (
        f'<svg class="rp-svg" xmlns="http://www.w3.org/2000/svg"'
        f' xmlns:xlink="http://www.w3.org/1999/xlink"'
        f' viewBox="{left:g} 0 {width:g} {height:g}" width="100%"'
        f' style="--rp-width:{width:.0f};--rp-height:{height:.0f}"{attributes}'
        f' fill="currentColor" font-family="system-ui, sans-serif"'
        f' stroke-linejoin="round" stroke-linecap="butt">'
        f"{body.strip()}"
    )
