"""Eq. (2) as it is printed: sums by hand, and arms that are followed by it."""

import numpy as np
import pytest

from robot_perception.arms.body_model import REST
from robot_perception.arms.likelihoods import Bodies, EdgeRules, look
from robot_perception.arms.printed import FORMS, SumCue
from robot_perception.arms.tracker import CUES, ArmRules, ArmTracker
from tests.arms.test_likelihoods import CAMERA, MODEL
from tests.arms.test_tracker import FILM, followed, off

STATES = REST + np.array([[0.0] * 8, [0.4, 0, 0, 0, 0, 0.3, 0, 0.5]])
FAR = EdgeRules(most=1000.0)


def seen(before=None):
    grey = None if before is None else look(FILM.frames[before]).grey
    return look(FILM.frames[12], grey, FAR)


@pytest.mark.parametrize("gain", [None, 0.5])
def test_the_logarithm_is_that_of_the_visible_points_read_off_one_by_one(gain):
    """D = Σ min(I_DT, K I'_DT), with the nearest pixel of each point; nothing is cut."""
    picture, bodies = seen(10), Bodies(MODEL, STATES)
    assert picture.moves
    for k, state in enumerate(STATES):
        contours = MODEL.contours(state[None])
        distances = []
        for (u, v), visible in zip(contours.points[0], contours.visible[0], strict=True):
            if visible:
                at = int(np.floor(v + 0.5)), int(np.floor(u + 0.5))
                static, moving = picture.static[at], picture.moving[at]
                distances.append(static if gain is None else min(static, gain * moving))
        assert max(distances) > 5, "farther than ours are cut to"
        total, squares = sum(distances), sum(d**2 for d in distances)
        for form, wanted in (("square of the sum", total**2), ("sum of the squares", squares)):
            cue = SumCue(sigma=7.0, gain=gain, weight=0.3, form=form)
            assert cue(picture, bodies)[k] == pytest.approx(-0.3 * wanted / 98)


def test_the_paper_prints_the_square_of_the_sum():
    assert SumCue().form == "square of the sum" == next(iter(FORMS))
    assert SumCue().gain is None


def test_arms_are_followed_by_it():
    cues = {**CUES, "edges": lambda first: SumCue(sigma=180.0, gain=0.5)}
    rules = ArmRules(edges=EdgeRules(most=1000.0))
    state, infos = followed(ArmTracker(CAMERA, rules=rules, cues=cues))
    assert off(state) < 16
    assert infos[-1].logs["edges"] < 0


@pytest.mark.parametrize(
    ("wrong", "said"),
    [({"sigma": 0.0}, "sigma must be positive"), ({"gain": -1.0}, "gain must be positive"),
     ({"weight": -0.1}, "weight must not be negative"), ({"form": "mean"}, "form must be one of")],
)  # fmt: skip
def test_what_is_no_number_of_the_cue_is_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        SumCue(**wrong)
