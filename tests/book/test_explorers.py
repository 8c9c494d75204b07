"""Explorers of computing chapters: they say what is recorded, and move as all do.

What the build has computed of a page is compared, where there is a site; otherwise all states are
computed here. Which explorers there are is read from what is recorded, so that a test of one
chapter imports no other.
"""

import pytest

from explorables.snapshots import finding_of
from studies.stored.recorded_rows import processor
from tests.book import states
from tests.book.computing import COMPUTING
from tests.chapters.findings import check_ends, check_presets_and_number_of_states

NAMED = [(stem, name) for stem in COMPUTING for name in states.recorded(stem)["explorers"]]
RECORD = "python -m tests.tools.snapshot {} --write"

each_explorer = pytest.mark.parametrize(
    ("stem", "name"), NAMED, ids=[f"{stem}-{name}" for stem, name in NAMED]
)


@pytest.mark.parametrize("stem", COMPUTING)
def test_what_is_recorded_are_the_explorers_of_the_page(stem: str):
    assert list(states.recorded(stem)["explorers"]) == list(states.explorers(stem)), RECORD.format(
        stem
    )


@each_explorer
def test_states_say_what_is_recorded_and_what_we_say_that_a_reader_finds(stem: str, name: str):
    explorer, recorded = states.explorers(stem)[name], states.recorded(stem)
    assert explorer.finds is not None, "say what a reader finds, and when it holds: finds="
    said = states.computed(stem, name)
    assert explorer.finds([finding_of(one) for one in said["findings"]])
    now, before = states.described(explorer, said), recorded["explorers"][name]
    lines = states.differences(before, now, recorded["processor"] != processor())
    assert not lines, "\n".join([*lines, RECORD.format(stem)])


@each_explorer
def test_no_preset_shows_the_default_and_there_are_not_too_many_states(stem: str, name: str):
    check_presets_and_number_of_states(states.explorers(stem)[name])


@each_explorer
def test_every_end_is_drawn_and_said_on_axes_that_stay(stem: str, name: str):
    check_ends(states.explorers(stem)[name])


def test_names_are_unique():
    names = [name for _, name in NAMED]
    assert len(set(names)) == len(names)
