"""How far a pattern may move between two pictures: section 4.1, Fig. 8."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.pattern_tracking.rivals import METHODS, Task
from robot_perception.chapters.pattern_tracking.scene import (
    COORDINATES,
    SCORED,
    SIGMAS,
    START,
    errors,
    moved,
    scene,
    seen,
)
from robot_perception.evaluation.intervals import Interval, bootstrap_median
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Condition, Origin

PAPER = "ceiling-navigation"


@dataclass(frozen=True, slots=True)
class Config:
    """Patches that move once.

    Parameters
    ----------
    seeds
        Of patch and ground; the paper has one of each, which are not to be had.
    sigmas
        How far along one coordinate, standard deviations of the random walk.
    methods
        Names in ``METHODS``.
    """

    seeds: tuple[int, ...] = SCORED[:40]
    sigmas: tuple[float, ...] = (0.0, 1.0, 2.0, 3.0, 4.0, 5.0)
    methods: tuple[str, ...] = tuple(METHODS)


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Errors of estimated places.

    Parameters
    ----------
    config
        What was run.
    errors : (methods, scenes, coordinates, displacements, 2)
        Of the coordinate that was moved, σ; backwards and forwards.
    """

    config: Config
    errors: Float[np.ndarray, "methods scenes 4 displacements 2"]

    def at(self, method: str, sigmas: float) -> Float[np.ndarray, "scenes 4 2"]:
        """Return the sizes of the errors of a method at a displacement."""
        where = self.config.sigmas.index(sigmas)
        return np.abs(self.errors[self.config.methods.index(method), :, :, where])

    def typical(self, method: str, sigmas: float) -> Interval:
        """Return the median over scenes of the error of a scene, itself the median over moves."""
        return bootstrap_median(np.median(self.at(method, sigmas), axis=(1, 2)), "σ")


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Move each patch once along each coordinate, and ask every method where it is.

    A tenth of σ is added at random, so that no place lies on a raster.
    """

    def task(seed: int, rng: np.random.Generator) -> np.ndarray:
        return moves(seed, config, rng)

    found = sweep(task, config.seeds, rng=rng, desc="patches")
    return Result(config, np.moveaxis(np.array(found), 1, 0))


def moves(
    seed: int, config: Config, rng: np.random.Generator
) -> Float[np.ndarray, "methods 4 displacements 2"]:
    """Return the errors of all methods in one scene."""
    one, (camera, *draws) = scene(seed), rng.spawn(1 + len(config.methods))
    pattern, first = one.pattern(), seen(one.picture(START), camera)
    found = np.empty((len(config.methods), 4, len(config.sigmas), 2))
    for c, coordinate in enumerate(COORDINATES):
        for d, sigmas in enumerate(config.sigmas):
            for side, sign in enumerate((-1, 1)):
                truth = moved(coordinate, sign * sigmas) + SIGMAS * camera.uniform(-0.1, 0.1, 4)
                image = one.picture(truth)
                given = Task(pattern, first, tuple(seen(image, camera) for _ in range(3)))
                for m, method in enumerate(config.methods):
                    pose = METHODS[method](given, draws[m])
                    found[m, c, d, side] = errors(pose, truth)[c]
    return found


def nearest(config: Config, *, rng: np.random.Generator) -> Result:
    """Return how near the nearest of 200 particles is drawn; no weight can choose better."""
    shape = (len(config.methods), len(config.seeds), 4, len(config.sigmas), 2)
    found = np.empty(shape)
    for place in np.ndindex(shape[1:]):
        draws = rng.standard_normal((200, 4))
        draws[:, place[1]] -= config.sigmas[place[2]]
        found[(slice(None), *place)] = np.abs(draws[:, place[1]][np.argmin((draws**2).sum(1))])
    return Result(config, found)


fig8 = Study(
    run,
    full=Config(),
    quick=Config(SCORED[:8], (2.0, 3.0), ("one picture", "three pictures")),
    seed=8,
)
SHOWN = Config(SCORED[:10], methods=("one picture",))
shown = Study(run, full=SHOWN, quick=SHOWN, seed=9)
"""What the page draws: ten patches, since all of them take long."""
ACCURATE = Accepted(
    0.0, 0.5, "half a standard deviation of the random walk; the paper names no number",
    Origin.CHOICE,
)  # fmt: skip


TOLD = (1.0, 2.0, 3.0, 4.0)
"""Displacements of the table, σ."""


def table(result: Result) -> Table:
    """Return the typical error by method and displacement."""
    rows = {m: [result.typical(m, k) for k in TOLD] for m in result.config.methods}
    heads = {f"{k:g}σ": "" for k in TOLD}
    about = "median error, in σ, after a displacement of so many σ; 95 % over "
    return Table(rows, heads, f"{about}{len(result.config.seeds)} patches", "method")


@fig8.claim(
    "tracker-fig8",
    paper=PAPER,
    place="§4.1, Fig. 8",
    basis="substitute",
    statement="With 200 particles the tracker finds a pattern that has moved by up to three "
    "standard deviations of its random walk.",
    paper_value="“the tracker remains accurate inside [−3σ, +3σ]”",
    method="Patches of a ceiling on cluttered grounds, moved once along x, y, θ or s by so many σ: "
    "error along that coordinate after one picture, at 3σ. Median over moves, then over patches.",
    accepted=ACCURATE,
    sabotage=Change("patches moved by five σ", run=lambda config, *, rng: _beyond(config, rng)),
)
def fig8_error(result: Result) -> Finding:
    """Compare what one picture gives at 2σ and at 3σ, and what three give."""
    two, edge = (result.typical("one picture", k) for k in (2.0, 3.0))
    drawn = nearest(result.config, rng=np.random.default_rng(8)).typical("one picture", 3.0)
    return Finding(
        edge,
        {
            "at 2σ, one picture": two,
            "at 3σ, three pictures in which it rests": result.typical("three pictures", 3.0),
            "at 3σ, the nearest of 200 draws": drawn,
        },
        tables={"errors": table(result)} if len(result.config.methods) > 2 else {},
        conditions=(
            Condition.judged(
                "the pattern moves by two σ at most", ACCURATE, inside=two, outside=edge
            ),
        ),
    )


def _beyond(config: Config, rng: np.random.Generator) -> Result:
    """Run with all displacements moved out to five σ, under the names of the study's own."""
    far = run(Config(config.seeds, (5.0,), config.methods), rng=rng)
    return Result(config, np.repeat(far.errors, len(config.sigmas), axis=3))
