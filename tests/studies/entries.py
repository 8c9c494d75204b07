"""Entries of a ledger that is made for a test."""

import math
from dataclasses import dataclass
from typing import Any

import pandas as pd

from studies.claims import Claim, Finding
from studies.ledger import Entry, entry
from studies.rows import Rows
from studies.trials import Trials
from studies.verdicts import Accepted, Basis

WORDS = {
    "paper": "perception-issues",
    "place": "§2.1",
    "basis": "mathematics",
    "statement": "Something holds.",
    "says": "the length is {value}",
    "form": "number",
    "method": "counted",
    "accepted": Accepted(1.0, 2.0, "theory"),
}
"""Of a plain claim."""


@dataclass(frozen=True, eq=False)
class Given(Trials):
    """A study whose rows are given; anything may stand for them."""

    found: Any = None

    def rows(self) -> Any:
        """Return what was given."""
        return self.found

    def is_current(self) -> bool:
        """Tell that nothing is to be recorded."""
        return True


def compute(rows: Any) -> Finding:
    """Stand for the function of a claim, and for that of a trial."""
    raise AssertionError("nothing is computed here")


def study(rows: Any = None, *, note: str = "Given.", seed: int = 0, changed: str = "") -> Given:
    """Return a study of some rows, or of one with a note."""
    rows = Rows(pd.DataFrame({"film": [0]}), "film", {}, note) if rows is None else rows
    return Given(compute, "walls", {"film": (0,)}, seed=seed, changed=changed, found=rows)


def claim(name: str, **changes: object) -> Claim:
    """Return a claim with fields that must be escaped."""
    fields = WORDS | {
        "id": name,
        "chapter": "walls",
        "place": "Fig. 1 & Table 2",
        "basis": Basis.SUBSTITUTE,
        "statement": "Distances are <squared>.",
        "accepted": Accepted(1, math.inf, "a round number", "our choice"),
        "study": study(),
        "compute": compute,
    }
    return Claim(**(fields | changes))


def made(name: str, finding: Finding, **changes: object) -> Entry:
    """Return the entry of such a claim."""
    return entry(claim(name, **changes), finding)
