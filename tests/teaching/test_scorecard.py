"""The scorecard has a card for every claim, with all that a reader can check."""

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import pytest

from explorables.figures.output import PAGE_VARIABLE
from robot_perception import chapters
from robot_perception.teaching.scores import overview
from robot_perception.teaching.scores import scorecard as module
from robot_perception.teaching.scores.papers import PAPERS, paper
from studies import registration
from studies.claims import Finding
from studies.intervals import Interval, exact
from studies.ledger import Ledger
from studies.registration import Registration
from studies.tables import Table
from studies.verdicts import Accepted, Condition
from tests.studies.entries import claim, made

BOOK = Path(__file__).parents[2] / "book"
TITLES = {"walls": "Walls & scans", "monobot": "On a rail"}
SAID = {"perception-issues": "A length of {good:.1f} <m>."}


@pytest.fixture
def ledger(monkeypatch):
    good = Finding(
        Interval(1.5, 1.4, 1.6, "m"),
        tables={"all of it": Table({"first": [2]}, {"x <m>": "a length"})},
        conditions=(Condition("the chain is simple", True),),
    )
    shown = Ledger(
        (
            made("good", good, paper_value="a <half>"),
            made("bad", Finding(exact(0)), chapter="monobot"),
            made("dark", Finding(None, note="Nobody has it.")),
        )
    )
    monkeypatch.setattr(module, "recorded", lambda: shown)
    monkeypatch.setattr(overview, "recorded", lambda: shown)
    return shown


def card(html, name):
    """Return the HTML of one card."""
    return next(part for part in html.split("<article")[1:] if f' id="{name}"' in part)


def html_of(ledger):
    claims = [claim(entry.id, chapter=entry.chapter) for entry in ledger.entries]
    return module.scorecard(claims, TITLES, SAID).bundle["text/html"]


def test_cards_stand_below_their_papers_experiments_before_mathematics(ledger, monkeypatch):
    more = (
        made("proof", Finding(exact(1)), basis="mathematics"),
        made("own", Finding(exact(1)), place="beyond the paper; §2"),
    )
    longer = Ledger((*more, *ledger.entries))
    monkeypatch.setattr(module, "recorded", lambda: longer)
    html = html_of(longer)
    order = (
        "Andrade-Cetto 2004: Perception Issues in Mobile Robotics</h2>",
        "A length of 1.5 &lt;m&gt;.",
        *(">Experiments<", 'id="good"', 'id="bad"', 'id="dark"'),
        *(">Mathematics: identities", 'id="proof"', ">Findings of ours</h2>", 'id="own"'),
    )
    places = [html.index(text) for text in order]
    assert places == sorted(places)
    assert html.count("<article") == 5


def test_a_card_says_everything_escaped(ledger):
    html = html_of(ledger)
    good = card(html, "good")
    for text in (
        'data-verdict="conditional"',
        'data-paper="perception-issues"',
        "Andrade-Cetto 2004, Fig. 1 &amp; Table 2",
        "Distances are &lt;squared&gt;.",
        '<p class="rp-condition">Only if the chain is simple.</p>',
        "<dt>Paper</dt><dd>a &lt;half&gt;",
        "<dt>Result</dt><dd>The length is 1.50\N{NO-BREAK SPACE}m [1.40, 1.60]; at least "
        "1\N{NO-BREAK SPACE}m wanted. <small>",
        "<dt>Stands on</dt><dd>a substitute for the paper&#x27;s world</dd>",
        "<dt>Holds from 1</dt><dd>Our choice (another verdict with the lower end 0.4",
        "<p>All of it</p>",
        "x &lt;m&gt;",
        "<dt>Rows</dt><dd>Given.</dd>",
        "robot-perception claims --run --claim good",
    ):
        assert text in good
    dark = card(html, "dark")
    assert "<dt>Result</dt><dd>Nobody has it. <small>" in dark
    assert "<dt>Paper</dt>" not in dark
    assert "Nobody has it." in dark


def test_each_paper_has_a_row_with_its_chapters_and_its_verdicts(ledger):
    shown = overview.overview(TITLES).bundle
    own, *others = shown["text/html"].split("<tr>")[2:]
    assert len(others) == len(PAPERS) - 1
    assert own.index("Walls &amp; scans") < own.index("On a rail")
    assert all(overview.TO_COME in row and "rp-badge " not in row for row in others)
    first, second, *_ = shown["text/plain"].split("\n")
    assert first == "Andrade-Cetto 2004: 1 conditional, 1 not reproduced, 1 untestable"
    assert second == f"Gil et al. 2006: {overview.TO_COME}"


def test_what_goes_beyond_a_paper_is_counted_apart(ledger, monkeypatch):
    ours = replace(ledger.entries[0], id="ours", place="beyond the paper, §2")
    monkeypatch.setattr(overview, "recorded", lambda: Ledger((*ledger.entries, ours)))
    lines = overview.overview(TITLES).bundle["text/plain"].split("\n")
    assert lines[0] == "Andrade-Cetto 2004: 1 conditional, 1 not reproduced, 1 untestable"
    assert lines[-1] == f"{overview.FOUND}: 1 conditional"


def test_a_card_leads_to_badge_function_and_test_on_the_page(ledger, monkeypatch):
    monkeypatch.setenv(PAGE_VARIABLE, "1")
    bad = card(html_of(ledger), "bad")
    assert 'Shown in <a href="monobot.html#claim-bad">On a rail</a>' in bad
    assert '<a href="_modules/tests/studies/entries.html#compute">book/entries.py</a>' in bad
    tests, test = "tests/book/test_claims", "test_the_record_says_what_the_rows_say"
    assert f'Tested by <a href="_modules/{tests}.html#{test}">{tests}.py</a>' in bad


def test_a_card_names_the_cell_that_computes_its_claim():
    some = chapters.claims(["covariance_intersection"])[0]
    links = module._links(made(some.id, Finding(exact(1))), some, "Two opinions")
    assert re.search(r"book/covariance_intersection\.ipynb, cell [\w-]+<", links)


def test_in_a_notebook_a_card_leads_to_the_notebook_and_names_the_rest(ledger, monkeypatch):
    monkeypatch.delenv(PAGE_VARIABLE, raising=False)
    bad = card(html_of(ledger), "bad")
    assert 'Shown in <a href="monobot.ipynb">On a rail</a>' in bad
    assert "_modules" not in bad
    assert "Tested by tests/book/test_claims.py" in bad


def test_the_filter_offers_each_verdict_and_paper_once_and_waits_for_its_script(ledger):
    form = html_of(ledger).split("<form", 1)[1].split("</form>")[0]
    assert form.split(">")[0].endswith(" hidden")
    for value in ("conditional", "not reproduced", "perception-issues"):
        assert form.count(f'value="{value}"') == 1
    assert form.count(" checked>") == 2


def test_withdrawn_claims_stand_in_a_table_of_their_own(ledger, monkeypatch):
    why = {"why": "nobody <has> it", "instead": "good", "day": "2026-01-03"}
    dated = [replace(entry, date="2026-01-02") for entry in ledger.entries]
    left = Ledger(tuple(dated)).withdrawing("bad", **why)
    monkeypatch.setattr(module, "recorded", lambda: left)
    monkeypatch.setenv(PAGE_VARIABLE, "1")
    html = module.withdrawn().bundle["text/html"]
    (row,) = html.split("<tr")[2:]
    for text in (
        ' id="bad"',
        "Distances are &lt;squared&gt;.",
        "<strong>not reproduced</strong>, 0 on 2026-01-02",
        '2026-01-03: nobody &lt;has&gt; it; in its place <a href="scorecard.html#good">good</a>',
    ):
        assert text in row
    assert html_of(left).count("<article") == 2
    assert ' id="bad"' not in html_of(left)
    assert repr(module.withdrawn()).startswith("bad not reproduced 0, withdrawn on 2026-01-03: ")


def test_claims_that_were_registered_again_stand_in_a_table_with_the_reason(ledger, monkeypatch):
    def one(claim, number, remark):
        return Registration(claim, number, "2026-01-03", "", "", "", remark)

    monkeypatch.setenv(PAGE_VARIABLE, "1")
    known = {"good": one("good", 1, "first"), "bad": one("bad", 2, "other <films>")}
    monkeypatch.setattr(registration, "latest", lambda: known | {"left": one("left", 3, "gone")})
    shown = module.registered_again()
    (row,) = shown.bundle["text/html"].split("<tr")[2:]
    assert 'href="scorecard.html#bad"' in row
    assert "<td>2</td>" in row
    assert "2026-01-03: other &lt;films&gt;" in row
    assert repr(shown) == "bad 2 times, last on 2026-01-03: other <films>"


def test_the_text_is_the_table_of_all(ledger):
    text = repr(module.scorecard(map(claim, ("good", "bad", "dark")), TITLES, SAID))
    assert [line.split()[0] for line in text.splitlines()[2:]] == ["good", "bad", "dark"]


@pytest.mark.parametrize(
    ("accepted", "value", "words"),
    [
        (
            Accepted(1, 3, "why", "our choice"),
            Interval(1.5, 1.4, 1.6),
            "the lower end 0.4 further in",
        ),
        (Accepted(1, 3, "why", "our choice"), Interval(9, 8, 10), "the upper end 5 further out"),
        (Accepted(1, 3, "why", "our choice"), Interval(2, 0.5, 6), "both ends 3 further out"),
        (Accepted(1, 3, "why", "paper"), Interval(2, 2, 2), "Set by the paper: why"),
    ],
)
def test_who_set_a_range_and_where_the_verdict_turns(accepted, value, words):
    assert words in module._details(made("x", Finding(value), accepted=accepted), "Given.")


@pytest.mark.parametrize(
    ("low", "high", "words"),
    [
        (-math.inf, 2.0, "up to 2"),
        (1.0, math.inf, "from 1"),
        (1.0, 1.0, "at 1"),
        (1, 2, "from 1 to 2"),
    ],
)
def test_ranges_are_written_in_words(low, high, words):
    some = made("x", Finding(exact(1.0)), accepted=Accepted(low, high, "counted"))
    assert f"<dt>Holds {words}</dt><dd>Set by theory: counted</dd>" in module._details(
        some, "Given."
    )


def test_papers_have_a_citation_and_an_entry_in_the_bibliography():
    bibliography = re.sub(r"\{([A-Z]+)\}", r"\1", (BOOK / "references.bib").read_text("utf-8"))
    for key in {declared.paper for declared in chapters.claims()}:
        assert paper(key).citation
    for known in PAPERS.values():
        assert f"{{{known.reference}," in bibliography
        assert f"title = {{{known.title}}}" in bibliography
    with pytest.raises(ValueError, match="'perception-issues'"):
        paper("perception")


def test_titles_of_chapters_are_those_of_their_notebooks():
    for stem, title in chapters.titles().items():
        cells = json.loads((BOOK / f"{stem}.ipynb").read_text("utf-8"))["cells"]
        lines = ("".join(cell["source"]).split("\n")[0] for cell in cells)
        assert next(line for line in lines if line.startswith("# ")) == f"# {title}"
