"""A study is run once; its claims and their sabotages read what it gives."""

from dataclasses import dataclass

import numpy as np
import pytest

from robot_perception.datasets.store import CACHE_VARIABLE
from robot_perception.evaluation.intervals import exact
from robot_perception.teaching.claims import Finding, Size
from robot_perception.teaching.ledger import record, sabotaged
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Condition
from tests.teaching.entries import WORDS

RUNS: list[tuple] = []


@dataclass(frozen=True)
class Config:
    runs: int
    gain: float = 1.5


def run(config: Config, *, rng: np.random.Generator) -> tuple[float, int]:
    RUNS.append((config, rng.integers(1 << 30)))
    return config.gain, config.runs


def broken(config: Config, *, rng: np.random.Generator) -> tuple[float, int]:
    RUNS.append(("broken", config))
    return -config.gain, config.runs


@pytest.fixture
def study(tmp_path, monkeypatch):
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    RUNS.clear()
    own = int.from_bytes(tmp_path.name.encode()[-4:])  # nothing in memory from another test
    return Study(run, full=Config(100), quick=Config(own))


def declared(study, function=None, name="some-claim", **changes):
    def found(result):
        gain, runs = result
        return Finding(exact(gain), {"runs": exact(runs)}, conditions=(Condition("dry", True),))

    found = function or found
    found.__module__ = "elsewhere.chapters.walls.growth"
    return study.claim(name, **(WORDS | changes))(found)


def test_a_claim_reads_the_result_of_its_size_which_is_computed_once(study):
    some, other = declared(study), declared(study, name="another")
    assert [c.find("quick").evidence["runs"].estimate for c in (some, other)] == [
        study.quick.runs
    ] * 2
    assert [config for config, _ in RUNS] == [study.quick]
    assert some.chapter == "walls"
    assert some.seed == study.seed


def test_the_generator_has_the_seed_of_the_study(study):
    Study(run, Config(7), Config(7), seed=3).result(Size.QUICK)
    assert RUNS[-1][1] == np.random.default_rng(3).integers(1 << 30)


@pytest.mark.parametrize(
    ("change", "value"),
    [
        (Change("a gain of three", gain=3.0), 3.0),
        (Change("another run", broken), -1.5),
        (Change("another run and gain", broken, gain=2.0), -2.0),
        (Change("another configuration", config=Config(9, 4.0)), 4.0),
    ],
)
def test_a_sabotage_changes_the_quick_study_and_reads_it_by_the_same_function(study, change, value):
    some = declared(study, sabotage=change)
    (found,) = sabotaged(some)
    assert (found.text, found.verdict, found.value.estimate) == (change.text, "refuted", value)
    assert some.sabotaged(change) == Finding(exact(value))  # of the value, nothing else


def test_a_claim_is_recorded_with_all_its_sabotages(study):
    some = declared(study, sabotage=[Change("three", gain=3.0), Change("four", gain=4.0)])
    made = record(some, versions="all of today")
    assert (made.verdict, made.value.estimate) == ("conditional", 1.5)
    assert [s.value.estimate for s in made.sabotages] == [3.0, 4.0]
    assert made.quick["evidence: runs"][0] == study.quick.runs


def test_a_value_of_its_own_serves_where_a_sabotage_has_less_to_say(study):
    def more(result, value):
        assert result[0] == 1.5, "of a sabotage the value alone is asked for"
        return Finding(value, {"twice": exact(2 * value.estimate)})

    some = declared(study, more, value=lambda r: exact(r[0]), sabotage=Change("three", gain=3.0))
    assert some.find("quick").evidence["twice"].estimate == 3.0
    assert [found.value.estimate for found in sabotaged(some)] == [3.0]


def test_a_study_of_no_dataclass_is_changed_as_a_whole():
    assert Study(run, full=3, quick=2).quick == 2
    with pytest.raises(TypeError, match="arguments must be numbers"):
        Study(run, full=[3], quick=[2]).result()
