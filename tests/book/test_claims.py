"""The ledger says what rows say, and every claim is registered as it stands.

Value, evidence, tables, conditions, note and verdict of a claim and of its sabotages are computed
from recorded rows.
"""

import math
import re
import subprocess
from collections.abc import Iterator
from typing import Any

import pytest

from robot_perception import chapters
from robot_perception.teaching.scores.badges import recorded
from studies import registration
from studies.claims import Claim
from studies.ledger import entry, sabotaged
from studies.verdicts import turned
from tests.book.pages import BOOK, ROOT, notebook

DIGITS = 1e-9
RECORD = "robot-perception claims --run --claim {} --write book/_data/claims.json"
REGISTER = "robot-perception register --claim {} --remark WHY"
SAME = f"`{REGISTER} --same`"
HEAD = b"claim\tnumber\tday\twords\tmeasure\treplicates\tremark"
"""First line of the list as it began; columns were only ever appended."""
CHANGED = re.compile(r"^\| \[([\w-]+)\]\(\S+\) \| [\w ]+ \| ([\w ]+) \|", re.MULTILINE)
"""A claim, a former verdict and the present one, on the page that says how the book was checked."""
NOT_COMPUTED = ("date", "versions", "sabotages")
EVERY = chapters.claims()
EACH = pytest.mark.parametrize("claim", EVERY, ids=lambda claim: claim.id)


def unlike(found: Any, before: Any, place: str) -> Iterator[str]:
    """Yield what differs between two plain values, numbers by more than their digits."""
    if isinstance(found, float | int) and isinstance(before, float | int):
        if not math.isclose(found, before, rel_tol=DIGITS, abs_tol=1e-12):
            yield f"{place}: {found}, recorded {before}"
    elif isinstance(found, dict) and isinstance(before, dict) and [*found] == [*before]:
        for name in found:
            yield from unlike(found[name], before[name], f"{place}, {name}")
    elif isinstance(found, list | tuple) and len(found) == len(before):
        for k, (one, other) in enumerate(zip(found, before, strict=True)):
            yield from unlike(one, other, f"{place}, {k}")
    elif found != before:
        yield f"{place}: {found}, recorded {before}"


@EACH
def test_the_record_says_what_the_rows_say(claim: Claim):
    finding, before = claim.find(), recorded()[claim.id].to_plain()
    found = entry(claim, finding).to_plain()
    lines = [line for name in found.keys() - set(NOT_COMPUTED)
             for line in unlike(found[name], before[name], name)]  # fmt: skip
    assert not lines, "\n".join([*lines, f"if this is right: {RECORD.format(claim.id)}"])
    assert claim.verdict(finding) == before["verdict"]


@EACH
def test_each_sabotage_turns_the_verdict_as_recorded(claim: Claim):
    found, made = recorded()[claim.id], sabotaged(claim)
    assert made, f"{claim.id}: when would its verdict be another one? Declare a sabotage"
    for ours in made:
        moved = found.verdict == "illustrated" and not found.value.overlaps(ours.value)
        assert moved or turned(found.verdict, ours.verdict), (
            f"{claim.id} is {found.verdict}, with {ours.text} it is {ours.verdict}: {ours.value}"
        )
    plain = [{"text": s.text, "verdict": f"{s.verdict}", "value": entry_of(s)} for s in made]
    before = [{"text": s.text, "verdict": s.verdict, "value": entry_of(s)} for s in found.sabotages]
    lines = list(unlike(plain, before, "sabotage"))
    assert not lines, "\n".join([*lines, f"if this is right: {RECORD.format(claim.id)}"])


def entry_of(sabotage: Any) -> list[float]:
    """Return the value of a sabotage as it is compared."""
    return [sabotage.value.estimate, sabotage.value.low, sabotage.value.high]


def test_the_record_has_every_claim_in_the_order_of_the_book():
    assert [e.id for e in recorded().entries] == [claim.id for claim in EVERY]


def test_the_list_of_changed_verdicts_says_those_of_the_record():
    told = dict(
        CHANGED.findall("\n".join(c.source for c in notebook(BOOK / "checked.ipynb").cells))
    )
    assert len(told) > 10
    assert told == {name: recorded()[name].to_plain()["verdict"] for name in told}


def test_what_differs_is_found():
    one = {"a": 1.0, "b": [1, {"c": "x"}], "n": None}
    assert not list(unlike(one, one | {"a": 1 + 1e-12}, ""))
    others = [one | change for change in (
        {"a": 1 + 1e-8}, {"a": None}, {"b": [1]}, {"b": [1, {"c": "y"}]}, {"b": [1, {"d": "x"}]},
        {"n": 0.0},
    )]  # fmt: skip
    for other in (*others, {"a": 1.0}):
        assert list(unlike(one, other, "")), other
        assert list(unlike(other, one, "")), other


# Registrations


@pytest.fixture(scope="module")
def registered() -> tuple[registration.Registration, ...]:
    """All registrations."""
    return registration.read()


@EACH
def test_each_claim_is_registered_as_it_stands(claim: Claim, registered):
    own = registration.of(registered, claim.id)
    assert own, f"register it before its rows exist: {REGISTER.format(claim.id)}"
    changed = registration.changed(own[-1], claim)
    assert not changed, (
        f"{claim.id} is registered with other {changed}. What was changed after rows were seen "
        f"needs new replicates: {REGISTER.format(claim.id)}. Where rows of this code give the "
        f"recorded value and verdict (`robot-perception store` first): {SAME.format(claim.id)}"
    )


def test_no_claim_is_scored_twice_on_the_same_replicates(registered):
    assert not list(registration.reused(registered))


def test_only_claims_of_the_book_are_registered_each_in_its_order(registered):
    ids = {claim.id for claim in EVERY}
    withdrawn = {gone.id: gone for gone in recorded().withdrawn}
    assert not withdrawn.keys() & ids
    assert ids.issuperset(gone.instead for gone in withdrawn.values() if gone.instead)
    assert {one.claim for one in registered} == ids | withdrawn.keys(), (
        "what was registered and scored stays: `robot-perception claims --withdraw ID --why … "
        "--instead … --write book/_data/claims.json`"
    )
    for name in ids:
        numbers = [one.number for one in registration.of(registered, name)]
        assert numbers == sorted(numbers)
        assert set(numbers) == set(range(min(numbers), max(numbers) + 1))
    assert all(one.remark.strip() and one.day for one in registered)


def test_the_list_was_only_ever_appended_to():
    """Each version on the line of main is the start of the next one, and of the file that is here.

    What a branch registered is appended where it is merged; of any version that git knows, on main
    or on a branch, no line is lost or changed, and none has changed its place among the others. The
    first line names the columns: later ones may have been appended to it.
    """
    name = registration.file().relative_to(ROOT).as_posix()
    columns, here = parts(registration.file().read_bytes())
    assert columns.startswith(HEAD)
    for line in (["--first-parent"], []):
        asked = subprocess.run(["git", "log", *line, "--format=%H", "--", name], cwd=ROOT,
                               capture_output=True, text=True)  # fmt: skip
        if asked.returncode:
            pytest.skip("there is no git here")
        now, named = here, columns
        for commit in asked.stdout.split():
            shown = subprocess.run(
                ["git", "show", f"{commit}:{name}"], cwd=ROOT, capture_output=True
            ).stdout
            head, shown = parts(shown)
            assert columns == head or columns.startswith(head + b"\t"), f"other columns at {commit}"
            if line:
                assert named.startswith(head), f"columns that stood there at {commit} have changed"
                assert now.startswith(shown), f"lines that stood there at {commit} have changed"
                now, named = shown, head
            rest = iter(here.splitlines())
            lost = [one for one in shown.splitlines() if one not in rest]
            assert not lost, f"lines that stood there at {commit} are gone: {lost}"


def parts(text: bytes) -> tuple[bytes, bytes]:
    """Return the line of a list that names its columns, and the lines below it."""
    head, _, lines = text.partition(b"\n")
    return head, lines
