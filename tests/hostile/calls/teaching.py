"""Valid calls of `teaching`."""

import atexit
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from robot_perception.evaluation.intervals import exact
from robot_perception.teaching import (
    bets,
    claims,
    controls,
    exercises,
    explore,
    figures,
    kept,
    ledger,
    prose,
    recordings,
    source,
    storage,
    tables,
    verdicts,
)
from tests.hostile.sweep import call

FOLDER = Path(tempfile.mkdtemp())
atexit.register(shutil.rmtree, FOLDER, ignore_errors=True)
(FOLDER / "shelf" / "mine").mkdir(parents=True)
ENVIRONMENT = {"ROBOT_PERCEPTION_DATA": str(FOLDER / "shelf")}
ALT = "A picture that is made for a test, and nothing else."
IMAGE = np.zeros((6, 8), dtype=np.uint8)
LEVEL = controls.slider("Level", [1.0, 2.0], 1.0)
RANGE = verdicts.Accepted(0.0, 1.0, "half and half")
TABLE = tables.Table({"a": [1.0]}, {"x": "a number"})
FOUND = claims.Finding(exact(0.5), {"more": exact(1.0)}, {"table": TABLE})
WORDS = {"paper": "p", "place": "§1", "statement": "It is so.", "method": "Counted."}


@dataclass(frozen=True)
class Kept:
    number: float = 1.0


def made(number: float) -> Kept:
    """Return a result that may be kept."""
    return Kept()


class Stored(recordings.Recording):
    """A recording whose result is stored beside these tests."""

    def _file(self) -> Path:
        return FOLDER / "result.npz"


def compute(size: object, rng: object) -> claims.Finding:
    return FOUND


def keep(folder: Path) -> Kept:
    return Kept()


def drawing(level: float = 1.0) -> np.ndarray:
    return np.full((6, 8), int(level), dtype=np.uint8)


def explorer() -> explore.Explorer:
    return explore.explore(drawing, alt=ALT, level=LEVEL)


RECORDING = Stored("mine", keep, Kept, "result")
CLAIM = claims.Claim(
    "c",
    "monobot",
    "p",
    "§1",
    verdicts.Basis.MATHEMATICS,
    "It is so.",
    "Counted.",
    RANGE,
    compute,
)
SABOTAGE = CLAIM.sabotage("half of it")(compute)
ENTRY = ledger.entry(CLAIM, FOUND, quick=FOUND)
BOOK = ledger.Ledger((ENTRY,))
BOOK.write(FOLDER / "claims.json")
storage.save(FOLDER / "kept.npz", Kept())
FIG, AX = figures.figure()
SHEET = exercises.Sheet({"a": exercises.Exercise(1.0)})
storage.save(FOLDER / "result.npz", Kept())
(FOLDER / "result.json").write_text('{"dataset": "mine", "date": "2026-01-01", "result": {}}')

RESULTS = {
    claims.Claim,
    claims.Sabotage,
    ledger.Entry,
    ledger.Ledger,
    ledger.Sabotaged,
    recordings.Read,
    verdicts.Turn,
}
CALLS = {
    claims.Claim.find: lambda: call(CLAIM, "quick"),
    claims.Claim.verdict: lambda: call(CLAIM, FOUND),
    claims.Finding: lambda: call(exact(1.0), {}, {}, (), "A note."),
    claims.claim: lambda: call(
        "c", **WORDS, basis="paper", accepted=RANGE, paper_value="1", seed=1
    ),
    claims.claims_in: lambda: call(claims),
    claims.Claim.sabotage: lambda: call(CLAIM, "half of it"),
    claims.Sabotage.find: lambda: call(SABOTAGE),
    claims.sabotages_in: lambda: call(claims),
    verdicts.Accepted: lambda: call(0.0, 1.0, "why", "theory"),
    verdicts.Accepted.contains: lambda: call(RANGE, exact(1.0)),
    verdicts.Accepted.excludes: lambda: call(RANGE, exact(1.0)),
    verdicts.Condition: lambda: call("at night", True),
    verdicts.decide: lambda: call("paper", RANGE, exact(1.0), ()),
    verdicts.turn: lambda: call(RANGE, exact(0.5)),
    verdicts.turned: lambda: call("reproduced", "refuted"),
    tables.Table: lambda: call({"a": [1.0]}, {"x": "a number"}, "about", "corner"),
    tables.Table.from_plain: lambda: call(TABLE.to_plain()),
    tables.Table.numbers: lambda: call(TABLE),
    tables.Table.pick: lambda: call(TABLE, ["a"], ["x"]),
    tables.Table.show: lambda: call(TABLE, 2, ["a"]),
    tables.Table.text: lambda: call(TABLE, 2),
    tables.Table.to_plain: lambda: call(TABLE),
    ledger.Entry.from_plain: lambda: call(ENTRY.to_plain()),
    ledger.Entry.to_plain: lambda: call(ENTRY),
    ledger.Ledger.chapter: lambda: call(BOOK, "monobot"),
    ledger.Ledger.from_json: lambda: call(BOOK.to_json()),
    ledger.Ledger.merged: lambda: call(BOOK, [ENTRY], ["c"]),
    ledger.Ledger.read: lambda: call(FOLDER / "claims.json"),
    ledger.Ledger.to_json: lambda: call(BOOK),
    ledger.Ledger.write: lambda: call(BOOK, FOLDER / "again.json"),
    ledger.different: lambda: call({"a": (1.0, 1.0, 1.0)}, {"a": (1.0, 1.0, 1.0)}, 1e-9),
    ledger.entry: lambda: call(CLAIM, FOUND, quick=FOUND),
    ledger.numbers: lambda: call(FOUND),
    ledger.record: lambda: call(CLAIM, [SABOTAGE], versions="1"),
    ledger.sabotaged: lambda: call(SABOTAGE),
    ledger.verdicts: lambda: call(BOOK),
    recordings.Recording: lambda: call("mine", keep, Kept, "result"),
    recordings.Recording.is_current: lambda: call(RECORDING),
    recordings.Recording.read: lambda: call(RECORDING),
    recordings.Recording.renew: lambda: call(RECORDING),
    recordings.Recording.stored: lambda: call(RECORDING),
    recordings.Recording.write: lambda: call(RECORDING),
    kept.kept: lambda: call(made, Kept, 2.0, code=[storage]),
    storage.load: lambda: call(FOLDER / "kept.npz", Kept),
    storage.same: lambda: call(FOLDER / "kept.npz", FOLDER / "result.npz"),
    storage.save: lambda: call(FOLDER / "more.npz", Kept()),
    figures.band: lambda: call(
        AX, np.arange(3.0), np.zeros(3), np.ones(3), figures.MEANING["truth"]
    ),
    figures.figure: lambda: call(1, 2, width=7.0, height=3.0),
    figures.film: lambda: call([IMAGE, IMAGE + 255], fps=5.0, alt=ALT, caption="Two.", name="two"),
    figures.image_axes: lambda: call(IMAGE, pixelated=True, lossless=True),
    figures.label: lambda: call(AX, 0.5, 0.5, "here", figures.MEANING["truth"]),
    figures.picture: lambda: call(
        IMAGE, alt=ALT, caption="One.", name="one", pixelated=True, lossless=True
    ),
    figures.show: lambda: call(FIG, alt=ALT, caption="One.", name="one"),
    figures.to_html: lambda: call(FIG, alt=ALT, prefix="a", effort=0),
    figures.to_svg: lambda: call(FIG, alt=ALT, prefix="a", effort=0),
    explore.Explorer: lambda: call(drawing, ALT, "One.", "one", {}, {"level": LEVEL}, False, False),
    explore.Explorer.end_points: lambda: call(explorer()),
    explore.Explorer.frame: lambda: call(explorer(), effort=0),
    explore.Explorer.grid: lambda: call(explorer()),
    explore.choice: lambda: call("Kind", ["a", "b"], "a"),
    explore.explore: lambda: call(
        drawing,
        alt=ALT,
        caption="One.",
        name="one",
        presets={},
        pixelated=False,
        lossless=False,
        level=LEVEL,
    ),
    explore.explorers_in: lambda: call({"one": explorer()}),
    explore.slider: lambda: call("Level", [1.0, 2.0], 1.0, "m", form=".2g"),
    explore.timeline: lambda: call("Time", [1.0, 2.0], 1.0, "s", fps=5.0, form=".2g"),
    explore.toggle: lambda: call("On", True),
    controls.Control: lambda: call("slider", "Level", (1.0, 2.0), ("1", "2"), 0, 5.0),
    controls.Control.index_of: lambda: call(LEVEL, 1.0),
    exercises.Exercise: lambda: call(1.0, ((2.0, "Half of it."),), "Again.", 1e-6),
    exercises.Exercise.judge: lambda: call(exercises.Exercise(1.0), 1.0),
    exercises.Sheet: lambda: call({"a": exercises.Exercise(1.0)}),
    exercises.Sheet.check: lambda: call(SHEET, "a", 1.0),
    bets.bet: lambda: call("Is it so?", {"yes": "It is.", "no": "It is."}, "yes"),
    prose.tell: lambda: call("There are {many}.", many=2),
    source.show_source: lambda: call(exact, whole=True),
}
