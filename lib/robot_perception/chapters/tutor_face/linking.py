"""Two tutors and a stranger before the robot: who keeps the link that one of them began."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.tutor_face.crossing import TUTORS, Seen, seen
from robot_perception.chapters.tutor_face.scene import CHOOSING, SCORED
from robot_perception.companion.faces.link import Link, LinkRules, SeenFace, keep_link
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, proportion
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Origin

PAPER = "companion-robot"
RULES = {
    "verified": ("verified", False),
    "nearest": ("nearest", False),
    "largest tutor": ("largest", False),
    "verified, told": ("verified", True),
}
"""Policies of the link, and whether the robot is told whose each face is."""


@dataclass(frozen=True, slots=True)
class Config:
    """Films of two tutors and a stranger.

    Parameters
    ----------
    seeds
        Of the films.
    frames
        Of each, ten a second.
    rule
        One of ``RULES``, that the claim is about.
    """

    seeds: tuple[int, ...] = SCORED[:160]
    frames: int = 120
    rule: str = "verified"


def linked(faces: Seen, frames: int, policy: str, *, told: bool) -> tuple[int, ...]:
    """Return who has the link in each picture: a person, -1 for no face, -2 for no link.

    The first link counts alone: when it has ended, there is none.
    """
    names = np.where(faces.people < TUTORS, faces.people, -1) if told else faces.names
    link: Link | None = None
    holders: list[int] = []
    for t in range(frames):
        here = np.flatnonzero(faces.frames == t)
        some = [
            SeenFace(faces.boxes[k], None if names[k] < 0 else f"tutor {names[k]}") for k in here
        ]
        link, info = keep_link(link, some, LinkRules(policy))
        if info.ended:
            return *holders, *[-2] * (frames - t)
        if link is not None:
            holders.append(-1 if info.held is None else int(faces.people[here[info.held]]))
        else:
            holders.append(-2)
    return tuple(holders)


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Who had the link.

    Parameters
    ----------
    config
        What was run.
    kept : (films, rules)
        Whether nobody but who began it had it in any picture.
    right : (films, rules)
        Of the pictures in which the face of who began it is found, the share in which it has it.
    """

    config: Config
    kept: Float[np.ndarray, "films rules"]
    right: Float[np.ndarray, "films rules"]

    def alone(self, rule: str) -> Interval:
        """Return the share of the films in which nobody else ever has the link."""
        column = self.kept[:, list(RULES).index(rule)]
        return proportion(int(column.sum()), len(column))

    def share(self, rule: str) -> Interval:
        """Return how often who began the link has it when seen, mean over films."""
        return bootstrap_mean(self.right[:, list(RULES).index(rule)])

    def table(self) -> Table:
        """Return what becomes of the link by rule."""
        rows = {rule: [self.alone(rule), self.share(rule)] for rule in RULES}
        columns = {
            "never another": "films in which no face but that of who began it has the link",
            "has it": "of the pictures in which that face is found, those in which it has the link",
        }
        return Table(rows, columns, f"{len(self.right)} films; 95 %", "the link goes to")


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Keep the link through each film by each rule."""

    def task(seed: int, rng: np.random.Generator) -> np.ndarray:
        faces = seen(seed, config.frames)
        return np.array([judged(faces, config.frames, *rule) for rule in RULES.values()])

    parts = np.array(sweep(task, config.seeds, rng=rng, desc="films"))
    return Result(config, *np.moveaxis(parts, -1, 0))


def judged(faces: Seen, frames: int, policy: str, told: bool) -> tuple[float, float]:
    """Tell whether only who began the link had it, and how often when that face was found."""
    holders = np.array(linked(faces, frames, policy, told=told))
    start = int(np.argmax(holders > -2))
    owner = holders[start]
    there = [t for t in range(start, frames) if owner in faces.people[faces.frames == t]]
    taken = holders[holders >= 0]
    return float((taken == owner).all()), float((holders[there] == owner).mean())


films = Study(run, full=Config(), quick=Config(CHOOSING[:3], 60), seed=5)
MOST = Accepted(
    0.8, 1.0, "four films in five; the paper says that verification avoids switches", Origin.CHOICE
)  # fmt: skip


@films.claim(
    "identity-keeps-link",
    paper=PAPER,
    place="§III",
    basis="substitute",
    statement="Verifying the identity keeps the link with the tutor who began it, also where there "
    "are several authorised ones.",
    paper_value="“the eigenface descriptor of the selected user is used to verify that the "
    "interaction link is kept with the user that initiated it”",
    method="Rendered films of two tutors and a stranger who shift and change places; tutors are "
    "enrolled by pictures of 25 occasions each. Share of the films in which no face but that of "
    "the tutor who began the link ever has it.",
    accepted=MOST,
    sabotage=Change("a link that goes on with the nearest face", rule="nearest"),
)
def identity_keeps_link(result: Result) -> Finding:
    """Compare verification with a tracker and with no verification."""
    return Finding(
        result.alone(result.config.rule),
        {
            "never another, nearest face": result.alone("nearest"),
            "never another, largest tutor": result.alone("largest tutor"),
            "who began has it, verified": result.share("verified"),
            "who began has it, nearest face": result.share("nearest"),
            "who began has it, told": result.share("verified, told"),
        },
        tables={"rules": result.table()} if result.config.frames == 120 else {},
    )
