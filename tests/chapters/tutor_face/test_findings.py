"""What the chapter tells a reader to find, in every state of its explorer."""

import numpy as np
import pytest
from scipy.stats import fisher_exact

from robot_perception.chapters.tutor_face import bets, views
from robot_perception.chapters.tutor_face.explorers import asked
from tests.chapters.findings import ExplorerTests
from tests.chapters.ledger import recorded


class TestExplorers(ExplorerTests):
    explorers = (asked,)


def states():
    return [(setting, asked.state(**setting)) for setting in asked.parameters()]


def test_with_ten_eigenimages_each_tutor_is_nearest_to_a_picture_of_his_own():
    tutors = [(s, of) for s, of in states() if of.true is not None and s["count"] >= 10]
    assert len(tutors) == 3 * 2 * 4
    assert all(of.distances.argmin() == of.true for _, of in tutors)


def test_a_looser_limit_lets_in_whoever_passed_a_tighter_one():
    limits = {}
    for setting, of in states():
        limits.setdefault((setting["who"], setting["count"]), []).append(of.most)
    assert all((np.diff(row) >= 0).all() for row in limits.values())


def test_presets_show_what_the_page_says():
    named = {name: asked.state(**{**asked.default, **v}) for name, v in asked.presets.items()}
    assert named["a stranger"].named is not None
    assert named["a stranger, half accepted"].most < named["a stranger"].most
    face = named["one eigenimage"].face
    off = [np.abs(named[n].rebuilt - face).mean() for n in ("one eigenimage", "five eigenimages")]
    assert off[0] > off[1]


def test_the_hero_knows_one_of_two():
    met = views.met()
    assert sorted(name is None for name in met.names) == [False, True]
    assert "person 1" in met.names


def test_the_film_bridges_its_misses_and_its_window_grows_in_them():
    _, seen = views.filmed()
    misses, held, _ = seen.bridged()
    assert misses >= 10
    assert held / misses > 0.7
    assert seen.share[seen.missed].mean() > 1.2 * seen.share[1:][~seen.missed[1:]].mean()


def test_the_right_answers_of_the_bets_are_what_is_recorded():
    assert bets.STRANGER["right"] == "some four in ten pass"
    passed = recorded()["eigenfaces"].evidence["strangers accepted"]
    assert 0.3 < passed.low < 0.4 < passed.high < 0.5
    assert bets.LAST["right"] == "there is no difference"
    table = recorded()["kalman-roi"].tables["held"]
    ours, last = (table[name, "short"] for name in table.rows)
    assert abs(ours.estimate - last.estimate) < 0.05


def test_only_the_darkest_faces_are_found_less_often():
    table = recorded()["face-detect"].tables["tones"]
    counts = [table[name, "people"] for name in table.rows]
    rates = [table[name, "found"] for name in table.rows]
    assert all(of.estimate == 1 for of in rates[:-1])
    found = round(counts[-1] * rates[-1].estimate)
    others = int(sum(counts[:-1]))
    beside = [[found, int(counts[-1]) - found], [others, 0]]
    assert fisher_exact(beside).pvalue < 0.001


def test_many_walking_particles_lose_the_face_more_often_than_few_that_are_steered():
    table = recorded()["icondensation-face"].tables["lost"]
    steered, plain, many, alone = (table[name, "lost"] for name in table.rows)
    assert many.low > steered.high
    assert alone.high < plain.low
    assert alone.estimate > steered.estimate


def test_words_name_who_comes_and_whom_he_is_taken_for():
    state = asked.state(who="a stranger", count=20, accepted=0.95)
    assert "a stranger" in state.words()
    assert state.words().endswith(f"tutor {state.named + 1}.")
    assert not state.right


def test_a_face_is_asked_for_that_the_gallery_does_not_hold():
    face = views.asked("the first tutor", 20, 0.95).face
    learnt = views.identifying.shown()[0].part(views.TUTORS, range(views.ENROLLED))[0]
    assert np.abs(learnt - face).max(axis=(1, 2)).min() > 0.05
    assert views.space(20).mean == pytest.approx(learnt.mean(axis=0))
