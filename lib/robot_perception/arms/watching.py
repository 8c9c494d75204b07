r"""A watch over tracked arms: each is told to be lost by its own likelihood, and may start anew.

Where an arm is lost its silhouette and its patches lie on something else. As far as that fits less
well than the arm does where it is held, and goes on doing so, the likelihood tells. The logarithm
of an arm's likelihood at the estimate, :math:`\ell_t`, is averaged over the last pictures,

.. math:: L_t = (1 - \kappa) L_{t-1} + \kappa \, \ell_t, \qquad L_0 = \ell_0,

and the arm is taken to be lost while :math:`L_t` lies below a level under which it seldom falls
where an arm is held. Where a lost arm lies on a trunk or a sleeve it may fit as well as held arms
of other people do, and nothing is noticed. The paper has nothing of the kind.
"""

from dataclasses import dataclass, replace
from typing import Annotated, final

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from robot_perception import checks
from robot_perception.arms.likelihoods import Bodies, Look, apart, look
from robot_perception.arms.tracker import ArmInfo, ArmState, ArmTracker
from robot_perception.beliefs import ParticleSet
from robot_perception.fields import Share, at_least, checked
from robot_perception.particles import systematic

__all__ = ["ArmWatch", "WatchInfo", "WatchState", "arm_logs"]

Image = UInt8[np.ndarray, "height width 3"]


@final
@dataclass(frozen=True, eq=False, slots=True)
class WatchState:
    """State of a watch over two arms.

    Parameters
    ----------
    arms
        State of the tracker.
    level : (2,)
        L, the averaged logarithm of each arm's likelihood.
    lost : (2,)
        For how many pictures each arm has been taken to be lost.
    """

    arms: ArmState
    level: Float[np.ndarray, "2"]
    lost: Annotated[Int[np.ndarray, "2"], at_least(0)]
    __post_init__ = checked


@final
@dataclass(frozen=True, eq=False, slots=True)
class WatchInfo:
    """Diagnostics of one step of a watch.

    Parameters
    ----------
    arms
        Those of the tracker.
    level : (2,)
        L, the averaged logarithm of each arm's likelihood.
    lost : (2,)
        Whether each arm is taken to be lost.
    """

    arms: ArmInfo
    level: Float[np.ndarray, "2"]
    lost: Bool[np.ndarray, "2"]


@final
@dataclass(frozen=True, eq=False, slots=True)
class ArmWatch:
    r"""Tracker of both arms that tells which of them it has lost.

    Nothing of the tracker changes unless it is asked to draw lost arms anew: then a share of the
    particles of such an arm is drawn, before the next picture, over all poses that its joints
    allow. Each picture's edges and flow are computed twice, by the tracker and by the watch.

    Parameters
    ----------
    tracker
        That follows the arms.
    level
        Below it L tells a lost arm. The number is for all of `CUES`: of rendered films that are not
        scored, L lies below it in a twentieth of the pictures in which an arm is held. Other cues
        need another one, found in the same way.
    newest
        κ, the weight of the newest picture.
    anew
        Share of the particles of a lost arm that are drawn anew in each picture; none by default.

    Raises
    ------
    ValueError
        If a share is not from 0 to 1.
    """

    tracker: ArmTracker
    level: float = -8.7
    newest: Share = 0.15
    anew: Share = 0.0
    __post_init__ = checked

    def start(
        self,
        image: Image,
        *,
        rng: np.random.Generator,
        face: Float[np.ndarray, "4"] | None = None,
        pose: Float[np.ndarray, "8"] | None = None,
    ) -> WatchState:
        """Return what is known after the first picture.

        Parameters and errors are those of `ArmTracker.start`.
        """
        arms = self.tracker.start(image, rng=rng, face=face, pose=pose)
        return WatchState(arms, arm_logs(arms, arms.first.seen), np.zeros(2, dtype=int))

    def step(
        self,
        state: WatchState,
        image: Image,
        *,
        rng: np.random.Generator,
        face: Float[np.ndarray, "4"] | None = None,
    ) -> tuple[WatchState, WatchInfo]:
        """Return what is known after a picture, and which arms are taken to be lost.

        Parameters and errors are those of `ArmTracker.step`.
        """
        checks.instance("state", state, WatchState)
        checks.generator("rng", rng)
        before = state.arms
        if self.anew and state.lost.any():
            before = replace(before, particles=self._anew(before, state.lost > 0, rng))
        arms, info = self.tracker.step(before, image, rng=rng, face=face)
        seen = look(image, before.grey, self.tracker.rules.edges)
        level = (1 - self.newest) * state.level + self.newest * arm_logs(arms, seen)
        lost = level < self.level
        after = WatchState(arms, level, np.where(lost, state.lost + 1, 0))
        return after, WatchInfo(info, level, lost)

    def _anew(
        self, arms: ArmState, lost: Bool[np.ndarray, "2"], rng: np.random.Generator
    ) -> ParticleSet:
        """Return particles of one weight, of which a share has lost arms anywhere."""
        count = len(arms.particles.states)
        states = arms.particles.states[systematic(arms.particles.weights, count, rng=rng)]
        low, high = arms.first.model.limits.T
        some = round(self.anew * count)
        for arm in np.flatnonzero(lost):
            own = slice(4 * arm, 4 * arm + 4)
            states[rng.permutation(count)[:some], own] = rng.uniform(low, high, (some, 4))
        return ParticleSet.uniform(states)


def arm_logs(arms: ArmState, seen: Look) -> Float[np.ndarray, "2"]:
    r"""Return the logarithm of the likelihood of each arm at the mean state, :math:`\ell_t`.

    Parameters
    ----------
    arms
        State of the tracker after a picture.
    seen
        What that picture says.
    """
    checks.instance("arms", arms, ArmState)
    bodies = Bodies(arms.first.model, arms.mean[None])
    return sum(apart(arms.cues, seen, bodies).values())[0]
