"""Every explorer: each control to both ends, presets, reset, keys, paper, no script."""

from collections.abc import Callable
from itertools import product
from pathlib import Path

import pytest
from playwright.sync_api import ElementHandle

from tests.site.conftest import Reading, Visit
from tests.site.contents import NOTEBOOKS
from tests.site.driver import PICTURE, drivers

SILENCE_MS = 1100
WINDOW = {"width": 1280, "height": 900}


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_explorers(
    name: str,
    visit: Callable[..., Visit],
    address: str,
    count: Callable[[str, int], None],
) -> None:
    """Every control of a page moves to both ends; presets and reset work; all is announced."""
    visitor = visit()
    page = visitor.open(f"{address}{name}.html")
    found = drivers(page)
    for driver in found:
        driver.reset()
        start = driver.look()
        for control in driver.controls:
            driver.drive(control)
            driver.reset()
        for preset in driver.root.query_selector_all(".rp-preset"):
            preset.click()
            driver.look()
            assert preset.get_attribute("aria-pressed") == "true"
        driver.reset()
        assert driver.look() == start, "reset does not lead back to the start"
        driver.drive(driver.controls[0])
        page.wait_for_timeout(SILENCE_MS)
        for told in driver.settings():
            assert told in driver.status(), "a move is not announced"
    count("explorers driven", len(found))
    count("controls driven to both ends", sum(len(driver.controls) for driver in found))
    count("states shown", sum(driver.states for driver in found))
    count("requests to other hosts", len(visitor.strangers))
    count("console errors and page errors", len(visitor.errors))
    assert not visitor.errors
    assert not visitor.strangers


@pytest.mark.parametrize("width", [1280, 390])
def test_points_are_dragged_and_moved_by_arrow_keys(
    width: int, visit: Callable[..., Visit], address: str, site: Path
) -> None:
    """The mouse takes a point to the nearest state, an arrow to the next one in its direction."""
    page = visit(viewport={"width": width, "height": 900}).page
    told = {"ArrowLeft": (-1, 0), "ArrowRight": (1, 0), "ArrowUp": (0, -1), "ArrowDown": (0, 1)}
    moved = 0
    for name in NOTEBOOKS:
        if '"drag": {' not in (site / f"{name}.html").read_text("utf-8"):
            continue
        page.goto(f"{address}{name}.html")
        for driver in drivers(page):
            if not (grip := driver.root.query_selector(".rp-grip")):
                continue
            moved += 1
            driver.reset()
            grip.scroll_into_view_if_needed()
            start, before = driver.settings(), driver.look()
            x, y = _middle(grip)
            page.mouse.move(x, y)
            page.mouse.down()
            for far, right, down in product((60, 120, 180), (1, 0, -1), (1, 0, -1)):
                page.mouse.move(x + far * right, y + far * down, steps=2)
                driver.look()
                if driver.settings() != start:
                    break
            page.mouse.up()
            assert driver.settings() != start, f"{name}: nothing is dragged"
            assert driver.look() != before
            turned = 0
            for key, (right, down) in told.items():
                was, old = _middle(grip), driver.settings()
                grip.focus()
                page.keyboard.press(key)
                driver.look()
                if driver.settings() == old:
                    continue
                now, turned = _middle(grip), turned + 1
                assert right * (now[0] - was[0]) + down * (now[1] - was[1]) > 0
            assert turned, f"{name}: no arrow moves the point"
            assert "arrow keys" in grip.get_attribute("aria-label")
            driver.reset()
            grip.scroll_into_view_if_needed()
            assert _middle(grip) == pytest.approx((x, y), abs=1), "reset leaves the grip behind"
    assert moved >= 5


def _middle(node: ElementHandle) -> tuple[float, float]:
    """Return where the middle of an element is, pixels of the page."""
    return tuple(
        node.evaluate(
            """node => { const { x, y, width, height } = node.getBoundingClientRect();
                return [x + width / 2, y + height / 2]; }"""
        )
    )


@pytest.mark.parametrize("reading", NOTEBOOKS, indirect=True)
def test_timelines_play_and_pause(reading: Reading) -> None:
    """Play moves time on, pause holds it; nothing moves before play is pressed."""
    page = reading(WINDOW)
    page.emulate_media(reduced_motion="no-preference")
    for control in page.query_selector_all(".rp-timeline"):
        slider = control.query_selector("input[type=range]")
        slider.focus()
        page.keyboard.press("Home")
        play = control.query_selector(".rp-play")
        assert play.inner_text() == "Play"
        play.click()
        assert play.inner_text() == "Pause"
        page.wait_for_function("(slider) => Number(slider.value) >= 2", arg=slider, timeout=15_000)
        play.click()
        assert play.inner_text() == "Play"
        held = slider.input_value()
        page.wait_for_timeout(600)
        assert slider.input_value() == held


@pytest.mark.parametrize("reading", NOTEBOOKS, indirect=True)
def test_explorers_on_paper(reading: Reading) -> None:
    """Print shows the picture and no control."""
    page = reading(WINDOW)
    page.emulate_media(media="print")
    for root in page.query_selector_all("div.explorer"):
        assert not root.query_selector(".rp-controls").is_visible()
        assert root.wait_for_selector(".rp-canvas > *", state="visible")  # it may be drawn anew


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_explorers_without_scripts(
    name: str, site: Path, visit: Callable[..., Visit], address: str
) -> None:
    """Without scripts there is the default picture with its alternative text."""
    page = visit(java_script_enabled=False).page
    page.goto(f"{address}{name}.html")
    expected = (site / f"{name}.html").read_text("utf-8").count('<div class="explorer"')
    roots = page.query_selector_all("div.explorer")
    assert len(roots) == expected
    for root in roots:
        picture = root.query_selector(".rp-canvas > *")
        assert picture.is_visible()
        alt = picture.get_attribute("aria-label") or picture.get_attribute("alt")
        assert len(alt) >= 20
        assert not root.query_selector("input")


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_explorers_from_a_folder(
    name: str, site: Path, visit: Callable[..., Visit], count: Callable[[str, int], None]
) -> None:
    """Explorers of a page opened from disk move too."""
    visitor = visit()
    page = visitor.open((site / f"{name}.html").as_uri())
    for root in page.query_selector_all("div.explorer"):
        before = page.evaluate(PICTURE, root)["picture"]
        preset = root.query_selector(".rp-preset[aria-pressed=false]")
        control = root.query_selector("input[type=range]")
        if preset:
            preset.click()
        elif control:
            control.focus()
            at_end = control.input_value() == control.get_attribute("max")
            page.keyboard.press("Home" if at_end else "End")
        seen = page.evaluate(PICTURE, root)
        assert not seen["complaint"]
        assert seen["picture"] != before or not (preset or control)
    count("console errors and page errors", len(visitor.errors))
    count("requests to other hosts", len(visitor.strangers))
    assert not visitor.errors
    assert not visitor.strangers


def test_films_of_drawings_are_dark_on_a_dark_page_before_they_play(
    visit: Callable[..., Visit], address: str, site: Path
) -> None:
    """Their posters, too; photographs keep their colours."""
    page = visit(color_scheme="dark").page
    drawn = 0
    for name in NOTEBOOKS:
        if 'class="rp-film"' not in (site / f"{name}.html").read_text("utf-8"):
            continue
        page.goto(f"{address}{name}.html")
        for poster in page.query_selector_all(".rp-film .rp-key:not([hidden]) img"):
            dark = poster.evaluate("img => getComputedStyle(img).filter.includes('invert')")
            assert dark == poster.evaluate("img => !!img.closest('.rp-drawing')")
            drawn += dark
    assert drawn
