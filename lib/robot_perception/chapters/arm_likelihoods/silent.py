"""What the contours of a straight arm do not tell, and what a pull towards rest does about it."""

from dataclasses import dataclass, replace

import numpy as np
import sympy
from jaxtyping import Float

from robot_perception.arms.body_model import BodyModel, Patches
from robot_perception.arms.likelihoods import (
    Bodies,
    CollisionCue,
    EdgeCue,
    LimitCue,
    StabiliserCue,
    summed,
)
from robot_perception.beliefs import ParticleSet
from robot_perception.chapters.arm_likelihoods.scene import (
    CAMERA,
    CHOOSING,
    SCORED,
    Glance,
    glance,
)
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, bootstrap_ratio, exact
from robot_perception.evaluation.sweep import sweep
from robot_perception.particles import condensation
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Origin

PAPER = "companion-robot"
ABOUT, BEND = 2, 3
RAISED = (1.2, 0.3, 1.2)
"""Away from the body, ahead, and about the axis, rad: an arm held to the side."""


def pose(bend: float) -> Float[np.ndarray, " 8"]:
    """Return a pose in which both arms are held to the side."""
    return np.tile([*RAISED, bend], 2)


def jacobian(model: BodyModel, state: np.ndarray, patches: Patches | None = None) -> np.ndarray:
    """Return how the points of the left arm move with its four angles (2n, 4), px/rad.

    Central differences of the contour's points, or of those of patches.
    """
    step, columns = 1e-5, []
    for k in range(4):
        pair = np.tile(state, (2, 1))
        pair[:, k] += [step, -step]
        if patches is None:
            points = model.contours(pair).points[:, : model.points // 2]
        else:
            points = model.surface(pair, patches).points
        columns.append((points[0] - points[1]).ravel() / (2 * step))
    return np.stack(columns, axis=1)


def symbolic() -> sympy.MatrixBase:
    """Return the derivative of the forearm's direction by γ at a straight elbow, by algebra."""
    alpha, beta, gamma, delta = sympy.symbols("alpha beta gamma delta", real=True)
    sin, cos = sympy.sin, sympy.cos
    u = sympy.Matrix([sin(alpha) * cos(beta), cos(alpha) * cos(beta), -sin(beta)])
    e1 = sympy.Matrix([cos(alpha), -sin(alpha), 0])
    w = cos(delta) * u + sin(delta) * (cos(gamma) * e1 + sin(gamma) * u.diff(beta))
    return sympy.simplify(w.diff(gamma).subs(delta, 0))


def rank(matrix: np.ndarray) -> int:
    """Return how many of the singular values are above a millionth of the largest."""
    sizes = np.linalg.svd(matrix, compute_uv=False)
    return int((sizes > 1e-6 * sizes[0]).sum())


@dataclass(frozen=True, slots=True)
class Straight:
    """An arm held to the side.

    Parameters
    ----------
    bend
        Of the elbow, rad.
    """

    bend: float = 0.0


@dataclass(frozen=True, eq=False, slots=True)
class Turned:
    """What moves when the upper arm turns about its axis.

    Parameters
    ----------
    moves
        How far a point of the contour moves at most, px/rad.
    contour, patches
        Ranks of the Jacobians of contour and patches; four if all angles are told.
    """

    moves: float
    contour: int
    patches: int


def turn(config: Straight, *, rng: np.random.Generator) -> Turned:
    """Turn the upper arm about its axis."""
    model = BodyModel.from_face(np.array([145.0, 42.0, 30.0, 30.0]), CAMERA)
    state = pose(config.bend)
    contour = jacobian(model, state)
    places = model.place(state)
    narrow = replace(places, around=np.column_stack([places.around[:, 0], np.full(6, 1.0)]))
    moves = np.hypot(*contour[:, ABOUT].reshape(-1, 2).T).max()
    return Turned(float(moves), rank(contour), rank(jacobian(model, state, narrow)))


straight = Study(turn, full=Straight(), quick=Straight())


@straight.claim(
    "straight-arm",
    paper=PAPER,
    place="§V, “Non-observable parts stabilisation”",
    basis="mathematics",
    statement="When an arm is straight, the rotation of the upper arm about its axis does not move "
    "the projected contours.",
    paper_value="“the model projected contours remain static under this DOF”",
    method="Largest motion of a contour point for a turn of the upper arm, by central differences; "
    "rank of the Jacobian of all contour points by the four angles; the derivative of the "
    "forearm's direction by algebra.",
    accepted=Accepted(0.0, 0.0, "no point moves"),
    sabotage=Change("an elbow that is bent by 0.3 rad", bend=0.3),
)
def straight_arm(result: Turned) -> Finding:
    """Tell what moves, and what patches see of it."""
    return Finding(
        exact(result.moves, "px/rad"),
        {
            "angles told by the contour": exact(float(result.contour)),
            "angles told by patches on the surface": exact(float(result.patches)),
            "entries of the derivative that are not zero, by algebra": exact(
                float(sum(entry != 0 for entry in symbolic()))
            ),
        },
    )


ROUNDS, LAST = 24, 8
"""Of condensation on one picture, and how many at the end count."""
COUNT = 400


@dataclass(frozen=True, slots=True)
class Config:
    """People who hold their arms to the side.

    Parameters
    ----------
    seeds
        Of them.
    strength
        λ_st, per rad².
    """

    seeds: tuple[int, ...] = SCORED[:40]
    strength: float = 0.15


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """What is known of both arms, without and with the pull.

    Parameters
    ----------
    config
        What was run.
    spread : (scenes, 2, 2)
        Standard deviation of γ, of straight and bent arms, without and with the pull, rad.
    error : (scenes, 2, 2)
        Distance from the estimated wrists to the true ones, mean of both, px.
    """

    config: Config
    spread: Float[np.ndarray, "scenes 2 2"]
    error: Float[np.ndarray, "scenes 2 2"]

    def table(self) -> Table:
        """Return what the pull does."""
        rows = {
            f"{arm}, {pull}": [
                bootstrap_mean(np.degrees(self.spread[:, i, j])),
                bootstrap_mean(self.error[:, i, j]),
            ]
            for i, arm in enumerate(("straight", "bent"))
            for j, pull in enumerate(("free", "pulled"))
        }
        columns = {
            "spread of γ (°)": "standard deviation of the turn about the upper arm's axis",
            "wrist off by (px)": "estimated wrist to true one",
        }
        return Table(rows, columns, f"{len(self.spread)} people; 95 %", "arms")


def settled(
    shown: Glance, strength: float, rng: np.random.Generator
) -> tuple[Float[np.ndarray, "rounds 8"], Float[np.ndarray, "rounds 8"]]:
    """Return means and spreads of particles that see one picture again and again.

    They start spread round the true pose and are weighed by the static shape, the limits of the
    joints and collisions, and by the pull.
    """
    cues = {"shape": EdgeCue(), "limits": LimitCue(), "collisions": CollisionCue()}
    if strength > 0:
        cues["pull"] = StabiliserCue(strength)

    def log_likelihood(states: np.ndarray) -> np.ndarray:
        logs = summed(cues, shown.seen, Bodies(shown.model, states))
        return np.sum(list(logs.values()), axis=0)

    def move(states: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        return states + np.tile([0.05, 0.05, 0.3, 0.05], 2) * rng.standard_normal(states.shape)

    start = shown.angles + np.tile([0.1, 0.1, 0.6, 0.1], 2) * rng.standard_normal((COUNT, 8))
    particles = ParticleSet.uniform(start)
    means, spreads = [], []
    for _ in range(ROUNDS):
        particles, _ = condensation(particles, move, log_likelihood, rng=rng)
        means.append(particles.mean)
        spreads.append(np.sqrt(np.diag(particles.cov)))
    return np.array(means[-LAST:]), np.array(spreads[-LAST:])


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Look at straight and bent arms again and again, without and with the pull."""

    def task(seed: int, rng: np.random.Generator) -> np.ndarray:
        found = np.empty((2, 2, 2))
        for i, bend in enumerate((0.0, 1.2)):
            shown = glance(seed, stops=True, pose=tuple(pose(bend).tolist()))
            for j, strength in enumerate((0.0, config.strength)):
                means, spreads = settled(shown, strength, rng)
                wrists = shown.model.pixels(shown.model.joints(means)[:, :, 2])
                off = np.linalg.norm(wrists - shown.wrists, axis=-1)
                found[:, i, j] = spreads[:, [ABOUT, 4 + ABOUT]].mean(), off.mean()
        return found

    return Result(
        config, *np.moveaxis(np.array(sweep(task, config.seeds, rng=rng, desc="people")), 1, 0)
    )


pulled = Study(run, full=Config(), quick=Config(CHOOSING[:6]), seed=4)


@pulled.claim(
    "stabiliser",
    paper=PAPER,
    place="§V, eq. of p_st",
    basis="substitute",
    statement="The stabiliser costs nothing where the image speaks, and holds where it is silent.",
    paper_value="“the stabilising effect will be negligible for the whole configuration space with "
    "the exception of the regions where the other cost terms are constant”",
    method="Arms held to the side before bare walls, seen 24 times by 400 particles that are "
    "weighed by the static shape. Bent arms: distance from the estimated wrists to the true ones, "
    "with the pull less without; bootstrap over people.",
    accepted=Accepted(-np.inf, 2.0, "two pixels at most, 12 mm at the wrist", Origin.CHOICE),
    sabotage=Change("a pull a thousand times as strong", strength=150.0),
)
def stabiliser(result: Result) -> Finding:
    """Tell what the pull does to bent and to straight arms."""
    return Finding(
        bootstrap_mean(result.error[:, 1, 1] - result.error[:, 1, 0], "px"),
        {
            "straight arm, spread of γ, pulled over free": _ratio(result, 0),
            "bent arm, spread of γ, pulled over free": _ratio(result, 1),
            "straight arm, wrist, pulled less free": bootstrap_mean(
                result.error[:, 0, 1] - result.error[:, 0, 0], "px"
            ),
        },
        tables={"pull": result.table()} if len(result.error) >= 40 else {},
    )


def _ratio(result: Result, arm: int) -> Interval:
    return bootstrap_ratio(result.spread[:, arm, 1], result.spread[:, arm, 0])
