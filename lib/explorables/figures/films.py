"""Films: many frames in one file, played, paused and stepped through, still on paper."""

import base64
import json
from collections.abc import Iterable, Iterator
from hashlib import sha256
from operator import length_hint

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox
from PIL import Image

from explorables.figures.output import (
    check_alt,
    check_name,
    figcaption,
    front_end,
    image_element,
    on_page,
    opening,
    style_element,
)
from explorables.figures.style import GROUND, STYLE
from explorables.figures.ticks import checked, settings
from explorables.figures.webp import check_image, to_animated_webp, to_webp
from explorables.media import Shown, data_element
from explorables.progress import progress

KEY_FRAMES = 5
"""Frames that stand for a film on paper; the first of them where no script runs."""

KEY_WIDTH = 400
"""Pixels of the longer side of the key frames that only paper shows."""

MOST_BYTES = 3_000_000
"""Largest film; a page of the book weighs at most 5 MB, and as text a film grows by a third."""

_CHECKED = checked(STYLE)
_HUES = 2 * np.array([0.213, 0.715, 0.072]) - np.eye(3)  # turned by 180°
_DARK = " ".join(f"{-0.84 * r:.4f} {-0.84 * g:.4f} {-0.84 * b:.4f} 0 0.92" for r, g, b in _HUES)
_DARK += " 0 0 0 1 0"


def film(
    frames: Iterable[np.ndarray | Figure],
    *,
    fps: float,
    alt: str,
    caption: str | None = None,
    name: str | None = None,
    poster: int = 0,
) -> Shown:
    """Show a film that the reader starts; nothing moves before.

    The frames are one animated WebP, in which a frame stores what has changed. A script takes it
    apart, so that the film can be stepped in both directions. Under reduced motion it advances by
    one frame a second; on paper stands a strip of key frames; without scripts its poster. A
    film of drawings without photographs has dark ground on a dark page.

    Parameters
    ----------
    frames
        Images of one size, of type uint8 and shape (height, width) or (height, width, 3); or
        figures, which become images on light ground. A generator may draw on one figure.
    fps
        Frames per second, at most 60.
    alt
        What a reader who cannot see the film has to know: what is shown, and what happens.
    caption, name
        As for `show`.
    poster
        The frame that stands until the reader plays the film, which then begins at its beginning.

    Raises
    ------
    ValueError
        If there are fewer than two frames, a frame is no 8-bit image or of another size than the
        first, there is no such `poster`, `fps` is out of range, the film is too large, or the
        alternative text does not serve.

    Examples
    --------
    >>> growing = (np.tri(60, 80, k, dtype=np.uint8) * 255 for k in range(-60, 80))
    >>> film(growing, fps=20, alt="A white triangle grows until it covers the picture.")
    A white triangle grows until it covers the picture.
    """
    text = check_alt(alt)
    check_name(name, caption)
    if not 0 < fps <= 60:
        raise ValueError(f"fps must be positive and at most 60, got {fps}")
    images, photographs = _images(frames)
    if not 0 <= poster < len(images):
        raise ValueError(f"poster must be one of {len(images)} frames, got {poster}")
    duration = round(1000 / fps)
    data = to_animated_webp(images, duration_ms=duration)
    if len(data) > MOST_BYTES:
        raise ValueError(
            f"{len(images)} frames of {_size(images[0])} pixels take {len(data) / 1e6:.1f} MB, more"
            f" than {MOST_BYTES / 1e6:.1f} MB: show fewer or smaller ones"
        )
    return Shown(
        {
            "text/html": _markup(images, data, duration, text, caption, name, photographs, poster),
            "text/plain": text,
        }
    )


def _images(
    frames: Iterable[np.ndarray | Figure],
) -> tuple[list[np.ndarray], dict[int, np.ndarray] | None]:
    """Return the frames as images, and where drawings hold photographs; None if none is a drawing.

    Places are by number of the axes: left, top, right and bottom as shares of the frame, over all
    frames.
    """
    images: list[np.ndarray] = []
    photographs: dict[int, np.ndarray] | None = {}
    for place, frame in enumerate(progress(frames, "film", length_hint(frames) or None)):
        if not isinstance(frame, Figure):
            pixels, photographs = frame, None
        else:
            pixels = _pixels(frame)
            for k, box in _photographs(frame) if photographs is not None else ():
                known = photographs.get(k, box)
                photographs[k] = np.r_[np.minimum(known, box)[:2], np.maximum(known, box)[2:]]
        images.append(check_image(pixels, channels=(3,), name="frames").copy())
        if pixels.shape != images[0].shape:
            sizes = f"{_size(pixels)}, the first has {_size(images[0])}"
            raise ValueError(f"frame {place} has {sizes}: the frames must be of one size")
    if len(images) < 2:
        raise ValueError(f"a film needs two frames or more, got {len(images)}")
    return images, photographs


def _photographs(fig: Figure) -> Iterator[tuple[int, np.ndarray]]:
    """Yield the axes that hold an image, and its place in the figure as `_images` has it."""
    for k, ax in enumerate(fig.axes):
        for image in ax.images:
            if box := Bbox.intersection(image.get_window_extent(), ax.bbox):
                (left, low), (right, high) = fig.transFigure.inverted().transform(box)
                yield k, np.array([left, 1 - high, right, 1 - low])


def _pixels(fig: Figure) -> np.ndarray:
    """Return what a file of the figure would show, without writing one."""
    own, ground = fig.canvas, fig.get_facecolor()
    canvas = FigureCanvasAgg(fig)
    fig.set_facecolor(GROUND)
    try:
        with settings(_CHECKED):
            canvas.draw()
    finally:
        fig.set_facecolor(ground)
        fig.set_canvas(own)
    return np.asarray(canvas.buffer_rgba())[..., :3]


def _size(image: np.ndarray) -> str:
    return " × ".join(map(str, [*image.shape[1::-1], *image.shape[2:]]))


def _markup(
    images: list[np.ndarray],
    data: bytes,
    duration: int,
    alt: str,
    caption: str | None,
    name: str | None,
    photographs: dict[int, np.ndarray] | None,
    poster: int,
) -> str:
    count = len(images)
    spread = np.linspace(0, count - 1, KEY_FRAMES).round().astype(int)
    spread[np.abs(spread - poster).argmin()] = poster
    keys = "".join(
        _key(images[place], place, count, alt, small=place != poster)
        for place in np.unique(spread).tolist()
    )
    height, width = images[0].shape[:2]
    columns = KEY_FRAMES if width < 1.6 * height else 3  # on paper
    numbers = {"count": count, "duration": duration, "width": width, "height": height}
    spec = json.dumps(numbers | {"alt": alt, "poster": poster})
    key = sha256(data + alt.encode()).hexdigest()[:12]
    canvas, style, shade = "rp-canvas", f"--rp-columns: {columns}", ""
    if photographs == {}:
        canvas += " rp-drawing"
    elif photographs:
        shade = _shade(f"shade-{key}", photographs.values())
        canvas += f" rp-shaded shade-{key}"
    states = base64.b64encode(data).decode()
    script = "" if on_page() else f"<script>{front_end('film.js')}</script>"
    return (
        f"{style_element('figure.css', 'explorer.css', 'film.css')}"
        f'<div class="rp-film" id="film-{key}">{opening("rp-figure", name)}'
        f'<div class="{canvas}" style="{style}">{shade}{keys}</div>'
        f"{figcaption(caption)}</figure>"
        f"{data_element('rp-spec', spec)}{data_element('rp-states', json.dumps(states))}"
        f"{script}</div>"
    )


def _shade(name: str, boxes: Iterable[np.ndarray]) -> str:
    """Write a filter that turns a frame dark but for its photographs.

    It is the style sheet's ``invert(0.92) hue-rotate(180deg)`` in one matrix; a part of the source
    is cut out by the region of a filter that does nothing. The rule stands in the page, since a
    style sheet would look for the filter in its own file.
    """
    parts = [
        f'<feOffset in="SourceGraphic" result="p{k}" x="{x:.4f}" y="{y:.4f}" '
        f'width="{right - x:.4f}" height="{bottom - y:.4f}"/>'
        for k, (x, y, right, bottom) in enumerate(boxes)
    ]
    nodes = "".join(f'<feMergeNode in="p{k}"/>' for k in range(len(parts)))
    dark = 'html[data-theme="dark"]', 'body[data-jp-theme-light="false"]'
    rule = ", ".join(f"{page} .{name} :is(canvas, .rp-key img)" for page in dark)
    return (
        f"<style>@media screen {{ {rule} {{ filter: url(#{name}); }} }}</style>"
        '<svg class="rp-filter" width="0" height="0" aria-hidden="true">'
        f'<filter id="{name}" x="0" y="0" width="1" height="1" primitiveUnits="objectBoundingBox" '
        'color-interpolation-filters="sRGB">'
        f'<feColorMatrix values="{_DARK}" result="dark"/>{"".join(parts)}'
        f'<feMerge><feMergeNode in="dark"/>{nodes}</feMerge></filter></svg>'
    )


def _key(image: np.ndarray, place: int, count: int, alt: str, *, small: bool) -> str:
    picture = Image.fromarray(image)
    if small:  # only the poster is seen on screens
        picture.thumbnail((KEY_WIDTH, KEY_WIDTH))
        alt = f"Frame {place + 1} of {count} of the same film."
    element = image_element(to_webp(np.asarray(picture)), "image/webp", picture.size, alt)
    hidden = " hidden" if small else ""
    number = f"<small hidden>{place + 1} of {count}</small>"
    return f'<span class="rp-key"{hidden}>{element}{number}</span>'
