"""Figs 8 and 9: ways of people, and hypotheses that stay where they are and are discarded."""

from collections.abc import Sequence

import numpy as np

from robot_perception.chapters.people_fusion import committee
from robot_perception.chapters.people_fusion.modalities import PAPER, configs
from robot_perception.chapters.people_fusion.rates import table
from robot_perception.chapters.people_fusion.sessions import Config
from robot_perception.evaluation.intervals import bootstrap_ratio
from robot_perception.people.trajectories import Trajectory, trajectories
from robot_perception.teaching.claims import Finding, Size, claim
from robot_perception.teaching.verdicts import Accepted

VIEWS = tuple(
    committee.View(discard=discard, after=committee.STATIC.longest) for discard in (False, True)
)
"""With all hypotheses, and without static ones; before that time none can be static."""


def ways(run: committee.Tracked) -> tuple[Trajectory, ...]:
    """Return the ways of all persons of a session in the world, by identity."""
    poses = run.recording.poses[run.recording.judged[run.rows]]
    return trajectories(run.persons, poses)


def before_and_after(chosen: Sequence[Config]) -> dict[str, committee.Rates]:
    """Return the rates with all hypotheses, and without those that stayed too long."""
    found = committee.compare({"": committee.System()}, chosen, VIEWS)[""]
    return dict(zip(("all", "static ones discarded"), found, strict=True))


def _finding(before: committee.Rates, after: committee.Rates) -> Finding:
    false = [1 - rates.matched / np.maximum(rates.hypotheses, 1) for rates in (before, after)]
    kept = bootstrap_ratio(after.matched, before.matched, "by session")
    return Finding(
        bootstrap_ratio(false[1], false[0], "share of false hypotheses, after over before"),
        {"false before": before.false, "false after": after.false, "people kept": kept},
        {"discarding": table({"all": before, "static ones discarded": after}, "hypotheses")},
    )


@claim(
    "trajectories",
    paper=PAPER,
    place="§4.1",
    basis="substitute",
    statement="To discard hypotheses that have not moved for long reduces the false ones.",
    paper_value="“longtime immovable hypotheses can be discarded”; no number",
    method="The rendered sessions after their first 20 s: share of false hypotheses without those "
    "that stayed within 0.4 m for over 20 s, over the share with all.",
    accepted=Accepted(0.0, 0.9, "at least a tenth of the share disappears", "our choice"),
    seed=67,
)
def static_discarded(size: Size, rng: np.random.Generator) -> Finding:
    """Compare the share of false hypotheses before and after."""
    found = before_and_after(configs(size))
    return _finding(found["all"], found["static ones discarded"])


@static_discarded.sabotage("as many hypotheses discarded, but drawn at random")
def at_random(size: Size, rng: np.random.Generator) -> Finding:
    """Discard at random as many of each session's hypotheses as were static."""
    runs = [committee.tracked(config) for config in configs(size)]
    mixed = []
    for run in runs:
        flat = rng.permutation(np.concatenate(run.static))
        ends = np.cumsum([len(some) for some in run.static])[:-1]
        static = tuple(np.split(flat, ends))
        mixed.append(committee.Tracked(run.recording, run.rows, run.persons, static))
    before, after = (
        committee.rates([committee.frames(run, view) for run in mixed], view) for view in VIEWS
    )
    return _finding(before, after)
