"""The ledger keeps ten digits and every word, merges by identifier, and is written whole."""

import json
import math
from dataclasses import replace

import pytest

from studies.claims import Finding
from studies.files import DamagedFile
from studies.intervals import Interval, exact
from studies.ledger import (
    Entry,
    Ledger,
    Sabotaged,
    agrees,
    entry,
    record,
    verdicts,
)
from studies.tables import Table
from studies.trials import Sabotage
from studies.verdicts import Accepted, Basis, Condition, Verdict, decide
from tests.studies.entries import claim, study

TABLE = Table({"plain": [Interval(2.0, 1.0, 3.0), "lost"]}, {"end (m)": "at the end", "map": ""})


def finding(value):
    return Finding(
        Interval(value, value - 0.1, value + 0.1, "m", "95 %"),
        {"a length": exact(1 / 3, "m"), "ours (time)": exact(0.7, "s")},
        {"ends": TABLE},
        (Condition("it rains", True), Condition("it snows", False)),
        "Ten words.",
    )


def some(name="some-claim", value=1.5, seed=0, **changes):
    own = study(value, seed=seed)
    return claim(name, basis=Basis.PAPER, study=own, compute=finding, **changes)


def test_an_entry_has_the_words_of_the_claim_and_what_it_gives():
    declared = some(seed=3, paper_value="n²")
    made = record(declared, versions="numpy 2")
    for name in ("id", "chapter", "paper", "place", "basis", "statement", "paper_value", "method"):
        assert getattr(made, name) == getattr(declared, name)
    assert (made.seed, made.note, made.verdict) == (3, "Ten words.", "conditional")
    failed = record(some(value=0.8), versions="")
    assert (failed.verdict, failed.conditions) == ("refuted", [])
    assert made.value.estimate == 1.5
    assert made.conditions == ["it rains"]
    assert made.versions == "numpy 2"
    assert made.turn.end == "lower"
    assert made.turn.by == pytest.approx(-0.4)


def test_an_entry_has_what_its_sabotages_gave():
    changes = (Sabotage("half of it", study(0.5)), Sabotage("twice", study(3.0)))
    made = record(some(sabotages=changes), versions="")
    assert [(s.text, s.verdict, s.value.high) for s in made.sabotages] == [
        ("half of it", "refuted", 0.6),
        ("twice", "reproduced", 3.1),
    ]
    assert Ledger.from_json(Ledger((made,)).to_json())["some-claim"].sabotages == made.sabotages


def test_round_trip_keeps_everything_to_ten_digits():
    made = record(some(), versions="numpy 2")
    text = Ledger((made,)).to_json()
    document = json.loads(text, parse_constant=pytest.fail)
    assert document["claims"][0]["accepted"]["high"] is None
    again = Ledger.from_json(text)["some-claim"]
    for name in Entry.__slots__:
        if name != "tables":
            assert getattr(again, name) == getattr(made, name), name
    assert again.tables["ends"].to_plain() == made.tables["ends"].to_plain()
    assert again.evidence["a length"].estimate == 0.3333333333
    assert Ledger((again,)).to_json() == text


def test_ends_that_are_not_finite_come_back():
    for low, high in ((-math.inf, 2.0), (-math.inf, math.inf)):
        made = replace(record(some(), versions=""), accepted=Accepted(low, high, "for the test"))
        again = Ledger.from_json(Ledger((made,)).to_json())["some-claim"]
        assert again.accepted == made.accepted


def test_lines_of_the_text_are_what_a_diff_should_show():
    lines = Ledger((record(some(), versions=""),)).to_json().splitlines()
    assert any(line.strip().startswith('"plain": [') for line in lines)
    assert max(map(len, lines)) < 300


def test_merging_replaces_adds_and_orders():
    a, b, c = (entry(some(name), finding(1.5)) for name in "abc")
    new = entry(some("b"), finding(7.0))
    merged = Ledger((a, b, c)).merged([new, entry(some("d"), finding(2.0))], ["d", "c", "b", "a"])
    assert [e.id for e in merged.entries] == ["d", "c", "b", "a"]
    assert merged["b"].value.estimate == 7.0
    assert merged["a"] is a


def scored(*names):
    """Return a ledger of claims that were scored."""
    return Ledger(tuple(record(some(name), versions="") for name in names))


def test_what_was_scored_is_never_dropped():
    with pytest.raises(ValueError, match=r"b was scored and .* claims --withdraw b --why"):
        scored("a", "b").merged([], ["a"])
    left = scored("a", "b").withdrawing("b", why="it was no claim", instead="a", day="2026-01-02")
    assert left.merged([], ["a"]) == left
    with pytest.raises(ValueError, match="b was withdrawn: a new claim needs a new name"):
        left.merged(scored("b").entries, ["a", "b"])


def test_a_withdrawn_claim_keeps_what_it_gave(tmp_path):
    before = scored("a", "b")
    left = before.withdrawing("b", why="it was no claim", instead="a", day="2026-01-02")
    left.write(tmp_path / "claims.json")
    again = Ledger.read(tmp_path / "claims.json")
    assert again == left
    (gone,) = again.withdrawn
    for name in ("id", "chapter", "paper", "place", "statement", "verdict", "value", "date"):
        assert getattr(gone, name) == getattr(before["b"], name), name
    assert (gone.day, gone.why, gone.instead) == ("2026-01-02", "it was no claim", "a")
    assert verdicts(again) == verdicts(scored("a"))
    with pytest.raises(KeyError, match="no claim 'b'"):
        again["b"]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"why": " "}, "must say why"),
        ({"day": "yesterday"}, "isoformat"),
        ({"verdict": "fine"}, "verdict of b"),
        ({"id": "a"}, "a stands in it twice"),
        ({"colour": "red"}, "colour"),
        ({"paper": 3}, "paper"),
    ],
)
def test_a_withdrawn_claim_that_says_too_little_is_no_part_of_a_ledger(change, says):
    left = scored("a", "b").withdrawing("b", why="it was no claim", instead="", day="2026-01-02")
    plain = json.loads(left.to_json())
    plain["withdrawn"][0] |= change
    with pytest.raises(ValueError, match=says):
        Ledger.from_json(json.dumps(plain))


def test_what_took_its_place_is_a_claim_of_the_book():
    with pytest.raises(ValueError, match="instead"):
        scored("a", "b").withdrawing("b", why="so", instead="c", day="2026-01-02")
    with pytest.raises(KeyError, match="no claim 'c'"):
        scored("a", "b").withdrawing("c", why="so", instead="a", day="2026-01-02")


def test_a_file_is_replaced_whole(tmp_path):
    file = tmp_path / "claims.json"
    ledger = Ledger((record(some(), versions=""),))
    ledger.write(file)
    Ledger(()).write(file)
    assert Ledger.read(file).entries == ()
    assert [p.name for p in tmp_path.iterdir()] == ["claims.json"]


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"claims": [{"id": 1}]}', "\x00"])
def test_reading_no_ledger_is_a_clear_error(text):
    with pytest.raises(ValueError, match="not a claim ledger"):
        Ledger.from_json(text)


@pytest.mark.parametrize("basis", Basis)
@pytest.mark.parametrize("value", [0.8, 1.0, 1.5, 2.0, 2.4, None])
def test_what_a_claim_gives_contradicts_nothing_and_any_other_verdict_does(basis, value):
    found = Finding(None, note="–") if value is None else Finding(finding(value).value)
    made = replace(entry(some(), found), basis=str(basis), sabotages=())
    made = replace(made, verdict=str(decide(basis, made.accepted, made.value)))
    assert len(Ledger.from_json(Ledger((made,)).to_json()).entries) == 1
    for verdict in {*Verdict} - {Verdict(made.verdict)}:
        text = Ledger((replace(made, verdict=str(verdict)),)).to_json()
        with pytest.raises(ValueError, match=f"called {verdict}, its numbers say {made.verdict}"):
            Ledger.from_json(text)
        told = (Sabotaged("half of it", str(verdict), made.value),)
        text = Ledger((replace(made, sabotages=told),)).to_json()
        with pytest.raises(ValueError, match=f"with half of it is called {verdict}, its value sa"):
            Ledger.from_json(text)


WRONG = {
    "unknown verdict": ({"verdict": "proven"}, "verdict of some-claim must be one of"),
    "unknown basis": ({"basis": "faith"}, "basis of some-claim must be one of"),
    "no condition": ({"conditions": []}, "called conditional, its numbers say reproduced"),
    "another value": ({"value": None}, "called conditional, its numbers say untestable"),
    "no range": ({"accepted": None}, "called conditional, its numbers say illustrated"),
    "no day": ({"date": "yesterday"}, "isoformat"),
    "no name": ({"id": " "}, "id must not be empty"),
    "no text": ({"place": 3}, "place.* str"),
    "a condition of no words": ({"conditions": [None]}, "conditions.*str"),
}


@pytest.mark.parametrize(("change", "message"), WRONG.values(), ids=WRONG)
def test_a_ledger_that_contradicts_itself_is_refused_with_its_file(change, message, tmp_path):
    plain = record(some(), versions="").to_plain()
    file = tmp_path / "claims.json"
    file.write_text(json.dumps({"claims": [plain | change]}))
    with pytest.raises(DamagedFile, match=rf"claims\.json: no claim ledger.*{message}"):
        Ledger.read(file)


def test_a_claim_that_stands_in_it_twice_is_named(tmp_path):
    made = record(some(), versions="")
    text = Ledger((made, replace(made, note="Another."))).to_json()
    with pytest.raises(ValueError, match="some-claim stands in it twice"):
        Ledger.from_json(text)


def test_unknown_claim_names_the_known_ones():
    with pytest.raises(KeyError, match="some-claim"):
        Ledger((entry(some(), finding(1.5)),))["other"]


def test_chapters_and_counts():
    ledger = Ledger(
        tuple(entry(some(n, v), finding(v)) for n, v in (("a", 1.5), ("b", 0.1), ("c", 2.5)))
    )
    assert ledger.chapter("monobot").entries == ()
    assert verdicts(ledger) == {Verdict.CONDITIONAL: 2, Verdict.REFUTED: 1}
    unmeasured = replace(ledger["a"], value=None, verdict="untestable")
    assert unmeasured.turn is None


def test_the_same_claim_gives_the_same_values_of_sabotages_too():
    declared = some(sabotages=(Sabotage("half of it", study(0.5)),))
    before = record(declared, versions="")
    (half,) = before.sabotages
    assert agrees(declared, before)
    assert not agrees(declared, replace(before, value=replace(before.value, high=9.0)))
    assert not agrees(declared, replace(before, sabotages=()))
    for other in (
        replace(half, text="a third of it"),
        replace(half, value=replace(half.value, low=0.0)),
    ):
        assert not agrees(declared, replace(before, sabotages=(other,)))
