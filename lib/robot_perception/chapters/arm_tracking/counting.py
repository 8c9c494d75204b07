"""How the error falls with the number of particles, for three filters."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from robot_perception.arms.tracker import FILTERS
from robot_perception.chapters.arm_likelihoods.scene import SCORED
from robot_perception.chapters.arm_tracking.tracking import FRAMES, tracked
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, bootstrap_ratio
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Origin

PAPER = "companion-robot"
COUNTS = (10, 50, 100, 200, 400, 800, 1600)


@dataclass(frozen=True, slots=True)
class Config:
    """Films of people who gesture before a bare wall.

    Parameters
    ----------
    seeds
        Of the films.
    counts
        Numbers of particles.
    filters
        Names in ``FILTERS``.
    scene
        Name of a scene.
    frames
        Of each film.
    taken
        The number of particles that the claim is about.
    """

    seeds: tuple[int, ...] = SCORED[:24]
    counts: tuple[int, ...] = COUNTS
    filters: tuple[str, ...] = tuple(FILTERS)
    scene: str = "gesturing, plain"
    frames: int = FRAMES
    taken: int = 400


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Errors by filter and number of particles.

    Parameters
    ----------
    config
        What was run.
    angle, wrist : (films, filters, counts)
        Mean error of the angles, degrees, and median error of the wrists, px.
    held : (films, filters, counts)
        Share of both arms that is held at the end.
    """

    config: Config
    angle: Float[np.ndarray, "films filters counts"]
    wrist: Float[np.ndarray, "films filters counts"]
    held: Float[np.ndarray, "films filters counts"]

    def of(self, values: np.ndarray, filter: str, count: int) -> Float[np.ndarray, " films"]:
        """Return values of a filter with so many particles."""
        config = self.config
        return values[:, config.filters.index(filter), config.counts.index(count)]

    def ratio(self, filter: str, many: int, few: int) -> Interval:
        """Return the mean error of the angles with many particles over that with few."""
        return bootstrap_ratio(self.of(self.angle, filter, many), self.of(self.angle, filter, few))

    def table(self) -> Table:
        """Return the error of the wrists by filter and number of particles."""
        rows = {
            name: [bootstrap_mean(self.of(self.wrist, name, count)) for count in self.config.counts]
            for name in self.config.filters
        }
        about = f"median error of the wrists, px, mean over {len(self.angle)} films; 95 %"
        return Table(rows, {f"{count}": "" for count in self.config.counts}, about, "particles")

    def shares(self) -> Table:
        """Return the error of the angles and the arms that are held, at 400 particles."""
        rows = {
            name: [
                bootstrap_mean(self.of(self.angle, name, self.config.taken)),
                bootstrap_mean(self.of(self.held, name, self.config.taken)),
            ]
            for name in self.config.filters
        }
        columns = {"angles (°)": "mean error", "held": "share of the arms at the end of a film"}
        return Table(rows, columns, f"{self.config.taken} particles; 95 %", "filter")


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Track each film by each filter with each number of particles."""

    def task(seed: int, rng: np.random.Generator) -> np.ndarray:
        found = np.empty((3, len(config.filters), len(config.counts)))
        for i, name in enumerate(config.filters):
            for j, count in enumerate(config.counts):
                one = tracked(seed, config.scene, "all cues", name, count, config.frames)
                found[:, i, j] = one.angle, one.wrist, one.held.mean()
        return found

    parts = np.array(sweep(task, config.seeds, rng=rng, desc="films"))
    return Result(config, *np.moveaxis(parts, 1, 0))


particles = Study(run, full=Config(), quick=Config(SCORED[:3], frames=36), seed=2)
"""All filters and numbers of particles."""
sizes = Study(
    run,
    full=Config(SCORED[:80], counts=(50, 400, 1600), filters=("auxiliary",)),
    quick=Config(SCORED[:6], counts=(400, 1200), filters=("auxiliary",), frames=30),
    seed=2,
)
"""More films: a ratio of errors needs them."""
ENOUGH = Accepted(
    0.85, np.inf, "four times as many particles take away less than 15 %", Origin.CHOICE
)  # fmt: skip


@sizes.claim(
    "apf-400",
    paper=PAPER,
    place="§V, “Implementation”",
    basis="substitute",
    statement="For both arms the auxiliary particle filter gets by with 400 particles.",
    paper_value="“tracking results are achieved with a reasonably small number of particles i.e. "
    "N_s = 400”",
    method="Films of people who gesture before a bare wall. Mean error of the eight angles with "
    "1600 particles over that with 400, auxiliary filter; ratio of means over films, bootstrap.",
    accepted=ENOUGH,
    sabotage=Change(
        "three particles",
        config=Config(SCORED[:6], counts=(3, 100), filters=("auxiliary",), frames=40, taken=3),
    ),
)
def apf_400(result: Result) -> Finding:
    """Compare numbers of particles and filters."""
    config = result.config
    most = config.counts[-1]
    value = result.ratio("auxiliary", most, config.taken)
    if len(result.angle) < 80:
        return Finding(value)
    every = particles.result()
    first = "auxiliary"
    others = [name for name in every.config.filters if name != first]
    return Finding(
        value,
        {
            "400 particles over 50": result.ratio(first, 400, 50),
            "400 particles over 10": every.ratio(first, 400, 10),
            **{
                f"{first} over {name}, {count} particles": bootstrap_ratio(
                    every.of(every.angle, first, count), every.of(every.angle, name, count)
                )
                for name in others
                for count in (50, 400)
            },
        },
        tables={"wrists": every.table(), "filters": every.shares()},
    )
