"""Explorers of computing chapters: they move as all do, and a reader finds what we say."""

import pytest

from robot_perception.teaching.explorations import Exploration
from tests.book.computing import found
from tests.chapters.findings import ExplorerTests

EXPLORERS = tuple(explorer for _, explorer in found(Exploration))


class TestExplorers(ExplorerTests):
    explorers = EXPLORERS


@pytest.mark.parametrize("explorer", EXPLORERS, ids=lambda explorer: explorer.name)
def test_what_we_say_that_a_reader_finds_holds_in_all_states(explorer: Exploration):
    assert explorer.finds is not None, "say what a reader finds, and when it holds: finds="
    assert explorer.finds(explorer.found())


def test_names_are_unique():
    names = [explorer.name for explorer in EXPLORERS]
    assert len(set(names)) == len(names)
