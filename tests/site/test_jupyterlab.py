"""Explorers in a real JupyterLab: after Run All Cells, under a busy kernel, without one."""

import os
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import nbformat
import pytest
from nbconvert import HTMLExporter
from playwright.sync_api import Browser, Page, expect

from tests.book.test_edits import EDITS, MODEL, NOW
from tests.site.conftest import Visit
from tests.site.contents import BOOK, NOTEBOOKS
from tests.site.driver import drivers
from tests.site.lab import IDLE, LAB_PAGES, Lab, jupyterlab

DRAWN = """
import time
from pathlib import Path

import numpy as np

from explorables.explore import explore, slider
from explorables.figures import figure

fig, ax = figure()

def line(gain):
    ax.clear()
    ax.plot([0, 1], [0, gain])
    return fig

explore(line, alt=lambda gain: f"A line of slope {gain:g} through 0.", caption="Slope $g$",
        gain=slider("Gain", [1, 2, 3, 4], 2))
"""
IMAGE = """
def square(side):
    image = np.zeros((60, 80), np.uint8)
    image[:side, :side] = 255
    return image

explore(square, alt=lambda side: f"A white square of {side} pixels.",
        side=slider("Side", [5, 20], 5))
"""
BUSY = """
while not Path("go").exists():
    time.sleep(0.05)
"""
FEW = ["walls"]
"""Sliders and points that are dragged; films that are computed are run by `make test-all`."""

EXPLORERS = [
    name
    for name in NOTEBOOKS
    if re.search("explore|Exploration", (BOOK / f"{name}.ipynb").read_text("utf-8"))
]
"""Notebooks that have explorers, as far as their text tells."""


def chosen(asked: str) -> list[str]:
    """Return which notebooks are run: those that are named, or one if that is none, or all."""
    if asked == "all":
        return EXPLORERS
    return [name for name in EXPLORERS if name in asked.split(",")] or FEW


CHAPTERS = chosen(os.environ.get(LAB_PAGES, ""))

expect.set_options(timeout=120_000)  # a kernel may start slowly; no test asserts a time


@pytest.fixture(scope="module")
def lab(browser: Browser, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    """A JupyterLab with copies of the chapters, and a notebook with two explorers."""
    cells = [nbformat.v4.new_code_cell(source.strip()) for source in (DRAWN, IMAGE, BUSY)]
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    small = nbformat.v4.new_notebook(cells=cells, metadata={"kernelspec": kernel})
    path = tmp_path_factory.mktemp("notebook") / "small.ipynb"
    nbformat.write(small, path)
    words = Path(__file__).with_name("words.ipynb")
    book = (BOOK / f"{name}.ipynb" for name in (*CHAPTERS, "scorecard"))
    with jupyterlab([path, words, *book]) as running:
        yield running


@pytest.fixture
def visit(browser: Browser, lab: Lab) -> Iterator[Visit]:
    """An empty page; kernels end with it."""
    with browser.new_context(viewport={"width": 1280, "height": 900}) as context:
        yield Visit(context.new_page(), (lab.address, lab.address.replace("http", "ws")))
    lab.end_kernels()


@pytest.fixture
def small(visit: Visit, lab: Lab) -> Page:
    """The notebook with two explorers, run."""
    (lab.folder / "go").touch()
    lab.open(visit.page, "small.ipynb")
    lab.run_all(visit.page, "small.ipynb")
    expect(visit.page.locator(".rp-controls")).to_have_count(2)
    return visit.page


def move(page: Page, *keys: str) -> None:
    """Press keys on the slider of every explorer."""
    for slider in page.locator(".explorer input").all():
        slider.focus()
        for key in keys:
            page.keyboard.press(key)


def test_notebooks_are_chosen_by_name() -> None:
    """Those that have explorers, in the order of the book; all only if that is asked for."""
    assert chosen("monobot,errata,walls") == ["walls", "monobot"]
    assert chosen("") == chosen("errata") == FEW
    assert set(FEW) < set(EXPLORERS) == set(chosen("all"))


@pytest.mark.parametrize("name", CHAPTERS)
def test_explorers_survive_run_all_cells(
    name: str, site: Path, lab: Lab, visit: Visit, count: Callable[[str, int], None]
) -> None:
    """Every explorer of a chapter that was run as a whole has its picture, and moves.

    Then one number of a study cell is changed as a reader would: nothing fails from there on,
    and what the chapter shows is another picture.
    """
    lab.open(visit.page, f"{name}.ipynb")
    lab.run_all(visit.page, name)
    expected = (site / f"{name}.html").read_text("utf-8").count('<div class="explorer"')
    expect(visit.page.locator(".explorer .rp-controls")).to_have_count(expected)
    assert visit.page.locator(":is(.rp-error, .rp-notice):visible").all_text_contents() == []
    found = drivers(visit.page)
    for driver in found:
        assert len(driver.pictures) == 1
        driver.drive(driver.controls[0])
        if driver.grip:
            driver.turn()
        assert not driver.wrong, f"{driver.name}: {', '.join(driver.wrong)}"
    count("explorers alive after Run All Cells", len(found))
    count("requests to other hosts", len(visit.strangers))
    assert not visit.strangers
    if edit := EDITS.get(name):
        place = f'later("{named[1]}"' if (named := NOW.match(edit.shown)) else edit.shown
        before = lab.outputs(visit.page, place)
        assert before != "[]"
        lab.edit(visit.page, name, edit.old, edit.new)
        assert MODEL.sub("", lab.outputs(visit.page, place)) != MODEL.sub("", before)


def test_a_busy_kernel_answers_when_it_is_free(lab: Lab, visit: Visit) -> None:
    """Pictures stand while the kernel is busy; then the newest move is answered."""
    page = visit.page
    (lab.folder / "go").unlink(missing_ok=True)
    lab.open(page, "small.ipynb")
    page.evaluate("() => { jupyterapp.serviceManager.kernels.commsOverSubshells = 'disabled'; }")
    page.evaluate("() => { jupyterapp.commands.execute('notebook:run-all-cells'); }")
    expect(page.locator(".rp-controls")).to_have_count(2)
    expect(page.locator(".rp-canvas img")).to_be_visible()
    expect(page.get_by_label("A line of slope 2 through 0.")).to_be_visible()
    move(page, "Home", "ArrowRight", "End")
    told = page.locator(".rp-notice")
    expect(told.first).to_have_text("The kernel is busy; the picture follows.")
    expect(page.get_by_label("A line of slope 2 through 0.")).to_be_visible()
    (lab.folder / "go").touch()
    expect(page.get_by_label("A line of slope 4 through 0.")).to_be_visible()
    expect(page.get_by_alt_text("A white square of 20 pixels.")).to_be_visible()
    expect(page.locator(":is(.rp-error, .rp-notice):visible")).to_have_count(0)


def test_a_restarted_kernel_is_reported_when_a_control_moves(small: Page) -> None:
    """The pictures stay, and the reader is told to run the cell."""
    small.evaluate("() => jupyterapp.shell.currentWidget.sessionContext.restartKernel()")
    small.wait_for_selector(IDLE)
    assert small.locator(".rp-notice:visible").count() == 0
    move(small, "End")
    for told in small.locator(".rp-notice").all():
        expect(told).to_have_text(re.compile("No kernel answers. Run this cell"))
    expect(small.locator(".rp-error:visible")).to_have_count(0)
    assert [driver.states for driver in drivers(small)] == [1, 1]


def test_a_saved_notebook_shows_its_pictures(small: Page, lab: Lab) -> None:
    """Opened again, trusted or not, and exported, it shows the default state."""
    move(small, "End")
    file = lab.folder / "small.ipynb"
    lab.command(small, "docmanager:save")
    told = ["A line of slope 2 through 0.", "A white square of 5 pixels."]
    page, _ = HTMLExporter().from_filename(str(file))
    assert re.findall(r'<img alt="([^"]*)" class="rp-frame', page) == told
    for trusted in (True, False):
        small.goto("about:blank")
        lab.end_kernels()
        if not trusted:
            file.write_text(file.read_text("utf-8").replace("through 0.", "through zero."))
            told[0] = "A line of slope 2 through zero."
        lab.open(small, "small.ipynb")
        if trusted:  # JupyterLab says that it has no model
            small.wait_for_selector(".jp-OutputArea-output.jupyter-widgets", state="attached")
        for alt in told:
            picture = small.get_by_alt_text(alt)
            expect(picture).to_be_visible()
            assert picture.bounding_box()["width"] > 50
        expect(small.locator(".jp-OutputArea-output:visible", has_text="widget")).to_have_count(0)


def test_words_between_figures_are_those_of_the_page(lab: Lab, visit: Visit) -> None:
    """A bet is answered by keys, badges have their style, and lead to the scorecard beside."""
    page = visit.page
    lab.open(page, "words.ipynb")
    lab.run_all(page, "words.ipynb")
    place = "() => jupyterapp.shell.currentWidget.content.activeCellIndex"
    replies = page.locator(".rp-reply")
    coin = page.locator(".rp-bet").first
    expect(coin).to_be_visible()
    assert not any(reply.is_visible() for reply in replies.all())
    coin.locator("input").first.focus()
    before = page.evaluate(place)
    for key in ("Space", "ArrowDown"):
        page.keyboard.press(key)
    assert [reply.is_visible() for reply in replies.all()] == [False, True, *[False] * 4]
    assert page.evaluate(place) == before
    expect(page.locator(".rp-badges .rp-badge").first).to_have_css("border-radius", "999px")
    for column in ("thead th", "tbody th"):
        expect(page.locator(f".rp-claims {column}").first).to_have_css("text-align", "left")
    expect(page.locator(".rp-source pre").first).to_have_css("white-space", "pre")
    page.locator(".rp-badges a.rp-badge").first.click()
    page.wait_for_function(
        "() => jupyterapp.shell.currentWidget?.context?.path === 'scorecard.ipynb'"
    )
    assert not visit.strangers
