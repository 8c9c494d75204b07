"""How many of a tutor's orders are obeyed in whole visits, and how many visits have no fault."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.tutor_face.scene import CHOOSING, SCORED
from robot_perception.chapters.tutor_following.visiting import SHOULD, Kind, judged, obeyed, visit
from robot_perception.evaluation.intervals import Interval, proportion
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Condition, Origin

_USUAL = Kind()
PAPER = "companion-robot"
KNOWN = 2
"""The first orders, of a stranger who is not obeyed and of a tutor who is recognised, come before
those that a tutor gives."""


@dataclass(frozen=True, slots=True)
class Config:
    """Visits to the robot.

    Parameters
    ----------
    seeds
        Of people, halls and times.
    kind
        How they go.
    """

    seeds: tuple[int, ...] = SCORED[:40]
    kind: Kind = _USUAL


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Orders and what became of them.

    Parameters
    ----------
    config
        What was run.
    orders
        What is done in a visit, in turn.
    given, obeyed : (visits, orders)
        Whether the visit came to the order, and whether the robot obeyed.
    """

    config: Config
    orders: tuple[str, ...]
    given: Float[np.ndarray, "visits orders"]
    obeyed: Float[np.ndarray, "visits orders"]

    def share(self) -> Interval:
        """Return the share of the orders of recognised tutors that are obeyed, all together."""
        given, obeyed = (part[:, KNOWN:].sum() for part in (self.given, self.obeyed))
        return proportion(int(obeyed), int(given))

    def reached(self, what: str) -> Interval:
        """Return the share of those visits that came to an order in which it is obeyed."""
        k = self.orders.index(what)
        return proportion(int(self.obeyed[:, k].sum()), int(self.given[:, k].sum()))

    def whole(self) -> Interval:
        """Return the share of the visits in which every order is obeyed."""
        every = self.obeyed.all(axis=1)
        return proportion(int(every.sum()), len(every))

    def table(self) -> Table:
        """Return how often each order was given, and was followed by the state that it should be.

        After a stranger's hand that is to wait: the robot is right if it does not obey.
        """
        rows = {}
        for k, what in enumerate(self.orders):
            given, right = int(self.given[:, k].sum()), int(self.obeyed[:, k].sum())
            name = what if what not in rows else f"{what} again"
            rows[name] = [given, proportion(right, given) if given else "–", SHOULD[what][0]]
        columns = {
            "given": "visits",
            "right": "share of these in which the robot then is in the state; 95 %",
            "state": "in which it should be",
        }
        return Table(rows, columns, corner="the visitor")


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Run each visit."""

    def task(seed: int, rng: np.random.Generator) -> tuple[bool, ...]:
        return obeyed(seed, config.kind)

    done = sweep(task, config.seeds, rng=rng, desc="visits")
    first = visit(config.seeds[0], config.kind.brief)
    orders = tuple(order.what for order in judged(first, config.kind))
    given, kept = np.zeros((2, len(done), len(orders)))
    for k, row in enumerate(done):
        given[k, : len(row)], kept[k, : len(row)] = 1, row
    return Result(config, orders, given, kept)


_BRIEF = Kind(brief=True, told=True)
visits = Study(run, full=Config(), quick=Config(CHOOSING[:1], _BRIEF), seed=3)
named = Study(
    run, full=Config(SCORED[:20], Kind(told=True)), quick=Config(CHOOSING[:1], _BRIEF), seed=3
)
"""The same of a robot that is told whose each face is."""
NINE = Accepted(
    0.9, 1.0, "nine orders in ten; the paper names no number", Origin.CHOICE
)  # fmt: skip


@visits.claim(
    "interaction-states",
    paper=PAPER,
    place="§II, Fig. 2",
    basis="substitute",
    statement="States that detectors drive lead a robot through an interaction: the orders of its "
    "tutor are obeyed in turn.",
    paper_value="“The relative position of the detected hand and the head defines the transition”",
    method="Rendered visits in a hall, everything in a loop: faces are found and recognised, open "
    "hands found, the tutor followed by patches through a passer-by, and the robot drives. A "
    "stranger raises a hand first. Of the orders of tutors who were recognised, those that lead to "
    "their state; a visit ends at the first that does not.",
    accepted=NINE,
    sabotage=Change(
        "a hand that ends the following although it began it",
        kind=Kind(brief=True, told=True, fresh=False),
    ),
)
def interaction_states(result: Result) -> Finding:
    """Tell how many orders are obeyed, and how many visits go through."""
    whole = result.whole()
    if result.config.kind.brief:
        return Finding(result.share(), {"visits without a fault": whole})
    return Finding(
        result.share(),
        {
            "visits without a fault": whole,
            "without a fault where the robot is told whose a face is": named.result().whole(),
            "strangers who are not obeyed": result.reached("a stranger's hand"),
            "tutors who are recognised": result.reached("tutor"),
        },
        tables={"orders": result.table()},
        conditions=(
            Condition.judged("the tutor is recognised, and no stranger is", NINE, outside=whole),
        ),
    )
