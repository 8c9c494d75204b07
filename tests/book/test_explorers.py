"""Explorers of computing chapters: they say what is recorded, and move as all do.

What the build has computed of a page is compared, where there is a site; otherwise all states are
computed here.
"""

import pytest

from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.recorded_rows import processor
from robot_perception.teaching.snapshots import finding_of
from tests.book import states
from tests.book.computing import COMPUTING, found
from tests.chapters.findings import ExplorerTests

EXPLORERS = tuple(explorer for _, explorer in found(Exploration))
NAMED = [(stem, name) for stem in COMPUTING for name in states.explorers(stem)]
RECORD = "python -m tests.tools.snapshot {} --write"


class TestExplorers(ExplorerTests):
    explorers = EXPLORERS


@pytest.mark.parametrize(("stem", "name"), NAMED, ids=[f"{s}-{n}" for s, n in NAMED])
def test_states_say_what_is_recorded_and_what_we_say_that_a_reader_finds(stem: str, name: str):
    explorer, recorded = states.explorers(stem)[name], states.recorded(stem)
    assert explorer.finds is not None, "say what a reader finds, and when it holds: finds="
    assert name in recorded["explorers"], RECORD.format(stem)
    said = states.computed(stem, name)
    assert explorer.finds([finding_of(one) for one in said["findings"]])
    now, before = states.described(explorer, said), recorded["explorers"][name]
    lines = states.differences(before, now, recorded["processor"] != processor())
    assert not lines, "\n".join([*lines, RECORD.format(stem)])


@pytest.mark.parametrize("stem", COMPUTING)
def test_nothing_is_recorded_of_an_explorer_that_is_none(stem: str):
    assert list(states.recorded(stem)["explorers"]) == list(states.explorers(stem))


def test_names_are_unique():
    names = [explorer.name for explorer in EXPLORERS]
    assert len(set(names)) == len(names)
