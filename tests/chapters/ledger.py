"""What every claim must pass; each chapter's ``test_claims.py`` takes these tests for its stem.

.. code-block:: python

    from tests.chapters.ledger import LedgerTests, quick

    class TestLedger(LedgerTests):
        stem = "walls"

    def test_something_more():
        assert quick("dp-quadratic").evidence[...]

All tests that need a claim's finding stand in that one file, so that it is computed once in a run.
What runs for long runs as a reader's would, without the checks of shapes: of a drive of the filter
they take six sevenths of the time, and the tests of the rooms have them.

Films are rendered and looked at with OpenCV and NumPy, which round otherwise on a processor without
AVX2: of a million bytes of a film three differ by one, and an estimate is another pixel. A class
tells in ``pictures`` how far numbers of which claim may be from the recorded ones there; verdicts
are compared everywhere. SIFT features are the same to the last bit. What is zero but for rounding
is rounded otherwise on every processor: ``rounding`` tells how large it can be, by claim.

A quick run of few films can turn on one of them, and on another processor it is another film: there
a claim that is named in ``few_films`` must agree with the recorded value, and no more is asked.

Some shares, and differences of shares, need more cases than a quick run has. A class names such
claims in ``open_when_quick``: there the quick run must be undecided and agree with the recorded
value, and its numbers are compared as all others are.
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from types import MappingProxyType

import cv2
import pytest

from robot_perception import chapters
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.ledger import (
    Entry,
    Ledger,
    Sabotaged,
    different,
    entry,
    numbers,
    sabotaged,
)
from robot_perception.teaching.records import records
from robot_perception.teaching.studies import Claim
from robot_perception.teaching.verdicts import turned
from tests.unchecked import unchecked

MEND = "robot-perception claims --run full --claim {} --write book/_data/claims.json"
"""The command that records a claim anew."""
DECLARED = ("id", "chapter", "paper", "place", "basis", "statement", "paper_value", "method")
Numbers = Mapping[str, Sequence[float]]
RTOL = 1e-6
"""Processors differ in the eleventh digit; iterated filters make some orders more of it."""


@cache
def recorded() -> Ledger:
    """Return the ledger as it is stored."""
    return Ledger.read(records() / "claims.json")


@cache
def quick(claim_id: str) -> Finding:
    """Return what a claim gives at the quick size; it is computed once."""
    with unchecked():
        return next(c for c in chapters.claims() if c.id == claim_id).find("quick")


def opencv_fuses() -> bool:
    """Tell whether OpenCV uses AVX2 and its fused products, as where the claims are recorded."""
    return "*AVX2" in cv2.getCPUFeaturesLine().split()


def values(found: Iterable[Sabotaged]) -> dict[str, tuple[float, float, float]]:
    """Return the values of sabotages by their texts."""
    return {f.text: (f.value.estimate, f.value.low, f.value.high) for f in found}


class LedgerTests:
    """The record of one chapter is what the library declares and computes."""

    stem: str
    pictures: Mapping[str, float] = MappingProxyType({})
    rounding: Mapping[str, float] = MappingProxyType({})
    open_when_quick: frozenset[str] = frozenset()
    few_films: frozenset[str] = frozenset()

    def other_film(self, claim: Claim) -> bool:
        """Tell whether a quick run has other films here than where it was recorded."""
        same = "*AVX512-SKX" in cv2.getCPUFeaturesLine().split()
        return claim.id in self.few_films and not same

    def unlike(self, claim: Claim, found: Numbers, recorded: Numbers) -> list[str]:
        """Return what differs from the recorded numbers, by what the class allows the claim."""
        return different(found, recorded, self.rtol(claim), self.rounding.get(claim.id, 0.0))

    def rtol(self, claim: Claim) -> float:
        """Return how far numbers may be from the recorded ones, of the larger."""
        return RTOL if opencv_fuses() else self.pictures.get(claim.id, RTOL)

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """Make one test a claim."""
        if "claim" in metafunc.fixturenames:
            claims = chapters.claims([self.stem])
            metafunc.parametrize("claim", claims, ids=[c.id for c in claims])

    def test_the_record_has_every_claim_in_the_order_of_the_chapter(self):
        declared = [claim.id for claim in chapters.claims([self.stem])]
        recorded_ids = [e.id for e in recorded().chapter(self.stem).entries]
        missing = [i for i in declared if i not in recorded_ids]
        assert not missing, f"record them: {MEND.format(' --claim '.join(missing))}"
        assert recorded_ids == declared

    def test_record_says_what_is_declared(self, claim: Claim):
        found = recorded()[claim.id]
        declared = Entry.from_plain(entry(claim, Finding(None, note="–")).to_plain())
        for name in (*DECLARED, "accepted", "seed"):  # to the digits that are recorded
            assert getattr(found, name) == getattr(declared, name), MEND.format(claim.id)

    def test_quick_verdict_and_numbers_are_the_recorded_ones(self, claim: Claim):
        found, finding = recorded()[claim.id], quick(claim.id)
        if self.other_film(claim):
            assert finding.value.overlaps(found.value)
            return
        if claim.id in self.open_when_quick:
            assert claim.verdict(finding) == "inconclusive" != found.verdict
            assert finding.value.overlaps(found.value)
        else:
            assert claim.verdict(finding) == found.verdict, f"{finding.value}: {finding.note}"
        lines = self.unlike(claim, numbers(finding), found.quick)
        assert not lines, "\n".join([*lines, f"if this is right: {MEND.format(claim.id)}"])

    def test_sabotage_turns_the_verdict_as_recorded(self, claim: Claim):
        found = recorded()[claim.id]
        with unchecked():
            made = sabotaged(claim)
        assert made, f"{claim.id}: when would its verdict be another one? Declare a sabotage"
        if self.other_film(claim):
            return
        for ours in made:
            moved = found.verdict == "illustrated" and not found.value.overlaps(ours.value)
            assert moved or turned(found.verdict, ours.verdict), (
                f"{claim.id} is {found.verdict}, and with {ours.text} it is {ours.verdict}: "
                f"{ours.value}"
            )
        names = [f.text for f in found.sabotages]
        assert names == [ours.text for ours in made], MEND.format(claim.id)
        lines = self.unlike(claim, values(made), values(found.sabotages))
        assert not lines, "\n".join([*lines, f"if this is right: {MEND.format(claim.id)}"])

    @pytest.mark.slow
    def test_full_numbers_are_the_recorded_ones(self, claim: Claim):
        found, finding = recorded()[claim.id], claim.find("full")
        assert claim.verdict(finding) == found.verdict
        stored = Finding(found.value, found.evidence, found.tables, (), found.note or "–")
        lines = self.unlike(claim, numbers(finding), numbers(stored))
        assert not lines, "\n".join([*lines, f"if this is right: {MEND.format(claim.id)}"])
