"""Figures: repeatable, themed, never without alternative text."""

import base64
import io
import re

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.backends.backend_svg import RendererSVG
from matplotlib.cbook import get_sample_data
from matplotlib.figure import Figure
from PIL import Image

from explorables.figures import (
    band,
    figure,
    image_axes,
    label,
    show,
    style,
    svg,
    to_html,
    to_svg,
)
from explorables.figures import webp as encoder
from explorables.figures.maps import plan
from explorables.figures.output import PAGE_VARIABLE, front_end
from explorables.figures.style import BLUE, COLOURS, INK, MUTED, ORANGE, RED
from explorables.figures.svg import HEAVY
from explorables.figures.webp import to_png, to_webp
from explorables.states import pack, render
from tests.unchecked import unchecked

ALT = "A straight line that rises from the origin to one."


def drawn() -> object:
    """Return a figure with a line, a band, a label, markers and mathematics."""
    fig, ax = figure()
    x = np.linspace(0, 1, 50)
    ax.plot(x, x, color=BLUE)
    ax.plot(x, x**2, "o", color=ORANGE)
    band(ax, x, x - 0.1, x + 0.1, BLUE)
    label(ax, 0.5, 0.6, "rising <fast>", BLUE)
    ax.set(xlabel="time / s", ylabel=r"$\sigma^2$ / m²", title="Title")
    return fig


def luminance(colour: str) -> float:
    """Return the relative luminance of a colour, as WCAG defines it."""
    channels = np.array([int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)])
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(one: str, other: str) -> float:
    """Return the contrast ratio of two colours."""
    high, low = sorted((luminance(one), luminance(other)), reverse=True)
    return (high + 0.05) / (low + 0.05)


def palette(theme: str) -> dict[str, str]:
    """Return the palette of a theme from the style sheet."""
    sheet = front_end("figure.css")
    start = sheet.index(":root {" if theme == "light" else 'html[data-theme="dark"]')
    block = sheet[start : sheet.index("}", start)]
    return dict(re.findall(r"--rp-(\w+): (#[0-9a-f]{6});", block))


def test_the_same_figure_gives_the_same_text():
    fig = drawn()
    assert to_svg(fig) == to_svg(fig) == to_svg(drawn())


def test_nothing_global_is_touched():
    before = dict(mpl.rcParams)
    to_svg(drawn())
    assert dict(mpl.rcParams) == before


def test_colours_come_from_the_page():
    svg = to_svg(drawn())
    assert "var(--rp-blue, #1f6fb4)" in svg
    assert "currentColor" in svg
    assert INK not in svg
    stripped = re.sub(r"var\([^)]*\)", "", svg)
    assert not any(colour in stripped for colour in (*COLOURS, MUTED))


def test_black_of_a_plain_artist_becomes_the_ink():
    fig, ax = figure()
    ax.axhline(0, color="black")
    assert "#000000" not in to_svg(fig)


def test_the_text_stays_text_and_is_escaped():
    svg = to_svg(drawn(), alt='a "quoted" & <tagged> line')
    assert "rising &lt;fast&gt;" in svg
    assert 'aria-label="a &quot;quoted&quot; &amp; &lt;tagged&gt; line"' in svg
    assert 'role="img"' in svg
    assert "<style" not in svg
    assert "font-family: " not in svg


def test_two_figures_do_not_share_identifiers():
    fig, ax = figure()
    ax.plot([0, 1], [1, 0], "s", clip_on=True)
    identifiers = [set(re.findall(r' id="([^"]*)"', to_svg(f))) for f in (drawn(), fig)]
    assert all(identifiers)
    assert identifiers[0].isdisjoint(identifiers[1])


def test_every_reference_finds_its_target():
    svg = to_svg(drawn())
    targets = set(re.findall(r' id="([^"]*)"', svg))
    references = set(re.findall(r'(?:url\(#|href="#)([^)"]*)', svg))
    assert references == targets


def test_rounding_moves_no_point_by_more_than_a_tenth():
    fig, ax = figure()
    x = np.linspace(0, 1, 30)
    ax.plot(x, np.sin(9 * x), color=BLUE)
    ax.set(xlim=(0, 1), ylim=(-1, 1))
    exact = ax.transData.transform(np.column_stack([x, np.sin(9 * x)])) * 72 / fig.dpi
    path = re.search(r'd="([^"]*)"[^>]*stroke: var\(--rp-blue', to_svg(fig))[1]
    points = np.array(re.findall(r"-?[\d.]+", path), dtype=float).reshape(-1, 2)
    points[:, 1] = 72 * fig.get_figheight() - points[:, 1]
    nearest = np.linalg.norm(exact[:, None] - points, axis=2).min(axis=0)
    assert nearest.max() < 0.1


def test_rounding_moves_no_mark_by_more_than_a_tenth():
    fig, ax = figure()
    points = np.random.default_rng(1).random((30, 2))
    ax.plot(*points.T, "o", color=BLUE)
    ax.set(xlim=(0, 1), ylim=(0, 1), xticks=[], yticks=[])
    exact = ax.transData.transform(points) * 72 / fig.dpi * [1, -1] + [0, 72 * fig.get_figheight()]
    marks = re.findall(r'<use [^>]* x="([\d.]+)" y="([\d.]+)"', to_svg(fig))
    assert np.linalg.norm(np.array(marks, dtype=float) - exact, axis=1).max() < 0.1


def test_a_figure_is_left_as_it_was():
    fig = drawn()
    fig.set_dpi(130)
    to_svg(fig)
    to_html(fig)
    assert fig.dpi == 130
    assert fig.patch.get_visible()


def test_clearing_the_axes_keeps_the_style():
    fig, ax = figure()
    fresh = to_svg(fig)
    ax.plot([0, 1], [0, 1])
    ax.clear()
    assert to_svg(fig) == fresh


def test_heavy_figures_are_rasterised_and_left_as_they_were():
    fig, ax = figure()
    rng = np.random.default_rng(0)
    points = ax.scatter(*rng.normal(size=(2, 20_000)), s=3, c=rng.uniform(size=20_000))
    svg = to_svg(fig)
    assert len(svg) < HEAVY
    assert "data:image/png" in svg
    assert "<text" in svg
    assert not points.get_rasterized()


def embedded(svg: str) -> list[np.ndarray]:
    """Return where the pixels of each embedded picture lie in the drawing, shape (pixels, 2)."""
    pattern = (
        r'xlink:href="data:image/png;base64,([^"]*)"'
        r' transform="scale\(1 -1\) translate\(0 -([\d.]+)\)"'
        r' x="([-\d.]+)" y="([-\d.]+)" width="([-\d.]+)" height="([-\d.]+)"'
    )
    found = []
    for data, *numbers in re.findall(pattern, svg):
        shift, x, y, width, height = map(float, numbers)
        image = np.asarray(Image.open(io.BytesIO(base64.b64decode(data))))
        rows, columns = np.nonzero(image[..., 3] > 127)
        found.append(
            np.column_stack(
                [
                    x + (columns + 0.5) * width / image.shape[1],
                    shift - (y + (rows + 0.5) * height / image.shape[0]),
                ]
            )
        )
    return found


def test_rasterised_points_lie_where_the_axes_have_them():
    fig, axes = figure(1, 2, height=3.37)
    cloud = np.random.default_rng(0).uniform(-2, 2, (30_000, 2))
    extreme = np.array([5.0, 4.0])
    for ax in axes:
        ax.plot(*np.vstack([cloud, extreme]).T, "o", markersize=2, color=BLUE)
        ax.plot(*np.vstack([extreme, -extreme]).T, color=RED, zorder=5)
        ax.set(aspect="equal", xlim=(-6, 6), ylim=(-6, 6))
    svg = to_svg(fig)
    pictures = embedded(svg)
    lines = re.findall(r'd="([^"]*)"[^>]*stroke: var\(--rp-red', svg)
    assert len(pictures) == len(lines) == 2

    height = 72 * fig.get_figheight()
    for ax, pixels, line in zip(axes, pictures, lines, strict=True):
        expected = ax.transData.transform(extreme) * 72 / fig.dpi * [1, -1] + [0, height]
        in_vectors = np.array(re.findall(r"-?[\d.]+", line), dtype=float)[:2]
        outermost = pixels[pixels[:, 0] > pixels[:, 0].max() - 2]
        assert np.abs(in_vectors - expected).max() < 0.1
        assert np.abs(outermost.mean(axis=0) - expected).max() < 1


# ---- columns ----

OPENING = re.compile(r"<svg[^>]*>")
LETTERS = re.compile(r">([^<>]+)</text>")
ON_THE_LEFT = re.compile(r'<text [^>]*text-anchor: end[^>]* x="([\d.]+)"[^>]*>([^<>]+)<')
"""Texts that end at a place: where, and what they say."""


def grid(**options: object) -> Figure:
    """Return two rows of three panels, each with its own title, a legend and a band."""
    fig, axes = figure(2, 3, width=7.4, height=4.0, **options)
    for number, ax in enumerate(axes.flat):
        ax.plot([0, 1], [number, 1], "o-", label=f"line {number}")
        band(ax, np.array([0.0, 1.0]), np.zeros(2), np.ones(2), BLUE)
        ax.set_title(f"panel {number}")
        ax.legend()
    return fig


def windows(markup: str) -> np.ndarray:
    """Return the viewBox of each drawing."""
    boxes = re.findall(r'viewBox="([^"]*)"', markup)
    return np.array([[float(number) for number in box.split()] for box in boxes])


def test_each_column_is_a_drawing_with_its_own_panels():
    fig = grid()
    markup = to_html(fig, alt=ALT)
    first, *drawings = re.split(OPENING, markup)
    for column, drawing in enumerate(drawings):
        own = {f"panel {column}", f"panel {column + 3}", f"line {column}", f"line {column + 3}"}
        named = {text for text in LETTERS.findall(drawing) if text.startswith(("panel", "line"))}
        assert named == own
    assert first == f'<div class="rp-row" role="img" aria-label="{ALT}">'
    assert markup.count("role=") == markup.count("aria-label=") == 1
    assert markup.count('aria-hidden="true"') == len(drawings) == 3
    assert markup.endswith("</div>")


def test_a_caption_that_names_columns_by_letters_letters_them():
    markup = show(untitled(), alt=ALT, caption="(a) One. (b), (c) Two more.").bundle["text/html"]
    drawings = re.split(OPENING, markup)[1:]
    found = [re.findall(r'<text x="([\d.]+)" y="9"[^>]*>\((\w)\)<', text) for text in drawings]
    assert [[letter for _, letter in each] for each in found] == [["a"], ["b"], ["c"]]
    lefts = windows(markup)[:, 0]
    np.testing.assert_allclose([float(each[0][0]) for each in found], lefts, atol=0.1)
    assert "(a)" not in show(grid(), alt=ALT, caption="Three.").bundle["text/html"]


def untitled():
    """Return the figure of three columns without titles."""
    fig = grid()
    for ax in fig.axes:
        ax.set_title("")
    return fig


def test_a_letter_stands_before_the_title_of_its_panel():
    """Beside it there may be no room; the figure itself keeps its titles."""
    fig = untitled()
    fig.axes[1].set_title("second")
    markup = show(fig, alt=ALT, caption="(a) One. (b), (c) Two more.").bundle["text/html"]
    found = [re.sub(r"<[^>]*>", "", text) for text in re.findall(r"<text.*?</text>", markup)]
    assert [text for text in found if text.startswith("(")] == ["(a)", "(b) second", "(c)"]
    assert fig.axes[1].get_title(loc="left") == "second"


def test_the_windows_of_the_columns_tile_the_figure():
    fig = grid()
    boxes, (whole,) = windows(to_html(fig)), windows(to_svg(fig))
    lefts, widths = boxes[:, 0], boxes[:, 2]
    np.testing.assert_allclose([lefts[0], (lefts + widths)[-1]], [0, whole[2]], atol=0.01)
    np.testing.assert_allclose((lefts + widths)[:-1], lefts[1:], atol=0.01)
    assert (boxes[:, [1, 3]] == whole[[1, 3]]).all()
    for ax, left, width in zip(fig.axes[:3], lefts, widths, strict=True):
        panel = ax.get_position()
        assert left < 72 * fig.get_figwidth() * panel.x0
        assert 72 * fig.get_figwidth() * panel.x1 < left + width


def test_taking_a_figure_apart_adds_and_loses_nothing():
    fig = grid()
    row, whole = to_html(fig), to_svg(fig)
    assert sorted(LETTERS.findall(row)) == sorted(LETTERS.findall(whole))
    for mark in ("<path ", "<use ", "<text"):
        drawn = [re.sub(r"<defs>.*?</defs>", "", text, flags=re.S) for text in (row, whole)]
        assert drawn[0].count(mark) == drawn[1].count(mark)
    assert len(row) < 1.2 * len(whole)
    assert all(ax.get_visible() for ax in fig.axes)


def test_the_drawings_of_a_row_do_not_share_identifiers():
    fig, axes = figure(1, 2)
    for ax in axes:  # alike
        ax.plot([0, 1], [1, 0], "s")
    for prefix in (None, "x"):
        markup = to_html(fig, prefix=prefix)
        found = re.findall(r' id="([^"]*)"', markup)
        assert len(found) == len(set(found))
        for drawing in re.split(OPENING, markup)[1:]:
            references = set(re.findall(r'(?:url\(#|href="#)([^)"]*)', drawing))
            assert references <= set(re.findall(r' id="([^"]*)"', drawing))


def spanning() -> Figure:
    """Return a figure with one panel over two."""
    fig, _ = figure(2, 2, height=4.0)
    upper = fig.axes[0].get_gridspec()[0, :]
    for ax in fig.axes[:2]:
        ax.remove()
    fig.add_subplot(upper)
    return fig


def annotated() -> Figure:
    """Return a figure with words beside its panels."""
    fig, _ = figure(1, 2)
    fig.text(0.5, 0.99, "over both")
    return fig


@pytest.mark.parametrize("made", [drawn, spanning, annotated, lambda: figure(3, 1, height=6)[0]])
def test_what_has_no_columns_stays_one_drawing(made):
    fig = made()
    assert to_html(fig, alt=ALT) == to_svg(fig, alt=ALT)


def test_heavy_columns_are_rasterised_and_left_as_they_were():
    fig, axes = figure(1, 2)
    cloud = np.random.default_rng(0).normal(size=(2, 20_000))
    for ax in axes:
        ax.scatter(*cloud, s=3)
    assert len(to_html(fig)) < HEAVY
    assert not any(points.get_rasterized() for ax in axes for points in ax.collections)


def test_columns_with_a_shared_axis_keep_their_numbers():
    fig, axes = figure(1, 2, sharey=True)
    axes[0].set_ylim(0, 30)
    for ax, drawing in zip(axes, re.split(OPENING, to_html(fig))[1:], strict=True):
        places = {text: float(x) for x, text in ON_THE_LEFT.findall(drawing)}
        assert {"0", "10", "20", "30"} <= places.keys()
        assert max(places.values()) < 72 * fig.get_figwidth() * ax.get_position().x0


def test_powers_of_ten_are_text():
    fig, (left, right) = figure(1, 2)
    left.loglog([1e-4, 1e3], [0.01, 100])
    right.semilogy([0, 1], [0.2, 0.9])
    texts = set(LETTERS.findall(to_html(fig)))
    assert {"10⁻⁴", "1", "100", "0.01", "0.3"} <= texts
    assert "DejaVu" not in to_html(fig)  # outlines of letters


@pytest.mark.parametrize(("limits", "between"), [((0.2, 0.9), True), ((0.02, 90.0), False)])
def test_values_between_powers_of_ten_are_labelled_where_there_is_room(limits, between):
    fig, ax = figure()
    ax.semilogy([0, 1], limits)
    ax.set_ylim(limits)
    ax.set_xticks([])
    labels = {text for text in LETTERS.findall(to_svg(fig)) if text[0].isdigit()}
    powers = {f"{10.0**k:g}" for k in range(-3, 4)}
    assert bool(labels - powers) == between
    assert bool(labels & powers) != between


# ---- images in figures ----

MATRIX = r'transform="matrix\(([^)]*)\)"'


def photograph(rows: int = 240, cols: int = 320, corner: int = 0) -> np.ndarray:
    """Return a piece of the photograph that comes with matplotlib."""
    with get_sample_data("grace_hopper.jpg") as file:
        whole = np.asarray(Image.open(file).convert("RGB"))
    return whole[corner : corner + rows, corner : corner + cols].copy()


def coordinates(rows: int, cols: int) -> np.ndarray:
    """Return a picture in which each pixel tells its column (red) and its row (green)."""
    row, col = np.indices((rows, cols), dtype=np.uint8)
    return np.stack([col, row, np.zeros_like(row)], axis=-1)


def webp(svg: str) -> np.ndarray:
    """Return the one WebP image of a figure."""
    (data,) = re.findall(r'xlink:href="data:image/webp;base64,([^"]*)"', svg)
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(data))))


def test_a_photograph_is_stored_at_its_own_resolution():
    photo = photograph(60, 80)
    fig, ax = figure()
    ax.imshow(photo)
    stored = webp(to_svg(fig))
    assert stored.shape == photo.shape
    assert np.abs(stored.astype(int) - photo).mean() < 8


@pytest.mark.parametrize("origin", ["upper", "lower"])
@pytest.mark.parametrize("limits", [(-0.5, 29.5), (10.5, 17.5)])
def test_every_pixel_lies_where_the_axes_have_it(origin, limits):
    fig, ax = figure()
    ax.imshow(coordinates(20, 30), origin=origin, gid=style.LOSSLESS)
    ax.set_xlim(limits)
    svg = to_svg(fig)
    pixels = webp(svg)
    rows, cols = np.indices(pixels.shape[:2]) + 0.5
    a, b, c, d, e, f = map(float, re.search(MATRIX, svg)[1].split(","))
    found = np.stack([a * cols + c * rows + e, b * cols + d * rows + f], axis=-1)
    expected = ax.transData.transform(pixels[..., :2].reshape(-1, 2)) * 72 / fig.dpi
    expected[:, 1] = 72 * fig.get_figheight() - expected[:, 1]
    assert np.abs(found.reshape(-1, 2) - expected).max() < 1e-3
    assert re.search(r'<g clip-path="url\(#[^>]*>\s*<image ', svg)


def test_data_keep_every_value_and_the_edges_of_their_cells():
    fig, ax = figure()
    heights = np.random.default_rng(0).uniform(size=(9, 7))
    ax.imshow(heights, alpha=0.5)
    svg = to_svg(fig)
    expected = mpl.colormaps["cividis"](mpl.colors.Normalize()(heights), bytes=True)
    assert (webp(svg)[..., :3] == expected[..., :3]).all()
    assert 'class="rp-lossless rp-pixelated"' in svg
    assert 'style="image-rendering: pixelated"' in svg
    assert 'opacity="0.5"' in svg


def test_a_photograph_is_no_vector_weight():
    rng = np.random.default_rng(0)
    fig, ax = image_axes(rng.integers(0, 255, (700, 900, 3), dtype=np.uint8))
    ax.plot(*rng.uniform(0, 700, (2, 2000)), color=BLUE)
    svg = to_svg(fig)
    assert len(svg) > HEAVY
    assert "data:image/png" not in svg
    assert "var(--rp-blue" in svg


def test_axes_of_a_picture_are_its_pixels_whatever_is_drawn():
    photo = photograph(60, 80)
    fig, ax = image_axes(photo)
    bare = to_svg(fig)
    assert "<text" not in bare
    assert fig.get_figwidth() / fig.get_figheight() == pytest.approx(80 / 60)
    ax.plot([-50, 200], [30, 30])
    ax.scatter([500], [500])
    assert (*ax.get_xlim(), *ax.get_ylim()) == (-0.5, 79.5, 59.5, -0.5)
    assert np.allclose(ax.get_window_extent().extents, fig.bbox.extents)
    ax.clear()
    assert to_svg(fig) == bare
    assert image_axes(photograph(80, 60))[0].get_figheight() == pytest.approx(5.25)


def test_a_grey_picture_stays_grey():
    grey = np.linspace(40, 200, 1200).reshape(30, 40).astype(np.uint8)
    fig, _ = image_axes(grey)
    assert np.abs(webp(to_svg(fig)).astype(int) - grey[..., None]).max() < 8
    assert "image-rendering" not in to_svg(fig)


def test_axes_of_what_is_no_picture_are_refused():
    for array in (np.zeros((4, 4, 4), np.uint8), np.zeros((0, 4), np.uint8), np.zeros((4, 4))):
        with unchecked(), pytest.raises(ValueError, match="an image must be uint8"):
            image_axes(array)


def overlays(photos: list[np.ndarray]) -> list[object]:
    """Return 20 frames with 200 marks that move over photographs, in turn."""
    points = np.random.default_rng(0).uniform(0, 1, (2, 200)) * [[320], [240]]
    frames = []
    for number in range(20):
        fig, ax = image_axes(photos[number % len(photos)])
        ax.plot(*points + number, "o", color=ORANGE, markersize=5)
        frames.append(render(fig, ALT))
    return frames


def test_states_of_an_explorer_share_their_photograph():
    photo = photograph()
    frames = overlays([photo])
    assert len({frame.data for frame in frames}) == 20
    once = 4 / 3 * len(to_webp(photo))  # as text
    assert len(frames[0].data) < once + 40_000
    assert len(pack(frames)) < 1.5 * once + 20 * 10_000


def test_the_same_pixels_are_encoded_once(monkeypatch: pytest.MonkeyPatch):
    encoded = []

    def saved(image: Image.Image, kind: str, **options: object) -> bytes:
        encoded.append((kind, options.get("method")))
        return f"{kind} {image.size} {options}".encode()

    monkeypatch.setattr(encoder, "_encoded", {})
    monkeypatch.setattr(encoder, "_saved", saved)
    red, blue = np.zeros((2, 4, 6, 3), dtype=np.uint8)
    blue[..., 2] = 255
    tall = np.zeros((6, 4, 3), dtype=np.uint8)
    for _ in range(2):
        for picture in (red, blue, tall):
            assert to_webp(picture) == to_webp(picture.copy()) != to_webp(picture, effort=0)
            assert to_png(picture).startswith(b"PNG")
    assert sorted(encoded, key=str) == 3 * [("PNG", None)] + 3 * [("WEBP", 0)] + 3 * [("WEBP", 4)]
    for shade in range(2 * encoder.REMEMBERED):
        to_webp(np.full((1, 1), shade, dtype=np.uint8))
    assert len(encoder._encoded) == encoder.REMEMBERED
    to_webp(red)
    assert len(encoded) == 9 + 2 * encoder.REMEMBERED + 1  # forgotten, and encoded anew


def test_what_is_drawn_as_pixels_is_written_as_matplotlib_writes_it(
    monkeypatch: pytest.MonkeyPatch,
):
    fig, (left, right) = figure(1, 2)
    left.imshow(photograph(), interpolation="nearest")
    right.scatter(*np.random.default_rng(1).random((2, 40)), rasterized=True, gid="rp-dots")
    ours = to_svg(fig, prefix="x")

    def theirs(self: RendererSVG, gc: object, x: float, y: float, im: np.ndarray, _: str) -> None:
        RendererSVG.draw_image(self, gc, x, y, im)

    monkeypatch.setattr(svg._Renderer, "_draw_pixels", theirs)
    assert ours.count("<image") == 2
    assert ours == to_svg(fig, prefix="x")


def test_states_with_photographs_of_their_own_stay_small():
    frames = overlays([photograph(corner=9 * k) for k in range(20)])
    assert len(pack(frames)) < 1_000_000


def test_masks_are_encoded_without_loss():
    mask = np.random.default_rng(0).integers(0, 2, (40, 50), dtype=np.uint8) * 255
    frame = render(mask, ALT, effort=0, lossless=True)
    assert (np.asarray(Image.open(io.BytesIO(frame.data)).convert("L")) == mask).all()


def test_panels_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="5 × 1 panels do not fit"):
        figure(5, height=3)


def test_panels_stand_where_their_margins_leave_them():
    """Inches to the left, right, below, above, and between panels."""
    _, axes = figure(2, 3, width=9, height=5)
    boxes = np.array([[ax.get_position().extents for ax in row] for row in axes]) * [9, 5, 9, 5]
    np.testing.assert_allclose(boxes[-1, 0, :2], [0.8, 0.56])
    np.testing.assert_allclose(boxes[0, -1, 2:], [9 - 0.2, 5 - 0.32])
    np.testing.assert_allclose(boxes[:, 1:, 0] - boxes[:, :-1, 2], 0.98)
    np.testing.assert_allclose(boxes[:-1, :, 1] - boxes[1:, :, 3], 0.82)


def test_a_plan_holds_its_points_with_a_margin():
    _, ax = figure()
    plan(ax, np.array([[1.0, -2], [4, 5]]), margin=0.5)
    assert (*ax.get_xlim(), *ax.get_ylim(), ax.get_aspect()) == (0.5, 4.5, -2.5, 5.5, 1.0)


def test_ellipses_lie_two_deviations_away_in_every_direction():
    covs = np.array([[[4.0, 1.5], [1.5, 1.0]], [[0.01, 0.0], [0.0, 9.0]]])
    means = np.array([[1.0, 2.0], [-3.0, 0.0]])
    _, ax = figure()
    style.ellipses(ax, means, covs, BLUE)
    rims = np.stack(ax.lines[0].get_data(), axis=-1).reshape(2, -1, 2)[:, :-1]
    off = rims - means[:, None]
    np.testing.assert_allclose(np.einsum("nki,nij,nkj->nk", off, np.linalg.inv(covs), off), 4.0)


def test_transparent_parts_of_a_picture_stay_transparent():
    image = np.full((6, 8, 4), 255, np.uint8)
    image[:3, :, 3] = 0
    fig, ax = figure()
    ax.imshow(image, gid=style.LOSSLESS)
    np.testing.assert_array_equal(webp(to_svg(fig))[..., 3], image[..., 3])
    assert fig.dpi == 100  # as it was


def test_axes_are_squeezed_like_those_of_matplotlib():
    assert figure(2, 3, width=9, height=5)[1].shape == (2, 3)
    assert figure(1, 2)[1].shape == (2,)


@pytest.mark.parametrize("alt", ["", "   ", "short", "plot_of_the_robot_position.png", None, 3])
def test_useless_alternative_text_is_refused(alt):
    fig, _ = figure()
    with unchecked(), pytest.raises(ValueError, match="alt must say"):
        show(fig, alt=alt)


def test_alternative_text_is_required():
    fig, _ = figure()
    with pytest.raises(TypeError, match="alt"):
        show(fig)


def test_a_shown_figure_has_caption_and_alternative_text():
    shown = show(drawn(), alt=ALT, caption="With $\\sigma < 1$ & more")._repr_mimebundle_()
    assert shown["text/plain"] == ALT
    html = shown["text/html"]
    formula = '<span class="math">\\(\\sigma &lt; 1\\)</span>'
    assert f"<figcaption>With {formula} &amp; more</figcaption></figure>" in html
    assert f'aria-label="{ALT}"' in html


def test_a_name_is_the_address_of_a_figure():
    html = show(drawn(), alt=ALT, caption="One.", name="worst-line").bundle["text/html"]
    assert '<figure class="rp-figure" id="fig-worst-line">' in html
    assert " id=" not in show(drawn(), alt=ALT).bundle["text/html"].split("<svg")[0]


@pytest.mark.parametrize("name", ["Worst", "worst line", "worst_line", "-worst", "", "fig:a"])
def test_a_name_that_is_no_address_is_refused(name):
    with pytest.raises(ValueError, match="name must be"):
        show(drawn(), alt=ALT, caption="One.", name=name)


def test_a_name_without_a_caption_is_refused():
    with pytest.raises(ValueError, match="needs a caption"):
        show(drawn(), alt=ALT, name="worst-line")


def test_a_page_carries_the_style_sheet_itself(monkeypatch):
    fig = drawn()
    assert "<style>" in show(fig, alt=ALT)._repr_mimebundle_()["text/html"]
    monkeypatch.setenv(PAGE_VARIABLE, "1")
    assert "<style>" not in show(fig, alt=ALT)._repr_mimebundle_()["text/html"]


@pytest.mark.parametrize("shape", [(4,), (4, 4, 2), (4, 4, 4, 3)])
def test_an_array_that_is_no_image_is_refused(shape):
    with pytest.raises(ValueError, match="an image must be uint8"):
        to_webp(np.zeros(shape, np.uint8))
    with pytest.raises(ValueError, match="got float64"):
        to_webp(np.zeros((4, 4)))


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_series_colours_can_be_read_as_text(theme):
    colours = palette(theme)
    names = ("ink", "muted", "blue", "orange", "green", "purple", "red", "teal", "magenta", "olive")
    ratios = {name: contrast(colours[name], colours["ground"]) for name in names}
    assert min(ratios.values()) >= 4.5, ratios


def test_fallback_colours_are_those_of_the_light_theme():
    light = palette("light")
    for name in light.keys() - {"ink", "ground"}:
        assert getattr(style, name.upper()) == light[name]
