"""What the computation of a claim shows; :mod:`.studies` declares claims and judges them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from robot_perception.evaluation.intervals import Interval
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Condition


class Size(StrEnum):
    """How much of a study is run: ``quick`` for the tests, ``full`` for the recorded ledger."""

    QUICK = "quick"
    FULL = "full"


@dataclass(frozen=True, slots=True)
class Finding:
    """What the computation of one claim shows.

    Parameters
    ----------
    value
        Our value, compared with the claim's accepted range; ``None`` if nothing can be measured,
        and then the note says why.
    evidence
        A few further numbers by name, shown beside the value.
    tables
        More than a few, by name.
    conditions
        Conditions that were tried; those that decide (:func:`.verdicts.deciding`) make the claim
        conditional.
    note
        One or two sentences for the reader; numbers in it come from the computation.

    Raises
    ------
    ValueError
        If there is neither a value nor a note.
    """

    value: Interval | None
    evidence: Mapping[str, Interval] = field(default_factory=dict)
    tables: Mapping[str, Table] = field(default_factory=dict)
    conditions: tuple[Condition, ...] = ()
    note: str = ""

    def __post_init__(self) -> None:
        if self.value is None and not self.note.strip():
            raise ValueError("a finding without a value must say in its note why there is none")
