"""Every page: served, from a folder, without scripts; one visit each, and one list of findings."""

from collections.abc import Callable, Iterable
from pathlib import Path

import pytest

from tests.site import folder, scorecard, served, unscripted
from tests.site.accessibility import serious
from tests.site.conftest import Visit
from tests.site.contents import NOTEBOOKS, PAGES
from tests.site.visits import Broken, Check, Facts, Standing, findings, measured


def judge(facts: Facts, checks: Iterable[Check]) -> None:
    """Fail with all that is wrong."""
    wrong = list(findings(facts, checks))
    assert not wrong, "\n".join([f"{len(wrong)} findings", *wrong])


@pytest.mark.parametrize("name", PAGES)
def test_page(
    name: str,
    visit: Callable[..., Visit],
    address: str,
    site: Path,
    count: Callable[[str, int], None],
) -> None:
    """A page that is served has no error, satisfies axe, fits its windows, and can be moved."""
    visitor = visit(color_scheme="dark")
    visitor.open(f"{address}{name}.html")
    standing = Standing(name, visitor, served.DARK, site)
    facts = measured(standing, served.STAGES, served.CHECKS)
    tell(facts, count)
    judge(facts, served.CHECKS)


def tell(facts: Facts, count: Callable[[str, int], None]) -> None:
    """Count what was seen in a visit, as far as it could be read."""
    known = {place: fact for place, fact in facts.items() if not isinstance(fact, Broken)}
    driven = known.get(("window", "explorers"), {"driven": []})["driven"]
    count("pages opened", 1)
    count("explorers driven", len(driven))
    count("controls driven to both ends", sum(found["controls"] for found in driven))
    count("states shown", sum(found["states"] for found in driven))
    count("requests to other hosts", len(known.get(("end", "other hosts"), ())))
    count("console errors and page errors", len(known.get(("end", "console"), ())))
    for theme, stage in (("light", "window"), ("dark", "dark")):
        found = serious(known.get((stage, "axe"), []))
        count(f"serious or critical violations, {theme}", len(found))


@pytest.mark.parametrize("name", PAGES)
def test_rows_of_a_page_are_recorded(name: str, site: Path) -> None:
    """No page has computed a few replicates of a study, as it does where a reader has edited it."""
    assert "computed here" not in (site / f"{name}.html").read_text("utf-8")


@pytest.mark.parametrize("name", folder.VISITED)
def test_page_from_a_folder(
    name: str, visit: Callable[..., Visit], site: Path, count: Callable[[str, int], None]
) -> None:
    """A page that is opened from disk has no error, asks no host, and moves."""
    visitor = visit()
    place = f"#{scorecard.claims()[-1].id}" if name in scorecard.PAGES else ""
    visitor.open(f"{(site / f'{name}.html').as_uri()}{place}")
    facts = measured(Standing(name, visitor, folder.FOLDER, site), [folder.FOLDER], folder.CHECKS)
    count("requests to other hosts", len(visitor.strangers))
    count("console errors and page errors", len(facts[folder.FOLDER.name, "console"]))
    judge(facts, folder.CHECKS)


@pytest.mark.parametrize("name", unscripted.VISITED)
def test_page_without_scripts(
    name: str, visit: Callable[..., Visit], address: str, site: Path
) -> None:
    """A page can be read without scripts, and says what is missing."""
    visitor = visit(java_script_enabled=False)
    visitor.page.goto(f"{address}{name}.html")
    stage = unscripted.UNSCRIPTED
    facts = measured(Standing(name, visitor, stage, site), [stage], unscripted.CHECKS)
    judge(facts, unscripted.CHECKS)


def test_there_are_points_and_films_of_drawings(site: Path) -> None:
    """What is checked only where it is found is found on some pages."""
    pages = [(site / f"{name}.html").read_text("utf-8") for name in NOTEBOOKS]
    assert sum(page.count('"drag": {') for page in pages) >= 5
    assert any('class="rp-film"' in page and "rp-drawing" in page for page in pages)


def test_remaining_pages(
    site: Path, visit: Callable[..., Visit], address: str, count: Callable[[str, int], None]
) -> None:
    """Index, search and source pages have no error, ask no other host, and satisfy axe."""
    others = {path.relative_to(site).as_posix() for path in site.rglob("*.html")}
    others -= {"index.html", *(f"{name}.html" for name in PAGES)}
    others = {page for page in others if not page.startswith("_static/")}
    sources = sorted(page for page in others if page.startswith("_modules/"))
    wrong: list[str] = []
    for page in [*sorted(others.difference(sources)), *sources[:1]]:  # source pages are all alike
        visitor = visit(color_scheme="dark")
        visitor.open(address + page)
        standing = Standing(page.removesuffix(".html"), visitor, served.DARK, site)
        facts = measured(standing, served.STAGES, served.PLAIN)
        tell(facts, count)
        wrong += [f"{page}, {words}" for words in findings(facts, served.PLAIN)]
    assert not wrong, "\n".join(wrong)


def test_index_leads_to_the_first_page(visit: Callable[..., Visit], address: str) -> None:
    """The bare address shows the landing page."""
    page = visit().page
    page.goto(f"{address}index.html")
    page.wait_for_url(f"**/{PAGES[0]}.html")


def test_search_finds(visit: Callable[..., Visit], address: str) -> None:
    """The search works without a server.

    The word names no module: Sphinx looks for the anchor of one as if its dots began classes.
    """
    visitor = visit()
    page = visitor.open(f"{address}search.html?q=freiburg")
    page.wait_for_selector("#search-results li a", timeout=10_000)
    assert not visitor.errors
