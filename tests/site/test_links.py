"""Every link of the built site has its target: the file, and the place on the page."""

from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

from tests.site.contents import NOTEBOOKS


class Names(HTMLParser):
    """What a page names, and where it links."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.ids: set[str] = set()
        self.again: set[str] = set()
        self.links: set[str] = set()
        self.feed(page.read_text("utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Note the name of an element, and the target of a link."""
        found = dict(attrs)
        if name := found.get("id"):
            (self.again if name in self.ids else self.ids).add(name)
        if tag == "a" and found.get("href"):
            self.links.add(found["href"])


def without_target(pages: dict[Path, Names]) -> list[str]:
    """Return the links within the site that lead nowhere."""
    wrong = []
    for page, names in pages.items():
        for link in sorted(names.links):
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
            known = pages[target].ids if target in pages else {unquote(parts.fragment)}
            if not target.exists() or unquote(parts.fragment) not in known | {""}:
                wrong.append(f"{page.name}: {link}")
    return wrong


def test_every_link_has_its_target(site: Path) -> None:
    files = (path.resolve() for path in site.rglob("*.html") if "_static" not in path.parts)
    pages = {path: Names(path) for path in files}
    wrong = without_target(pages)
    assert not wrong, "\n".join(wrong)
    for name in NOTEBOOKS:  # a name that stands twice leads to one of two places
        again = pages[site.resolve() / f"{name}.html"].again
        assert not again, f"{name}: {', '.join(sorted(again))}"


def test_links_without_a_target_are_named(tmp_path: Path) -> None:
    one, two = tmp_path / "one.html", tmp_path / "two.html"
    good = '<p id="a"></p><a href="#a"></a><a href="two.html#b%20c"></a><a href="https://a.b#c">'
    one.write_text(f'{good}<a href="two.html#a"></a><a href="#"></a><a href="no.html"></a>')
    two.write_text('<p id="b c"></p><a href="#x">')
    found = without_target({page: Names(page) for page in (one, two)})
    assert found == ["one.html: no.html", "one.html: two.html#a", "two.html: #x"]
