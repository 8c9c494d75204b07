"""Fig. 7: the study of the building, and its maps."""

import numpy as np
import pytest

from robot_perception.chapters.loop_closing import building
from robot_perception.chapters.loop_closing import figures as draw
from robot_perception.chapters.loop_closing.loops import Case
from robot_perception.teaching.figures import figure

RNG = np.random.default_rng
FEW = (Case("plain", association="known"), Case("anchored"), Case("external", "small"))


@pytest.fixture(scope="module")
def study():
    return building.run(building.Config(seeds=2, cases=FEW), rng=RNG(0))


# The building


def test_a_seed_does_not_depend_on_how_many_there_are(study):
    one = building.run(building.Config(seeds=1, cases=FEW[:1]), rng=RNG(0))
    np.testing.assert_array_equal(one.runs[FEW[0]].errors[0], study.runs[FEW[0]].errors[0])
    assert not np.allclose(study.runs[FEW[0]].errors[1], study.runs[FEW[0]].errors[0])


def test_landmarks_of_the_scans_are_true_ones(study):
    number, none = study.sightings
    assert number > 2
    assert none < 0.005


def test_known_names_are_never_wrong_and_leave_no_landmark_twice(study):
    known = study.runs[FEW[0]]
    assert not known.false.any()
    assert not known.twice.any()
    assert (known.map_shape <= known.map_error + 1e-12).all()  # a motion can only improve


def test_the_start_is_out_of_sight_before_and_in_sight_at_the_end(study):
    poses = study.config.world[1]
    here, reach = poses[study.config.before, :2], study.config.scanner.max_range
    assert np.hypot(*here) > reach
    assert np.hypot(*(poses[-1, :2] - poses[int(8 / 0.2), :2])) < 0.2
    way = study.config.step * study.config.before
    assert 70 < way < 80


def test_closing_the_loop_with_known_names_makes_the_error_small(study):
    plain = study.runs[FEW[0]]
    assert (plain.distance() < plain.distance(study.config.before) / 5).all()


@pytest.mark.parametrize("given", ["a sensor of the position", "nothing"])
def test_readings_of_a_good_path_lie_on_the_plan(given):
    made = building.built(given, every=40, beams=12)
    gaps = _distance(made.readings, made.faces)
    assert (np.median(gaps) < 0.15) == (given != "nothing")
    _, ax = figure()
    draw.built_map.on(ax, made)
    assert f"{made.off:.2f} m off" in ax.get_title(loc="left")
    assert f"{made.twice} landmarks twice" in ax.get_title(loc="left")


def test_set_up_says_what_is_driven():
    rows = building.setup_table().rows
    assert rows["floor, loop"][1] == f"{building.Config().world[0].area:.0f} m², 88 m"
    assert rows["drives"][1] == str(building.Config().seeds)


def _distance(points, faces):
    along = faces[:, 1] - faces[:, 0]
    arm = points[:, None] - faces[:, 0]
    share = ((arm * along).sum(axis=-1) / (along**2).sum(axis=-1)).clip(0, 1)
    return np.linalg.norm(arm - share[..., None] * along, axis=-1).min(axis=1)
