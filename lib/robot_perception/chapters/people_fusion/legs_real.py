"""Legs of real people that others marked: how many are found, and what else is taken for legs."""

import itertools
from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float
from scipy.optimize import linear_sum_assignment

from robot_perception import datasets
from robot_perception.datasets import LegScans
from robot_perception.evaluation.intervals import bootstrap_mean, proportion
from robot_perception.people import legs
from robot_perception.people.legs import LegRules
from robot_perception.teaching.tables import Table

MARKED = ("positive_1", "positive_2", "positive_3")
EMPTY = ("negative_2_left", "negative_2_right")
RULES = LegRules()
BOUNDS = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0])
NEAR = 0.2
"""A leg is found if one is reported within that of its mark, m; ours."""
THIRD = 3
"""Every third beam of the scanner of 0.35° gives about the paper's degree."""


@dataclass(frozen=True, eq=False, slots=True)
class Real:
    """What the detector makes of real scans.

    Parameters
    ----------
    distances, hits : (legs,)
        Of each marked leg: how far away, m, and whether it is found.
    persons : (scans,)
        Pairs of legs reported in scans without people.
    """

    distances: Float[np.ndarray, " legs"]
    hits: Bool[np.ndarray, " legs"]
    persons: Float[np.ndarray, " scans"]


def read(name: str) -> LegScans:
    """Return a recording of scans.

    Raises
    ------
    FileNotFoundError
        If it is not on this computer.
    """
    found = datasets.find("leg_scans", f"{name}.npz")
    if found is None:
        raise FileNotFoundError(f"the recording leg_scans/{name} is not on this computer")
    return datasets.read_leg_scans(found)


def run(every: int, rules: LegRules = RULES) -> Real:
    """Run the detector on real scans.

    Parameters
    ----------
    every
        Of so many beams one is used.
    rules
        What is taken for a leg.
    """
    distances, hits = [], []
    for scans in map(read, MARKED):
        angles = scans.angles[::every]
        for k in np.unique(scans.scans_of_legs):
            marked = scans.legs[scans.scans_of_legs == k]
            seen = legs.profiles(scans.ranges[k, ::every], angles, rules)
            hits.append(_hits(seen.middles[legs.are_legs(seen, rules)], marked))
            distances.append(np.hypot(*marked.T))
    persons = [
        len(legs.detect(ranges[::every], scans.angles[::every], rules).mean)
        for scans in map(read, EMPTY)
        for ranges in scans.ranges
    ]
    return Real(np.concatenate(distances), np.concatenate(hits), np.array(persons, dtype=float))


def table(results: dict[str, Real]) -> Table:
    """Return the share of marked legs found, by distance and by distance between beams."""
    rows = {}
    for low, high in itertools.pairwise(BOUNDS):
        cells = []
        for real in results.values():
            some = real.hits[(real.distances >= low) & (real.distances < high)]
            cells.append(proportion(int(some.sum()), some.size) if some.size else None)
        rows[f"{low:g} to {high:g} m"] = cells
    rows["persons in a scan of nobody"] = [bootstrap_mean(r.persons) for r in results.values()]
    columns = dict.fromkeys(results, "share of the marked legs that are found")
    return Table(rows, columns, "Wilson interval over legs", "distance")


def _hits(found: np.ndarray, marked: np.ndarray) -> Bool[np.ndarray, " legs"]:
    """Tell which marked legs are found, each by a leg of its own."""
    apart = np.hypot(*(marked[:, None] - found).transpose(2, 0, 1))
    row, column = linear_sum_assignment(np.minimum(apart, 1.0))
    hit = np.zeros(len(marked), dtype=bool)
    hit[row[apart[row, column] <= NEAR]] = True
    return hit
