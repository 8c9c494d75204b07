"""The README promises the minutes that the proof took when it was last timed."""

import json
import re

import pytest

from tests.proof import RECORD
from tests.tools import minutes

README = (minutes.ROOT / "README.md").read_text("utf-8")
PROMISED = dict(re.findall(r"^\| ([^|]+?) \| (\d+) minutes? \|", README, re.MULTILINE))
RECORDED = json.loads(RECORD.read_text("utf-8"))
OF = {
    "set-up": "setup",
    "`make book`": "book",
    "`make test`": "test",
}
FACTOR = 1.5
"""Other machines are faster and slower; by more than this a promise is another one."""


def recorded(row: str) -> float:
    """Return the recorded minutes of a row of the README's table."""
    (name,) = (name for start, name in OF.items() if row.startswith(start))
    return RECORDED["seconds"][name]["clock"] / 60


@pytest.mark.parametrize("row", PROMISED)
def test_a_promise_is_what_was_timed(row: str):
    took = recorded(row)
    assert took / FACTOR <= int(PROMISED[row]) <= max(1.0, took * FACTOR)


def test_every_command_of_the_table_is_timed():
    assert len(PROMISED) == len(OF)
    assert RECORDED["files"]


@pytest.mark.parametrize("name", minutes.CHANGES)
def test_what_is_changed_to_time_a_check_is_there(name: str):
    file, change = minutes.CHANGES[name]
    text = (minutes.ROOT / file).read_text("utf-8")
    changed = change(text)
    assert changed != text
    if file.endswith(".ipynb"):  # and nothing else is
        pairs = zip(text.splitlines(), changed.splitlines(), strict=True)
        assert sum(one != other for one, other in pairs) == 1
