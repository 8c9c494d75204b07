"""Every link of the built site has its target: the file, and the place on the page."""

from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


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
