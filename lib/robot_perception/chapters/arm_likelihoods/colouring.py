"""Colours of patches: where in a picture a hand is found, and which patch is to be trusted."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy.stats import rankdata

from robot_perception.arms.likelihoods import COLOUR, Bodies, PatchCue, confidences
from robot_perception.chapters.arm_likelihoods.scene import (
    AWAY,
    BEND,
    CLUTTER,
    SCORED,
    Glance,
    glance,
)
from robot_perception.companion.cues import bhattacharyya, patch_histograms, patch_points
from robot_perception.evaluation.intervals import (
    Interval,
    bootstrap_mean,
    correlation,
    proportion,
)
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted, Origin

PAPER = "companion-robot"
STEP, SIDE = 4, 8.0
"""From one place of the swept square to the next, and its side, px; ours."""
ROWS, COLUMNS = np.arange(8, 240, STEP), np.arange(8, 320, STEP)
SIGMA = 0.35
"""Of the distance of all channels; ours."""
HANDS, HEAD = (5, 8), 1
"""Parts of the picture."""


def field(shown: Glance) -> Float[np.ndarray, "rows columns"]:
    """Return the likelihood of the hand's colours over the picture, its largest value 1.

    The hand is the one on the left, as it looks at rest.
    """
    first = shown.first
    joints = first.model.joints(first.state[None])[0, 0]
    u, v = first.model.pixels(joints[2:].mean(axis=0))
    square = np.array([[-0.5, -0.5, 1.0, 1.0]])
    there = patch_points(np.array([[u, v, 0.0, SIDE]]), square)
    hand, _ = patch_histograms(first.seen.image, there)
    x, y = (part.ravel() for part in np.meshgrid(COLUMNS, ROWS))
    states = np.column_stack([x, y, np.zeros(x.size), np.full(x.size, SIDE)]).astype(float)
    seen, _ = patch_histograms(shown.image, patch_points(states, square))
    squared = (bhattacharyya(seen, hand) ** 2).sum(axis=(1, 2))
    return np.exp(-(squared - squared.min()) / (2 * SIGMA**2)).reshape(len(ROWS), len(COLUMNS))


@dataclass(frozen=True, slots=True)
class Config:
    """People who gesture.

    Parameters
    ----------
    seeds
        Of them.
    clutter
        On the wall.
    skin
        Whether the head and the forearms count, too.
    """

    seeds: tuple[int, ...] = SCORED[:120]
    clutter: int = CLUTTER
    skin: bool = False


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Where the hand's colours are.

    Parameters
    ----------
    config
        What was run.
    hand, skin : (scenes,)
        Whether the best place is on a hand, and on a hand, the head or a bare arm.
    share : (scenes,)
        Of the picture where the likelihood is above a half of its largest.
    bare : (scenes,)
        Of the same before a bare wall.
    """

    config: Config
    hand: Float[np.ndarray, " scenes"]
    skin: Float[np.ndarray, " scenes"]
    share: Float[np.ndarray, " scenes"]
    bare: Float[np.ndarray, " scenes"]


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Look for the hand's colours in each picture."""

    def best(shown: Glance) -> tuple[float, float, float]:
        likelihood = field(shown)
        k, j = np.unravel_index(likelihood.argmax(), likelihood.shape)
        v, u = ROWS[k], COLUMNS[j]
        near = shown.parts[max(v - 4, 0) : v + 5, max(u - 4, 0) : u + 5]
        hand = np.isin(near, HANDS).any()
        return hand, hand or np.isin(near, (HEAD, 4, 7)).any(), (likelihood > 0.5).mean()

    def task(seed: int, rng: np.random.Generator) -> np.ndarray:
        return np.array([*best(glance(seed, config.clutter)), best(glance(seed))[0]], dtype=float)

    return Result(config, *np.array(sweep(task, config.seeds, rng=rng, desc="people")).T)


hands = Study(run, full=Config(), quick=Config(SCORED[:16]), seed=1)
MOST = Accepted(0.8, 1.0, "four pictures in five; the paper shows one", Origin.CHOICE)


@hands.claim(
    "bhattacharyya",
    paper=PAPER,
    place="§V, Fig. 9",
    basis="substitute",
    statement="The colours of a patch of the hand, swept over the whole picture, have their "
    "highest likelihood on a hand.",
    paper_value="“obtained by computing the Bhattacharyya distance between the colour distribution "
    "of the reference ROI and a patch swept all over the image”",
    method="The square is taken from the hand at rest and swept in steps of 4 px over a later "
    "picture, before a cluttered wall. Share of pictures in which the best place touches a hand.",
    accepted=MOST,
    sabotage=Change("any skin counts", config=Config(SCORED[:60], skin=True)),
)
def swept_over(result: Result) -> Finding:
    """Tell where the hand's colours are found."""
    there = result.skin if result.config.skin else result.hand
    return Finding(
        proportion(int(there.sum()), len(there)),
        {
            "on a hand, the head or a forearm": proportion(
                int(result.skin.sum()), len(result.skin)
            ),
            "share of the picture above half of the peak": bootstrap_mean(result.share),
            "bare wall": proportion(int(result.bare.sum()), len(result.bare)),
        },
    )


@dataclass(frozen=True, slots=True)
class Trust:
    """Patches on the limbs of people who gesture.

    Parameters
    ----------
    seeds
        Of the people.
    clutter
        On the wall.
    by
        What says how far a patch is trusted: ``"confidence"``, the paper's, or ``"contrast"``, how
        unlike its surroundings it is.
    """

    seeds: tuple[int, ...] = SCORED[:120]
    clutter: int = CLUTTER
    by: str = "confidence"


@dataclass(frozen=True, eq=False, slots=True)
class Trusted:
    """What is foretold, and what came.

    Parameters
    ----------
    config
        What was run.
    confidence, contrast, error : (scenes, patches)
        The paper's weight, the distance from the surroundings, and how far off the patch's own
        likelihood puts it, as a share of how far it is where nothing is known.
    """

    config: Trust
    confidence: Float[np.ndarray, "scenes patches"]
    contrast: Float[np.ndarray, "scenes patches"]
    error: Float[np.ndarray, "scenes patches"]

    def foretells(self, by: str) -> Interval:
        """Return the rank correlation of a forecast with the error."""
        forecast = getattr(self, by)
        return correlation(rankdata(forecast), rankdata(self.error))


TURNS = np.radians(np.arange(-40.0, 40.1, 8.0))


def errors(shown: Glance) -> Float[np.ndarray, " patches"]:
    """Return how far off each patch's own likelihood puts it if two angles are not known.

    As a share of how far off it is if nothing is known of them: a hand moves more than an upper
    arm.
    """
    first = shown.first
    found = np.empty(len(first.patches))
    for arm in range(2):
        away, bend = (part.ravel() for part in np.meshgrid(TURNS, TURNS))
        states = np.tile(shown.angles, (away.size + 1, 1))
        states[1:, 4 * arm + AWAY] += away
        states[1:, 4 * arm + BEND] += bend
        bodies = Bodies(shown.model, states)
        cue = PatchCue(first.patches, first.reference)
        logs = -cue.squared(shown.seen, bodies) / (2 * cue.sigma**2)
        surface = bodies.surface(first.patches)
        middles = surface.points.mean(axis=2)
        for p in np.flatnonzero(first.patches.limbs // 3 == arm):
            weights = np.exp(logs[1:, p] - logs[1:, p].max())
            off = np.linalg.norm(middles[1:, p] - middles[0, p], axis=-1)
            found[p] = weights @ off / weights.sum() / off.mean()
    return found


def contrasts(shown: Glance) -> Float[np.ndarray, " patches"]:
    """Return how unlike its surroundings in the picture at rest each patch is: mean D²."""
    first = shown.first
    surface = first.model.surface(first.state[None], first.patches)
    found = np.empty(len(first.patches))
    for p, points in enumerate(surface.points[0]):
        middle, reach = points.mean(axis=0), 24.0
        ring = np.array([[x, y, 0.0, 10.0] for x, y in middle + reach * _circle(8)])
        there = patch_points(ring, np.array([[-0.5, -0.5, 1.0, 1.0]]))
        seen, inside = patch_histograms(first.seen.image, there)
        around = seen[inside[:, 0] > 0.5, 0]
        squared = bhattacharyya(around, first.reference[p, list(COLOUR)]) ** 2
        found[p] = squared.mean() if len(around) else 0.0
    return found


def _circle(count: int) -> Float[np.ndarray, "n 2"]:
    angles = 2 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def trust(config: Trust, *, rng: np.random.Generator) -> Trusted:
    """Compare forecast and error of each patch."""

    def task(seed: int, rng: np.random.Generator) -> np.ndarray:
        shown = glance(seed, config.clutter)
        return np.array([confidences(shown.first.reference), contrasts(shown), errors(shown)])

    parts = np.array(sweep(task, config.seeds, rng=rng, desc="people"))
    return Trusted(config, *np.moveaxis(parts, 1, 0))


trusted = Study(trust, full=Trust(), quick=Trust(SCORED[:16]), seed=1)


@trusted.claim(
    "patch-confidence",
    paper=PAPER,
    place="§V, “Implementation”",
    basis="substitute",
    statement="A patch's likelihood against the uniform histogram says beforehand how well it can "
    "be tracked.",
    paper_value="“uniform coloured patches produce low likelihood values, whereas higher "
    "likelihood values characterise confident patches”",
    method="Six patches a person, before cluttered walls. Two angles of an arm are not known; each "
    "patch's own likelihood puts it somewhere. Rank correlation of λ_p with how far off that is, "
    "as a share of how far off it is where nothing is known, over all patches, which are counted "
    "as if independent.",
    accepted=Accepted(-1.0, -0.1, "more trust, less error: a weak one counts", Origin.CHOICE),
    sabotage=Change(
        "how unlike its surroundings a patch is", config=Trust(SCORED[:60], by="contrast")
    ),
)
def patch_confidence(result: Trusted) -> Finding:
    """Compare the paper's forecast with another one."""
    return Finding(
        result.foretells(result.config.by),
        {
            "how unlike its surroundings": result.foretells("contrast"),
            "hands alone": _hands(result, "confidence"),
            "hands alone, how unlike": _hands(result, "contrast"),
        },
    )


def _hands(result: Trusted, by: str) -> Interval:
    return correlation(rankdata(getattr(result, by)[:, [2, 5]]), rankdata(result.error[:, [2, 5]]))
