"""The lamps go out: how long do hypotheses live that only the sonars confirm?"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception.chapters.people_fusion import committee, sessions
from robot_perception.chapters.people_fusion.modalities import PAPER
from robot_perception.chapters.people_fusion.sessions import (
    SENSORS,
    TEST,
    TURNED,
    Config,
    Recording,
    own,
)
from robot_perception.evaluation.intervals import Interval, bootstrap_ratio
from robot_perception.evaluation.sweep import sweep
from robot_perception.geometry import wrap_angle
from robot_perception.people.aggregation import AggregationRules, Hypotheses, StepInfo, step
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted, Condition

DARK_AT, DURATION = 8.0, 14.0  # when the lamps go out, and how long a session takes, s
LONGEST = DURATION - DARK_AT  # that a hypothesis is followed, s
HEARD = 2.0  # further away the sonars take nothing for a person, m
SHORT, LONG = 2.0, 5.0  # after which the camera might see again, s
NOBODY = -1
AS_A_LASER = replace(committee.RULES.sensors["sonar"], alpha=committee.RULES.sensors["laser"].alpha)
TRUSTED = replace(committee.RULES, sensors={**committee.RULES.sensors, "sonar": AS_A_LASER})
"""A match of the sonars raises a weight as much as one of the laser."""
WITH, WITHOUT, STRONG = range(3)
ENDS = (
    (SENSORS, committee.RULES),
    (tuple(name for name in SENSORS if name != "sonar"), committee.RULES),
    (SENSORS, TRUSTED),
)
"""Who takes part from the moment on, by which rules: with sonars, without, and with strong ones."""


@dataclass(frozen=True, slots=True)
class Dark:
    """Sessions in which all lamps go out, and by how much the sonars' directions are turned, rad.

    Paper: sudden changes of the illumination, not said which, nor how long the tracker of skin
    colour takes to recover. Ours: all lamps out for good, so that it never does, and we look how
    many hypotheses are left when it might have.
    """

    sessions: tuple[Config, ...]
    turned: float = 0.0


@dataclass(frozen=True, eq=False, slots=True)
class Lives:
    """What became of n hypotheses that counted as persons when the lamps went out, in s sessions.

    There are the session, whose they are, or nobody's, where that person was (m and rad), after how
    long the person leaves, and how long the hypothesis lives in each of `ENDS`, s. ``glances``
    are how often a face looked at the camera, and how often it was found, before and after.
    """

    session: Int[np.ndarray, " n"]
    person: Int[np.ndarray, " n"]
    polar: Float[np.ndarray, "n 2"]
    leaves: Float[np.ndarray, " n"]
    life: Float[np.ndarray, "n 3"]
    glances: Float[np.ndarray, "s 2 2"]

    def of(self, where: str, reach: float = HEARD) -> Bool[np.ndarray, " n"]:
        """Tell which are of people ``"ahead"`` or ``"behind"`` within reach (m), or of nobody."""
        r, phi = self.polar.T
        ahead = np.abs(phi) <= np.pi / 2
        side = {"ahead": ahead, "behind": ~ahead}.get(where)
        return (
            self.person == NOBODY if side is None else (self.person != NOBODY) & side & (r < reach)
        )

    def mean(self, values: np.ndarray, some: Bool[np.ndarray, " n"], about: str = "") -> Interval:
        """Return the mean over some hypotheses, with an interval over the sessions that have any."""
        sums, count = self._sums(values, some), self._sums(some, some)
        return bootstrap_ratio(sums[count > 0], count[count > 0], about or "share, by session")

    def alive(self, after: float, end: int, some: Bool[np.ndarray, " n"]) -> Interval:
        """Return the share alive after a while (s), of those whose person is still there."""
        return self.mean(self.life[:, end] >= after, some & (self.leaves >= after))

    def saved(self, after: float, some: Bool[np.ndarray, " n"], end: int = WITH) -> Interval:
        """Return the share alive after a while (s), of those that are deleted without sonars."""
        return self.alive(after, end, some & (self.life[:, WITHOUT] < after))

    def longer(self, some: Bool[np.ndarray, " n"]) -> Interval:
        """Return the mean life with sonars over that without, while the person is there."""
        sums = (self._sums(self.lasted(end), some) for end in (WITH, WITHOUT))
        return bootstrap_ratio(*sums, "by session")

    def lasted(self, end: int) -> Float[np.ndarray, " n"]:
        """Return how long hypotheses live while the person is there, s."""
        return np.minimum(self.life[:, end], self.leaves)

    def _sums(self, values: np.ndarray, some: np.ndarray) -> Float[np.ndarray, " s"]:
        rows = self.session[some]
        return np.bincount(rows, values[some].astype(float), len(self.glances))


def turned_sonars(recording: Recording, by: float) -> Recording:
    """Return a recording in which the sonars hear as much in directions turned by an angle, rad."""
    mine = np.repeat(recording.sensors, recording.counts) == SENSORS.index("sonar")
    means = recording.means.copy()
    means[mine, 1] = wrap_angle(means[mine, 1] + by)
    return replace(recording, means=means)


def steps(
    recording: Recording, rows: Sequence[int], found: Hypotheses, rules: AggregationRules
) -> Iterator[tuple[float, Hypotheses, StepInfo]]:
    """Yield time (s), hypotheses and what became of them, of a robot that stands."""
    for k in rows:
        found, info = step(found, recording.found(k), np.zeros(3), rules)
        yield float(recording.times[k]), found, info


def lives(
    names: Sequence[int], story: Iterator[tuple[float, Hypotheses, StepInfo]]
) -> Float[np.ndarray, " n"]:
    """Return how long after the moment hypotheses are deleted, s; one made one with it lives on."""
    now, ends = {name: name for name in names}, dict.fromkeys(names, LONGEST)
    for time, _, info in story:
        for kept, gone in info.absorbed:
            now = {name: kept if one == gone else one for name, one in now.items()}
        for name in [name for name, one in now.items() if one in info.removed]:
            ends[name] = time - DARK_AT
            del now[name]
    return np.array([ends[name] for name in names])


def outlive(config: Config, turned: float = 0.0) -> Lives:
    """Return what becomes of the hypotheses of one session."""
    recording = turned_sonars(sessions.record(config), turned)
    dark = recording.times >= DARK_AT
    *_, (_, found, _) = steps(
        recording, np.flatnonzero(~dark).tolist(), Hypotheses.none(), committee.RULES
    )
    row = int(np.searchsorted(recording.judged_at, DARK_AT)) - 1
    persons = found.select(found.weight > committee.RULES.person)
    scene = committee.frame(recording, row, persons, committee.ALL)
    i, j = own(scene.apart, committee.REACH)
    person = np.full(len(scene.hypotheses), NOBODY)
    person[j] = scene.people_ids[i]
    ends = []
    for sensors, rules in ENDS:
        taken = np.isin(recording.sensors, [SENSORS.index(name) for name in sensors])
        story = steps(recording, np.flatnonzero(dark & taken).tolist(), found, rules)
        ends.append(lives(scene.hypotheses_ids.tolist(), story))
    there = recording.present & (recording.polar[..., 0] < committee.FARTHEST)
    away = ~there & (recording.judged_at >= DARK_AT)[:, None]
    leaves = np.where(away, recording.judged_at[:, None] - DARK_AT, LONGEST).min(axis=0)
    return Lives(
        np.zeros(len(person), dtype=int),
        person,
        recording.polar[row, person],
        np.where(person == NOBODY, LONGEST, leaves[person]),
        np.stack(ends, axis=-1),
        glances(recording)[None],
    )


def glances(recording: Recording) -> Float[np.ndarray, "2 2"]:
    """Return how often a face in view looked at the camera, and was found, before and after."""
    sums = np.zeros((2, 2))
    for row in np.flatnonzero(recording.sensors[recording.judged] == SENSORS.index("camera")):
        face = recording.present[row] & recording.clear[row] & (recording.gaze[row] > TURNED)
        people = recording.polar[row, face & (recording.polar[row, :, 0] < committee.FARTHEST), 1]
        seen = recording.found(int(recording.judged[row])).positions.mean[:, 1]
        hit = np.abs(wrap_angle(people[:, None] - seen)) < committee.TURN
        sums[int(recording.judged_at[row] >= DARK_AT)] += len(people), hit.any(axis=1).sum()
    return sums


def outlive_all(config: Dark, *, rng: np.random.Generator) -> Lives:
    """Return what becomes of the hypotheses of all sessions; nothing is drawn."""
    jobs = [(session, config.turned) for session in config.sessions]
    parts = sweep(_outlived, jobs, rng=rng, desc="sessions")
    whole = {
        name: np.concatenate([getattr(part, name) for part in parts])
        for name in ("person", "polar", "leaves", "life", "glances")
    }
    return Lives(np.repeat(np.arange(len(parts)), [len(part.person) for part in parts]), **whole)


def _outlived(job: tuple[Config, float], *, rng: np.random.Generator) -> Lives:
    return outlive(*job)


# The claim ---------------------------------------------------------------------------------------

DARKENED = tuple(Config(seed, DURATION, lights_out=DARK_AT) for seed in TEST)
SOON = f"the camera sees again within {SHORT:g} s"
MOSTLY = Accepted(0.5, 1.0, "more often than not", "our choice")


@Study(outlive_all, Dark(DARKENED), Dark(DARKENED[:16]), seed=68).claim(
    "sonar-keeps-alive",
    paper=PAPER,
    place="§4",
    basis="substitute",
    statement="The sonars keep hypotheses behind the robot alive until the camera sees again, when "
    "the light changes suddenly.",
    paper_value="“preventing a precipitate extinction of hypotheses”; no number",
    method="All lamps go out in a session. Of the hypotheses of people within 2 m behind the robot "
    f"that are deleted within {LONG:g} s without sonars: share that is alive then with them, "
    "from the same hypotheses on.",
    accepted=MOSTLY,
    sabotage=Change("sonars that hear as much in the opposite direction", turned=np.pi),
    value=lambda found: found.saved(LONG, found.of("behind")),
)
def sonar_keeps_alive(found: Lives, value: Interval) -> Finding:
    """Compare how long hypotheses live, behind and ahead, near and far, of people and of nobody."""
    near, soon = found.of("behind"), found.saved(SHORT, found.of("behind"))
    groups = {
        "behind": near,
        "behind, at any distance": found.of("behind", np.inf),
        "ahead": found.of("ahead"),
        "of nobody": found.of("nobody"),
    }
    ends = {"with sonars": WITH, "without": WITHOUT, "with sonars as strong as the laser": STRONG}
    before, after = found.glances.transpose(1, 2, 0)
    return Finding(
        value,
        {f"saved after {SHORT:g} s": soon}
        | {f"life {name} (s)": found.mean(found.lasted(k), near, "s") for name, k in ends.items()}
        | {f"life with over without, {name}": found.longer(some) for name, some in groups.items()}
        | {f"saved after {LONG:g} s, as strong as the laser": found.saved(LONG, near, STRONG)}
        | {
            f"faces found {when}": bootstrap_ratio(hit, asked, "by session")
            for when, (asked, hit) in (("in the light", before), ("in the dark", after))
        },
        conditions=(Condition.judged(SOON, MOSTLY, inside=soon, outside=value),),
    )
