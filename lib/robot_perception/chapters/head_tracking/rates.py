"""How fast to adapt, and above which score: overlap against a of eq. (29) and the threshold."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from robot_perception.appearance.segmentation import filled
from robot_perception.chapters.head_tracking import heads
from robot_perception.evaluation.sweep import sweep

LIGHT_ALONE = heads.Config(others=0, turns=False)
"""Sequences in which nothing but the light makes it hard: nobody passes, and no back is seen."""


@dataclass(frozen=True, slots=True)
class Config:
    """Values of both, all ours: the paper gives no number and calls the threshold empirical.

    Parameters
    ----------
    rates
        a of eq. (29); 0 is the fixed model.
    gates
        Scores from which the model is adapted.
    films
        Sequences, by `heads.Config`; its variants are not used.
    """

    rates: tuple[float, ...] = (0.0, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5)
    gates: tuple[float, ...] = (0.0, 0.4, 0.5, 0.6, 0.7, 0.8)
    films: heads.Config = LIGHT_ALONE


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Means over the images in which the head is visible, by sequence.

    Parameters
    ----------
    rates : (rates,)
        a.
    gates : (gates,)
        Thresholds.
    iou, off, said : (rates, gates, sequences)
        Overlap; share of the images in which it is below ``heads.OFF``; share in which the tracker
        says it has lost the head.
    """

    rates: Float[np.ndarray, " rates"]
    gates: Float[np.ndarray, " gates"]
    iou: Float[np.ndarray, "rates gates sequences"]
    off: Float[np.ndarray, "rates gates sequences"]
    said: Float[np.ndarray, "rates gates sequences"]


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Follow the head of every sequence with every pair of values."""
    found = np.array(sweep(_Task(config), config.films.seeds, rng=rng, desc="rates and gates"))
    iou, off, said = np.moveaxis(found, 0, -1)
    return Result(np.array(config.rates), np.array(config.gates), iou, off, said)


@dataclass(frozen=True, slots=True)
class _Task:
    config: Config

    def __call__(self, seed: int, *, rng: np.random.Generator) -> np.ndarray:
        """Return the three means (3, rates, gates) of a sequence."""
        film = heads.film(self.config.films, seed)
        truth = np.array([filled(outline, film.masks.shape[1:]) for outline in film.outlines])
        first = heads.start(film.frames[0], film.ellipses[0])
        half_widths = heads.sizes(film, self.config.films.depth_sigma, rng)
        seen = film.visible >= heads.SEEN
        found = np.empty((3, len(self.config.rates), len(self.config.gates)))
        for i, rate in enumerate(self.config.rates):
            for j, gate in enumerate(self.config.gates):
                if rate == 0 and j > 0:  # nothing is adapted, whatever the gate
                    found[:, i, j] = found[:, i, 0]
                    continue
                variant = heads.Variant(replace(heads.RULES, rate=rate, gate=gate))
                track = heads.follow(film.frames, first, variant, half_widths)
                iou = heads.overlaps(track, truth)[seen]
                found[:, i, j] = iou.mean(), (iou < heads.OFF).mean(), track.lost[seen].mean()
        return found
