"""Recorded rows are those of the code that is here: their keys say so, and drawn trials.

``make test`` computes one trial of each study that takes a few seconds, drawn by the hash of its
code: from the combinations of factors that are cheap, or else from the first one of the cheapest
variant. ``make test-all`` computes two of each study, drawn by the commit, so that another commit
tries others.
"""

import os
import subprocess
from random import Random

import numpy as np
import pytest

from robot_perception import chapters
from studies.stored import recorded_rows, storage
from studies.trials import AS_DECLARED, Trials
from tests.book.changed import CHANGED
from tests.book.computing import COMPUTING
from tests.book.pages import ROOT
from tests.proof import WHOLE
from tests.unchecked import unchecked

DRAWN = 2
"""Trials of each study that the whole proof computes anew."""
SHORT = 1.5
"""Trials that take longer are computed in the whole proof only, s."""
CHEAP = 1.0
"""Where no trial takes longer, any combination of factors may be drawn, s."""
LARGEST = 1e6
RECORD = "robot-perception store --chapter {}"
RENEW = f"{RECORD} --keys"
STUDIES = chapters.trials(COMPUTING)
NAMES = tuple(dict.fromkeys(f"{study.stem}.{study.name}" for study in STUDIES))
COMMIT = "ROBOT_PERCEPTION_DRAWN"
"""Environment variable: draw trials as at this commit."""


def of(name: str) -> list[Trials]:
    """Return a study and its variants."""
    return [study for study in STUDIES if f"{study.stem}.{study.name}" == name]


def seconds(study: Trials) -> tuple[float, float]:
    """Return what a trial of the first combination takes, and one of any; who knows if nobody."""
    known = recorded_rows.seconds(study.stem, study.name)
    return known.get(study.changed or AS_DECLARED, (np.inf, np.inf))


def least(name: str) -> float:
    """Return what the cheapest trial of a study takes, s."""
    return min(seconds(study)[0] for study in of(name))


def commit() -> str:
    """Return the commit that is tested; without git a word that stays."""
    if COMMIT in os.environ:
        return os.environ[COMMIT]
    said = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True)
    return said.stdout.strip() or "no commit"


def drawn(name: str) -> list[tuple[Trials, dict]]:
    """Return trials of a study and its variants, each variant as likely as another."""
    random = Random(f"{commit()} {name}")
    variants = random.choices(of(name), k=DRAWN)
    return [(study, random.choice(list(study.trials()))) for study in variants]


def cheap(name: str) -> tuple[Trials, dict]:
    """Return a trial that takes little, the same as long as the code of the study is."""
    variants = of(name)
    random = Random(f"{name} {variants[0].code()}")
    if any_ := [study for study in variants if seconds(study)[1] <= CHEAP]:
        study = random.choice(any_)
        return study, random.choice(list(study.trials()))
    study = min(variants, key=lambda one: seconds(one)[0])
    return study, next(study.trials()) | {study.replicate: random.choice(study.replicates)}


@pytest.mark.parametrize("study", STUDIES, ids=lambda s: f"{s.stem}.{s.name}-{s.changed}")
def test_rows_are_of_this_code_and_these_levels(study: Trials):
    variants = recorded_rows.variants(study.stem, study.name)
    assert (study.changed or AS_DECLARED) in variants, RENEW.replace(" --keys", "").format(
        study.stem
    )
    assert study.is_current(), f"recorded by other code: {RENEW.format(study.stem)}"
    assert len(study.rows()) >= len(list(study.trials()))
    for name, values in study.axes.items():  # in the order in which they are run; text as text
        recorded = study.rows().levels(name)
        assert len(recorded) == len(values)
        assert all(a == b or a == f"{b}" for a, b in zip(recorded, values, strict=True))


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=[pytest.mark.slow] if least(n) > SHORT else []) for n in NAMES],
)
def test_trials_that_are_drawn_give_what_is_recorded(name: str):
    if os.environ.get(CHANGED) and all(study.is_current() for study in of(name)):
        pytest.skip("nothing has changed")
    chosen = drawn(name) if WHOLE else [cheap(name)]
    with unchecked():
        lines = [line for study, where in chosen for line in study.differs(**where)]
    assert not lines, "\n".join([*lines, f"{COMMIT}={commit()}"] if WHOLE else lines)


def test_what_a_trial_takes_is_recorded():
    without = [name for name in NAMES if not np.isfinite(least(name))]
    assert not without, f"{RECORD} --anew measures it"


def test_cheap_trials_are_drawn_by_code_and_not_by_the_commit(monkeypatch: pytest.MonkeyPatch):
    """Whether `make test` is green or red is the same at every commit that leaves the code."""
    names = [name for name in NAMES if least(name) <= SHORT][::10]
    seen = []
    for word in ("a", "b"):
        monkeypatch.setenv(COMMIT, word)
        seen.append([where for _, where in map(cheap, names)])
    monkeypatch.setattr(Trials, "code", lambda self: "other code")
    assert seen[0] == seen[1] != [where for _, where in map(cheap, names)]


def test_other_commits_draw_other_trials(monkeypatch: pytest.MonkeyPatch):
    seen = set()
    for name in ("a", "b", "c"):
        monkeypatch.setenv(COMMIT, name)
        seen.add(repr([where for study in NAMES for _, where in drawn(study)]))
        assert commit() == name
    assert len(seen) == 3


def test_every_file_is_of_a_study_and_holds_what_it_declares():
    declared = {name: {study.changed or AS_DECLARED for study in of(name)} for name in NAMES}
    files = sorted(recorded_rows.folder().iterdir())
    assert {file.stem for file in files} == declared.keys()
    for file in (file for file in files if file.suffix == ".npz"):
        stem, _, study = file.stem.partition(".")
        undeclared = set(recorded_rows.variants(stem, study)) - declared[file.stem]
        assert not undeclared, f"{file.name} has rows that nobody declares: {undeclared}"
        stored = storage.load(file, recorded_rows._Stored).variants
        assert set(stored) == set(recorded_rows.variants(stem, study))
        assert file.stat().st_size < LARGEST, file.name
    assert {file.suffix for file in files} == {".npz", ".json"}
