"""A plugin of pytest that runs of some files the tests of some stems, studies, claims or rooms.

``make check`` says which (`tests.tools.reached`). A test that is of no stem and no room is run.
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
    left = [item for item in items if not is_chosen(item.nodeid, chosen, rooms)]
    config.hook.pytest_deselected(items=left)
    items[:] = [item for item in items if is_chosen(item.nodeid, chosen, rooms)]
