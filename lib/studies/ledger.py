"""The recorded claims: entries of the ledger, in JSON that a diff can be read of."""

import json
import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from datetime import date
from pathlib import Path
from typing import Any

from studies import checks
from studies.claims import Claim, Finding
from studies.files import reading, written
from studies.intervals import Interval
from studies.project import project
from studies.sentences import Form, sentence
from studies.tables import Table
from studies.verdicts import Accepted, Basis, Turn, Verdict, decide, turn

DIGITS = 10
"""Significant digits that are recorded: processors differ in the eleventh."""
TEXTS = (
    *("id", "chapter", "paper", "place", "basis", "statement", "says", "form"),
    *("paper_value", "method"),
    *("verdict", "note", "date", "versions"),
)
"""Fields of an entry that are texts."""


@dataclass(frozen=True, slots=True)
class Sabotaged:
    """Result of a sabotage.

    Parameters
    ----------
    text
        What was changed.
    verdict
        What the claim's rule says of it.
    value
        Its value.
    """

    text: str
    verdict: str
    value: Interval | None


@dataclass(frozen=True, slots=True)
class Entry:
    """One row of the ledger: a claim with what its rows say.

    Parameters
    ----------
    id, chapter, paper, place, basis, statement, says, form, paper_value, method, accepted, seed
        As in :class:`Claim`.
    verdict
        What follows.
    value
        Our value, ``None`` if nothing can be measured.
    evidence, tables, note
        As in :class:`Finding`.
    conditions
        Words of the conditions on which it hangs whether the claim holds.
    sabotages
        What variants gave in which the statement's truth is turned.
    date, versions
        When it was recorded, and with what.
    """

    id: str
    chapter: str
    paper: str
    place: str
    basis: str
    statement: str
    says: str
    form: str
    paper_value: str
    method: str
    accepted: Accepted | None
    seed: int
    verdict: str
    value: Interval | None
    evidence: Mapping[str, Interval]
    tables: Mapping[str, Table]
    conditions: Sequence[str]
    note: str
    sabotages: Sequence[Sabotaged] = ()
    date: str = ""
    versions: str = ""

    def result(self, verdict: bool = True) -> str:
        """Return what was found as a sentence, with its verdict or without; a note if nothing was.

        Where something decides whether the claim holds, the sentence says so.
        """
        if self.value is None:
            return self.note
        follows = " only if ".join([self.verdict, *self.conditions[:1]])
        words = ", and ".join([follows, *self.conditions[1:]]) if verdict else ""
        return sentence(self.says, self.form, self.value, self.accepted, words)

    @property
    def turn(self) -> Turn | None:
        """Shift of the accepted range that turns the verdict, ``None`` if none does."""
        if self.accepted is None or self.value is None:
            return None
        return turn(self.accepted, self.value)

    def to_plain(self) -> dict[str, Any]:
        """Return the entry in plain types that JSON can hold, numbers to ten digits."""
        plain = asdict(self)
        plain["tables"] = {name: table.to_plain() for name, table in self.tables.items()}
        if self.accepted is not None:
            ends = {name: plain["accepted"][name] for name in ("low", "high")}
            plain["accepted"] |= {n: end if math.isfinite(end) else None for n, end in ends.items()}
        return _rounded(plain)

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "Entry":
        """Return the entry of :meth:`to_plain`.

        Raises
        ------
        ValueError
            If a part is missing, a word is unknown, or the numbers contradict a verdict.
        TypeError
            If a part is of another type.
        """
        row = dict(plain)
        missing = [name for name in cls.__slots__[:-2] if name not in row]
        if missing:
            raise ValueError(f"plain is no entry: it lacks {', '.join(missing)}")
        if row["accepted"] is not None:
            ends = dict(row["accepted"])
            ends["low"] = -math.inf if ends["low"] is None else ends["low"]
            ends["high"] = math.inf if ends["high"] is None else ends["high"]
            row["accepted"] = Accepted(**ends)
        row["value"] = row["value"] and Interval(**row["value"])
        row["evidence"] = {name: Interval(**value) for name, value in row["evidence"].items()}
        row["sabotages"] = tuple(
            Sabotaged(**found | {"value": found["value"] and Interval(**found["value"])})
            for found in row["sabotages"]
        )
        row["tables"] = {name: Table.from_plain(value) for name, value in row["tables"].items()}
        made = cls(**row)
        made._check()
        return made

    def _check(self) -> None:
        for name in TEXTS:
            checks.instance(name, getattr(self, name), str)
        checks.instances("conditions", self.conditions, str)
        checks.instances("text of a sabotage", [found.text for found in self.sabotages], str)
        if not self.id.strip():
            raise ValueError("id must not be empty")
        if self.date:
            date.fromisoformat(self.date)
        checks.one_of(f"verdict of {self.id}", self.verdict, tuple(Verdict))
        checks.one_of(f"basis of {self.id}", self.basis, tuple(Basis))
        checks.one_of(f"form of {self.id}", self.form, tuple(Form))
        follows = decide(self.basis, self.accepted, self.value)
        if self.conditions and None not in (self.accepted, self.value):
            follows = Verdict.CONDITIONAL
        if self.verdict != follows:
            raise ValueError(f"{self.id} is called {self.verdict}, its numbers say {follows}")
        for found in self.sabotages:
            follows = decide(self.basis, self.accepted, found.value)
            if found.verdict != follows:
                raise ValueError(
                    f"{self.id} with {found.text} is called {found.verdict}, its value says "
                    f"{follows}"
                )


def entry(claim: Claim, finding: Finding) -> Entry:
    """Return the ledger entry of a claim that was computed.

    Parameters
    ----------
    claim
        What was tested.
    finding
        What it gave.
    """
    return Entry(
        id=claim.id,
        chapter=claim.chapter,
        paper=claim.paper,
        place=claim.place,
        basis=str(claim.basis),
        statement=claim.statement,
        says=claim.says,
        form=str(claim.form),
        paper_value=claim.paper_value,
        method=claim.method,
        accepted=claim.accepted,
        seed=claim.seed,
        verdict=str(claim.verdict(finding)),
        value=finding.value,
        evidence=dict(finding.evidence),
        tables=dict(finding.tables),
        conditions=[c.text for c in claim.deciding(finding)],
        note=finding.note,
    )


def record(claim: Claim, *, versions: str) -> Entry:
    """Compute a claim and its sabotages, and return its entry, dated today."""
    made = entry(claim, claim.find())
    made = replace(
        made, sabotages=sabotaged(claim), date=date.today().isoformat(), versions=versions
    )
    return Entry.from_plain(made.to_plain())


def sabotaged(claim: Claim) -> tuple[Sabotaged, ...]:
    """Compute the sabotages of a claim and return what they gave."""
    found = [(change.text, claim.sabotaged(change)) for change in claim.sabotages]
    return tuple(Sabotaged(text, str(claim.verdict(f)), f.value) for text, f in found)


@dataclass(frozen=True, slots=True)
class Withdrawn:
    """A claim that was scored and is none of the book any more.

    Parameters
    ----------
    id, chapter, paper, place, statement
        As in its entry.
    verdict, value, date
        What it gave, and when it was recorded.
    day
        When it was withdrawn, as a date.
    why
        Why, in a sentence.
    instead
        Identifier of the claim that took its place; empty if none did.
    """

    id: str
    chapter: str
    paper: str
    place: str
    statement: str
    verdict: str
    value: Interval | None
    date: str
    day: str
    why: str
    instead: str = ""

    def to_plain(self) -> dict[str, Any]:
        """Return it in plain types that JSON can hold, numbers to ten digits."""
        return _rounded(asdict(self))

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "Withdrawn":
        """Return what :meth:`to_plain` gave.

        Raises
        ------
        ValueError
            If a day is none, a verdict is unknown, or it is not said why.
        TypeError
            If a part is missing or of another type.
        """
        made = cls(**plain | {"value": plain["value"] and Interval(**plain["value"])})
        for name in set(cls.__slots__) - {"value"}:
            checks.instance(name, getattr(made, name), str)
        for day in (made.date, made.day):
            date.fromisoformat(day)
        checks.one_of(f"verdict of {made.id}", made.verdict, tuple(Verdict))
        if not made.id.strip() or not made.why.strip():
            raise ValueError(f"{made.id!r} must say why it was withdrawn")
        return made


@dataclass(frozen=True, slots=True)
class Ledger:
    """The recorded claims in the order of the book, and those that were withdrawn."""

    entries: tuple[Entry, ...]
    withdrawn: tuple[Withdrawn, ...] = ()

    def __getitem__(self, claim_id: str) -> Entry:
        for found in self.entries:
            if found.id == claim_id:
                return found
        known = ", ".join(e.id for e in self.entries)
        raise KeyError(f"no claim {claim_id!r} in the ledger; it has {known}")

    def chapter(self, stem: str) -> "Ledger":
        """Return the part of the ledger that one chapter computes."""
        return Ledger(tuple(e for e in self.entries if e.chapter == stem))

    def merged(self, entries: Iterable[Entry], order: Sequence[str]) -> "Ledger":
        """Return the ledger with some entries new or anew, and all in an order.

        Parameters
        ----------
        entries
            They take the place of those of the same identifier.
        order
            Identifiers of all declared claims.

        Raises
        ------
        ValueError
            If a scored claim is declared no more and not withdrawn: no entry is ever dropped; or if
            a withdrawn one is scored again.
        """
        by_id = {e.id: e for e in (*self.entries, *entries)}
        lost = [name for name in by_id if name not in order]
        if lost:
            raise ValueError(
                f"{', '.join(lost)} was scored and is declared no more; what was scored stays in "
                f"the ledger: `{project().command} claims --withdraw {lost[0]} --why … "
                "--instead … --write FILE` keeps it among the withdrawn"
            )
        again = sorted(by_id.keys() & {gone.id for gone in self.withdrawn})
        if again:
            raise ValueError(f"{', '.join(again)} was withdrawn: a new claim needs a new name")
        return Ledger(tuple(by_id[name] for name in order if name in by_id), self.withdrawn)

    def withdrawing(self, claim_id: str, *, why: str, instead: str, day: str) -> "Ledger":
        """Return the ledger with an entry among the withdrawn.

        Raises
        ------
        KeyError
            If there is no such entry.
        ValueError
            If it is not said why, or no entry has the identifier of what took its place.
        """
        gone = self[claim_id]
        left = tuple(e for e in self.entries if e.id != claim_id)
        checks.one_of("instead", instead, ("", *(e.id for e in left)))
        kept = {name: getattr(gone, name) for name in Withdrawn.__slots__ if hasattr(gone, name)}
        made = Withdrawn(**kept, day=day, why=why, instead=instead)
        return Ledger(left, (*self.withdrawn, Withdrawn.from_plain(made.to_plain())))

    def to_json(self) -> str:
        """Return the ledger as JSON text, a list of numbers on one line."""
        parts = {"claims": self.entries, "withdrawn": self.withdrawn}
        texts = [
            f'"{name}": [\n' + ",\n".join(_text(e.to_plain()) for e in part) + "\n]"
            for name, part in parts.items()
            if part or name == "claims"
        ]
        return "{\n" + ",\n".join(texts) + "\n}\n"

    @classmethod
    def from_json(cls, text: str) -> "Ledger":
        """Return the ledger written by :meth:`to_json`.

        Raises
        ------
        ValueError
            If the text is no ledger, or contradicts itself: a claim stands in it twice, or with a
            verdict that its numbers do not give.
        """
        try:
            plain = json.loads(text)
            found = tuple(map(Entry.from_plain, plain["claims"]))
            gone = tuple(map(Withdrawn.from_plain, plain.get("withdrawn", ())))
            names = Counter(e.id for e in (*found, *gone))
            twice = [name for name, times in names.items() if times > 1]
            if twice:
                raise ValueError(f"{', '.join(twice)} stands in it twice")
        except (KeyError, TypeError, AttributeError, ValueError, RecursionError) as error:
            raise ValueError(f"the text is not a claim ledger: {error}") from error
        return cls(found, gone)

    @classmethod
    def read(cls, path: Path | str) -> "Ledger":
        """Return the ledger stored in a file.

        Raises
        ------
        DamagedFile
            If the file is no ledger.
        OSError
            If it cannot be read.
        """
        with reading(path, "no claim ledger"):
            return cls.from_json(Path(path).read_text(encoding="utf-8"))

    def write(self, path: Path | str) -> None:
        """Store the ledger in a file, at once or not at all; ``OSError`` if it cannot be."""
        text = self.to_json()
        with written(path) as beside:
            beside.write_text(text, encoding="utf-8")


def agrees(claim: Claim, recorded: Entry) -> bool:
    """Tell whether a claim and its sabotages give recorded verdicts, and values to ten digits."""
    found = replace(entry(claim, claim.find()), sabotages=sabotaged(claim)).to_plain()
    known = recorded.to_plain()
    named = ("value", "verdict", "conditions", "sabotages")
    return all(found[name] == known[name] for name in named)


def verdicts(ledger: Ledger) -> dict[Verdict, int]:
    """Return how many claims of the book have which verdict, in the order of :class:`Verdict`."""
    found = [e.verdict for e in ledger.entries]
    return {v: found.count(v) for v in Verdict if v in found}


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}")
    if isinstance(value, Mapping):
        return {key: _rounded(item) for key, item in value.items()}
    return [_rounded(item) for item in value] if isinstance(value, list | tuple) else value


def _text(value: Any, indent: int = 0) -> str:
    """Return JSON with a line a key; lists and mappings without mappings in them on one line."""
    pad = " " * (indent + 1)
    if isinstance(value, Mapping) and any(isinstance(v, Mapping | list) for v in value.values()):
        lines = (
            f"{pad}{json.dumps(k, ensure_ascii=False)}: {_text(v, indent + 1)}"
            for k, v in value.items()
        )
        return "{\n" + ",\n".join(lines) + "\n" + " " * indent + "}"
    return json.dumps(value, ensure_ascii=False, allow_nan=False)
