"""The studies: peaks, maxima, sums, hidden poses, patches and pulls, by law."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from robot_perception.arms.body_model import REST, BodyModel
from robot_perception.arms.likelihoods import Bodies, EdgeCue, summed
from robot_perception.book import arm_likelihoods as page
from robot_perception.chapters.arm_likelihoods.scene import (
    AWAY,
    AWAYS,
    BEND,
    BENDS,
    CAMERA,
    CHOOSING,
    cues,
    derivative,
    glance,
    held_to_the_side,
    kinds,
    swept,
)
from studies.rows import Rows


def bump(at, height, wide=2.0):
    k, j = np.meshgrid(np.arange(len(AWAYS)), np.arange(len(BENDS)), indexing="ij")
    return height * np.exp(-((k - at[0]) ** 2 + (j - at[1]) ** 2) / (2 * wide**2))


def test_peaks_are_counted_and_compared():
    log = np.log(bump((8, 8), 1.0) + bump((25, 20), 0.4) + bump((25, 3), 0.01) + 1e-6)
    angles = np.zeros(8)
    angles[[AWAY, BEND]] = AWAYS[8] + np.radians(14.0), BENDS[8] - np.radians(14.0)
    found = page.peaks(log.ravel(), angles)
    assert found.count == 2
    assert found.second == pytest.approx(0.4, rel=0.01)
    assert found.there
    for axis in (AWAY, BEND):
        away = angles.copy()
        away[axis] += np.radians(30) * np.sign(angles[axis] - (AWAYS[8], BENDS[8])[axis == BEND])
        assert not page.peaks(log, away).there


def test_a_sharper_surface_has_its_highest_peak_where_it_was():
    log = np.log(bump((8, 8), 1.0) + bump((25, 20), 0.9) + 1e-6)
    angles = np.zeros(8)
    angles[[AWAY, BEND]] = AWAYS[8], BENDS[8]
    blunt, sharp = page.peaks(log, angles), page.peaks(9 * log, angles)
    assert blunt.there
    assert sharp.there
    assert sharp.second < 0.5 < blunt.second


def test_the_sweep_moves_two_angles_of_the_arm_on_the_left_only():
    states = swept(np.arange(8.0))
    assert states.shape == (len(AWAYS) * len(BENDS), 8)
    np.testing.assert_array_equal(states[:, [1, 2, 4, 5, 6, 7]],
                                  np.tile([1, 2, 4, 5, 6, 7], (len(states), 1)))  # fmt: skip
    assert len(np.unique(states[:, AWAY])) == len(AWAYS)
    np.testing.assert_array_equal(states[:, BEND].reshape(len(AWAYS), -1)[3], BENDS)


def test_a_mix_is_the_product_of_its_cues():
    shown = glance(CHOOSING[0], 10)
    logs = summed(cues(shown.first), shown.seen, Bodies(shown.model, swept(shown.angles)))
    every = page.surfaces(shown)
    assert set(every) == set(page.MIXES)
    np.testing.assert_allclose(
        every["all"], logs["shape and motion"] + logs["colour"] + logs["texture"]
    )
    np.testing.assert_allclose(every["shape, colour"], logs["shape"] + logs["colour"])


def test_who_stands_still_has_no_edge_that_moves():
    assert not glance(CHOOSING[0], 10, stops=True).seen.moves
    assert glance(CHOOSING[0], 10).seen.moves


def test_maxima_are_those_that_rise_enough():
    x = np.linspace(0, 6 * np.pi, 400)
    assert page.maxima(1 - np.cos(x)) == 3
    assert page.maxima(1 - np.cos(x) + 0.01 * np.sin(40 * x)) == 3
    assert page.maxima(np.linspace(0, 1, 50)) == 1, "the end of a slope counts"
    assert page.maxima(np.ones(50)) <= 1, "a score that is the same everywhere"


def test_scores_are_best_at_the_truth_of_a_clean_picture():
    shown = glance(CHOOSING[0])
    found = page.scores(shown)
    middle = len(page.FINE) // 2
    assert abs(int(found["distances"].argmax()) - middle) < 12
    assert ((found["edges"] >= 0) & (found["edges"] <= 1)).all()
    np.testing.assert_allclose(page.turned(shown)[middle], shown.angles, atol=1e-9)
    others = np.delete(page.turned(shown), AWAY, axis=1)
    assert (others == np.delete(shown.angles, AWAY)).all(), "one angle turns"


def test_costs_grow_as_their_form_says():
    times = np.array([1, 2, 4])
    rows = pd.DataFrame(
        {
            "person": np.repeat([1, 2], 6),
            "times": np.tile(np.repeat(times, 2), 2),
            "form": ["square of the sum", "sum of the squares"] * 6,
            "cost": np.tile(np.stack([times**2.0, times], axis=1).ravel(), 2),
        }
    )
    rows = Rows(rows, "person", {})
    assert page.growth(rows, "square of the sum").estimate == pytest.approx(2)
    assert page.growth(rows, "sum of the squares").estimate == pytest.approx(1)


def test_a_wrong_pose_costs_more_the_more_points_there_are():
    found = {times: page.grown.trial(person=CHOOSING[0], times=times) for times in (1, 2)}
    square, even = (found[2]["cost"] / found[1]["cost"])[[0, 2]]
    assert square == pytest.approx(4, rel=0.2)
    assert even == pytest.approx(1, rel=0.2)
    shown = glance(CHOOSING[0])
    wrong = shown.angles + np.radians(10) * np.eye(8)[AWAY]
    contours = shown.model.contours(wrong[None])
    far = page.sampled(shown.seen.static, contours, shown.seen.most)[contours.visible]
    np.testing.assert_allclose(found[1]["cost"][:2], [far.sum() ** 2 / 2, (far**2).sum() / 2])
    assert found[1]["wide"][0] < found[1]["wide"][2], "a sum of many distances is sharp"


def test_poses_are_possible_and_leave_the_other_arm_alone():
    shown = glance(CHOOSING[0])
    low, high = shown.model.limits.T
    states = page.arms(shown, low, high, 500, np.random.default_rng(0))
    assert 100 < len(states) <= 500
    np.testing.assert_array_equal(states[:, 4:], np.tile(shown.angles[4:], (len(states), 1)))
    assert not shown.model.collides(states).any()
    assert shown.model.possible(states).all()


def test_a_hidden_pose_is_compared_with_as_many_that_are_near():
    found = [page.hiding.but(close=close).trial(person=CHOOSING[2]) for close in (8.0, 0.01)]
    assert found[0]["cost"] == list(page.COSTS)
    assert (found[0]["hidden"] <= found[1]["hidden"]).all(), "fewer poses near the truth"


def test_distances_are_those_of_all_edges_without_a_gain_and_not_cut():
    shown = glance(CHOOSING[0], 10)
    contours = shown.model.contours(swept(shown.angles)[:50])
    plain, one, half = (page.distances(shown.seen, contours, K) for K in (None, 1.0, 0.25))
    np.testing.assert_allclose(plain, one)
    assert (half <= plain).all()
    assert (half < plain).any()
    assert plain.max() > shown.seen.most
    even = replace(shown.seen, moving=np.full_like(shown.seen.moving, 8.0))
    np.testing.assert_allclose(page.distances(even, contours, 0.25), np.minimum(plain, 2.0))
    far = replace(shown.seen, moving=np.full_like(shown.seen.moving, np.inf))
    np.testing.assert_array_equal(page.distances(far, contours, 0.25), plain)


def test_the_best_pose_is_the_one_with_the_least_sum():
    for person in CHOOSING[:4]:
        shown = glance(person, 40)
        contours = shown.model.contours(swept(shown.angles))
        far = page.distances(shown.seen, contours, 0.25)
        best = swept(shown.angles)[np.where(contours.visible, far, 0.0).sum(axis=1).argmin()]
        there = np.abs(best - shown.angles).max() <= page.NEAR
        assert page.moved.trial(person=person, passers=0)["moving"] == there


def test_a_gain_of_one_adds_nothing():
    found = page.moved.but(K=1.0).trial(person=CHOOSING[0], passers=0)
    assert found["still"] == found["moving"]
    assert set(found) == {
        "person",
        "passers",
        "still",
        "moving",
        "mean_still",
        "mean_moving",
        "mean_toll",
    }


def test_pairs_are_told_apart_by_what_is_alike():
    squared = np.array([[0.1, 0.2], [0.3, 0.4]])
    here = np.array([[True, True], [False, False]])
    assert page.chance(squared, here, ~here) == 1
    assert page.chance(squared, ~here, here) == 0
    assert page.chance(np.ones((2, 2)), here, ~here) == 0.5
    mixed = np.array([[True, False], [False, True]])
    assert page.chance(squared, mixed, ~mixed) == 0.5


def test_a_square_is_like_itself():
    shown = glance(CHOOSING[9])
    place = page.place_of(shown, shown.angles, [2, 3])
    assert shown.parts[int(place[1] + 0.5), int(place[0] + 0.5)] == 5, "on the hand"
    at = np.array([[page.COLUMNS[30], page.ROWS[25]]])
    squared = page.unlike(shown.image, page.histograms(shown.image, at))
    assert squared[25, 30] == pytest.approx(0, abs=1e-9)
    assert squared.shape == (len(page.ROWS), len(page.COLUMNS))
    assert squared.max() > 0.5


def test_a_patch_of_which_nothing_is_known_puts_itself_anywhere():
    shown = glance(CHOOSING[1])
    found = page.off_by_patch(shown)
    assert found.shape == (6,)
    assert ((found > 0) & (found < 1.3)).all()
    grey = replace(shown.seen, image=np.full_like(shown.image, 99),
                   grey=np.full_like(shown.seen.grey, 99))  # fmt: skip
    nothing = page.off_by_patch(replace(shown, seen=grey))
    assert (abs(nothing - 1) < abs(found - 1).max()).all()


def test_a_patch_before_its_own_colour_is_not_unlike_its_surroundings():
    shown = glance(CHOOSING[1])
    told = page.unlike_around(shown)
    assert ((told > 0) & (told <= 1)).all()


def test_kinds_of_patches_are_those_of_the_outfit():
    short = next(glance(k) for k in CHOOSING if glance(k).outfit.short)
    long = next(glance(k) for k in CHOOSING if not glance(k).outfit.short)
    assert kinds(short).count("bare forearm") == 2
    assert kinds(long).count("bare forearm") == 0
    assert kinds(short).count("hand") == kinds(long).count("hand") == 2
    for each in (short, long):
        plain = each.outfit.pattern == "plain"
        assert kinds(each)[0] == ("plain sleeve" if plain else "printed sleeve")


def test_a_forecast_is_correlated_over_sleeves_and_its_interval_counts_people():
    rng = np.random.default_rng(0)
    error = np.repeat(rng.normal(size=30), 6)
    table = pd.DataFrame(
        {"person": np.repeat(np.arange(30), 6), "counts": np.tile([1.0, 0.0], 90),
         "kind": ["plain sleeve", "hand"] * 90,
         "weight": np.where(np.tile([1, 0], 90), -error, error), "error": error}
    )  # fmt: skip
    rows = Rows(table, "person", {})
    assert page.foretold(rows, "weight").estimate == pytest.approx(-1)
    skewed = Rows(table.assign(weight=-np.exp(3 * table["error"])), "person", {})
    assert page.foretold(skewed, "weight").estimate == pytest.approx(-1), "of ranks"
    assert page.foretold(rows, "weight", kind="hand").estimate == pytest.approx(1)
    noisy = Rows(table.assign(weight=np.repeat(rng.normal(size=30), 6)), "person", {})
    once = Rows(noisy.table.drop_duplicates("person").assign(counts=1.0), "person", {})
    wide, alone = page.foretold(noisy, "weight"), page.foretold(once, "weight")
    assert wide.high - wide.low == pytest.approx(alone.high - alone.low, rel=0.1)


def test_contours_of_a_straight_arm_have_rank_three():
    model = BodyModel.from_face(np.array([145.0, 42.0, 30.0, 30.0]), CAMERA)
    straight, bent = (page.jacobian(model, held_to_the_side(bend)) for bend in (0.0, 0.4))
    ranks = [np.linalg.matrix_rank(J, tol=1e-6 * np.linalg.norm(J)) for J in (straight, bent)]
    assert ranks == [3, 4]
    assert np.abs(straight[:, page.ABOUT]).max() == 0
    assert all(entry == 0 for entry in derivative())


def test_a_strong_pull_leaves_the_arms_at_rest():
    shown = glance(CHOOSING[0], stops=True, pose=tuple(held_to_the_side(0.0, 0.2).tolist()))
    means = page.settled(shown, 300.0, 0.65, np.random.default_rng(0))
    assert means.shape == (8, 8)
    assert np.abs(means - REST).max() < 0.25
    free = page.settled(shown, 0.0, 0.65, np.random.default_rng(0))
    wrists = shown.model.pixels(shown.model.joints(free)[:, :, 2]) - shown.wrists
    assert np.linalg.norm(wrists, axis=-1).mean() < 25


def test_the_upper_arm_is_turned_by_any_angle_unless_it_agrees_with_rest():
    found = [page.pulled.but(agrees=agrees, arm="straight", pull=0.0).trial(
        person=CHOOSING[0], arm="straight", pull=0.0) for agrees in (False, True)]  # fmt: skip
    assert found[1]["wrong"] == pytest.approx(found[1]["from_rest"])
    assert found[0]["wrong"] != pytest.approx(found[0]["from_rest"])


def test_the_edge_cue_of_the_page_is_the_library():
    shown = glance(CHOOSING[3])
    bodies = Bodies(shown.model, swept(shown.angles))
    contours = bodies.contours
    far = page.sampled(shown.seen.static, contours, shown.seen.most)
    squared = np.where(contours.visible, far, 4.0) ** 2
    np.testing.assert_allclose(-squared.mean(axis=1) / (2 * 0.65**2), EdgeCue()(shown.seen, bodies))


def test_a_trial_of_smoothness_counts_both_scores_of_its_scene():
    found, score = page.bumpy.trial(person=CHOOSING[0]), page.scores(glance(CHOOSING[0], 40))
    assert found["edges"] == page.maxima(score["edges"])
    assert found["smooth"] == page.maxima(score["distances"])
    assert found["smooth_step"] < found["edges_step"]
    same = page.bumpy.but(smooth="edges").trial(person=CHOOSING[0])
    assert same["edges"] == same["smooth"]


def test_a_trial_of_the_mixes_tells_what_their_surfaces_have():
    shown = glance(CHOOSING[0], 40, 2)
    found = page.multiplied.trial(person=CHOOSING[0])
    assert found["cues"] == list(page.MIXES)
    tops = [page.peaks(log, shown.angles) for log in page.surfaces(shown).values()]
    assert found["there"].tolist() == [top.there for top in tops]
    assert found["peaks"].tolist() == [top.count for top in tops]
    assert (found["out"] <= found["there"]).all()
    wrong = page.multiplied.but(off=40.0).trial(person=CHOOSING[0])
    assert wrong["there"][0] == found["there"][0], "the outline needs no patch"
    assert wrong["there"][2] == 0


def test_a_trial_of_the_straight_arm_has_the_ranks_of_both_jacobians():
    found = page.straight.trial(arm="held to the side")
    assert (found["moves"], found["contour"], found["patches"]) == (0, 3, 4)
    bent = page.straight.but(bend=0.3).trial(arm="held to the side")
    assert (bent["contour"], bent["patches"]) == (4, 4)
    assert bent["moves"] > 10


def test_a_square_of_the_hand_is_like_hands_and_is_not_compared_with_itself():
    shown = glance(CHOOSING[4], 40)
    found = page.compared.trial(person=CHOOSING[4])
    assert found["hand"] == found["skin"] == 1, "the best place is the square itself"
    assert found["alike"] > 0.8
    assert page.compared.but(square="sleeve").trial(person=CHOOSING[4])["alike"] < found["alike"]
    place = page.place_of(shown, shown.angles, [2, 3])
    squared = page.unlike(shown.image, page.histograms(shown.image, place[None]))
    hands = np.isin(shown.parts[np.ix_(page.ROWS, page.COLUMNS)], page.HANDS)
    assert found["alike"] < page.chance(squared, hands, ~hands)


def test_a_trial_of_trust_foretells_by_the_weight_or_by_the_surroundings():
    shown = glance(CHOOSING[3], 40)
    weighed = page.trusted.trial(person=CHOOSING[3])
    np.testing.assert_array_equal(weighed["forecast"], weighed["weight"])
    np.testing.assert_array_equal(weighed["counts"], [k in page.SLEEVES for k in kinds(shown)])
    other = page.trusted.but(by="its surroundings").trial(person=CHOOSING[3])
    np.testing.assert_array_equal(other["forecast"], weighed["unlike"])
    np.testing.assert_array_equal(other["error"], weighed["error"])


def test_each_patch_is_judged_by_the_turns_of_its_own_arm():
    shown = glance(CHOOSING[3])
    both, own = page.off_by_patch(shown), shown.first.patches.limbs // 3
    left = replace(shown, angles=shown.angles + np.r_[np.zeros(4), np.full(4, 0.2)])
    changed = page.off_by_patch(left) != both
    assert changed[own == 1].any()


def test_a_bent_arm_is_held_where_the_pull_agrees():
    found = {
        pull: page.pulled.but(agrees=True).trial(person=CHOOSING[0], arm="bent", pull=pull)
        for pull in (0.0, 20.0)
    }
    assert found[20.0]["from_rest"] < found[0.0]["from_rest"]
    assert found[20.0]["wrong"] == pytest.approx(found[20.0]["from_rest"])


def test_poses_that_show_little_cost_little_unless_it_is_priced():
    found = np.array([page.hiding.trial(person=person)["hidden"] for person in CHOOSING[:8]])
    printed, *_, priced = found.mean(axis=0)
    assert printed >= 0.3
    assert priced <= 0.15
