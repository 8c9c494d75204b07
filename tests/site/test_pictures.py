"""Photographs, label images and films on a page opened from disk: keys, themes, paper, rest."""

import base64
import io
import json
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageSequence
from playwright.sync_api import Browser, ElementHandle, Page

from explorables.figures import film
from tests.site import extra
from tests.site.accessibility import serious, violations
from tests.site.conftest import Visit
from tests.site.driver import PICTURE
from tests.site.measures import WIDE_ELEMENTS

PALETTE = {(30, 60, 110), (20, 130, 135), (215, 150, 40), (245, 225, 170)}
HEAVIEST = 5_000_000
DRAWN = "([root, frame]) => root.dataset.drawn === String(frame)"


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of pictures."""
    return extra.build("pictures", tmp_path_factory.mktemp("pictures"))


@pytest.fixture
def enter(browser: Browser, built: Path) -> Iterator[Callable[..., Visit]]:
    """Open the page from disk; keyword arguments go to the browser context."""
    with extra.visits(browser, built) as make:
        yield make


def films(page: Page) -> list[ElementHandle]:
    """Return the films of a page: the window over the portrait, the walk."""
    found = page.query_selector_all(".rp-film")
    assert len(found) == 2
    return found


def expected(root: ElementHandle, built: Path) -> list[np.ndarray]:
    """Return the frames of a film as Pillow takes them out of what is stored."""
    script = (built.parent / root.get_attribute("data-states")).read_text()
    data = json.loads(script.split(", ", 1)[1].removesuffix(");\n"))
    film = Image.open(io.BytesIO(base64.b64decode(data)))
    frames = []
    for image in ImageSequence.Iterator(film):
        image.load()
        step = json.loads(root.query_selector(".rp-spec").text_content())["duration"]
        frames += [np.asarray(image.convert("RGB")).astype(int)] * (image.info["duration"] // step)
    return frames


def frame_of(root: ElementHandle, frame: int) -> np.ndarray:
    """Return the picture of a film once it shows a frame."""
    root.owner_frame().wait_for_function(DRAWN, arg=[root, frame])
    png = root.eval_on_selector("canvas", "node => node.toDataURL('image/png').split(',')[1]")
    return np.asarray(Image.open(io.BytesIO(base64.b64decode(png))).convert("RGB")).astype(int)


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_page_is_sound(enter: Callable[..., Visit], theme: str) -> None:
    """No error, no other host, nothing that axe finds, and it fits a telephone."""
    visitor = enter(color_scheme=theme)
    page = visitor.page
    for root in films(page):
        root.query_selector("button[aria-label='One frame on']").click()
        frame_of(root, 1)
    found = serious(violations(page))
    page.set_viewport_size({"width": 390, "height": 844})
    wide = page.evaluate(WIDE_ELEMENTS)
    assert not visitor.errors
    assert not visitor.strangers
    assert not found, "\n".join(found)
    assert not wide, "\n".join(wide)


def test_the_page_is_light_enough(built: Path) -> None:
    """The page with all that it can load of its own weighs less than any page may."""
    states = list((built.parent / "_static" / "explorers").iterdir())
    assert built.stat().st_size + sum(path.stat().st_size for path in states) < HEAVIEST


def test_marks_move_over_the_photograph(enter: Callable[..., Visit]) -> None:
    """The photograph stays, at its own resolution; the number of marks follows the slider."""
    page = enter().page
    root = page.query_selector_all(".explorer")[0]
    slider = root.query_selector("input[type=range]")

    def look() -> tuple[str, int]:
        assert not page.evaluate(PICTURE, root)["complaint"]
        source = root.query_selector("image").get_attribute("xlink:href")
        return source, len(root.query_selector_all(".rp-canvas svg use"))

    photograph, marks = look()
    slider.focus()
    page.keyboard.press("Home")
    assert look() == (photograph, 10)
    page.keyboard.press("ArrowRight")
    assert look() == (photograph, 20)
    assert marks == 200
    data = base64.b64decode(photograph.removeprefix("data:image/webp;base64,"))
    assert Image.open(io.BytesIO(data)).size == (320, 240)


def test_a_label_image_keeps_its_labels(enter: Callable[..., Visit], built: Path) -> None:
    """Every pixel that the page shows has the colour of a class, and its edges."""
    page = enter().page
    root = page.query_selector_all(".explorer")[1]
    root.query_selector("input[type=range]").focus()
    seen = set()
    for key in ("Home", "End"):
        page.keyboard.press(key)
        seen.add(page.evaluate(PICTURE, root)["picture"])
        image = root.query_selector("img")
        name = image.evaluate("node => node.src").split("/")[-1]
        file = built.parent / "_static" / "explorers" / name
        colours = np.unique(np.asarray(Image.open(file)).reshape(-1, 3), axis=0)
        assert set(map(tuple, colours.tolist())) <= PALETTE
        assert image.evaluate("node => getComputedStyle(node).imageRendering") == "pixelated"
        assert image.bounding_box()["width"] > 600
    assert len(seen) == 2


def test_films_are_stepped_by_keys(enter: Callable[..., Visit], built: Path) -> None:
    """Every key leads to the frame that Pillow finds there, forwards and backwards."""
    page = enter().page
    for root in films(page):
        frames = expected(root, built)
        last = len(frames) - 1
        track = root.query_selector("input")
        assert track.get_attribute("max") == str(last)
        track.focus()
        steps = {"ArrowRight": 1, "End": last, "ArrowLeft": last - 1, "Home": 0}
        for key, frame in steps.items():
            page.keyboard.press(key)
            assert np.abs(frame_of(root, frame) - frames[frame]).mean() < 1, (key, frame)
            assert track.get_attribute("aria-valuetext") == f"{frame + 1} of {len(frames)}"
        for frame in range(1, 8):
            page.keyboard.press("ArrowRight")
            assert np.abs(frame_of(root, frame) - frames[frame]).mean() < 1, frame
        page.keyboard.press("ArrowLeft")
        assert np.abs(frame_of(root, 6) - frames[6]).mean() < 1


@pytest.mark.parametrize(("motion", "pause_ms"), [("no-preference", 83), ("reduce", 1000)])
def test_films_move_when_they_are_told(
    enter: Callable[..., Visit], motion: str, pause_ms: int
) -> None:
    """Still until Play; then 12 frames a second, or one where reduced motion is preferred."""
    visitor = enter(reduced_motion=motion)
    page = visitor.page
    page.clock.install()
    page.reload()
    root = films(page)[0]
    play = root.query_selector(".rp-play")
    page.clock.run_for(5000)
    assert root.get_attribute("data-drawn") is None, "it started by itself"
    root.query_selector("input").focus()
    page.keyboard.press("ArrowRight")
    page.wait_for_function(DRAWN, arg=[root, 1])
    page.clock.pause_at(page.evaluate("Date.now()") + 1000)
    page.keyboard.press("Space")
    assert play.inner_text() == "Pause"
    page.clock.run_for(pause_ms - 1)
    assert root.get_attribute("data-drawn") == "1"
    for frame in (2, 3):
        page.clock.run_for(pause_ms)
        page.wait_for_function(DRAWN, arg=[root, frame], polling=20)
    page.keyboard.press("Space")
    assert play.inner_text() == "Play"
    page.clock.run_for(5 * pause_ms)
    assert root.get_attribute("data-drawn") == "3"


def test_films_play_to_their_end_and_again(enter: Callable[..., Visit]) -> None:
    """At the end the film stands; Play begins anew."""
    page = enter().page
    root = films(page)[0]
    play = root.query_selector(".rp-play")
    root.query_selector("input").focus()
    page.keyboard.press("End")
    page.keyboard.press("ArrowLeft")
    frame_of(root, 44)
    play.click()
    frame_of(root, 45)
    page.wait_for_function("play => play.textContent === 'Play'", arg=play)
    play.click()
    page.wait_for_function("root => Number(root.dataset.drawn) < 45", arg=root)
    assert play.inner_text() == "Pause"


def test_paper_shows_a_strip(enter: Callable[..., Visit]) -> None:
    """In print a film is five frames with their numbers, an explorer its default, all light."""
    page = enter(color_scheme="dark").page
    for root in films(page):
        root.query_selector("input").focus()
        page.keyboard.press("End")
        frame_of(root, int(root.query_selector("input").get_attribute("max")))
    page.emulate_media(media="print")
    page.wait_for_function("document.documentElement.dataset.theme === 'light'")
    for root, count in zip(films(page), (46, 60), strict=True):
        keys = root.query_selector_all(".rp-key")
        assert len(keys) == 5
        assert all(key.is_visible() for key in keys)
        assert keys[-1].inner_text() == f"{count} of {count}"
        assert not root.query_selector("canvas").is_visible()
        assert not root.query_selector(".rp-controls").is_visible()
    assert all(root.is_visible() for root in page.query_selector_all(".explorer .rp-canvas > *"))


def test_without_scripts_there_is_the_first_frame(enter: Callable[..., Visit]) -> None:
    """Without scripts a film is one picture with its alternative text."""
    for root in films(enter(java_script_enabled=False).page):
        shown = [image for image in root.query_selector_all("img") if image.is_visible()]
        assert len(shown) == 1
        assert len(shown[0].get_attribute("alt")) >= 20
        assert not root.query_selector("button")


def bare() -> str:
    """Return a film as Jupyter shows it."""
    images = np.zeros((4, 30, 40, 3), np.uint8)
    for number, image in enumerate(images):
        image[:, 10 * number :] = (200, 60, 60)
    shown = film(images, fps=10, alt="A red ground is covered from the left by black.")
    return shown._repr_mimebundle_()["text/html"]


def test_an_output_is_complete_by_itself(browser: Browser) -> None:
    """An output plays where nothing else is, and twice the script makes one set of controls."""
    page = browser.new_page()
    page.set_content(f"<body>{bare()}{bare()}</body>")
    roots = page.query_selector_all(".rp-film")
    assert [len(root.query_selector_all(".rp-controls")) for root in roots] == [1, 1]
    roots[1].query_selector("input").focus()
    page.keyboard.press("End")
    shown = frame_of(roots[1], 3)
    assert np.abs(shown[:, :28]).mean() < 12
    assert np.abs(shown[:, 32:] - [200, 60, 60]).mean() < 12
    assert roots[1].query_selector("input").get_attribute("data-lm-suppress-shortcuts") == "true"
    page.close()


def test_a_sanitised_output_shows_the_first_frame(browser: Browser) -> None:
    """What Jupyter leaves of an output that it does not trust: one picture, described."""
    page = browser.new_page()
    safe = re.sub(r"<(script|style)\b.*?</\1>", "", bare(), flags=re.S)
    page.set_content(f"<body>{safe}</body>")
    shown = [image for image in page.query_selector_all("img") if image.is_visible()]
    assert [image.get_attribute("alt") for image in shown] == [
        "A red ground is covered from the left by black."
    ]
    page.close()
