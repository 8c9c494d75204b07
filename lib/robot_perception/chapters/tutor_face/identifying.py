"""Who is it: eigenfaces on what the detector cuts out, by the number of eigenimages."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float, Int

from robot_perception.chapters.tutor_face.scene import (
    CHOOSING,
    DETECTOR,
    EIGENIMAGES,
    SCORED,
    cut,
    found,
    look,
    person,
)
from robot_perception.companion.faces.eigenfaces import enrol
from robot_perception.evaluation.intervals import Interval, bootstrap_mean
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Condition, Origin

PAPER = "companion-robot"
PEOPLE, FEW = 10, 3
"""In a gallery; the paper does not say how many it has. Each gallery of ten is cut into three of
three, too, as a robot with three tutors has it."""
ENROLLED, LATER = 7, 3
"""Pictures of each at enrolment, so that three people can make 20 eigenimages, and afterwards."""
STRANGERS = 4
COUNTS = (1, 2, 5, 10, 20)
CASES = ("three people", "ten people", "ten people, cut out exactly")
"""Who is known, and how a face is cut out: at its detection, or at the true square."""


@dataclass(frozen=True, slots=True)
class Config:
    """Galleries of people whom nobody has seen before.

    Parameters
    ----------
    galleries
        How many.
    counts
        Of eigenimages; section III: 20.
    cases
        Names in ``CASES``.
    shuffled
        Whether the names of the gallery are shuffled.
    """

    galleries: int = 24
    counts: tuple[int, ...] = COUNTS
    cases: tuple[str, ...] = CASES
    shuffled: bool = False


SHARES = ("right", "known", "strangers", "left")


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Shares of faces by gallery.

    Parameters
    ----------
    config
        What was run.
    shares : (galleries, 4, cases, counts)
        Of later pictures, those whose nearest is of the same person; those that are accepted by
        the thresholds and rightly named; of strangers, those accepted; and what the eigenimages
        leave of a new face, as a share of what the mean face leaves.
    missed : (galleries,)
        Share of the pictures in which the face is not found; nobody is named there.
    """

    config: Config
    shares: Float[np.ndarray, "galleries 4 cases counts"]
    missed: Float[np.ndarray, " galleries"]

    def of(self, name: str, count: int = EIGENIMAGES, case: str = CASES[0]) -> Interval:
        """Return the mean over galleries of one of the ``SHARES``."""
        place = self.config.cases.index(case), self.config.counts.index(count)
        return bootstrap_mean(self.shares[:, SHARES.index(name), *place])


@dataclass(frozen=True, eq=False, slots=True)
class Faces:
    """Faces of some people.

    Parameters
    ----------
    pictures : (n, rows, columns)
        Grey values, 0 to 1.
    people, times : (n,)
        Whose each is, strangers from ``PEOPLE`` on, and which picture of that person.
    missed
        Share of the pictures in which no face was found.
    """

    pictures: Float[np.ndarray, "n rows columns"]
    people: Int[np.ndarray, " n"]
    times: Int[np.ndarray, " n"]
    missed: float

    def part(self, who: range, when: range) -> tuple[Float[np.ndarray, "m rows columns"], list]:
        """Return the pictures of some people at some times, and their names."""
        of = np.isin(self.people, who) & np.isin(self.times, when)
        return self.pictures[of], [f"person {k + 1}" for k in self.people[of]]


@lru_cache(maxsize=8)
def faces(seed: int) -> tuple[Faces, Faces]:
    """Return faces of ten people and of strangers: as detected, and the same cut out exactly."""
    rng = np.random.default_rng(seed)
    framed: tuple[list, list] = [], []
    missed = total = 0
    for k in range(PEOPLE + STRANGERS):
        who = person(1000 * seed + k)
        for time in range(ENROLLED + LATER if k < PEOPLE else LATER):
            one = look(rng, who)
            boxes = DETECTOR.find(one.image)
            hit = found(boxes, one.box)
            total, missed = total + 1, missed + (hit is None)
            if hit is not None:
                framed[0].append((cut(one.image, boxes[hit]), k, time))
            framed[1].append((cut(one.image, one.box), k, time))
    parts = [[np.array(part) for part in zip(*some, strict=True)] for some in framed]
    return Faces(*parts[0], missed / total), Faces(*parts[1], 0.0)


def scored(
    known: Faces, who: range, count: int, names: np.random.Generator | None = None
) -> tuple[float, float, float, float]:
    """Enrol some people and return the four ``SHARES``; shuffle their names if told to.

    Who was found less than twice at enrolment cannot be enrolled, and is not recognised later.
    Where faces were missed there are fewer pictures, and so many eigenimages less two at most.
    """
    pictures, whose = known.part(who, range(ENROLLED))
    enough = [whose.count(name) > 1 for name in whose]
    pictures, whose = pictures[enough], [n for n, one in zip(whose, enough, strict=True) if one]
    if names is not None:
        names.shuffle(whose)
    space = enrol(pictures, whose, min(count, len(pictures) - 2))
    later, true = known.part(who, range(ENROLLED, ENROLLED + LATER))
    seen = [space.recognise(face) for face in later]
    others = known.part(range(PEOPLE, PEOPLE + STRANGERS), range(LATER))[0]
    mean = np.mean([np.sqrt(((face - space.mean) ** 2).mean()) for face in later])
    return (
        float(np.mean([one.nearest == name for one, name in zip(seen, true, strict=True)])),
        float(np.mean([one.name == name for one, name in zip(seen, true, strict=True)])),
        float(np.mean([space.recognise(face).name is not None for face in others])),
        float(np.mean([one.from_space for one in seen]) / mean),
    )


def groups(case: str) -> list[range]:
    """Return who is enrolled together."""
    if case == CASES[0]:
        return [range(k, k + FEW) for k in range(0, PEOPLE - FEW + 1, FEW)]
    return [range(PEOPLE)]


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Enrol each gallery with each number of eigenimages, and ask who comes."""

    def task(seed: int, rng: np.random.Generator) -> tuple:
        detected, exact = faces(seed)
        names = rng if config.shuffled else None
        rows = [
            [
                np.mean([scored(exact if case == CASES[2] else detected, who, n, names)
                         for who in groups(case)], axis=0)
                for n in config.counts
            ]
            for case in config.cases
        ]  # fmt: skip
        return np.moveaxis(np.array(rows), -1, 0), detected.missed

    seeds = SCORED[: config.galleries]
    shares, missed = zip(*sweep(task, seeds, rng=rng, desc="galleries"), strict=True)
    return Result(config, np.array(shares), np.array(missed))


galleries = Study(run, full=Config(), quick=Config(2, (2, EIGENIMAGES)), seed=2)
GOOD = Accepted(
    0.9, 1.0, "“good results”, says the paper, without a number; nine in ten is our reading",
    Origin.CHOICE,
)  # fmt: skip


def by_count(result: Result) -> Table:
    """Return the shares among three people by the number of eigenimages."""
    words = {
        "right": "share of new pictures whose nearest in the gallery is of the same person",
        "known": "accepted by the thresholds and rightly named",
        "strangers": "of people who are not in the gallery, accepted",
        "left": "what the eigenimages leave of a new face, of what the mean face leaves",
    }
    rows = {f"{n}": [result.of(name, n) for name in words] for n in result.config.counts}
    about = f"three people; 95 % over {len(result.missed)} worlds of three galleries each"
    return Table(rows, words, about, "eigenimages")


@galleries.claim(
    "eigenfaces",
    paper=PAPER,
    place="§III",
    basis="substitute",
    statement="With 20 eigenimages faces that the detector has cut out are recognised well.",
    paper_value="“good results and acceptable processing times for eigenspaces created with 20 "
    "eigenimages”",
    method="Galleries of three rendered people, seven pictures each, cut out by the detector; the "
    "share of three more of each whose nearest in the gallery is of the same person. Mean over "
    "galleries; bootstrap over worlds of ten people, of which three galleries are made.",
    accepted=GOOD,
    sabotage=Change("names of the gallery that are shuffled", shuffled=True),
)
def eigenfaces(result: Result) -> Finding:
    """Compare three people with ten, and tell who is let in."""
    few, many, exact = (result.of("right", case=case) for case in CASES)
    return Finding(
        few,
        {
            "ten people": many,
            "ten people, cut out exactly": exact,
            "two eigenimages": result.of("right", 2),
            "known people accepted": result.of("known"),
            "strangers accepted": result.of("strangers"),
            "pictures without a detection": bootstrap_mean(result.missed),
        },
        tables={"counts": by_count(result)} if len(result.config.counts) > 2 else {},
        conditions=(Condition.judged("few people are known: three, not ten", GOOD, outside=many),),
    )


GALLERY = CHOOSING[4]
"""The gallery that the page shows: the first in which no picture was without a detection."""


@lru_cache(maxsize=2)
def shown() -> tuple[Faces, Faces]:
    """Return the gallery that the page shows."""
    return faces(GALLERY)
