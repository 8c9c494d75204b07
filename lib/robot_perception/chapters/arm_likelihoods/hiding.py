"""A pose that hides its limbs has fewer points to pay for."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from robot_perception.arms.likelihoods import mean_square, sampled, square_of_sum, sum_of_squares
from robot_perception.chapters.arm_likelihoods.scene import SCORED, Glance, glance
from robot_perception.evaluation.intervals import Interval, mean, proportion
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Origin

PAPER = "companion-robot"
PRICE = 5.0
"""Of a hidden point, px: as far as an edge can be; ours."""
FORMS = {
    "as printed": square_of_sum,
    "sum of the squares": sum_of_squares,
    "mean over the visible points": mean_square,
    "mean, hidden points priced": lambda d, visible, sigma: mean_square(d, visible, sigma, PRICE),
}
FEWEST = 0.05
"""A pose hides an arm if it is among the twentieth of all that shows the fewest points; ours."""


@dataclass(frozen=True, slots=True)
class Config:
    """People who gesture.

    Parameters
    ----------
    seeds
        Of them.
    poses
        That are drawn for each.
    form
        One of ``FORMS``.
    """

    seeds: tuple[int, ...] = SCORED[:80]
    poses: int = 4000
    form: str = "as printed"


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Whether a hidden pose is preferred.

    Parameters
    ----------
    config
        What was run.
    preferred : (scenes, forms)
        Whether the best pose that hides an arm beats the true one.
    visible : (scenes, forms)
        Points of the arm that it shows, as a share of those that the true one shows.
    """

    config: Config
    preferred: Float[np.ndarray, "scenes forms"]
    visible: Float[np.ndarray, "scenes forms"]

    def share(self, form: str) -> Interval:
        """Return in which share of the scenes the hidden pose is preferred."""
        column = self.preferred[:, list(FORMS).index(form)]
        return proportion(int(column.sum()), len(column))

    def table(self) -> Table:
        """Return the forms."""
        rows = {form: [self.share(form), mean(self.visible[:, k])] for k, form in enumerate(FORMS)}
        columns = {
            "hidden preferred": "share of scenes in which the best pose that hides an arm has a "
            "higher likelihood than the true one",
            "visible": "points of the arm that this pose shows, over those that the true one does",
        }
        return Table(rows, columns, f"{len(self.visible)} scenes; 95 %", "D²")


def drawn(shown: Glance, count: int, rng: np.random.Generator) -> Float[np.ndarray, "m 8"]:
    """Return poses that differ from the true one in the arm on the left, and collide nowhere."""
    low, high = shown.model.limits.T
    states = np.tile(shown.angles, (count, 1))
    states[:, :4] = rng.uniform(low, high, (count, 4))
    return states[~shown.model.collides(states)]


def best_hidden(
    shown: Glance, states: Float[np.ndarray, "m 8"], form: str
) -> tuple[Float[np.ndarray, " 8"], float, float]:
    """Return the best of the poses that hide the arm on the left.

    Returns
    -------
    (8,)
        The pose, rad.
    float
        By how much the logarithm of its likelihood is above that of the true pose.
    float
        Points of the arm that it shows, as a share of those that the true pose shows.
    """
    contours = shown.model.contours(np.vstack([shown.angles, states]))
    distances = sampled(shown.seen.static, contours, shown.seen.most)
    logs = FORMS[form](distances, contours.visible, 1.0)
    arm = contours.visible[:, : shown.model.points // 2].sum(axis=1)
    share = arm / max(arm[0], 1)
    hidden = np.argsort(share[1:], kind="stable")[: max(int(FEWEST * len(states)), 1)] + 1
    best = hidden[logs[hidden].argmax()]
    return states[best - 1], float(logs[best] - logs[0]), float(share[best])


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Draw poses for each person."""

    def task(seed: int, rng: np.random.Generator) -> np.ndarray:
        shown = glance(seed)
        states = drawn(shown, config.poses, rng)
        found = [best_hidden(shown, states, form)[1:] for form in FORMS]
        return np.array([(gain > 0, share) for gain, share in found], dtype=float)

    parts = np.array(sweep(task, config.seeds, rng=rng, desc="people"))
    return Result(config, *np.moveaxis(parts, -1, 0))


hidden = Study(run, full=Config(), quick=Config(SCORED[:12], poses=2000), seed=3)


@hidden.claim(
    "hidden-parts",
    paper=PAPER,
    place="§V, eq. 2",
    basis="substitute",
    statement="The sum over the visible points prefers the true pose to poses that hide an arm.",
    paper_value="“N_p model points uniformly distributed along each visible model projected "
    "segments”; the paper does not speak of it",
    method="Before bare walls 4000 poses of one arm are drawn within the joints' limits, without "
    "collisions; the other arm is true. Share of scenes in which the best of the twentieth that "
    "shows the fewest points has a higher likelihood (2) than the true pose.",
    accepted=Accepted(0.0, 0.15, "three scenes in twenty at most", Origin.CHOICE),
    sabotage=Change(
        "a price on what is hidden",
        config=Config(SCORED[:60], poses=2000, form="mean, hidden points priced"),
    ),
)
def hidden_parts(result: Result) -> Finding:
    """Compare the forms."""
    return Finding(
        result.share(result.config.form),
        {form: result.share(form) for form in list(FORMS)[1:]},
        tables={"forms": result.table()} if len(result.visible) >= 80 else {},
    )
