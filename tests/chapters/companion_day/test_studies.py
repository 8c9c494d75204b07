"""Days are counted as they went, and a system that is left out changes only what asks it."""

from collections.abc import Iterator
from copy import deepcopy

import numpy as np
import pytest

from robot_perception.book import companion_day as page
from robot_perception.chapters.companion_day import acts
from robot_perception.chapters.companion_day.acts import ACTS, Day, Outcome
from robot_perception.day.robot import SYSTEMS
from studies.rows import Rows, framed


class Short:
    """A day without a world: an act fails on odd days where it is the second, or a system lacks."""

    def __init__(self, seed: int) -> None:
        self.seed, self.outcomes, self.lacks = seed, [], frozenset()

    def branch(self, without: frozenset[str] = frozenset(), strain: str = "") -> "Short":
        other = deepcopy(self)
        other.lacks = without | ({strain} if strain else set())
        return other

    def part(self, part: str) -> Iterator[None]:
        self.outcomes += [
            Outcome(act, not self.lacks and not (self.seed % 2 and act == "follow"), "")
            for act in page.OF[part]
            if act != "halt" or not self.seed % 2 or self.lacks
        ]
        yield


@pytest.fixture
def short(monkeypatch):
    """Days without a world."""
    monkeypatch.setattr(page, "day_of", Short)
    page.morning.cache_clear()
    yield
    page.morning.cache_clear()


@pytest.fixture
def rows(short):
    """Four such days."""
    levels = ("nothing", *page.CHANGES)
    found = [
        {"day": day, "change": change, **page.lived.one(day, change)}
        for day in range(4)
        for change in levels
    ]
    return Rows(framed(found), "day", {}, "")


def test_a_plain_day_is_counted_as_it_went(short):
    good, bad = page.lived.one(2, "nothing"), page.lived.one(3, "nothing")
    assert good["tried"].all()
    assert good["reached"].all()
    assert [ACTS[k] for k in np.flatnonzero(~bad["tried"])] == ["halt"]
    assert [ACTS[k] for k in np.flatnonzero(bad["tried"] & ~bad["reached"])] == ["follow"]


@pytest.mark.parametrize("change", sorted(page.CHANGES))
def test_a_change_changes_only_what_asks_for_it(short, change):
    plain, other = page.lived.one(2, "nothing"), page.lived.one(2, change)
    differ = {ACTS[k] for k in np.flatnonzero(plain["reached"] != other["reached"])}
    assert differ == {act for part in page.CHANGES[change] for act in page.OF[part]}


def test_three_systems_out_at_once_change_what_asks_for_one_of_them(short):
    assert page.asked("laser and sonar and skin") == {"guide"}
    assert page.asked("ceiling and arms") == {"hall", "guide", "go", "point"}
    assert page.asked("nothing") == set()


def test_shares_are_of_days(rows):
    assert page.reached(rows, ACTS).estimate == 0.5
    assert page.reached(rows, ("learn", "find")).estimate == 1.0
    assert page.hardest(rows) == "attend"
    assert np.isnan(page.ledger(rows)).sum() == 2
    assert page.worth(rows)["faces"][0].estimate == 0.5
    assert page.worth(rows)["faces"][1].estimate == 0.0
    assert page.swapped(rows, "laser") == (4, 0)


def test_help_comes_after_an_act_that_failed_and_only_then(monkeypatch):
    helped = []
    today = object.__new__(Day)
    today.outcomes = []
    monkeypatch.setattr(Day, "help", lambda self, part: helped.append(part))
    for part in acts.PARTS:
        ends = lambda self, part=part: iter([self.ended(part, part != "guide", "")])  # noqa: E731
        monkeypatch.setattr(Day, part, ends)
    list(today.run(helped=True))
    assert helped == ["attend"]
    assert [end.act for end in today.outcomes] == list(acts.PARTS)
    today.outcomes = []
    list(today.run())
    assert [end.act for end in today.outcomes] == ["learn", "find", "hall", "guide"]


def test_every_system_is_asked_somewhere():
    assert set(acts.ASKED) == set(SYSTEMS)
    assert {part for parts in page.CHANGES.values() for part in parts} < set(acts.PARTS)
    assert sum(page.OF.values(), ()) == ACTS
