"""The lamps go out: which hypotheses are kept that only the sonars confirm?"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception.chapters.people_fusion import committee
from robot_perception.chapters.people_sensors import sessions
from robot_perception.chapters.people_sensors.sessions import (
    PAPER,
    QUICK,
    SENSORS,
    TEST,
    Config,
    Recording,
    own,
)
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, bootstrap_ratio
from robot_perception.evaluation.sweep import sweep
from robot_perception.geometry import wrap_angle
from robot_perception.people.aggregation import (
    AggregationInfo,
    AggregationRules,
    Aggregator,
    Hypotheses,
)
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Condition

HEARD = 2.0  # further away the sonars take nothing for a person, m
AFTER = (1.0, 2.0, 3.0, 5.0)  # when the camera might see again, s
SHORT, LONG = 2.0, 5.0
ENDS = ("with sonars", "with sonars that hear nothing", "without sonars")
OURS, LIBRARY = "rules of the committee", "rules of the library"
RULES = {OURS: committee.RULES, LIBRARY: AggregationRules()}
"""As chosen, and as the library has them: there a match of the sonars raises a weight by more than
the silence of the camera lowers it meanwhile."""


@dataclass(frozen=True, slots=True)
class Darkness:
    """Sessions, moments at which it gets dark (s), and by how much the sonars are turned, rad.

    People are followed who are then on one of the ``sides`` of the robot.

    Paper: sudden changes of the illumination, not said which, nor how long the tracker of skin
    colour takes to recover. Ours: the camera reports nothing from the moment on, as in the sessions
    ``rendered`` in which all lamps go out; we look what is left when it might see again.
    """

    sessions: tuple[Config, ...]
    moments: tuple[float, ...]
    rendered: tuple[Config, ...]
    sides: tuple[str, ...] = ("behind",)
    turned: float = 0.0


@dataclass(frozen=True, eq=False, slots=True)
class Kept:
    """What became of the n hypotheses of people that counted as persons when it got dark.

    There are the session, where the person was whose it is (m and rad), whether the person is still
    there after the times `AFTER`, and whether the hypothesis is then there and still theirs, at
    each of `ENDS`.
    """

    session: Int[np.ndarray, " n"]
    polar: Float[np.ndarray, "n 2"]
    there: Bool[np.ndarray, "n t"]
    kept: Bool[np.ndarray, "n e t"]

    def of(self, where: str, reach: float = HEARD) -> Bool[np.ndarray, " n"]:
        """Tell which are of people ``"ahead"`` or ``"behind"``, within reach, m."""
        ahead = np.abs(self.polar[:, 1]) <= np.pi / 2
        return (ahead == (where == "ahead")) & (self.polar[:, 0] < reach)

    def share(self, after: float, end: int, some: Bool[np.ndarray, " n"]) -> Interval:
        """Return the share that is kept after a while (s), of those whose person is there."""
        return self._mean(self.kept[:, end], after, some)

    def more(self, after: float, some: Bool[np.ndarray, " n"], than: int = 1) -> Interval:
        """Return how much larger the share kept is with sonars than at another one of `ENDS`."""
        return self._mean(self.kept[:, 0].astype(float) - self.kept[:, than], after, some)

    def _mean(self, values: np.ndarray, after: float, some: np.ndarray) -> Interval:
        t = AFTER.index(after)
        asked = some & self.there[:, t]
        rows = self.session[asked]
        count = np.bincount(rows)
        sums = np.bincount(rows, values[asked, t].astype(float))
        return bootstrap_ratio(sums[count > 0], count[count > 0].astype(float), "by session")


@dataclass(frozen=True, eq=False, slots=True)
class Dusk:
    """What is kept by rules, and in sessions rendered dark directions a picture, light and dark."""

    kept: dict[str, Kept]
    reported: Float[np.ndarray, "s 2"]


def silenced(recording: Recording, sensor: str, since: float) -> Recording:
    """Return a recording in which a sensor reports nobody from a time (s) on."""
    mute = (recording.sensors == SENSORS.index(sensor)) & (recording.times >= since)
    heard = ~np.repeat(mute, recording.counts)
    return replace(
        recording,
        counts=np.where(mute, 0, recording.counts),
        means=recording.means[heard],
        covs=recording.covs[heard],
    )


def turned_sonars(recording: Recording, by: float) -> Recording:
    """Return a recording in which the sonars hear as much in directions turned by an angle, rad."""
    mine = np.repeat(recording.sensors, recording.counts) == SENSORS.index("sonar")
    means = recording.means.copy()
    means[mine, 1] = wrap_angle(means[mine, 1] + by)
    return replace(recording, means=means)


def steps(
    recording: Recording, rows: Sequence[int], found: Hypotheses, rules: AggregationRules
) -> Iterator[tuple[int, Hypotheses, AggregationInfo]]:
    """Yield the reading, the hypotheses and what became of them, of a robot that stands."""
    for k in rows:
        found, info = Aggregator(rules).step(found, recording.found(k), np.zeros(3))
        yield k, found, info


def outlived(
    recording: Recording,
    story: Iterator[tuple[int, Hypotheses, AggregationInfo]],
    whose: Mapping[int, int],
    looked: Sequence[int],
) -> Bool[np.ndarray, "n t"]:
    """Return which hypotheses are there and still theirs at some of the judged readings.

    Who was made one with another one lives on in it.
    """
    now, kept = {name: name for name in whose}, np.zeros((len(whose), len(looked)), dtype=bool)
    asked = recording.judged[list(looked)].tolist()
    if not whose:
        return kept
    for k, found, info in story:
        for stays, gone in info.absorbed:
            now = {name: stays if one == gone else one for name, one in now.items()}
        now = {name: one for name, one in now.items() if one not in info.removed}
        if k in asked:
            t = asked.index(k)
            kept[:, t] = [
                name in now and theirs(recording, looked[t], person, found, now[name])
                for name, person in whose.items()
            ]
        if not now or k == asked[-1]:
            break
    return kept


def theirs(recording: Recording, row: int, person: int, found: Hypotheses, name: int) -> bool:
    """Tell whether a hypothesis is near a person, in the way that its covariance allows."""
    one, people = found.select(found.identity == name), recording.polar[row, [person]]
    apart = committee.ALL.apart(people, one.mean, np.sqrt(one.cov[:, 0, 0]))
    return bool((apart <= committee.REACH).all())


def darkened(
    recording: Recording,
    found: Hypotheses,
    rules: AggregationRules,
    moment: float,
    sides: Sequence[str],
) -> Kept:
    """Return what is kept of the hypotheses that at a moment (s) are those of people."""
    dark, heard = recording.times >= moment, recording.sensors != SENSORS.index("sonar")
    after = np.flatnonzero(dark).tolist()
    row = int(np.searchsorted(recording.judged_at, moment)) - 1
    persons, whose = found.select(found.weight > rules.person), {}
    for side in sides:
        seen = committee.frame(recording, row, persons, committee.View(side))
        i, j = own(seen.apart, committee.REACH)
        whose |= zip(seen.hypotheses_ids[j].tolist(), seen.people_ids[i].tolist(), strict=True)
    looked = looks(recording, moment)
    blind = silenced(recording, "camera", moment)
    ends = (
        (blind, after),
        (silenced(blind, "sonar", moment), after),
        (blind, np.flatnonzero(dark & heard).tolist()),
    )
    kept = [outlived(one, steps(one, rows, found, rules), whose, looked) for one, rows in ends]
    person = np.array(list(whose.values()), dtype=int)
    there = recording.present & (recording.polar[..., 0] < committee.FARTHEST)
    return Kept(
        np.zeros(len(person), dtype=int),
        recording.polar[row, person],
        there[np.ix_(looked, person)].T,
        np.stack(kept, axis=1),
    )


def looks(recording: Recording, moment: float) -> list[int]:
    """Return the judged readings of the laser next after the times `AFTER` from a moment, s."""
    laser = np.flatnonzero(recording.sensors[recording.judged] == SENSORS.index("laser"))
    at = np.searchsorted(recording.judged_at[laser], moment + np.array(AFTER))
    return laser[at].tolist()


def after_dark(config: Darkness, *, rng: np.random.Generator) -> Dusk:
    """Return what is kept in all sessions, by rules; nothing is drawn."""
    jobs = [(session, config) for session in config.sessions]
    done = sweep(_after_dark, jobs, rng=rng, desc="sessions")
    kept = {name: _joined([one[name] for one in done]) for name in RULES}
    return Dusk(kept, np.array([reported(session) for session in config.rendered]))


def _after_dark(job: tuple[Config, Darkness], *, rng: np.random.Generator) -> dict[str, list[Kept]]:
    session, config = job
    recording = turned_sonars(sessions.record(session), config.turned)
    return {
        name: nights(recording, rules, config.moments, config.sides)
        for name, rules in RULES.items()
    }


def nights(
    recording: Recording,
    rules: AggregationRules,
    moments: Sequence[float],
    sides: Sequence[str] = ("behind",),
) -> list[Kept]:
    """Return what is kept after each of some rising moments (s), the light being on until then."""
    found, begin, kept = Hypotheses.none(), 0, []
    for moment in moments:
        end = int(np.searchsorted(recording.times, moment))
        for _, after, _ in steps(recording, range(begin, end), found, rules):
            found = after
        kept.append(darkened(recording, found, rules, moment, sides))
        begin = end
    return kept


def _joined(parts: list[list[Kept]]) -> Kept:
    """Return as one what is kept at all moments of each session."""
    flat = [one for part in parts for one in part]
    counts = [sum(len(one.session) for one in part) for part in parts]
    names = ("polar", "there", "kept")
    columns = (np.concatenate([getattr(one, name) for one in flat]) for name in names)
    return Kept(np.repeat(np.arange(len(parts)), counts), *columns)


def reported(config: Config) -> tuple[float, float]:
    """Return how many directions a picture gives before and after the lamps go out."""
    recording = sessions.record(config)
    camera = recording.sensors == SENSORS.index("camera")
    dark = recording.times >= config.lights_out
    return tuple(float(recording.counts[camera & some].mean()) for some in (~dark, dark))


# The claim ---------------------------------------------------------------------------------------

NIGHTS = tuple(Config(seed) for seed in range(7401, 7441))
"""Sessions of their own: times, range and the rules of the condition were settled on others."""
RENDERED = tuple(Config(seed, 14.0, lights_out=8.0) for seed in TEST[:8])
STRONG = (
    "a match of the sonars raises a weight by more than the camera's silence lowers it meanwhile"
)
CLEARLY = Accepted(0.2, 1.0, "one hypothesis in five more", "our choice")


@Study(
    after_dark,
    Darkness(NIGHTS, (6.0, 12.0, 18.0, 24.0, 30.0), RENDERED, ("ahead", "behind")),
    Darkness(QUICK, (8.0, 16.0, 24.0), RENDERED[:2]),
    seed=68,
).claim(
    "sonar-keeps-alive",
    paper=PAPER,
    place="§4",
    basis="substitute",
    statement="When the light changes suddenly the sonars keep hypotheses of people behind the "
    "robot until the camera sees again.",
    paper_value="“preventing a precipitate extinction of hypotheses”; no number",
    method="The camera sees nothing from a moment on, as when all lamps go out. Of the people "
    f"within {HEARD:g} m behind the robot who had a hypothesis: share whose hypothesis is still "
    f"there and theirs {LONG:g} s later, by the {LIBRARY}, less that share if the sonars hear "
    "nothing.",
    accepted=CLEARLY,
    sabotage=Change("sonars that hear as much in the opposite direction", turned=np.pi),
    value=lambda dusk: dusk.kept[LIBRARY].more(LONG, dusk.kept[LIBRARY].of("behind")),
)
def sonar_keeps_alive(dusk: Dusk, value: Interval) -> Finding:
    """Compare what is kept behind and ahead, after shorter and longer times, by both rules."""
    ours, library = dusk.kept[OURS], dusk.kept[LIBRARY]
    behind, front = library.of("behind"), library.of("ahead")
    late, soon = (ours.more(after, ours.of("behind")) for after in (LONG, SHORT))
    return Finding(
        value,
        {
            f"after {LONG:g} s, {OURS}": late,
            f"after {SHORT:g} s, {OURS}": soon,
            "over a robot without sonars": library.more(LONG, behind, than=2),
            "at any distance": library.more(LONG, library.of("behind", np.inf)),
        }
        | ({"ahead": library.more(LONG, front)} if front.any() else {})
        | {
            f"directions a picture, in the {when}": bootstrap_mean(some)
            for when, some in zip(("light", "dark"), dusk.reported.T, strict=True)
        },
        {"kept": kept_table(dusk)},
        conditions=(Condition.judged(STRONG, CLEARLY, inside=value, outside=late),),
    )


def kept_table(dusk: Dusk) -> Table:
    """Return the shares kept behind the robot, by rules and sonars, after all times."""
    rows = {
        f"{rules}, {end}": tuple(kept.share(after, k, kept.of("behind")) for after in AFTER)
        for rules, kept in dusk.kept.items()
        for k, end in enumerate(ENDS)
    }
    about = "share of the hypotheses that are still there and theirs, 95 % bootstrap by session"
    return Table(rows, {f"{after:g} s": "after the light has gone" for after in AFTER}, about)
