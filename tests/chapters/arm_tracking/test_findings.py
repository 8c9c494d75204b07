"""What the chapter tells a reader to find, beyond what its explorers assert themselves."""

import numpy as np
import pytest

from robot_perception.arms.likelihoods import Bodies, apart, look, summed
from robot_perception.arms.tracker import ArmRules, ArmTracker
from robot_perception.book import arm_tracking as page
from robot_perception.particles import effective_number


def test_the_film_of_pointing_holds_both_arms():
    state = page.moment(page.POINTS, page.PLAIN, 16)
    assert state.held == 2
    assert np.ptp(state.sticks[:, 2, 1]) > 40, "one arm is lifted"


def test_the_factors_of_both_arms_are_the_likelihood_of_the_page():
    shown, state = page.begun()
    seen, bodies = look(shown.frames[1], state.grey), Bodies(state.first.model, shown.angles[:9])
    whole = sum(summed(state.cues, seen, bodies).values())
    parts = sum(apart(state.cues, seen, bodies).values())
    np.testing.assert_allclose(parts.sum(axis=1), whole, rtol=1e-10)


def test_more_particles_count_where_arms_are_drawn_apart():
    shown, start = page.begun()
    count = {}
    for name in ("auxiliary", "apart"):
        state, rng, each = start, np.random.default_rng(0), []
        for image in shown.frames[1:12]:
            state, info = ArmTracker(page.CAMERA, rules=ArmRules(filter=name)).step(
                state, image, rng=rng
            )
            each.append(info.effective)
        count[name] = np.mean(each)
    assert count["apart"] > 2 * count["auxiliary"]


def test_the_exercises_are_what_the_library_says():
    logs = page.LOGS
    ratio = effective_number(logs[:, 0]) / effective_number(logs.sum(axis=1))
    assert page.EXERCISES["arms-apart"].answer == pytest.approx(ratio)
    assert page.EXERCISES["arms-ray"].answer == pytest.approx(0.748, abs=1e-3)
