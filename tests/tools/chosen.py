"""A plugin of pytest that runs of some files the tests of some stems, studies, claims or rooms.

``make check`` says which (`tests.tools.reached`). A test that is of no stem and no room is run. Of
the tests that are marked as slow it runs the sweeps of wrong input, of the rooms that are chosen.
"""

import json
import os
from pathlib import Path

import pytest

from tests.book import registry

CHOSEN = "ROBOT_PERCEPTION_CHOSEN"
"""Environment variable: by file, as JSON, the words that choose its tests."""
FOLDERS = ("tests/hostile/calls", "tests/tools/mutants")
"""Whose files are named as rooms."""
SWEEPS = ("tests/hostile/test_hostile.py", "tests/test_bounds.py")
"""Files whose slow tests are those of a room."""


def words(test: str, rooms: frozenset[str] = frozenset()) -> frozenset[str]:
    """Return the words that choose a test by the values in its name; none if it is always run."""
    value = test.partition("[")[2].removesuffix("]")
    return registry.owners(value) | ({value} & rooms)


def is_chosen(test: str, chosen: dict[str, list[str]], rooms: frozenset[str]) -> bool:
    """Tell whether a test is run, by its name in pytest."""
    file = test.partition("::")[0]
    own = words(test, rooms)
    return file not in chosen or not own or not own.isdisjoint(chosen[file])


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out the tests that nobody has chosen."""
    chosen = json.loads(os.environ.get(CHOSEN, "{}"))
    root = Path(__file__).parents[2]
    files = (file for folder in FOLDERS for file in (root / folder).iterdir())
    rooms = frozenset(file.stem for file in files)
    run = [item for item in items if is_chosen(item.nodeid, chosen, rooms) and _is_due(item, rooms)]
    left = {*items} - {*run}
    config.hook.pytest_deselected(items=[item for item in items if item in left])
    items[:] = run


def _is_due(item: pytest.Item, rooms: frozenset[str]) -> bool:
    """Tell whether a test is fast, or the sweep of a room."""
    swept = item.nodeid.partition("::")[0] in SWEEPS and words(item.nodeid, rooms)
    return item.get_closest_marker("slow") is None or bool(swept)
