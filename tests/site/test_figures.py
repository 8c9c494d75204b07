"""Every figure of the book: letters on a telephone, room for controls, numbers and links."""

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest
from bs4 import BeautifulSoup
from playwright.sync_api import Page

from tests.site.conftest import Reading, Visit
from tests.site.contents import NOTEBOOKS, PAGES
from tests.site.test_pages import WIDE_ELEMENTS

SMALLEST_PX = 10
LETTERS = """
(smallest) => {
  const found = [];
  for (const picture of document.querySelectorAll("main .rp-svg")) {
    const named = picture.closest("[aria-label]");
    const place = picture.closest("figure")?.id || named.getAttribute("aria-label").slice(0, 60);
    const tell = (words) => found.push(`${place}: ${words}`);
    const canvas = picture.closest(".rp-canvas")?.getBoundingClientRect(); // it cuts off
    const [first, last] = canvas ? [canvas.left - 0.5, canvas.right + 0.5] : [0, innerWidth];
    const others = [];
    for (const text of picture.querySelectorAll("text")) {
      const box = text.getBoundingClientRect();
      const words = text.textContent;
      if (!words.trim() || !box.width) continue;
      const { a, b } = text.getScreenCTM();
      const size = parseFloat(getComputedStyle(text).fontSize) * Math.hypot(a, b);
      if (size < smallest - 0.05) tell(`${words} has ${size.toFixed(1)} px`);
      if (box.left < first || box.right > last) tell(`${words} leaves the window`);
      const lying = Math.abs(a) > Math.abs(b); // above and below letters a line has room
      const [x, y] = lying ? [2, 0.16 * box.height] : [0.1 * box.width, 2];
      const own = [box.left + x, box.right - x, box.top + y, box.bottom - y, words];
      for (const [left, right, top, bottom, name] of others) {
        const apart = own[0] >= right || left >= own[1] || own[2] >= bottom || top >= own[3];
        if (!apart) tell(`${words} and ${name} overlap`);
      }
      others.push(own);
    }
    for (const outline of picture.querySelectorAll("use")) { // letters of formulas, 100 units high
      if (!/DejaVu|STIX|cmr/.test(outline.getAttribute("xlink:href"))) continue;
      const { a, b } = outline.getScreenCTM();
      const size = 100 * Math.hypot(a, b); // raised letters have 0.7 of it
      if (size < 0.69 * smallest) tell(`a formula has letters of ${size.toFixed(1)} px`);
    }
  }
  return found;
}
"""
TOGETHER = """
() => [...document.querySelectorAll("div.explorer")].map((root) => {
  const canvas = root.querySelector(".rp-canvas").getBoundingClientRect();
  const controls = root.querySelector(".rp-controls").getBoundingClientRect();
  const header = document.querySelector(".bd-header-article")?.getBoundingClientRect().height ?? 0;
  const height = controls.bottom - canvas.top + header;
  return { name: root.querySelector("figure").id || root.id, height };
})
"""
WINDOW = {"width": 1280, "height": 800}
TELEPHONE = {"width": 390, "height": 844}


def settled(page: Page) -> Page:
    """Return the page once its explorers have given their controls a place."""
    page.evaluate(
        "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
    )
    return page


@pytest.mark.parametrize("viewport", [TELEPHONE, WINDOW], ids=["telephone", "window"])
@pytest.mark.parametrize("reading", [*NOTEBOOKS, PAGES[0]], indirect=True)
def test_letters_of_figures_can_be_read(reading: Reading, viewport: dict[str, int]) -> None:
    """Letters have ten pixels or more, none leaves the window or overlaps, in presets too."""
    page = reading(viewport)
    small = page.evaluate(LETTERS, SMALLEST_PX)
    for preset in page.query_selector_all(".rp-preset"):
        preset.click()
        page.wait_for_selector(".explorer[data-busy]", state="detached")
        small += page.evaluate(LETTERS, SMALLEST_PX)
    if (
        page.url.endswith(f"/{PAGES[0]}.html") and viewport == WINDOW
    ):  # cards beside each other are thumbnails
        small = [found for found in small if not found.endswith("px")]
    assert not small, "\n".join(sorted(set(small)))


def test_letters_that_are_too_small_are_found(visit: Callable[..., Visit], address: str) -> None:
    """The measure of letters measures: a picture made narrow has letters that are too small."""
    page = settled(visit(viewport=TELEPHONE).open(f"{address}{NOTEBOOKS[0]}.html"))
    page.add_style_tag(content=".rp-svg { width: 120px !important; flex: none !important; }")
    assert any(found.endswith("px") for found in page.evaluate(LETTERS, SMALLEST_PX))
    page.add_style_tag(content=".rp-svg { width: 340px !important; --rp-text: 2.5 !important; }")
    found = page.evaluate(LETTERS, SMALLEST_PX)
    assert {words for line in found for words in ("overlap", "leaves") if words in line} == {
        "overlap",
        "leaves",
    }


@pytest.mark.parametrize("reading", NOTEBOOKS, indirect=True)
def test_columns_stand_above_each_other_on_a_telephone(reading: Reading) -> None:
    """Drawings of a row stand in a line where there is room, else one under the other."""
    page = reading(WINDOW)
    tops = (
        "(row) => [...row.children].map((child) => Math.round(child.getBoundingClientRect().top))"
    )
    rows = page.query_selector_all(".rp-row")
    for row in rows:
        assert len(set(row.evaluate(tops))) == 1
    page.set_viewport_size(TELEPHONE)
    for row in rows:
        found = row.evaluate(tops)
        assert len(set(found)) > 1
        assert found == sorted(found)
    assert not page.evaluate(WIDE_ELEMENTS)


@pytest.mark.parametrize("reading", NOTEBOOKS, indirect=True)
def test_picture_and_controls_are_seen_together(reading: Reading) -> None:
    """In a window of 1280 × 800 a reader sees what he moves."""
    page = reading(WINDOW)
    high = [found for found in page.evaluate(TOGETHER) if found["height"] > WINDOW["height"]]
    assert not high


@cache
def read(file: Path) -> BeautifulSoup:
    """Return a page of the site."""
    return BeautifulSoup(file.read_text("utf-8"), "html.parser")


@pytest.mark.parametrize("name", PAGES)
def test_captions_are_numbered_and_links_have_targets(name: str, site: Path) -> None:
    """Captions count from one, by chapter; a link to a figure shows the number of its target."""
    file = site / f"{name}.html"
    captions = read(file).select("main figure.rp-figure > figcaption")
    numbers = [caption.select_one(".rp-number").text for caption in captions]
    counted = [re.fullmatch(r"Fig\. (?:(.*)\.)?(\d+)", number) for number in numbers]
    assert all(counted), numbers
    assert [int(match[2]) for match in counted] == list(range(1, 1 + len(numbers)))
    assert len({match[1] for match in counted}) <= 1
    for link in read(file).select("article a[href*='#fig-']:not(.headerlink)"):
        other, _, target = link["href"].partition("#")  # a heading may begin with the same word
        figure = read((file.parent / other).resolve() if other else file).find(id=target)
        assert figure.name == "figure", target
        number = figure.select_one(".rp-number").text
        assert number == link.text or not link.text.startswith("Fig. ")
        assert link.text
