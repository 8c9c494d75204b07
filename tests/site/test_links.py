"""Every link of the built site has its target: the file, and the place on the page; by number."""

import re
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from bs4 import BeautifulSoup

from tests.site.contents import PAGES
from tests.site.soup import LARGE, parsed

TRACEBACK = 'class="output traceback'


class Names(HTMLParser):
    """What a page names, and where it links."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.ids: set[str] = set()
        self.again: set[str] = set()
        self.links: set[str] = set()
        self.feed(LARGE.sub(r"\1\3", page.read_text("utf-8")))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note the name of an element, and the target of a link."""
        found = dict(attrs)
        if name := found.get("id"):
            (self.again if name in self.ids else self.ids).add(name)
        if tag == "a" and found.get("href"):
            self.links.add(found["href"])


def astray(pages: dict[Path, Names]) -> list[str]:
    """Return the links within the site that lead nowhere, or to one of two places."""
    wrong = []
    for page, names in pages.items():
        for link in sorted(names.links):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
            place, found = unquote(parts.fragment), pages.get(target)
            known = found is None or place in found.ids - found.again
            if not target.exists() or (place and not known):
                wrong.append(f"{page.name}: {link}")
    return wrong


def test_every_link_has_its_target(site: Path) -> None:
    files = (path.resolve() for path in site.rglob("*.html") if "_static" not in path.parts)
    wrong = astray({path: Names(path) for path in files})
    assert not wrong, "\n".join(wrong)


def test_no_page_of_the_library_shows_an_address_in_memory(site: Path) -> None:
    """A function in a signature would be at another one at each build."""
    pages = [*(site / "library").glob("*.html")]
    assert pages
    assert not [page.name for page in pages if re.search(r"at 0x[0-9a-f]", page.read_text("utf-8"))]


def test_no_page_shows_that_something_failed(site: Path) -> None:
    """What cannot be displayed leaves a traceback, and its cell does not fail by it."""
    failed = [page.name for page in site.glob("*.html") if TRACEBACK in page.read_text("utf-8")]
    assert not failed


def test_links_without_a_target_are_named(tmp_path: Path) -> None:
    one, two = tmp_path / "one.html", tmp_path / "two.html"
    good = '<p id="a"></p><a href="#a"></a><a href="two.html#b%20c"></a><a href="https://a.b#c">'
    one.write_text(f'{good}<a href="two.html#a"></a><a href="#"></a><a href="no.html"></a>')
    two.write_text('<p id="b c"></p><a href="#x"></a><p id="d"></p><p id="d"></p><a href="#d"></a>')
    found = astray({page: Names(page) for page in (one, two)})
    assert found == [
        "one.html: no.html",
        "one.html: two.html#a",
        "two.html: #d",
        "two.html: #x",
    ]


@cache
def read(file: Path) -> BeautifulSoup:
    """Return a page of the site."""
    return parsed(file.read_text("utf-8"))


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
