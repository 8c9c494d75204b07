"""People from several sensors: one reading of the aggregation, its growth, and the whole system."""

import numpy as np

from data_synth.people import readings
from data_synth.people.staging import RIG, Config, staged
from robot_perception.book.people_fusion import RULES as COMMITTEE
from robot_perception.book.people_sensors import Senses
from robot_perception.people.aggregation import AggregationRules, Aggregator, Hypotheses
from robot_perception.people.detections import Detections, polar
from tests.tools.benchmarks.harness import Row

RULES = AggregationRules()
MOTION = np.array([0.02, 0.0, 0.01])


def _reading(people: int, false: int) -> tuple[Hypotheses, Detections]:
    """Return hypotheses of people who were seen before, and a reading with some false ones."""
    rng = np.random.default_rng(people)
    r, phi = 1.0 + np.arange(people) % 8, np.linspace(-np.pi, np.pi, people, endpoint=False)
    first = Detections(0.0, "laser", polar(r, phi, 0.1, 0.05))
    known, _ = Aggregator(RULES).step(Hypotheses.none(), first, np.zeros(3))
    r = np.concatenate([r, rng.uniform(1, 8, false)])
    phi = np.concatenate([phi, rng.uniform(-np.pi, np.pi, false)])
    return known, Detections(0.1, "laser", polar(r, phi, 0.1, 0.05))


def _row(people: int, false: int, at_most: float | None = None) -> Row:
    known, reading = _reading(people, false)

    def agree() -> None:
        _, info = Aggregator(RULES).step(known, reading, MOTION)
        assert info.matched.sum() >= 0.9 * people  # a false one may be nearer

    return Row(
        work=f"people aggregation, {people} people, {people + false} detections",
        ours=lambda: Aggregator(RULES).step(known, reading, MOTION),
        at_most=at_most,
        agree=agree,
        inner=20,
    )


SECONDS = 2.0


def _system() -> Row:
    """Return the row of the whole system: detectors on all signals of two seconds, aggregated."""
    session, noise = staged(Config(46, SECONDS + 0.05))
    signals = list(readings(session, RIG, rng=noise))

    def run() -> Hypotheses:
        senses, aggregator = Senses(np.random.default_rng(0)), Aggregator(COMMITTEE)
        known = aggregator.start()
        for signal in signals:
            known, _ = aggregator.step(known, senses.detect(signal, 0.0), np.zeros(3))
        return known

    def agree() -> None:
        assert len(run().persons(COMMITTEE)) >= 2  # of three people

    return Row(
        work=f"people system, {len(signals)} readings of {SECONDS:g} s, signals to persons",
        ours=run,
        at_most=SECONDS,
        agree=agree,
    )


def rows() -> list[Row]:
    """Return the rows of the benchmark table that concern people."""
    return [_row(10, 5, 2e-3), *(_row(n, n // 2) for n in (20, 40, 80, 160)), _system()]
