"""Words: found in prose by their forms, placed under headings, named as the library names them."""

import pytest
from bs4 import BeautifulSoup
from docutils import nodes
from docutils.utils import new_document

from robot_perception.teaching.pages.contents import Contents, Page
from robot_perception.teaching.words import sphinx_terms, terms
from robot_perception.teaching.words.terms import Finder, Term, called, heading, prose, uses, words
from studies.files import DamagedFile

GATE = Term("gate", "A region.", ("one#open",), ("gating",), library=("gating.gate",))
SLAM = Term("EKF-SLAM", "A *filter* for <maps>.", ("one#named",), ours="$P$")
FILTER = Term("Kalman filter", "It predicts.", ("one#open",), papers={"sift-slam": "$K$"})
GAIN = Term("gain", "A factor.", ("one#open",), ("Kalman gain",), hover=("Kalman gain",))
TEXT = """# One

## Open

Gates, and a `gain`. $gate$

(named)=
## Below

<a id="here"></a>Words.

```python
# No heading
```
"""


def book():
    code = 'say("what the gating does")\nname = "gain"'
    return Contents(
        [Page("one", 1, "Part", (TEXT, code)), Page("two", None, "Part", ("# Two", ""))]
    )


def found(text):
    return [
        (text[a:b], term.name) for a, b, term in Finder((GATE, SLAM, FILTER, GAIN), "one")(text)
    ]


def test_words_are_found_whole_with_their_plurals_the_longest_first():
    text = "Gates of EKF-SLAM: no Kalman\nfilter gains, Kalman gains; floodgate, gate-keeper."
    assert found(text) == [
        ("Gates", "gate"),
        ("EKF-SLAM", "EKF-SLAM"),
        ("Kalman\nfilter", "Kalman filter"),
        ("Kalman gains", "gain"),
    ]


def test_prose_is_text_and_what_cells_say_without_code_and_formulas():
    said = prose(book().pages["one"])
    assert "Gates" in said
    assert "what the gating does" in said
    assert "gain" not in said
    assert "gate$" not in said


def test_uses_name_the_pages_in_their_order():
    pages = tuple(book().pages.values())
    assert {k: [p.stem for p in v] for k, v in uses((GATE, GAIN), pages).items()} == {
        "gate": ["one"],
        "gain": [],
    }


@pytest.mark.parametrize(
    ("place", "said"), [("one#open", "Open"), ("one#named", "Below"), ("one#here", "Below")]
)
def test_a_place_has_the_heading_at_it_below_its_name_or_above_it(place, said):
    assert heading(book(), place) == said


@pytest.mark.parametrize("place", ["one#no-heading", "one#gone", "three#open", "one"])
def test_no_place_is_an_error(place):
    with pytest.raises(ValueError, match="no place"):
        heading(book(), place)


def test_names_of_the_library_are_functions_fields_methods_and_arguments():
    assert called("kalman.update(prior)") is called("kalman.update")
    assert called("beliefs.Gaussian.cov")
    assert called("walls.simplify")


@pytest.mark.parametrize(
    "name", ["kalman.nothing", "beliefs.Gaussian.skew", "kalman.update(posterior)", "kalman update"]
)
def test_another_name_is_an_error(name):
    with pytest.raises(ValueError, match=r"nothing is called|no argument|no name of the library"):
        called(name)


def test_a_page_of_words_says_what_is_known_and_links():
    page = BeautifulSoup(words(book(), (SLAM, GATE)).bundle["text/html"], "html.parser")
    assert [article["id"] for article in page.find_all("article")] == ["word-ekf-slam", "word-gate"]
    assert page.select_one("article p").decode_contents() == "A <em>filter</em> for &lt;maps&gt;."
    facts = [dt.text for dt in page.select("dt")]
    assert facts == ["Our symbol", "Explained in", "In the library", "Explained in", "Used in"]
    assert page.select_one("nav").text.split() == ["E", "G"]


def test_a_damaged_list_is_named(tmp_path):
    file = tmp_path / "terms.toml"
    file.write_text('[[term]]\nname = "gate"\nmeans = "?"')
    with pytest.raises(DamagedFile, match="is no list of words"):
        terms.read(file)


class Builder:
    def get_relative_uri(self, page, target):
        return f"{target}.html"


def marked(page, *children, listed="terms", patch):
    document = new_document("page")
    document += children
    patch.setattr(terms, "read", lambda: (GATE, FILTER))
    mark = object.__new__(sphinx_terms.MarkTerms)
    mark.document = document
    env = type("Env", (), {"docname": page})()
    app = type("App", (), {"builder": Builder()})()
    patch.setattr(sphinx_terms.MarkTerms, "env", env)
    patch.setattr(sphinx_terms.MarkTerms, "config", type("C", (), {"book_terms": listed})())
    patch.setattr(sphinx_terms.MarkTerms, "app", app)
    mark.run()
    return [node.astext() for node in document.findall(nodes.raw)]


def test_the_first_use_in_prose_is_marked_and_no_other(monkeypatch):
    link = nodes.reference("", "gate", refuri="x")
    box = nodes.tip("", nodes.paragraph("", "A gate in a box."))
    text = nodes.paragraph("", "", link, nodes.Text(" no; a gate & a Kalman filter, a gate."))
    found = marked("one", box, nodes.title("", "Gates"), text, patch=monkeypatch)
    assert found == [
        '<a class="rp-term" href="words.html#word-gate" title="A region.">gate</a>',
        '<a class="rp-term" href="words.html#word-kalman-filter" title="It predicts.">'
        "Kalman filter</a>",
    ]
    assert text.astext().startswith("gate no; a <a")
    assert text.astext().endswith(", a gate.")


@pytest.mark.parametrize(
    ("page", "listed"), [("words", "terms"), ("library/slam", "terms"), ("one", "")]
)
def test_pages_of_words_and_code_are_left_as_they_are(page, listed, monkeypatch):
    text = nodes.paragraph("", "A gate.")
    assert marked(page, text, listed=listed, patch=monkeypatch) == []
