"""Commands and observations that come with time stamps of their own, in one order."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float, Int

from robot_perception import checks

SLACK = 1e-6  # of a step: times of many digits are rounded
MOST_TICKS = 1e7


@dataclass(frozen=True, eq=False, slots=True)
class Held:
    """Pieces of time in each of which one command is in force.

    Parameters
    ----------
    commands : (pieces, d)
        In the units they were given in, for instance m/s and rad/s.
    durations : (pieces,)
        s, all positive.
    intervals : (pieces,)
        Which interval each piece is part of, from 0; every interval has a piece.

    Raises
    ------
    ValueError
        If shapes disagree, a number is not finite, a duration not positive, or an interval missing.
    """

    commands: Float[np.ndarray, "pieces d"]
    durations: Float[np.ndarray, " pieces"]
    intervals: Int[np.ndarray, " pieces"]

    def __post_init__(self) -> None:
        commands = checks.array("commands", self.commands, ("pieces", "d"))
        size, beside = (len(commands),), f"commands {commands.shape}"
        durations = checks.array("durations", self.durations, size, beside)
        if not (durations > 0).all():
            raise ValueError(f"durations must be positive, got {durations.min()}")
        intervals = checks.integers("intervals", self.intervals, size, beside=beside)
        rise = np.diff(intervals, prepend=0)
        if rise[:1].any() or not np.isin(rise, (0, 1)).all():
            raise ValueError(f"intervals must count up from 0, got {checks.shown(self.intervals)}")
        object.__setattr__(self, "commands", commands)
        object.__setattr__(self, "durations", durations)
        object.__setattr__(self, "intervals", intervals)


@dataclass(frozen=True, eq=False, slots=True)
class Merged:
    """Commands and observations in one order: move, observe, move, observe …

    Parameters
    ----------
    times : (k + 1,)
        When the first command begins to act, and the k moments of observation, s, rising.
    held
        The commands between them, in k intervals.
    rows
        For each moment the rows observed then.
    early, late, skipped
        Rows that are in none: not after the first command, after the last one, or in the pause
        after a moment.
    """

    times: Float[np.ndarray, " moments"]
    held: Held
    rows: tuple[slice, ...]
    early: int
    late: int
    skipped: int


def merge(
    times: Float[np.ndarray, " n"],
    commands: Float[np.ndarray, "n d"],
    observed: Float[np.ndarray, " m"],
    *,
    delay: float = 0.0,
    pause: float = 0.0,
) -> Merged:
    """Merge commands, each held until the next, with observations.

    Ties: observations of one time are one moment. A command acts from its time on, so that an
    observation at that time is made before it; of several commands of one time the last acts. An
    observation at the time of the first command is early, one at that of the last is used.

    Parameters
    ----------
    times : (n,)
        Of the commands, s, not falling.
    commands : (n, d)
        One at each of these times, for instance speed and turn rate.
    observed : (m,)
        Times of the observations on the same clock, s, not falling.
    delay
        Time from a command to its effect, s.
    pause
        Least time from one moment that is used to the next, s.

    Raises
    ------
    ValueError
        If shapes disagree, a time is not finite or falls, a command or the delay is not finite, the
        pause is negative, or no observation falls into the time of the commands.
    """
    times, observed = _stamps("times", times), _stamps("observed", observed)
    delay = checks.number("delay", delay)
    pause = checks.not_negative("pause", pause)
    if not times.size:
        raise ValueError("times must hold a command, got none")
    begin, end = times[[0, -1]] + delay
    early = int(np.searchsorted(observed, begin, side="right"))
    late = int(observed.size - np.searchsorted(observed, end, side="right"))
    moments = _apart(np.unique(observed[early : observed.size - late]), pause)
    if not moments.size:
        raise ValueError(
            f"no observation falls between {begin:.3f} and {end:.3f} s: of {observed.size} "
            f"{early} are early, {late} late (observed against times with a delay of {delay} s)"
        )
    low, high = (np.searchsorted(observed, moments, side=side) for side in ("left", "right"))
    stamps = np.concatenate([[begin], moments])
    cuts = np.clip(stamps - delay, times[0], times[-1])  # subtracting may round out of the log
    rows = tuple(slice(i, j) for i, j in zip(low.tolist(), high.tolist(), strict=True))
    skipped = int(observed.size - early - late - (high - low).sum())
    return Merged(stamps, hold(times, commands, cuts), rows, early, late, skipped)


def hold(
    times: Float[np.ndarray, " n"],
    commands: Float[np.ndarray, "n d"],
    cuts: Float[np.ndarray, " k"],
) -> Held:
    """Return the commands in force between given times, equal neighbours joined.

    Each command is held until the next, of several of one time the last. No piece reaches across a
    cut, so that what is observed there can be used at its own time.

    Parameters
    ----------
    times : (n,)
        Of the commands, s, not falling.
    commands : (n, d)
        One at each of these times.
    cuts : (k,)
        Rising times from the first of a command to the last, s.

    Raises
    ------
    ValueError
        If shapes disagree, a number is not finite, the cuts do not rise, or there is no command.
    """
    times = _stamps("times", times)
    commands = checks.array("commands", commands, (times.size, "d"), f"times {times.shape}")
    cuts = checks.array("cuts", cuts, finite=False)
    if cuts.ndim != 1 or cuts.size < 2 or not (np.diff(cuts) > 0).all():
        raise ValueError(f"cuts must be two or more rising times, got {checks.shown(cuts)}")
    if not times.size or cuts[0] < times[0] or cuts[-1] > times[-1]:
        known = f"from {times[0]:.3f} to {times[-1]:.3f} s" if times.size else "nowhere"
        wanted = f"from {cuts[0]:.3f} to {cuts[-1]:.3f} s, as the cuts want"
        raise ValueError(f"commands at these times are known {known}, not {wanted}")
    changes = np.any(np.diff(commands, axis=0) != 0, axis=1)
    changed = times[1:][changes]
    inside = changed[(changed > cuts[0]) & (changed < cuts[-1])]
    edges = np.union1d(inside, cuts)
    row = np.searchsorted(times, edges[:-1], side="right") - 1
    interval = np.searchsorted(cuts, edges[1:], side="left") - 1
    return Held(commands[row], np.diff(edges), interval)


def ticks(
    times: Float[np.ndarray, " n"], *, rate: float, longest_gap: float
) -> Float[np.ndarray, " k"]:
    """Return moments at a rate, as for the pictures of a film, but none in a gap between readings.

    Parameters
    ----------
    times : (n,)
        Of the readings, s, not falling, one at least.
    rate
        Moments in a second.
    longest_gap
        How long after a reading moments go on without another one, s.

    Returns
    -------
    (k,)
        s, rising, from the first reading to the last: so many at most as fit into the gaps of all
        readings, however far they are apart.

    Raises
    ------
    ValueError
        If times are not finite or fall, there is none, a number is not positive, or there would be
        more than 1e7 moments.
    """
    times, rate = _stamps("times", times), checks.positive("rate", rate)
    longest_gap = checks.positive("longest_gap", longest_gap)
    if not times.size:
        raise ValueError("times must hold a reading, got none")
    breaks = np.flatnonzero(np.diff(times) > longest_gap)
    begins = times[np.concatenate([[0], breaks + 1])]
    ends = np.append(times[breaks] + longest_gap, times[-1])
    counts = np.floor((ends - begins) * rate + SLACK) + 1
    if counts.sum() > MOST_TICKS:
        raise ValueError(f"rate must give {MOST_TICKS:g} moments at most, got {counts.sum():g}")
    return np.concatenate(
        [begin + np.arange(count) / rate for begin, count in zip(begins, counts, strict=True)]
    )


def _stamps(name: str, times: np.ndarray) -> np.ndarray:
    times = checks.array(name, times, ("n",))
    falls = np.flatnonzero(np.diff(times) < 0)
    if falls.size:
        raise ValueError(
            f"{name} must not fall, got {times[falls[0]]} before {times[falls[0] + 1]}"
        )
    return times


def _apart(times: np.ndarray, pause: float) -> np.ndarray:
    """Return the times that follow the last one returned by at least a pause."""
    kept: list[float] = []
    for time in times.tolist():
        if not kept or time - kept[-1] >= pause:
            kept.append(time)
    return np.array(kept)
