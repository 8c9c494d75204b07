"""Whatever stands in a record, a label or a caption stays text in the HTML that is made of it."""

import json
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from bs4 import BeautifulSoup
from matplotlib.figure import Figure

from explorables.bets import bet
from explorables.explore import choice, explore
from explorables.figures import figure, film, show
from explorables.figures.output import PAGE_VARIABLE
from robot_perception.teaching.course.exercises import Exercise, Sheet
from robot_perception.teaching.pages.cards import Card, cards
from robot_perception.teaching.pages.contents import Contents
from robot_perception.teaching.scores import badges, overview, scorecard
from robot_perception.teaching.scores.performance import Latency, Record, Work
from studies.claims import Finding
from studies.intervals import Interval
from studies.ledger import Entry, Ledger, Sabotaged, Withdrawn
from studies.tables import Table
from studies.verdicts import Accepted, Condition
from tests.studies.entries import claim, made, study
from tests.teaching.test_contents import page

PLAIN = "a word that is long enough"
HOSTILE = (
    f"{PLAIN}<!--<script>alert(1)</script>",
    f'{PLAIN}" onmouseover="alert(1)" x="',
    f"{PLAIN}' onmouseover='alert(1)' x='",
    f"{PLAIN}</script><img src=x onerror=alert(1)>",
    f"{PLAIN}</style></title></textarea><svg onload=alert(1)>",
    f"{PLAIN} $x</span><script>alert(1)</script>$ <!--",
    f"{PLAIN}]]><b>&lt;b&gt;</b>",
)


def entry(text: str) -> Entry:
    table = Table({text: [Interval(1, 0, 2), text]}, {text: text, "other": text}, text, text)
    number = Interval(1.5, 1.4, 1.6, text, text)
    finding = Finding(number, {text: number}, {text: table}, (Condition(text, True),), note=text)
    words = {
        "place": text, "statement": text, "method": text, "paper_value": text,
        "accepted": Accepted(1, 2, text, "our choice"),
    }  # fmt: skip
    sabotages = (Sabotaged(text, text, number),)
    other = {"verdict": text, "date": text, "versions": text, "sabotages": sabotages}
    return replace(made(text, finding, **words), **other)


def drawing(text: str) -> Figure:
    fig, ax = figure()
    ax.set_title(text.replace("$", ""))
    ax.set_xlabel(text.replace("$", ""))
    return fig


def frames() -> list[np.ndarray]:
    return [np.full((20, 30), k, np.uint8) for k in (0, 200)]


def explored(text: str, draw: Callable[..., Any]) -> Any:
    return explore(
        draw, alt=text, caption=text, name="some-name", presets={text: {"which": text}},
        which=choice(text, [text, "other"], text),
    )  # fmt: skip


def record(text: str) -> Record:
    work = Work(f"people {text}", 1.0, 2.0, text, text, reached=False)
    latency = Latency(text, text, "built page", 1.0, 2.0, 3.0, text, reached=False)
    return Record(text, text, text, (work,), (latency,), 1)


PRODUCERS: dict[str, Callable[[str], Any]] = {
    "badges": badges.badges,
    "score": lambda text: badges.score(),
    "table of claims": lambda text: badges.claim_table("walls"),
    "scorecard": lambda text: scorecard.scorecard(
        [claim(text, study=study(note=text))], {"walls": text}, {"perception-issues": text}
    ),
    "withdrawn claims": lambda text: scorecard.withdrawn(),
    "overview": lambda text: overview.overview({"walls": text}),
    "benchmarks": lambda text: record(text).about(),
    "tables of benchmarks": lambda text: record(text).tables(),
    "missed targets": lambda text: record(text).missed(),
    "themes": lambda text: record(text).themes().show(),
    "table": lambda text: entry(text).tables[text].show(bold=[text]),
    "cards": lambda text: cards(
        Contents([page("walls", text)]), {"walls": Card(text, drawing(text), text)}
    ),
    "bet": lambda text: bet(text, {text: text, "other": text}, text),
    "exercise": lambda text: Sheet({text: Exercise(1, ((2, text),), text)}).check(text, 2),
    "another exercise": lambda text: Sheet({text: Exercise(text)}).check(text, [text]),
    "figure": lambda text: show(drawing(text), alt=text, caption=text, name="some-name"),
    "film": lambda text: film(frames(), fps=2, alt=text, caption=text, name="some-name"),
    "explorer of drawings": lambda text: explored(text, lambda which: drawing(text)),
    "explorer of pictures": lambda text: explored(text, lambda which: frames()[0]),
}
"""What makes HTML of a text, by what it makes; the text stands in every place where one can."""


def parsed(make: Callable[[str], Any], text: str, monkeypatch: pytest.MonkeyPatch) -> BeautifulSoup:
    gone = Withdrawn(**dict.fromkeys(Withdrawn.__slots__, text) | {"value": entry(text).value})
    shown = Ledger((entry(text),), (replace(gone, paper=entry(text).paper),))
    for module in (badges, scorecard, overview):
        monkeypatch.setattr(module, "recorded", lambda: shown)
    return BeautifulSoup(make(text)._repr_mimebundle_()["text/html"], "html.parser")


def structure(page: BeautifulSoup) -> list[tuple[str, list[str]]]:
    """Return the elements with the names of their attributes; a formula is one or is none."""
    for formula in page.find_all("span", class_="math"):
        formula.unwrap()
    return [(element.name, sorted(element.attrs)) for element in page.find_all(True)]


@pytest.mark.parametrize("medium", ["1", ""], ids=["page", "notebook"])
@pytest.mark.parametrize("name", PRODUCERS)
def test_no_text_becomes_markup(name, medium, monkeypatch):
    monkeypatch.setenv(PAGE_VARIABLE, medium)
    wanted = structure(parsed(PRODUCERS[name], PLAIN, monkeypatch))
    assert wanted
    for text in HOSTILE:
        page = parsed(PRODUCERS[name], text, monkeypatch)
        assert structure(page) == wanted, text
        for script in page.find_all("script", type="application/json"):
            assert "<" not in script.string, "HTML reads on where a script nests"
            json.loads(script.string)
