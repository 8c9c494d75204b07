"""More than five frames: what the rule of stable tracks does to the map."""

from collections.abc import Mapping

import numpy as np

from robot_perception.chapters.visual_slam import frontend
from robot_perception.chapters.visual_slam.drives import Options
from robot_perception.chapters.visual_slam.frontend import Seen
from robot_perception.chapters.visual_slam.maps import (
    PAPER,
    Account,
    Config,
    Filter,
    mean,
    ratio,
    run,
    table,
)
from robot_perception.geometry import se3
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted


def rules(*frames: int) -> tuple[Filter, ...]:
    """Return filters by the least number of frames of a track; paper: more than 5; 0: no rule."""
    return tuple(Filter(f"more than {n}" if n else "none", Options(stable=n)) for n in frames)


STABLE = Study(
    run,
    full=Config(rules(0, 2, 5, 10), 1),
    quick=Config(rules(0, 5), 1, frontend.FEW[:3], frames=120),
    seed=45,
)


@STABLE.claim(
    "stable-landmarks",
    paper=PAPER,
    place="§5",
    basis="substitute",
    statement="With only those points in the map that were tracked for more than five frames, it "
    "holds far fewer landmarks.",
    paper_value="about 1500, against about 100 000 of Sim et al. (2005)",
    method="Twenty rendered buildings, ten particles: landmarks with the "
    "rule over those without, interval over the buildings.",
    accepted=Accepted(0.0, 0.5, "at most half as many", "our choice"),
    sabotage=Change("only points that stay in sight for more than five frames", lasting=5),
)
def stable_landmarks(found: Mapping[str, Account]) -> Finding:
    """Count the landmarks with and without the rule."""
    five, none = found["more than 5"], found["none"]
    return Finding(
        ratio(five.landmarks, none.landmarks, "landmarks"),
        {
            "landmarks with the rule": mean(five.landmarks),
            "landmarks without": mean(none.landmarks),
            "ATE, with over without": ratio(five.path, none.path),
        },
        {"rules": table(found, ("landmarks", "ATE (m)", "wrong"), "frames")},
        note=f"{five.landmarks.mean():.0f} landmarks in place of {none.landmarks.mean():.0f}.",
    )


DEEP = 0.1
"""A depth is wrong where it errs by more than this share; ours."""


def wrong_depths(seen: Seen) -> tuple[float, float]:
    """Return the share of wrong depths among points of one frame, and among stable tracks."""
    T = se3.compose(se3.from_se2(seen.poses), frontend.RIG.T_robot_camera)[seen.frames]
    depths = np.einsum("ni,ni->n", T[:, :3, 2], seen.places - T[:, :3, 3])
    wrong = np.abs(seen.points[:, 2] / depths - 1) > DEEP
    lengths = np.bincount(seen.tracks)[seen.tracks]
    return float(wrong[lengths == 1].mean()), float(wrong[lengths > Options().stable].mean())
