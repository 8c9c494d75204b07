"""What splitting extracts of a scan: its straight parts, which the floor plan knows."""

from dataclasses import dataclass
from functools import partial

import numpy as np
from jaxtyping import Float, Int

from data_synth.laser import Scanner, scan
from data_synth.office import drive, make_office
from robot_perception import walls
from robot_perception.chapters.walls.splitting import (
    Simplify,
    heights,
    reference_vertices,
    split,
    to_chain,
)
from robot_perception.evaluation.intervals import Interval, exact, mean
from robot_perception.evaluation.sweep import sweep
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted, Condition

EXACT = Scanner(range_sigma=0.0, resolution=1e-6, spot=0.0, dropout=0.0)
NOISY = Scanner(resolution=0.0)
"""Scanners without and with noise, mixed pixels and lost readings.

Without noise the two ends of a wall can be equally far from a chord. Readings to the micrometre
settle such ties alike on every processor.
"""


@dataclass(frozen=True, slots=True)
class Config:
    """Scans of drives through offices. The paper gives none of these values: all are ours.

    How many drives; tolerances ε, m, of which ``chosen`` is the chapter's; shares of their readings
    that a part and the chord that extracts it must have in common, of which the first is the
    claim's; distance between scans, m; fewest readings and least length, m, of a straight part;
    which vertex splits, a name of `SPLITS`.
    """

    drives: int = 12
    tolerances: tuple[float, ...] = (0.015, 0.03, 0.045, 0.08, 0.3, 0.8)
    chosen: float = 0.08
    commons: tuple[float, ...] = (0.5, 0.8, 0.9)
    step: float = 1.0
    least_readings: int = 6
    least_length: float = 0.4
    split: str = "farthest"


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """What became of the straight parts of the scans of each drive.

    Share of the parts that a chord extracts; share of the scans whose vertices at the chosen
    tolerance are those of the brute-force simplification; how many parts and scans there are.
    """

    config: Config
    extracted: Float[np.ndarray, "drives tolerances commons"]
    agree: Float[np.ndarray, " drives"]
    parts: int
    scans: int

    def share(self, tolerance: float, common: float) -> Interval:
        """Return the share of the parts that is extracted, over drives."""
        place = self.config.tolerances.index(tolerance), self.config.commons.index(common)
        return mean(self.extracted[:, *place])


SPLITS: dict[str, Simplify] = {
    "farthest": walls.simplify,
    "middle": lambda chain, tolerance: split(chain, tolerance, heights, lambda far: far.size // 2),
}
"""How chains are simplified, by the vertex that splits."""


def run(config: Config, scanner: Scanner = NOISY, *, rng: np.random.Generator) -> Result:
    """Simplify the scans of drives, each through an office of its own, and look for their parts."""
    rows = sweep(partial(_of_drive, scanner), [config] * config.drives, rng=rng, desc="drives")
    extracted, agree, parts, scans = zip(*rows, strict=True)
    return Result(config, np.array(extracted), np.array(agree), sum(parts), sum(scans))


def straight_parts(
    chain: Float[np.ndarray, "n 2"], faces: Int[np.ndarray, " n"], config: Config
) -> Int[np.ndarray, "parts 2"]:
    """Return the ends of each long enough run of readings on one face (-1: on none or on two)."""
    starts = np.flatnonzero(np.r_[True, faces[1:] != faces[:-1]])
    parts = np.stack([starts, np.r_[starts[1:], len(faces)] - 1], axis=-1)
    long = _readings(parts) >= config.least_readings
    long &= np.linalg.norm(chain[parts[:, 1]] - chain[parts[:, 0]], axis=-1) >= config.least_length
    return parts[long & (faces[starts] >= 0)]


def overlaps(
    parts: Int[np.ndarray, "parts 2"], kept: Int[np.ndarray, " kept"]
) -> Float[np.ndarray, " parts"]:
    """Return the largest share of the readings of both that a part has in common with a chord.

    Of the readings at its ends a chord has the first, and the last one only if no other begins
    there. So above one half no other chord has as much of the part, and no other part of the chord.
    """
    chords = np.stack([kept[:-1], kept[1:] - 1], axis=-1)
    chords[-1, 1] += 1
    first = np.maximum(parts[:, None, 0], chords[:, 0])
    shared = np.minimum(parts[:, None, 1], chords[:, 1]) - first + 1
    return (shared / np.maximum(_readings(parts)[:, None], _readings(chords))).max(axis=1)


def _readings(stretches: np.ndarray) -> np.ndarray:
    return stretches[:, 1] - stretches[:, 0] + 1


def _of_drive(
    scanner: Scanner, config: Config, *, rng: np.random.Generator
) -> tuple[np.ndarray, float, int, int]:
    office = make_office(rng=rng)
    scans = scan(office.faces, drive(office, step=config.step), scanner, rng=rng)
    on = np.where(scans.mixed, -1, scans.faces)
    simplify, common, agree = SPLITS[config.split], [], []
    for ranges, faces in zip(scans.ranges, on, strict=True):
        chain = to_chain(ranges, scanner)
        parts = straight_parts(chain, faces[np.isfinite(ranges)], config)
        kept = {e: np.asarray(simplify(chain, e)) for e in config.tolerances}
        common.append([overlaps(parts, vertices) for vertices in kept.values()])
        reference = reference_vertices(chain, config.chosen)
        agree.append(kept[config.chosen].tolist() == reference)
    shares = np.concatenate(common, axis=1)[..., None] > np.array(config.commons)
    return shares.mean(axis=1), float(np.mean(agree)), shares.shape[1], len(agree)


COLUMNS = {
    "exact readings": "without noise, to the micrometre: share of the straight parts that has more "
    "than half of its readings in common with one chord, and that chord with it",
    "noise of 1.5 cm": "the same with noise, mixed pixels and lost readings",
    "the same, four fifths": "more than four fifths in common",
}


def twice(config: Config, *, rng: np.random.Generator) -> tuple[Result, Result]:
    """Scan the same offices without noise and with it."""
    seed = int(rng.integers(2**32))
    clean, noisy = (
        run(config, scanner, rng=np.random.default_rng(seed)) for scanner in (EXACT, NOISY)
    )
    return clean, noisy


extracting = Study(twice, full=Config(), quick=Config(drives=4, step=6.0))


@extracting.claim(
    "dp-recursive",
    paper="perception-issues",
    place="§2.1, Tables 1 and 2",
    basis="substitute",  # scans of our own offices
    statement="Splitting a chain at the vertex farthest from its chord, again and again, "
    "extracts its straight parts.",
    method="share of the straight parts of noisy simulated scans, known from the floor plan, that "
    "have more than half of their readings in common with one chord, and that chord with them",
    accepted=Accepted(
        0.9,
        1.0,
        "nine parts of ten; above one half of the readings in common, a part has one chord at "
        "most and a chord one part",
        "our choice",
    ),
    sabotage=[
        Change(
            "a split at the middle vertex in place of the farthest",
            config=Config(drives=3, step=8.0, tolerances=(0.08,), split="middle"),
        ),
        Change(
            "a third of the tolerance, so that noise splits the walls",
            config=Config(drives=3, step=8.0, tolerances=(0.08 / 3,), chosen=0.08 / 3),
        ),
    ],
)
def dp_recursive(result: tuple[Result, Result]) -> Finding:
    """Look for the straight parts of scans with several tolerances, with and without noise."""
    clean, noisy = result
    config, drives = noisy.config, noisy.config.drives
    most, more, all_but = config.commons
    rows = {
        f"{100 * e:g} cm, {e / NOISY.range_sigma:.0f}σ": [
            clean.share(e, most),
            noisy.share(e, most),
            noisy.share(e, more),
        ]
        for e in config.tolerances
    }
    evidence = {
        "the same if four fifths of the readings are asked for": noisy.share(config.chosen, more),
        "the same if nine tenths are asked for": noisy.share(config.chosen, all_but),
        "scans whose vertices are those of a brute-force simplification": exact(
            noisy.agree.mean(), about=f"of {noisy.scans}"
        ),
    }
    ends = (noisy.share(e, most) for e in (config.tolerances[0], config.tolerances[-1]))
    condition = Condition(
        "the tolerance is well above the noise and below the size of what is to be seen",
        all(dp_recursive.accepted.excludes(share) for share in ends),
    )
    table = Table(rows, COLUMNS, f"mean and 95 % interval over {drives} drives", "tolerance ε")
    return Finding(
        noisy.share(config.chosen, most),
        evidence,
        {"straight parts extracted": table},
        (condition,),
        f"{noisy.parts:,} straight parts in {noisy.scans:,} scans, ε = {100 * config.chosen:g} cm.",
    )
