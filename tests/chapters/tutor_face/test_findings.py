"""What the chapter tells a reader to find, beyond what its explorer asserts itself."""

import numpy as np
import pytest
from scipy.stats import fisher_exact

from robot_perception.book import tutor_face as tutor


def test_a_looser_limit_lets_in_whoever_passed_a_tighter_one():
    limits = {}
    for setting in tutor.ask.parameters():
        most = tutor.ask.state(**setting).most
        limits.setdefault((setting["who"], setting["count"]), []).append(most)
    assert all((np.diff(row) >= 0).all() for row in limits.values())


def test_presets_show_what_the_page_says():
    ask = tutor.ask
    named = {name: ask.state(**ask.default | values) for name, values in ask.presets.items()}
    assert named["a stranger"].named is not None
    assert named["a stranger, half accepted"].most < named["a stranger"].most
    face = named["one eigenimage"].face
    off = [np.abs(named[n].rebuilt - face).mean() for n in ("one eigenimage", "five eigenimages")]
    assert off[0] > off[1]


def test_words_name_who_comes_and_whom_he_is_taken_for():
    setting = {"who": "a stranger", "count": 20, "accepted": 0.95}
    state, words = tutor.asked(**setting), tutor.ask.described(**setting)
    assert state.true is None
    assert "a stranger" in words
    assert words.endswith(f"tutor {state.named + 1}.")


def test_a_face_is_asked_for_that_the_gallery_does_not_hold():
    face = tutor.asked("the first tutor", 20, 0.95).face
    learnt, _ = tutor.part(tutor.faces(tutor.GALLERY), range(3), range(tutor.ENROLLED))
    assert np.abs(learnt - face).max(axis=(1, 2)).min() > 0.05
    assert tutor.tutors(20).mean == pytest.approx(learnt.mean(axis=0))


def test_no_face_is_missed_in_the_world_that_the_page_shows():
    every = tutor.PEOPLE * (tutor.ENROLLED + tutor.LATER) + tutor.STRANGERS * tutor.LATER
    assert len(tutor.faces(tutor.GALLERY)) == every


def test_the_hero_knows_one_of_two():
    names = tutor.two_people().names
    assert sorted(name is None for name in names) == [False, True]
    assert "person 1" in names


def test_the_film_bridges_its_misses_and_its_window_grows_in_them():
    steps = tutor.track(tutor.CHOOSING[1], "short", frames=90)
    gaps = [step for step in steps if tutor.at_face(step.whole, step.truth) is None]
    assert len(gaps) >= 10
    assert np.mean([tutor.near(step.box, step.truth) for step in gaps]) > 0.7
    share = np.array([step.searched for step in steps[1:]])
    missed = np.array([step.missed for step in steps[1:]])
    assert share[missed].mean() > 1.2 * share[~missed].mean()


# What the text says of the rows


def test_strangers_pass_and_more_eigenimages_show_more_of_a_face():
    table = tutor.by_count(tutor.recognised.rows())
    assert table["20", "strangers"].low > 0.2
    left = [table[count, "left"].estimate for count in table.rows]
    assert left == sorted(left, reverse=True)


def test_light_from_the_side_decides_and_not_which_people():
    rows = tutor.enrolled.rows()
    even, other, side = (tutor.known_right(rows, light) for light in tutor.LIGHTS)
    assert side.high < min(even.low, other.low)
    let_in = [tutor.strangers_in(rows, light) for light in tutor.LIGHTS]
    assert max(let_in[0].high, let_in[1].high) < let_in[2].low
    few = tutor.by_light(rows)
    assert [row[0] for row in few.rows.values()] == [20, 8, 8]


def test_the_detector_looks_at_less_than_a_third_of_the_picture():
    assert tutor.bridged.rows().mean("searched", scene="short").high < 1 / 3


def test_who_began_the_link_has_it_more_often_verified_than_with_the_nearest_face():
    rows = tutor.linked.rows()
    verified, near, told = (
        rows.mean("has", rule=rule) for rule in ("verified", "nearest", "verified, told")
    )
    assert near.estimate < verified.low
    assert verified.high < told.low
    assert rows.rate("alone", rule="nearest").high < 0.5


def test_only_the_darkest_faces_are_found_less_often():
    frontal = tutor.detected.rows().where(turn=0)
    found = [frontal.of("found", tone=tone) for tone in range(6)]
    assert all(of.all() for of in found[:-1])
    dark, others = found[-1], sum(len(of) for of in found[:-1])
    assert fisher_exact([[dark.sum(), (~dark).sum()], [others, 0]]).pvalue < 0.001


def test_many_walking_particles_lose_the_face_more_often_than_few_that_are_steered():
    rows = tutor.steered.rows()
    steered, plain, _, alone = (rows.mean("lost", filter=name) for name in tutor.FILTERS)
    more = rows.difference("lost", ("filter", tuple(tutor.FILTERS)[2], "I-Condensation"))
    assert more.low > 0
    assert alone.high < plain.low
    assert alone.estimate > steered.estimate
