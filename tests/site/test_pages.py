"""Every page, in both themes and on a telephone: no errors, no other host, readable."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from axe_playwright_python.sync_playwright import Axe
from playwright.sync_api import Page

from tests.site.conftest import Reading, Visit
from tests.site.contents import BOOK, NOTEBOOKS, PAGES
from tests.site.measures import ALIGNED, EQUATIONS

WINDOW = {"width": 1280, "height": 900}
TELEPHONE = {"width": 390, "height": 844}
WIDE_ELEMENTS = """
() => {
  const width = document.documentElement.clientWidth;
  const held = (node) => {
    for (let box = node; box && box !== document.body; box = box.parentElement) {
      const style = getComputedStyle(box);
      if (style.position === "fixed") return true;
      if (box !== node && style.overflowX !== "visible") return true;
    }
    return false;
  };
  const wide = [...document.querySelectorAll("main *")].filter((node) => {
    const box = node.getBoundingClientRect();
    return box.width > 1 && box.height > 1 && box.right > width + 1 && !held(node);
  });
  const page = document.documentElement.scrollWidth;
  const names = wide.map((node) => node.outerHTML.slice(0, 120));
  return page > width ? [`the page is ${page} px wide`, ...names] : names;
}
"""


def violations(page: Page, theme: str = "light") -> list[str]:
    """Return the findings of axe of serious or critical impact; in the dark, of colours alone."""
    options: dict[str, Any] = {"preload": False, "resultTypes": ["violations"]}
    if theme == "dark":
        options["runOnly"] = {"type": "rule", "values": ["color-contrast", "link-in-text-block"]}
    context = {"exclude": [[".rp-svg > *"]]}  # a figure is one image with a name
    found = Axe().run(page, context=context, options=options).response["violations"]
    return [
        f"{v['impact']}: {v['id']} ({v['help']}) at {node['target']}: {node['html'][:160]}"
        for v in found
        if v["impact"] in ("serious", "critical")
        for node in v["nodes"]
    ]


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("name", PAGES)
def test_page(
    name: str,
    theme: str,
    visit: Callable[..., Visit],
    address: str,
    count: Callable[[str, int], None],
) -> None:
    """A page has no error, asks no other host, satisfies axe, and fits a telephone."""
    visitor = visit(color_scheme=theme)
    page = visitor.open(f"{address}{name}.html")
    assert page.evaluate("document.documentElement.dataset.theme") == theme
    found = violations(page, theme)
    page.set_viewport_size(TELEPHONE)
    page.wait_for_timeout(150)
    wide = page.evaluate(WIDE_ELEMENTS)
    count("pages opened", 1)
    count("requests to other hosts", len(visitor.strangers))
    count("console errors and page errors", len(visitor.errors))
    count(f"serious or critical violations, {theme}", len(found))
    assert not visitor.errors
    assert not visitor.strangers
    assert not found, "\n".join(found)
    assert not wide, "\n".join(wide)


def test_remaining_pages(
    site: Path, visit: Callable[..., Visit], address: str, count: Callable[[str, int], None]
) -> None:
    """Index, search and source pages have no error, ask no other host, and satisfy axe."""
    others = {path.relative_to(site).as_posix() for path in site.rglob("*.html")}
    others -= {"index.html", *(f"{name}.html" for name in PAGES)}
    others = {page for page in others if not page.startswith("_static/")}
    sources = sorted(page for page in others if page.startswith("_modules/"))
    pages = [*sorted(others.difference(sources)), *sources[:1]]  # source pages are all alike
    visitors = {theme: visit(color_scheme=theme) for theme in ("light", "dark")}
    for theme, visitor in visitors.items():
        found: list[str] = []
        for page in pages:
            visitor.open(address + page)
            found += violations(visitor.page, theme)
        count("pages opened", len(pages))
        count("requests to other hosts", len(visitor.strangers))
        count("console errors and page errors", len(visitor.errors))
        count(f"serious or critical violations, {theme}", len(found))
        assert not visitor.errors
        assert not visitor.strangers
        assert not found, "\n".join(found)


def test_index_leads_to_the_first_page(visit: Callable[..., Visit], address: str) -> None:
    """The bare address shows the landing page."""
    page = visit().page
    page.goto(f"{address}index.html")
    page.wait_for_url(f"**/{PAGES[0]}.html")


@pytest.mark.parametrize("name", [PAGES[0], *NOTEBOOKS[:1]])
def test_page_from_a_folder(
    name: str, site: Path, visit: Callable[..., Visit], count: Callable[[str, int], None]
) -> None:
    """A page opened from disk has no error and asks no host."""
    visitor = visit()
    visitor.open((site / f"{name}.html").as_uri())
    count("requests to other hosts", len(visitor.strangers))
    count("console errors and page errors", len(visitor.errors))
    assert not visitor.errors
    assert not visitor.strangers


def test_search_finds(visit: Callable[..., Visit], address: str) -> None:
    """The search works without a server."""
    visitor = visit()
    page = visitor.open(f"{address}search.html?q=robot")
    page.wait_for_selector("#search-results li a", timeout=10_000)
    assert not visitor.errors


@pytest.mark.parametrize("served", [True, False])
@pytest.mark.parametrize("name", NOTEBOOKS)
def test_notebook_downloads(
    name: str, served: bool, visit: Callable[..., Visit], address: str, site: Path
) -> None:
    """The download button of a chapter hands over its notebook, from a folder too."""
    page = visit().open((address if served else f"{site.as_uri()}/") + f"{name}.html")
    page.click(".dropdown-download-buttons button")
    with page.expect_download() as download:
        page.click(".dropdown-download-buttons a[href$='.ipynb']")
    assert download.value.suggested_filename == f"{name}.ipynb"
    assert Path(download.value.path()).read_bytes() == (BOOK / f"{name}.ipynb").read_bytes()


def test_paper_is_light_and_has_no_buttons(visit: Callable[..., Visit], address: str) -> None:
    """On paper there is no header and no dark ground; the screen stays dark."""
    page = visit(color_scheme="dark").open(f"{address}{PAGES[0]}.html")
    page.emulate_media(media="print")
    page.wait_for_function("document.documentElement.dataset.theme === 'light'")
    assert not page.is_visible(".article-header-buttons")
    assert page.locator("h1:visible").count() == 1
    page.emulate_media(media="screen")
    page.wait_for_function("document.documentElement.dataset.theme === 'dark'")


COLUMNS = """
() => [...document.querySelectorAll("div.cell_output div.output > div.highlight pre")].filter(
  (text) => text.scrollWidth > text.clientWidth + 1 || getComputedStyle(text).whiteSpace !== "pre"
).map((text) => text.textContent.slice(0, 200))
"""


@pytest.mark.parametrize("reading", NOTEBOOKS, indirect=True)
def test_paper_keeps_columns_and_offers_no_code(reading: Reading) -> None:
    """On A4 text tables keep their lines whole, and no word of a button is left."""
    page = reading({"width": 718, "height": 1000})
    page.emulate_media(media="print")
    assert page.evaluate(COLUMNS) == []
    assert page.locator("details.hide > summary:visible").count() == 0


def test_mathematics_of_the_bibliography_is_set(visit: Callable[..., Visit], address: str) -> None:
    """No entry shows a dollar."""
    page = visit().open(f"{address}references.html")
    assert page.locator(".citation mjx-container").count() > 0
    assert "$" not in page.locator(".bd-article").inner_text()


def test_errata_are_whole_on_a_telephone(visit: Callable[..., Visit], address: str) -> None:
    """Nothing on the page has to be moved sideways to be read, and each erratum has its claim."""
    page = visit(viewport=TELEPHONE).open(f"{address}errata.html")
    held = """() => [...document.querySelectorAll(".bd-article *")].filter(
      (box) => box.clientWidth && box.scrollWidth > box.clientWidth + 1
        && getComputedStyle(box).overflowX !== "visible" && !box.closest(".math")
    ).map((box) => box.outerHTML)"""
    assert page.evaluate(held) == []
    claims = page.locator(".bd-article a[href^='scorecard.html#']")
    assert claims.count() == page.locator(".bd-article h2").count() > 0


SIDEWAYS = """
(selector) => [...document.querySelectorAll(selector)].filter(
  (box) => box.checkVisibility() && box.scrollWidth > box.clientWidth + 1
).map((box) => `${box.scrollWidth} px in ${box.clientWidth}: ${box.textContent.slice(0, 200)}`)
"""
WHOLE = ".bd-article :is(.rp-table, div.math, mjx-container[display='true'])"
CODE = ".bd-article div.highlight pre"


@pytest.mark.parametrize("reading", NOTEBOOKS, indirect=True)
def test_nothing_has_to_be_moved_sideways(reading: Reading) -> None:
    """Tables and formulas are whole on a telephone; in a window code is, too."""
    assert reading(TELEPHONE).evaluate(SIDEWAYS, WHOLE) == []
    assert reading(WINDOW).evaluate(SIDEWAYS, f"{WHOLE}, {CODE}") == []


@pytest.mark.parametrize("reading", PAGES, indirect=True)
def test_equations_stand_in_the_middle_and_words_of_tables_at_the_left(reading: Reading) -> None:
    """A displayed equation is centred, on a telephone too, where a wide one begins at the left."""
    assert reading(WINDOW).evaluate(ALIGNED) == []
    assert reading(WINDOW).evaluate(EQUATIONS) == []
    assert reading(TELEPHONE).evaluate(EQUATIONS) == []


def test_equations_and_words_out_of_place_are_found(
    visit: Callable[..., Visit], address: str
) -> None:
    """The measures measure: boxes that shrink and columns at the right are seen."""
    page = visit().open(f"{address}walls.html")
    page.add_style_tag(content="div.math > * { flex: none !important; }")
    page.add_style_tag(content=".rp-table td { text-align: right !important; }")
    assert page.evaluate(EQUATIONS)
    assert page.evaluate(ALIGNED)


@pytest.mark.parametrize("name", NOTEBOOKS[:1])
def test_without_scripts_a_page_says_so(
    name: str, visit: Callable[..., Visit], address: str
) -> None:
    """A reader is told why no control is there."""
    page = visit(java_script_enabled=False).page
    page.goto(f"{address}{name}.html")
    assert page.get_by_text("controls need scripts").is_visible()
    page = visit().open(f"{address}{name}.html")
    assert not page.get_by_text("controls need scripts").is_visible()


UNSET = r"""
() => [...document.querySelectorAll(".math")].filter((formula) => {
  const box = formula.querySelector("math")?.getBoundingClientRect();
  const set = box?.width && box.height && !/[\\&]/.test(formula.innerText);
  return formula.checkVisibility() && !set;
}).map((formula) => formula.textContent)
"""
SOURCE = r"""
() => [...document.querySelectorAll("p, li, td, th, dt, dd, legend, label, figcaption, h1, h2, h3")]
  .filter((text) => text.checkVisibility() && /\\[(\[]/.test(text.innerText))
  .map((text) => text.innerText)
"""


def test_without_scripts_formulas_are_set(visit: Callable[..., Visit], address: str) -> None:
    """Each has a size and its place and shows no LaTeX; no other text shows any either."""
    page = visit(java_script_enabled=False).page
    for name in ("monobot", "anchored_slam", "notation", "references", "library/slam"):
        page.goto(f"{address}{name}.html")
        assert page.locator(".math").count() > 0
        assert page.evaluate(UNSET) == []
        assert page.evaluate(SOURCE) == []
        assert page.evaluate(EQUATIONS) == []


@pytest.mark.parametrize("reading", NOTEBOOKS, indirect=True)
def test_tables_of_results_can_be_taken_in_at_a_glance(reading: Reading) -> None:
    """They have six rows at most outside of folds."""
    page = reading(WINDOW)
    rows = """tables => tables.filter(table => !table.closest("details"))
      .map(table => table.tBodies[0].rows.length).filter(rows => rows > 6)"""
    assert page.eval_on_selector_all("table.rp-results", rows) == []
