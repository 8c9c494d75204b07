"""The trained detector of open hands, stored as JSON with what each stage reached.

``robot-perception hands --write`` trains it as the notebook has it, and stores it.
"""

import json
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path

from robot_perception.companion.hands.cascade import Cascade, StageReport
from robot_perception.files import DamagedFile, reading
from robot_perception.teaching.plain import write_json
from robot_perception.teaching.records import records


@dataclass(frozen=True, eq=False, slots=True)
class Trained:
    """A cascade and what its stages reached."""

    cascade: Cascade
    stages: tuple[StageReport, ...]


def model_file() -> Path:
    """Return where the trained detector is stored."""
    return records() / "open_hand.json"


def write(found: Trained, file: Path) -> None:
    """Store a cascade as JSON, a line a feature and a line a stage."""
    reports = [{k: round(v, 4) for k, v in asdict(report).items()} for report in found.stages]
    write_json(file, found.cascade.to_plain() | {"training": reports})


def read(file: Path) -> Trained:
    """Read what `write` has stored.

    Raises
    ------
    robot_perception.files.DamagedFile
        If it is no JSON, of another version, or something is missing.
    """
    with reading(file, "no trained detector"):
        plain = json.loads(file.read_text(encoding="utf-8"))
    try:
        reports = tuple(StageReport(**report) for report in plain["training"])
        return Trained(Cascade.from_plain(plain), reports)
    except (ValueError, KeyError, TypeError) as error:
        raise DamagedFile(f"{file}: {error}") from error


@lru_cache(maxsize=1)
def stored() -> Trained:
    """Return the detector of the book."""
    return read(model_file())
