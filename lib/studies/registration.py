"""Registrations: what a claim measures is written down before its rows exist, and how often.

``registrations.tsv`` is appended to and never changed. A line holds the claim, the number of the
registration, its day, the hash of its words (statement, measure, range with its reason, sabotage,
stopping rule), the hash of the code that makes a value of rows, the replicates to score on, and the
hash of its trials: the function of a trial of its study and of those of its sabotages, what that
reaches in cells and in the packages of chapters, the worlds, seeds, factors and keywords. Rooms of
the library do not count: what is tested may be mended, what it is tested on may not. Lines of
before 2026-11-29 lack that hash. Number 0 is what stood before this rule. Whoever changes words,
measure or trials after rows were seen draws new replicates, unless the rows still give the recorded
value: `reused` finds the claims of which two registrations share some.
"""

import csv
import inspect
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import astuple, dataclass, fields
from datetime import date
from pathlib import Path
from typing import Any

from studies.claims import Claim
from studies.files import reading, written
from studies.keys.cells import definitions, sources, tried_on
from studies.keys.dependencies import REGISTRATIONS, hashed
from studies.records import records

BEFORE = "before this rule"


@dataclass(frozen=True, slots=True)
class Registration:
    """One line of the file.

    Parameters
    ----------
    claim
        Identifier of the claim.
    number
        How often it was registered before; 0 for what stood before this rule.
    day
        When, as a date.
    words, measure
        Hashes of what the claim says, and of the code that makes its value of rows; of some of
        number 0, which had no rows, ``-``.
    replicates
        What is scored: name and ends of the replicates; of those without rows their seed.
    remark
        Why it was registered anew.
    trial
        Hash of what it is tested on; empty in lines that are older than this hash.
    """

    claim: str
    number: int
    day: str
    words: str
    measure: str
    replicates: str
    remark: str
    trial: str = ""


def file() -> Path:
    """Return the file of the registrations."""
    return records() / REGISTRATIONS


def read(path: Path | None = None) -> tuple[Registration, ...]:
    """Return all registrations in their order.

    Raises
    ------
    DamagedFile
        If the file has another form, or the numbers of a claim do not follow each other.
    OSError
        If it cannot be read.
    """
    path = file() if path is None else path
    with reading(path, "no list of registrations"), path.open(encoding="utf-8", newline="") as text:
        rows = list(csv.DictReader(text, delimiter="\t", strict=True))
        found = tuple(
            Registration(**row | {"number": int(row["number"]), "trial": row.get("trial") or ""})
            for row in rows
        )
        _check(found)
        return found


def _check(registrations: Iterable[Registration]) -> None:
    """Raise ``ValueError`` unless days are dates, and each claim is numbered from 0 or 1 on."""
    last: dict[str, int] = {}
    for one in registrations:
        date.fromisoformat(one.day)
        if one.remark is None:
            raise ValueError(f"a line of {one.claim} is cut off")
        before = last.get(one.claim, 0)
        if one.number not in (before, before + 1):
            raise ValueError(f"{one.claim} is numbered {one.number} after {before}")
        last[one.claim] = one.number


def write(registrations: Iterable[Registration], path: Path | None = None) -> None:
    """Write registrations to the file, at once or not at all."""
    path = file() if path is None else path
    with written(path) as beside, beside.open("w", encoding="utf-8", newline="") as text:
        lines = csv.writer(text, delimiter="\t", lineterminator="\n")
        lines.writerow(field.name for field in fields(Registration))
        lines.writerows(astuple(one)[: None if one.trial else -1] for one in registrations)


def of(registrations: Sequence[Registration], claim: str) -> tuple[Registration, ...]:
    """Return the registrations of one claim."""
    return tuple(one for one in registrations if one.claim == claim)


def latest() -> dict[str, Registration]:
    """Return the last registration of each claim; a later line of the same number is the same."""
    found: dict[str, Registration] = {}
    for one in read():
        if one.claim not in found or one.number > found[one.claim].number:
            found[one.claim] = one
    return found


def in_words(claim: str) -> str:
    """Return when a claim was registered, for a reader; a claim of no list was not."""
    last = latest().get(claim)
    if last is None:
        return "not registered"
    return f"on {last.day}" if last.number else "no: it is older than this rule"


def words_of(claim: Claim) -> str:
    """Hash what a claim says that it measures, and when it holds."""
    accepted = claim.accepted
    ends = None if accepted is None else (accepted.low, accepted.high, accepted.why)
    said = claim.statement, claim.method, ends, [change.text for change in claim.sabotages]
    return hashed(repr((*said, str(claim.basis), claim.stopping)))


def measure_of(claim: Claim) -> str:
    """Hash the code that makes a claim's value of rows, and what decides whether it holds."""
    cells = definitions(sources(claim.module) or ())
    function = inspect.unwrap(claim.compute) if claim.compute else None
    decides = cells.said(function.__name__) if function else cells.keyword(claim.id, "conditions")
    known = decides, cells.keyword(claim.id, "value")
    sabotages = [(one.study.name, one.study.changed) for one in claim.sabotages]
    return hashed(repr((claim.study.name, known, sabotages)))


def trial_of(claim: Claim) -> str:
    """Hash what a claim is tested on: trials of its study and its sabotages, and their worlds."""
    own, *others = (claim.study, *(change.study for change in claim.sabotages))
    spans = [_spans(study.replicates) for study in others]  # those of its own have a column
    return hashed(repr(([_tried(study) for study in (own, *others)], spans)))


def _tried(study: Any) -> tuple[Any, ...]:
    """Return what the trials of a study are, whatever they are repeated on."""
    factors = [(name, [*levels]) for name, levels in study.axes.items() if name != study.replicate]
    return tried_on(study.one), study.seed, factors, sorted(study.fixed.items())


def replicates_of(claim: Claim) -> str:
    """Return what a claim is scored on, in words that `replicates` reads."""
    return f"{claim.study.name} {claim.study.replicate} {_spans(claim.study.replicates)}"


def replicates(text: str) -> tuple[str, frozenset[str]]:
    """Return of what replicates are and which, from the words of `replicates_of`.

    Examples
    --------
    >>> sorted(replicates("bridged film 5000-5002,5007")[1])
    ['5000', '5001', '5002', '5007']
    """
    what, _, spans = text.rpartition(" ")
    found: set[str] = set()
    for span in spans.split(","):
        first, _, last = span.partition("-")
        ends = first.isdecimal() and last.isdecimal()
        found |= {f"{k}" for k in range(int(first), int(last) + 1)} if ends else {span}
    return what, frozenset(found)


def same(one: Registration, claim: Claim) -> bool:
    """Tell whether a registration is of what a claim says and measures now."""
    return not changed(one, claim)


def changed(one: Registration, claim: Claim) -> str:
    """Return in words what of a claim is no more as it was registered; nothing if all is."""
    now = {
        "words": (one.words, words_of(claim)),
        "measure": (one.measure, measure_of(claim)),
        "replicates": (one.replicates, replicates_of(claim)),
        "trial or world": (one.trial, trial_of(claim)),
    }
    return ", ".join(part for part, (before, here) in now.items() if before != here)


def anew(
    claim: Claim, before: Sequence[Registration], remark: str, *, same: bool = False
) -> Registration:
    """Return the next registration of a claim, dated today.

    Where it is the `same` claim by other code, its number stays.

    Raises
    ------
    ValueError
        If it is called the same, and its words have changed.
    """
    own = of(before, claim.id)
    if same and (not own or own[-1].words != words_of(claim)):
        raise ValueError(f"{claim.id} is not the same: its words have changed, or are new")
    number = own[-1].number + (not same) if own else 1
    hashes = words_of(claim), measure_of(claim)
    return Registration(
        claim.id,
        number,
        date.today().isoformat(),
        *hashes,
        replicates_of(claim),
        remark,
        trial_of(claim),
    )


def reused(registrations: Sequence[Registration]) -> Iterator[str]:
    """Yield the claims of which two registrations that differ share replicates, in words."""
    for claim in dict.fromkeys(one.claim for one in registrations):
        own = of(registrations, claim)
        for k, later in enumerate(own):
            for earlier in own[:k]:
                if (later.number, later.words) == (earlier.number, earlier.words):
                    continue  # the same by other code
                what, which = replicates(later.replicates)
                other, before = replicates(earlier.replicates)
                if what.rpartition(" ")[2] == other.rpartition(" ")[2] and which & before:
                    shared = ", ".join(sorted(which & before)[:3])
                    yield f"{claim}: {later.number} scores {what} {shared} of {earlier.number}"


def _spans(values: Sequence[object]) -> str:
    """Return replicates in words, whole numbers that follow each other as their ends."""
    if not all(isinstance(value, int) and value >= 0 for value in values):
        return ",".join(re.sub("[ ,]", "_", f"{value}") for value in values)
    parts: list[list[int]] = []
    for value in values:
        if parts and value == parts[-1][-1] + 1:
            parts[-1] = [parts[-1][0], value]
        else:
            parts.append([value])
    return ",".join("-".join(map(str, part)) for part in parts)
