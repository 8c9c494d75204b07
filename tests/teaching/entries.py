"""Entries of a ledger that is made for a test."""

import math

from robot_perception.teaching.claims import Finding, Size
from robot_perception.teaching.ledger import Entry, entry
from robot_perception.teaching.studies import Claim, Study
from robot_perception.teaching.verdicts import Accepted, Basis

WORDS = {
    "paper": "perception-issues",
    "place": "§2.1",
    "basis": "mathematics",
    "statement": "Something holds.",
    "method": "counted",
    "accepted": Accepted(1.0, 2.0, "theory"),
}
"""Of a plain claim."""

SIZES = Study(lambda size, *, rng: size, full=Size.FULL, quick=Size.QUICK)
"""A study whose result is its size."""


def compute(size: Size) -> Finding:
    """Stand for the function of a claim."""
    raise AssertionError("nothing is computed here")


def claim(name: str, **changes: object) -> Claim:
    """Return a claim with fields that must be escaped."""
    fields = WORDS | {
        "id": name,
        "chapter": "walls",
        "place": "Fig. 1 & Table 2",
        "basis": Basis.SUBSTITUTE,
        "statement": "Distances are <squared>.",
        "accepted": Accepted(1, math.inf, "a round number", "our choice"),
        "study": SIZES,
        "compute": compute,
    }
    return Claim(**(fields | changes))


def made(name: str, finding: Finding, **changes: object) -> Entry:
    """Return the entry of such a claim."""
    return entry(claim(name, **changes), finding)
