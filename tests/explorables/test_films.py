"""Films: what is stored, what stands for it without scripts and on paper, what is refused."""

import base64
import html
import io
import json
import re

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image, ImageSequence

from explorables.figures import figure, film, films
from explorables.figures.output import PAGE_VARIABLE
from explorables.figures.style import BLUE
from tests.unchecked import unchecked

ALT = "A bright square moves over a dark ground, left to right."


def frames(count=12, shape=(48, 64)):
    """Return images in which a square moves over a gradient."""
    ground = np.linspace(0, 90, shape[1]).astype(np.uint8)
    images = np.tile(ground, (count, shape[0], 1))
    for number, image in enumerate(images):
        image[10:20, 4 * number : 4 * number + 10] = 240
    return list(images)


def markup(images, fps=10, **options):
    """Return the HTML of a film."""
    return film(images, fps=fps, **({"alt": ALT} | options))._repr_mimebundle_()["text/html"]


def stored(text):
    """Return the animated WebP of a film."""
    states = re.search(r'class="rp-states">([^<]*)</script>', text)[1]
    return Image.open(io.BytesIO(base64.b64decode(json.loads(states))))


def keys(text):
    """Return the key frames of a film: their pixels, alternative texts, and whether hidden."""
    pattern = r'<span class="rp-key"( hidden)?><img [^>]*alt="([^"]*)"[^>]*base64,([^"]*)"'
    return [
        (np.asarray(Image.open(io.BytesIO(base64.b64decode(data)))), html.unescape(alt), bool(off))
        for off, alt, data in re.findall(pattern, text)
    ]


def test_the_frames_are_those_that_were_given():
    images = frames()
    shown = [np.asarray(f.convert("L")) for f in ImageSequence.Iterator(stored(markup(images)))]
    assert len(shown) == len(images)
    assert stored(markup(images)).info["loop"] == 0  # for ever
    for image, frame in zip(images, shown, strict=True):
        assert np.abs(frame.astype(int) - image).mean() < 6


def test_frames_that_stand_still_last_as_long_as_all_of_them():
    images = frames(3)
    film_of = stored(markup([images[0], *[images[1]] * 4, images[2]], fps=20))
    durations = []
    for number in range(film_of.n_frames):
        film_of.seek(number)
        film_of.load()
        durations.append(film_of.info["duration"])
    assert sum(durations) == 6 * 50
    assert all(duration % 50 == 0 for duration in durations)


def test_what_does_not_change_is_not_stored_again():
    rng = np.random.default_rng(0)
    ground = rng.integers(0, 255, (120, 160, 3), dtype=np.uint8)
    images = [ground.copy() for _ in range(30)]
    for number, image in enumerate(images):
        image[40:50, 5 * number : 5 * number + 10] = 255
    several, two = (len(stored(markup(i)).fp.getvalue()) for i in (images, images[:2]))
    assert several < 2 * two


def test_key_frames_stand_for_the_film():
    images = frames(12, shape=(300, 500))
    text = markup(images)
    found = keys(text)
    assert "--rp-columns: 3" in text
    assert "--rp-columns: 5" in markup(frames())
    assert [hidden for _, _, hidden in found] == [False, True, True, True, True]
    assert [alt for _, alt, _ in found] == [
        ALT,
        *(f"Frame {number} of 12 of the same film." for number in (4, 7, 9, 12)),
    ]
    assert [pixels.shape[:2] for pixels, _, _ in found] == [(300, 500), *[(240, 400)] * 4]
    assert np.abs(found[0][0][..., 0].astype(int) - images[0]).mean() < 6
    assert re.findall(r"<small hidden>(\d+) of 12</small>", text) == ["1", "4", "7", "9", "12"]
    assert len(keys(markup(frames(3)))) == 3


def test_a_generator_may_draw_on_one_figure():
    fig, ax = figure(width=3, height=2.3)

    def drawn(height):
        ax.clear()
        ax.plot([0, 1], [height, height], color=BLUE, linewidth=6)
        ax.set(ylim=(0, 1))
        return fig

    before = fig.get_facecolor(), fig.dpi, fig.canvas
    shown = ImageSequence.all_frames(stored(markup(drawn(h) for h in (0.2, 0.5, 0.8))))
    assert (fig.get_facecolor(), fig.dpi, fig.canvas) == before
    assert shown[0].size == (300, 230)
    rows = [int((np.asarray(image)[:, 200, 0] < 100).nonzero()[0].mean()) for image in shown]
    assert rows[0] > rows[1] + 20 > rows[2] + 40
    corner = np.asarray(shown[0].convert("RGB"))[2, 2]
    assert corner.min() > 245, "figures stand on light ground"


def regions(text):
    """Return the places of photographs in a film, as shares of the frame: x, y, width, height."""
    parts = re.findall(r'<feOffset [^>]*x="(.*?)" y="(.*?)" width="(.*?)" height="(.*?)"', text)
    return np.array(parts, dtype=float)


def test_photographs_among_drawings_keep_their_colours_where_they_stand():
    def drawn():
        for shift in (0, 10):
            fig = Figure((4, 2), dpi=50)
            left, right = fig.add_axes((0.1, 0.25, 0.4, 0.5)), fig.add_axes((0.6, 0.1, 0.3, 0.8))
            left.imshow(frames()[0], aspect="auto", extent=(0, 20, 0, 10))
            left.set(xlim=(shift, 20), ylim=(0, 20))
            right.plot([0, 1], [0, 1])
            yield fig

    text = markup(drawn())
    assert regions(text) == pytest.approx(np.array([[0.1, 0.5, 0.4, 0.25]]), abs=1e-3)
    name = re.search(r'<filter id="(.*?)"', text)[1]
    assert f"filter: url(#{name});" in text
    assert f'class="rp-canvas rp-shaded {name}"' in text
    matrix = np.array(re.search(r'values="(.*?)"', text)[1].split(), dtype=float).reshape(4, 5)
    assert matrix @ [1, 1, 1, 1, 1] == pytest.approx([0.08, 0.08, 0.08, 1], abs=1e-3)  # white
    assert matrix @ [0, 0, 0, 1, 1] == pytest.approx([0.92, 0.92, 0.92, 1], abs=1e-3)
    red = matrix @ [0.9, 0.1, 0.1, 1, 1]
    assert red[0] > red[1] + 0.2  # the hue stays


@pytest.mark.parametrize("photograph", [False, True])
def test_a_film_of_drawings_turns_dark_with_the_page_and_photographs_stay(photograph):
    def drawn():
        fig, ax = figure(width=2, height=2)
        for k in range(3):
            ax.clear()
            if photograph and k == 2:
                ax.imshow(frames()[k])
            ax.plot([0, k], [0, 1])
            yield fig

    text = markup(drawn())
    assert ('class="rp-canvas rp-drawing"' in text) != photograph
    assert len(regions(text)) == photograph
    for kind in ("rp-drawing", "rp-shaded"):
        assert kind not in markup(frames()).split("</style>")[-1]


def test_a_generator_may_draw_into_one_array():
    image = np.zeros((48, 64), np.uint8)

    def drawn(height):
        image[:] = 20
        image[height : height + 10] = 240
        return image

    shown = stored(markup(drawn(height) for height in (0, 15, 30)))
    assert shown.n_frames == 3
    rows = [np.asarray(f.convert("L"))[:, 0].argmax() for f in ImageSequence.Iterator(shown)]
    assert (np.diff(rows) > 10).all()


def test_the_script_comes_with_the_output_but_not_on_a_page(monkeypatch):
    live = markup(frames())
    assert "explorablesFilms" in live
    assert "<style>" in live
    monkeypatch.setenv(PAGE_VARIABLE, "1")
    page = markup(frames())
    assert "explorablesFilms" not in page
    assert "<style>" not in page
    assert markup(frames()) == page


def test_texts_cannot_leave_their_place():
    alt = 'A square that moves: </script><b> & "so on".'
    shown = film(frames(), fps=10, alt=alt, caption="With $x < 1$")
    text = shown._repr_mimebundle_()["text/html"]
    assert repr(shown) == alt
    assert text.count("</script>") == 3
    assert keys(text)[0][1] == alt
    spec = json.loads(re.search(r'class="rp-spec">(.*?)</script>', text, re.S)[1])
    size = {"count": 12, "width": 64, "height": 48, "poster": 0}
    assert spec == size | {"duration": 100, "alt": alt}
    assert r'With <span class="math">\(x &lt; 1\)</span></figcaption>' in text


@pytest.mark.parametrize(
    ("images", "message"),
    [
        ([], "two frames or more, got 0"),
        (frames(1), "two frames or more, got 1"),
        ([np.zeros((4, 4))] * 2, "an image must be uint8 of shape .*, got float64"),
        ([np.zeros((4, 4, 4), np.uint8)] * 2, r"height, width\[, 3\]"),
        (
            [np.zeros((4, 6), np.uint8), np.zeros((4, 5), np.uint8)],
            "frame 1 has 5 × 4, the first has 6 × 4",
        ),
        ([np.zeros((4, 6), np.uint8), np.zeros((4, 6, 3), np.uint8)], "frame 1 has 6 × 4 × 3"),
        ([Figure((1, 1), dpi=50), Figure((2, 1), dpi=50)], "frame 1 has 100 × 50"),
        (["frame-1.png", "frame-2.png"], "an image must be uint8 .*, got str"),
    ],
)
def test_frames_that_make_no_film_are_refused(images, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        markup(images)


@pytest.mark.parametrize("fps", [0, -5, 61, float("nan"), float("inf")])
def test_speeds_that_cannot_be_shown_are_refused(fps):
    with pytest.raises(ValueError, match="fps must be positive and at most 60, got"):
        markup(frames(), fps=fps)


def test_useless_alternative_text_is_refused():
    with pytest.raises(ValueError, match="alt must say"):
        markup(frames(), alt="film.webp")


def test_a_film_too_large_for_a_page_is_refused(monkeypatch):
    monkeypatch.setattr(films, "MOST_BYTES", 500)
    with pytest.raises(ValueError, match=r"12 frames of 64 × 48 pixels take .* MB, more than"):
        markup(frames())


def test_a_poster_stands_until_the_film_is_played():
    text = markup(frames(12), poster=5)
    found = keys(text)
    assert re.findall(r"<small hidden>(\d+) of 12</small>", text) == ["1", "4", "6", "9", "12"]
    assert [hidden for *_, hidden in found] == [True, True, False, True, True]
    assert [alt == ALT for _, alt, _ in found] == [False, False, True, False, False]
    assert '"poster": 5' in text
    for wrong in (-1, 12):
        with pytest.raises(ValueError, match=f"one of 12 frames, got {wrong}"):
            markup(frames(12), poster=wrong)
