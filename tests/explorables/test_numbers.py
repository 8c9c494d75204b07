"""Numbers of figures and the links to them, in a small book of plain pages."""

import io
import re
from pathlib import Path

import pytest
from sphinx.application import Sphinx
from sphinx.util.docutils import docutils_namespace

from explorables import sphinx_extension
from explorables.figures.output import figcaption, opening

WORDS = {"one": "The first.", "two": "The second.", "three": "The third."}


def shown(name: str | None, caption: str | None) -> str:
    """Return a page's source of a figure as `show` writes it."""
    html = f"{opening('rp-figure', name)}<svg></svg>{figcaption(caption)}</figure>"
    return f"```{{raw}} html\n{html}\n```\n"


PAGES = {
    "index": "# Book\n\n```{toctree}\n:numbered:\nalpha\nbeta\n```\n",
    "alpha": "# Alpha\n\nSee [](#fig-two), [the third](#fig-three) and [](#fig-one).\n\n"
    + shown("one", WORDS["one"])
    + shown(None, None)
    + shown(None, "Without a name.")
    + shown("two", WORDS["two"]),
    "beta": "# Beta\n\nAs [the figure](#fig-one) and [](#fig-three) say.\n\n"
    + shown("three", WORDS["three"]),
}


def made(folder: Path, pages: dict[str, str]) -> tuple[dict[str, str], str]:
    """Build pages, again if they are there; return what they become, and the warnings."""
    source, target = folder / "source", folder / "html"
    source.mkdir(exist_ok=True)
    for name, text in pages.items():
        path = source / f"{name}.md"
        if not path.exists() or path.read_text() != text:
            path.write_text(text)
    warnings = io.StringIO()
    settings = {"extensions": "myst_parser,tests.explorables.test_numbers"}
    with docutils_namespace():  # without it a second build in one process complains
        app = Sphinx(
            source, None, target, folder / "trees", "html", settings, io.StringIO(), warnings
        )
        app.build()
    return {name: (target / f"{name}.html").read_text() for name in pages}, warnings.getvalue()


def setup(app: Sphinx) -> None:
    """Number figures, without the rest of the book's extension."""
    sphinx_extension.connect_figures(app)


def captions(page: str) -> list[str]:
    """Return the captions of a page without their tags."""
    return [re.sub("<[^>]*>", "", c) for c in re.findall(r"<figcaption.*?</figcaption>", page)]


def links(page: str) -> list[tuple[str, str]]:
    """Return the links to figures: address and text."""
    found = re.findall(
        r'<a class="reference internal" href="([^"]*#fig-[^"]*)"[^>]*>(.*?)</a>', page
    )
    return [(address, re.sub("<[^>]*>", "", text)) for address, text in found]


def test_figures_are_numbered_by_chapter_and_links_have_the_numbers(tmp_path: Path):
    pages, warnings = made(tmp_path, PAGES)
    assert not warnings
    assert captions(pages["alpha"]) == [
        "Fig. 1.1 The first.",
        "Fig. 1.2 Without a name.",
        "Fig. 1.3 The second.",
    ]
    assert captions(pages["beta"]) == ["Fig. 2.1 The third."]
    assert links(pages["alpha"]) == [
        ("#fig-two", "Fig. 1.3"),
        ("beta.html#fig-three", "the third"),
        ("#fig-one", "Fig. 1.1"),
    ]
    assert links(pages["beta"]) == [("alpha.html#fig-one", "Fig. 1.1"), ("#fig-three", "Fig. 2.1")]


def test_a_page_that_refers_to_a_changed_number_is_written_again(tmp_path: Path):
    made(tmp_path, PAGES)
    longer = shown("new", "A new one.") + shown("one", WORDS["one"])
    pages, warnings = made(tmp_path, PAGES | {"alpha": "# Alpha\n\n" + longer})
    assert not warnings
    assert links(pages["beta"])[0] == ("alpha.html#fig-one", "Fig. 1.2")


@pytest.mark.parametrize(
    ("page", "complaint"),
    [
        ("# Beta\n\nAs [](#fig-four) says.\n", "fig-four"),
        ("# Beta\n\n" + shown("one", "Again."), "figure fig-one stands twice"),
    ],
)
def test_a_link_without_target_and_a_name_used_twice_are_warned_of(
    tmp_path: Path, page: str, complaint: str
):
    _, warnings = made(tmp_path, PAGES | {"alpha": "# A\n\n" + shown("one", "1"), "beta": page})
    assert complaint in warnings
