"""Limits of times, places and angles of a recording: numbers beyond are in another unit.

Times may be counted from 1970 or from anywhere else, but end before the year 2286 and span a week
at most. Ten readings and more follow each other, in the median, within half a minute and not within
10 µs; of fewer there is no telling. Places may be far from the origin of their map, as UTM
coordinates are, but not farther than 1e8 m.

Headings may be unwrapped, so that they go beyond one turn. Then each is near the one before; where
they are wrapped, within about a turn of it: a turn and a half, since known logs let headings pass π
a little before they wrap them. Degrees break that where they jump or wrap, or pass twenty turns
(126 rad), which a robot does only if it circles all day; and where headings beyond a turn are all
whole numbers, they were written in degrees. Degrees in small steps with decimals that stay below
126 cannot be told from radians.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from jaxtyping import Bool, Float

from robot_perception.checks import one_of

UNITS = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9}
"""Units of time, by what a second holds of them."""
NAMES = {"s": "seconds", "ms": "milliseconds", "us": "microseconds", "ns": "nanoseconds"}
LATEST = 1e10  # s since 1970
LONGEST = 7 * 86400.0  # s
STEPS = 1e-5, 30.0  # s, least and largest median
READINGS = 10  # from so many on the median is looked at
USUAL_STEP = 0.1  # s

FARTHEST = 1e8  # m
TURN = 2 * np.pi + 1e-3  # rad: a full turn of a sensor that counts in float32, too
MOST_TURNS, LARGEST_JUMP = 20, 1.5  # turns

Check = tuple[str, Callable[[np.ndarray], np.ndarray]]
"""Why rows of a table are bad, and which rows are, or which of their values."""


def per_second(time_unit: Any) -> int:
    """Return what a second holds of a unit of time, or raise ``ValueError``."""
    return UNITS[one_of("time_unit", time_unit, UNITS)]


def time_fault(times: Float[np.ndarray, "*k"], time_unit: str) -> str:
    """Return why numbers, in any order, are no times of a recording; nothing if they may be."""
    fault = _fault(times / UNITS[time_unit])
    if not fault:
        return ""
    unit = likely_unit(times)
    if not unit:
        return f"{fault}, which no recording does"
    return f"{fault}; these times look like {NAMES[unit]} (time_unit={unit!r})"


def likely_unit(times: Float[np.ndarray, "*k"]) -> str:
    """Return the unit in which numbers would most likely be times; nothing if in none."""
    units = [unit for unit in UNITS if not _fault(times / UNITS[unit])]
    return min(units, key=lambda unit: _strangeness(times / UNITS[unit]), default="")


def in_order(name: str, times: Float[np.ndarray, " k"]) -> Float[np.ndarray, " k"]:
    """Return times that never fall, or raise ``ValueError``."""
    falls = np.diff(times) < 0
    if falls.any():
        k = int(np.argmax(falls))
        raise ValueError(f"{name} must not fall, got {times[k]:.15g} before {times[k + 1]:.15g}")
    return times


def far_places(*columns: int) -> Check:
    """Return a check that the columns of a table are places in m."""
    columns = list(columns)
    return (
        f"a place lies beyond {FARTHEST:g} m: are these metres?",
        lambda rows: _beyond(rows, columns, FARTHEST),
    )


def wide_angles(*columns: int) -> Check:
    """Return a check that the columns of a table are angles within a turn, in rad."""
    columns = list(columns)
    return (
        "an angle is beyond a full turn: are these radians?",
        lambda rows: _beyond(rows, columns, TURN),
    )


def no_headings(column: int) -> tuple[Check, ...]:
    """Return checks that a column of a table holds the headings of one drive, in rad."""
    degrees = "are these degrees?"

    def jumps(rows: np.ndarray) -> Bool[np.ndarray, " rows"]:
        return np.abs(np.diff(rows[:, column], prepend=rows[:1, column])) > LARGEST_JUMP * TURN

    def winds(rows: np.ndarray) -> Bool[np.ndarray, " rows"]:
        return np.abs(rows[:, column]) > MOST_TURNS * TURN

    def counts(rows: np.ndarray) -> Bool[np.ndarray, " rows"]:
        whole = (rows[:, column] == np.round(rows[:, column])).all()
        return whole & (np.abs(rows[:, column]) > TURN)

    return (
        (f"its heading is {LARGEST_JUMP} turns or more from the one before: {degrees}", jumps),
        (f"its heading is beyond {MOST_TURNS} turns: {degrees}", winds),
        (f"its heading is beyond a turn, and all are whole numbers: {degrees}", counts),
    )


def _beyond(rows: np.ndarray, columns: list[int], most: float) -> Bool[np.ndarray, "rows _"]:
    """Return which values of some columns are larger than they can be."""
    bad = np.zeros(rows.shape, dtype=bool)
    bad[:, columns] = np.abs(rows[:, columns]) > most
    return bad


def _fault(times: Float[np.ndarray, "*k"]) -> str:
    farthest, span = np.abs(times).max(initial=0.0), np.ptp(times) if times.size else 0.0
    if span > LONGEST:
        return f"its {times.size} times span {span:g} s, more than a week"
    if farthest > LATEST:
        return f"its times reach {farthest:g} s"
    step = _median_step(times)
    if times.size >= READINGS and step and not STEPS[0] <= step <= STEPS[1]:
        return f"its {times.size} times are {step:g} s apart"
    return ""


def _median_step(times: Float[np.ndarray, "*k"]) -> float:
    """Return the median step between different times, 0 if all are the same."""
    steps = np.diff(np.unique(times))
    return float(np.median(steps)) if steps.size else 0.0


def _strangeness(times: Float[np.ndarray, "*k"]) -> float:
    step = _median_step(times)
    return abs(np.log10(step / USUAL_STEP)) if step else 0.0
