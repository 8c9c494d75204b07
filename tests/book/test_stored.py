"""What is stored of recordings and long runs is what this code computes with these packages."""

import json
import re

import pytest

from robot_perception import chapters, datasets
from studies.records import records
from tests.book.pages import ROOT

STORED = (*chapters.recordings(), *chapters.states())
RENEW = "stored by other code: `robot-perception store --keys --only {}`"
DAMAGED = (
    "{0}.npz is not what was stored: get it back from git, or `robot-perception store --only {0}`"
)
PIN = re.compile(r"^([\w-]+)==([\w.]+)", re.MULTILINE)


@pytest.mark.parametrize("stored", STORED, ids=lambda stored: stored.store)
def test_what_is_stored_is_of_this_code(stored):
    recording = getattr(stored, "dataset", None)
    if recording is not None:
        assert stored.is_what_was_stored(), DAMAGED.format(stored.store)
        assert stored.of_this_code(), RENEW.format(stored.store)
        if datasets.find(recording) is None:
            pytest.skip(f"{recording} is not on this computer")
    assert stored.is_current(), RENEW.format(stored.store)


def test_what_is_recorded_was_computed_with_the_packages_that_are_pinned():
    """A pin that is moved is noticed on any machine, other packages of a reader are not."""
    pinned = set(PIN.findall((ROOT / "constraints.txt").read_text("utf-8")))
    said = {file.name: json.loads(file.read_text("utf-8")) for file in records().rglob("*.json")}
    found = {stored.store: said[f"{stored.store}.json"].get("versions", "") for stored in STORED}
    for name, rows in said.items():
        for variant, about in rows.get("variants", {}).items():
            found[f"{name.removesuffix('.json')} ({variant})"] = about.get("versions", "")
    assert len(found) > len(STORED)
    others = [
        f"{name}: {versions or 'not said'}"
        for name, versions in found.items()
        if not versions or {tuple(part.split()) for part in versions.split(", ")} - pinned
    ]
    assert not others, "\n".join(
        [
            *others,
            "computed with packages that constraints.txt does not name: "
            "`make setup`, then `robot-perception store --keys`",
        ]
    )
