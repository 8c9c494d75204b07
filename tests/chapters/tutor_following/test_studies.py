"""The studies: worlds, trackers and the robot, and what they count, by law."""

import json

import numpy as np
import pytest

from data_synth.companion.walks import REGION
from robot_perception.chapters.tutor_following import (
    following,
    interacting,
    raising,
    training,
    visiting,
    walking,
)
from robot_perception.chapters.tutor_following.scene import FACES, at, hands, shot
from robot_perception.companion.hands.cascade import Goals
from robot_perception.companion.robot import BODY, CompanionRobot
from robot_perception.files import DamagedFile

RNG = np.random.default_rng


def test_the_square_of_a_shot_is_where_the_detector_has_the_hand():
    some = [shot(RNG(k)) for k in range(16)]
    hits = [at(hands().find(one.grey), one.hand).any() for one in some]
    assert sum(hits) >= 11


def test_a_hand_that_is_down_has_no_square_and_nothing_is_at_it():
    one = shot(RNG(3), raised=0.0)
    assert np.isnan(one.hand).all()
    assert not at(np.array([[10.0, 10, 20, 20]]), one.hand).any()
    assert at(np.zeros((0, 4)), one.face).shape == (0,)


def test_a_detection_is_at_a_hand_that_it_overlaps():
    truth = np.array([10.0, 10, 20, 20])
    boxes = np.array([[10.0, 10, 20, 20], [12, 11, 20, 20], [40, 10, 20, 20]])
    assert at(boxes, truth).tolist() == [True, True, False]


def test_rates_are_of_their_tilt_and_alarms_are_what_is_at_no_hand():
    found = np.array([[1.0, 0], [1, 1], [0, 0]])
    config = raising.Config(3, (0, 15), ("fist",))
    tones = np.array([0, 0, 5])
    result = raising.Result(config, found, np.ones((3, 1)), found * 0, found, tones)
    assert result.rate(0).estimate == pytest.approx(2 / 3)
    assert result.rate(15).estimate == pytest.approx(1 / 3)
    assert raising.by_tone(result)["1", "hand"].estimate == 1
    assert raising.by_tone(result)["6", "people"] == 1
    assert raising.by_gesture(result)["fist", "taken"].estimate == 1


def test_a_person_is_held_by_the_last_pictures():
    overlaps = np.array([[0.9] * 80 + [0.1] * 10, [0.0] * 79 + [0.5] * 11])
    assert walking.locked(overlaps).tolist() == [False, True]


def test_gains_are_differences_on_the_same_films():
    held = np.array([[[True, False]], [[True, True]], [[False, False]]])
    ways = ("several, gated", "one patch, adapting")
    config = following.Config((1, 2, 3), 40, ("none",), ways)
    result = following.Result(config, held)
    assert result.gain(*ways, "none").estimate == pytest.approx(1 / 3)
    assert result.share(ways[0], "none").estimate == pytest.approx(2 / 3)


def test_trackers_of_one_film_are_the_same_alone_and_together():
    ways = ("one patch, fixed", "several, fixed")
    both = walking.tracked(100, "none", ways, 40)
    alone = walking.overlaps(walking.WAYS[ways[1]], walking.film(100, "none", 40), 100)
    np.testing.assert_array_equal(both[1], alone)
    assert both[:, 0].min() > 0.7


def test_the_light_falls_to_a_third_on_the_way_and_stays_otherwise():
    dark, steady = (walking.film(101, name, 40).light for name in ("darker", "none"))
    assert dark[0] == pytest.approx(1)
    assert 0.2 < dark[-1].mean() < 0.4
    assert dark[-1, 0] > dark[-1, 2]
    assert (np.diff(dark[:, 0]) <= 0).all()
    assert (steady == 1).all()


def test_the_robot_of_the_chapter_is_that_of_the_room_with_its_numbers():
    """The world's people are as large as the room takes them to be."""
    robot = visiting.robot(visiting.Kind())
    usual = CompanionRobot(lambda grey, box: None, hands())
    assert robot.tracker.rules == usual.tracker.rules
    assert robot.rules == usual.rules
    assert (robot.faces.scale, robot.faces.neighbours) == (
        usual.faces.scale,
        usual.faces.neighbours,
    )
    assert (REGION[2] - REGION[0], REGION[3] - REGION[1]) == BODY
    assert not visiting.robot(visiting.Kind(fresh=False)).rules.fresh


def test_a_robot_that_is_told_knows_the_tutor_by_his_place():
    face = np.array([100.0, 60, 30, 30])
    told = visiting.recogniser(100, True, face)
    grey = np.zeros((240, 320), np.uint8)
    assert told(grey, np.array([102.0, 61, 30, 30])) == "tutor 1"
    assert told(grey, np.array([160.0, 60, 30, 30])) is None
    assert visiting.recogniser(100, True, visiting.NOTHING)(grey, face) is None


def test_orders_after_the_first_that_is_not_obeyed_are_not_given():
    config = interacting.Config((1, 2))
    orders = ("a stranger's hand", "tutor", "hand above", "walks")
    given = np.array([[1, 1, 1, 1], [1, 0, 0, 0.0]])
    obeyed = np.array([[1, 1, 1, 0], [0, 0, 0, 0.0]])
    result = interacting.Result(config, orders, given, obeyed)
    assert result.share().estimate == 0.5
    assert result.whole().estimate == 0
    assert result.reached("tutor").estimate == 1
    assert result.table()["walks", "given"] == 1


def test_enrolment_is_of_three_tutors_and_knows_the_first():
    known = visiting.gallery(100)
    assert [known.names.count(name) for name in known.people] == [visiting.PORTRAITS] * 3
    assert FACES.neighbours == 2


@pytest.fixture(scope="module")
def small():
    return training.trained(training.BRIEF, RNG(1))


def test_training_is_the_same_twice_and_meets_its_goals(small):
    again = training.trained(training.BRIEF, RNG(1))
    assert again.cascade.to_plain() == small.cascade.to_plain()
    for report in small.stages:
        assert report.detection >= Goals().detection
        assert report.false_alarms <= 0.5 or report.features == training.BRIEF.goals.most


def test_a_stored_detector_is_read_as_it_was(small, tmp_path):
    file = tmp_path / "hand.json"
    training.write(small, file)
    back = training.read(file)
    assert back.cascade.to_plain() == small.cascade.to_plain()
    assert len(back.stages) == len(small.stages)


def test_the_detector_of_the_book_has_met_its_goals():
    stored = training.stored()
    assert len(stored.cascade.stages) == training.GOALS.stages
    for report in stored.stages:
        assert report.detection >= training.GOALS.detection
        assert report.false_alarms <= training.GOALS.false_alarms


@pytest.mark.parametrize("change", [{"version": 2}, {"training": [{"features": 3}]}])
def test_another_version_or_a_damaged_model_is_named(small, tmp_path, change):
    file = tmp_path / "hand.json"
    training.write(small, file)
    file.write_text(json.dumps(json.loads(file.read_text()) | change))
    with pytest.raises(DamagedFile, match=r"hand\.json"):
        training.read(file)


def test_no_model_is_named(tmp_path):
    with pytest.raises((DamagedFile, OSError)):
        training.read(tmp_path / "none.json")
