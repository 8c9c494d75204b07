"""The studies: worlds, trackers and what they count, by law."""

from fractions import Fraction

import numpy as np
import pytest

from robot_perception.appearance import shape_scores
from robot_perception.appearance.affine_snake import area
from robot_perception.appearance.segmentation import boundary, filled
from robot_perception.book import colour_and_shape as page
from studies.rows import Rows, framed

RNG = np.random.default_rng
SQUARE = np.array([[10.0, 10.0], [29.0, 10.0], [29.0, 29.0], [10.0, 29.0]])


def rows_of(last):
    """Two films of each kind by two trackers, of which all overlap by what is given at the end."""
    trials = [
        {"film": film, "world": world, "tracker": name, "overlap": value, "last": value}
        for film in (0, 1)
        for world in page.WORLDS
        for name in ("both", "edges alone")
        for value in [last.get((world, name, film), 0.8)]
    ]
    return Rows(framed(trials), "film", {})


# Films and what is counted


def test_a_film_is_as_long_as_it_is_tracked_and_its_first_frame():
    assert len(page.filmed("circles", 9001, 3).frames) == 4


def test_overlap_of_squares():
    assert page.overlap(SQUARE, SQUARE) == 1
    assert page.overlap(SQUARE, SQUARE + 30) == 0
    aside = page.overlap(SQUARE, SQUARE + np.array([10.0, 0.0]))
    assert aside == pytest.approx(9 / 29, abs=1e-12)  # they are 19 px wide


def test_films_are_counted_kind_by_kind_by_their_last_frames():
    rows = rows_of({("rectangle", "edges alone", 1): 0.1, ("snail", "both", 1): 0.19,
                    ("circles", "edges alone", 0): 0.2})  # fmt: skip
    assert page.lost(rows, "edges alone").tolist() == [0, 0, 0, 1, 0, 0, 0, 0]
    assert page.lost(rows, "both").tolist() == [0, 0, 0, 0, 0, 0, 0, 1]
    assert page.lost(rows, "both", least=0.81).all()
    assert page.held(rows, "both").estimate == pytest.approx(7 / 8)
    assert page.more_often(rows, "edges alone", "both").estimate == 0
    assert page.more_often(rows, "edges alone", "both", ("rectangle",)).estimate == 0.5
    ahead = page.further(rows, "both", "edges alone")
    assert ahead.estimate == pytest.approx((0.7 - 0.61 + 0.6) / 8)
    assert page.by_loss(rows)["edges alone", "rectangle"] == 0.5


def test_the_same_draws_go_to_all_trackers_and_others_to_other_films():
    first, again, other, kind = (
        page.draws(*of).random() for of in (("snail", 4002), ("snail", 4002), ("snail", 4003),
                                            ("beetle", 4002))
    )  # fmt: skip
    assert first == again
    assert len({first, other, kind}) == 3


def test_scored_films_are_new_and_spaces_have_cells_of_one_number():
    own = {*page.CHOOSING, page.TRAINING, *range(1001, 1031), *range(2001, 2041)}
    for study in (page.followed, page.relit, page.recoloured, page.slid, page.replaced):
        assert not set(study.replicates) & own
    assert not {*page.illuminated.replicates} & {*page.recoloured.replicates}
    assert {page.rules_of("circles", space).binning.count for space in page.SPACES} == {4096}
    assert {binning.count for binning in page.CELLS.values()} == {4096}
    for name, count in page.MANY.items():
        assert page.rules_of("snail", name).samples == count


def test_in_the_first_frames_both_cues_are_on_the_object():
    for world in ("circles", "snail"):
        film, rules = page.filmed(world, 9001, 3), page.rules_of(world)
        outlines = page.follow("both", film, rules, page.trained(world), RNG(0))
        assert page.overlaps_of(film, outlines).min() > 0.5


# Snakes


def test_what_is_cut_out_is_of_the_shells_colours_and_starts_a_frame_before():
    cases = list(page.cut_out(page.CHOOSING[2], (8, 24), RNG(0)))
    for case in cases:
        start, truth = (filled(o, case.neck.shape) for o in (case.start, case.truth))
        assert (start & truth).sum() > 0.85 * (start | truth).sum()
        assert (case.piece.mask & truth).sum() > 0.6 * truth.sum()
        assert (case.piece.mask & case.neck).sum() > 0.5 * case.neck.sum()
        np.testing.assert_array_equal(case.piece.boundary(), boundary(case.piece.mask))
    (bare,) = page.cut_out(page.CHOOSING[2], (4,), RNG(0), neck=False)
    assert bare.neck.any()  # where it would be
    assert (bare.neck & bare.piece.mask).sum() < 0.3 * bare.neck.sum()


def test_what_lies_within_an_outline_is_counted():
    (case,) = page.cut_out(page.CHOOSING[2], (8,), RNG(0))
    whole = np.array([[-1.0, -1], [320, -1], [320, 240], [-1, 240]])
    inside = filled(case.truth, case.neck.shape)
    assert page.within(whole, case) == (1, pytest.approx(inside.mean()))
    taken, lies = page.within(case.truth, case)
    assert lies == 1
    assert taken == pytest.approx((inside & case.neck).sum() / case.neck.sum())


def test_the_affine_snake_is_affine_and_the_free_one_swallows_more():
    found = page.slid.but(frames=(8, 24)).trial(film=page.CHOOSING[2])
    rows = Rows(framed([found]), "film", {})
    assert rows.of("residual", snake="affine").max() < 1e-8
    assert rows.of("residual", snake="free", rigidity=page.LOOSE).min() > 0.5
    loose = {k: rows.mean("swallowed", snake=k, rigidity=page.LOOSE).estimate for k in page.SNAKES}
    assert loose["free"] > loose["affine"]


def test_the_gap_is_the_mean_of_the_films_means_over_the_cases_that_count():
    trials = [
        {"film": film, "snake": snake, "rigidity": page.LOOSE, "reach": 5.0,
         "piece": True, "held": held, "swallowed": value, "overlap": 0.5, "residual": 0.0}
        for film, held, snake, value in (
            (0, 0.9, "affine", 0.0), (0, 0.9, "free", 0.4), (0, 0.6, "affine", 0.1),
            (0, 0.6, "free", 0.1), (1, 0.9, "affine", 0.0), (1, 0.9, "free", 0.6),
            (1, 0.1, "affine", 0.0), (1, 0.1, "free", 0.9))
    ]  # fmt: skip
    found = page.gap(Rows(framed(trials), "film", {}), "swallowed")
    assert found.estimate == pytest.approx((0.2 + 0.6) / 2)


# The sign of the area's score


@pytest.mark.parametrize("ratio", [Fraction(1, 3), Fraction(1), Fraction(2), Fraction(7, 2)])
@pytest.mark.parametrize("sign", page.SIGNS)
def test_exact_rho_is_that_of_the_scores(ratio, sign):
    exact = page.exact_rho(ratio, sign == "printed")
    score = page.SIGNS[sign](1.0, float(ratio))
    assert float(exact) == pytest.approx(shape_scores.rho(1.0, score, 1.0, page.EVEN))


def test_a_perfect_match_costs_everything_as_printed_and_nothing_turned_round():
    assert page.exact_rho(Fraction(1), True) == 1
    assert page.exact_rho(Fraction(1), False) == 0
    assert page.exact_rho(Fraction(2), True) == Fraction(1, 2)


@pytest.mark.slow
def test_the_printed_sign_prefers_a_shell_of_twice_the_area():
    found = page.shells.trial(film=page.CHOOSING[3])
    assert (found["right first, printed"], found["right first, turned round"]) == (False, True)
    assert found["perfect"] == 1
    assert page.shells.but(printed=False).trial(film=page.CHOOSING[3])["perfect"] == 0


# Models of colours


def test_a_mixture_finds_the_parts_that_colours_come_from():
    rng = RNG(0)
    colours = np.concatenate([rng.normal(middle, 0.03, (300, 3)) for middle in (0.2, 0.5, 0.8)])
    shares, means, _ = page.mixed(colours)
    np.testing.assert_allclose(shares, 1 / 3, atol=0.02)
    np.testing.assert_allclose(means, [[m] * 3 for m in (0.2, 0.5, 0.8)], atol=0.02)
    moved = page.adapted((shares, means, np.tile(0.01 * np.eye(3), (3, 1, 1))), colours + 0.1)
    np.testing.assert_allclose(moved[1], means + 0.02, atol=0.01)  # a fifth of the way
    density = page.densities((np.ones(1), np.zeros((1, 3)), np.eye(3)[None]), np.zeros((1, 3)))
    assert density.item() == pytest.approx((2 * np.pi) ** -1.5)


def test_a_predicted_cloud_goes_on_as_it_went():
    cloud = RNG(0).normal(0.4, [0.05, 0.03, 0.01], (400, 3))
    before, last = (page.distributions.describe(cloud + step) for step in (0.0, 0.1))
    told = page.predicted(before, last, cloud + 0.1)
    np.testing.assert_allclose(told, cloud + 0.2, atol=1e-9)


def test_a_window_moves_to_where_its_colour_is():
    index = np.zeros((60, 80), dtype=int)
    index[20:40, 34:54] = 1
    moved = page.shifted(np.array([0.0, 1.0]), index, (28, 17, 20, 20))
    assert np.abs(np.subtract(moved, (34, 20, 20, 20))).max() <= 2


@pytest.mark.parametrize("model", page.MODELS)
def test_every_model_follows_circles_that_keep_their_colour(model):
    found = page.recoloured.but(steady=True).trial(film=9001, world="circles", model=model)
    assert found["overlap"] > 0.7


def test_a_model_is_compared_with_the_space_that_does_best():
    trials = [
        {"film": film, "world": "circles", "model": model, "overlap": value, "last": value}
        for film in (0, 1)
        for model, value in zip(page.MODELS, (0.1, 0.5, 0.2, 0.3, 0.7, 0.05), strict=True)
    ]
    rows = Rows(framed(trials), "film", {})
    assert page.ahead(rows, "adapted mixture", "circles").estimate == pytest.approx(0.2)


def middles_of(film, at):
    """Return mean colours of the disc and of a corner of the ground, shares of full light."""
    inside = filled(film.outlines[at], (240, 320))
    parts = film.frames[at][inside], film.frames[at][:30, :30].reshape(-1, 3)
    return [(part.mean(axis=0) / 255) ** 2.2 for part in parts]


def test_light_falls_on_all_and_paint_on_the_disc_alone():
    far = 24
    light, paint, calm = (page.lit(one, 9003) for one in (page.COLOURED, page.PAINTED, page.CALM))
    (disc, ground), (later, beneath) = middles_of(light, 0), middles_of(light, far)
    assert later / disc == pytest.approx(beneath / ground, rel=0.05)
    assert np.ptp(later / disc) > 0.2
    (disc, ground), (later, beneath) = middles_of(paint, 0), middles_of(paint, far)
    assert beneath == pytest.approx(ground, rel=0.02)
    assert np.abs(later / disc - 1).max() > 0.2
    for before, after in zip(middles_of(calm, 0), middles_of(calm, far), strict=True):
        assert after == pytest.approx(before, rel=0.03)


def test_brightness_alone_keeps_the_shares_of_red_green_and_blue():
    film = page.lit(page.BRIGHTER, 9003)
    (disc, _), (later, _) = middles_of(film, 0), middles_of(film, 24)
    assert np.ptp(later / disc) < 0.05
    assert abs((later / disc).mean() - 1) > 0.1


def test_a_window_that_is_told_the_place_lies_on_a_disc_and_one_at_rest_does_not():
    told, rests = (
        page.illuminated.trial(film=9003, world=page.CALM, model=one)["overlap"]
        for one in (page.TOLD, page.RESTS)
    )
    assert told > 0.98
    assert rests < 0.5


# Another shape, and something in front


@pytest.mark.parametrize("name", page.TURNS)
def test_shapes_have_the_area_of_a_disc(name):
    assert area(page.shape(name)) == pytest.approx(np.pi)
    assert np.ptp(np.hypot(*page.shape(name).T)) > 0.5 or name != "star"


def test_colours_go_on_and_are_not_those_of_the_ground():
    for seed in range(20):
        colour = page.paint_of(RNG(seed))
        first, next_ = (np.asarray(colour(t)) ** (1 / 2.2) for t in (0, 1))
        assert np.abs(first - 0.55).max() >= 0.29
        assert 0 < np.linalg.norm(next_ - first) < 0.021
        still = page.paint_of(RNG(seed), 0.0)
        assert (still(0) == still(9)).all()


def test_a_disc_in_its_own_place_is_not_rejected():
    found = page.replaced.trial(film=9001, other="disc")
    assert found["on"] > 0.9
    assert not found["rejected"]
    assert found["rho"] < 0.2


def test_a_star_in_its_place_is_rejected():
    found = page.replaced.trial(film=9001, other="star")
    assert found["rejected"]
    assert found["rho"] > page.IN_RGB.worst


@pytest.mark.parametrize("paint", [page.OTHER, page.OWN])
@pytest.mark.parametrize("cover", page.COVERS)
def test_a_disc_passes_behind_two_fifths_of_a_thing_that_lies_still(cover, paint):
    seen, hidden = page.behind(cover, paint, 29, RNG(9002))
    assert hidden == pytest.approx(0.4, abs=0.03)
    way = seen.outlines[-1].mean(axis=0) - seen.outlines[0].mean(axis=0)
    assert np.hypot(*way) == pytest.approx(140)
    spread = [
        seen.frames[t][filled(seen.outlines[t], (240, 320))].std(axis=0).max() for t in (0, 14, 28)
    ]
    assert (spread[1] > 2 * max(spread[0], spread[2])) == (paint == page.OTHER)


def test_a_larger_thing_hides_all_of_the_disc():
    assert page.behind(page.WHOLE, page.OTHER, 29, RNG(9002))[1] == 1


def test_an_outline_at_rest_ends_off_the_disc():
    short = page.passed.but(frames=29).trial(film=9002, cover="square", paint=page.OTHER)
    assert not short["rests"]
    assert short["held"] == (short["last"] >= 0.5)


# A training sequence


@pytest.mark.parametrize("order", [1, 2])
def test_nothing_is_missed_of_states_that_go_on_as_was_learnt(order):
    rng = RNG(order)
    A = rng.normal(size=(8, 8 * order)) / (8 * order)
    known = page.distributions.Dynamics(A, rng.normal(size=8), np.eye(8))
    states = [*rng.normal(size=(order, 8))]
    for _ in range(5):
        states.append(known.A @ np.concatenate(states[: -order - 1 : -1]) + known.b)
    states = np.array(states)
    assert page.missed_by(known, states) == pytest.approx(np.zeros((5, 8)), abs=1e-12)
    assert page.missed_by(known, states + 1).shape == (5, 8)
    assert np.abs(page.missed_by(known, states + 1)).max() > 0.1


def test_colours_of_the_first_frame_have_not_turned_and_are_those_of_the_tracker():
    found = page.described("rectangle", 9001, 5)
    assert found.shape == (5, 8)
    assert (found[0, 6:] == 0).all()
    assert found[0, 5] > 0
    assert (found[1:, 6:] != 0).any()


def test_a_film_that_teaches_itself_is_foretold_better_than_by_colours_that_stay():
    rows = page.foretold.but(itself=True, world=("rectangle",)).run(film=(9001,))
    assert rows.table["learnt"].tolist() == list(page.LEARNT)
    free = rows.of("error", learnt=page.BY_ONE), rows.of("error", learnt=page.BY_TWO)
    assert max(*free) < 0.9


def test_an_error_over_that_of_colours_that_stay_is_a_geometric_mean():
    trials = [{"film": film, "world": "snail", "learnt": page.GO_ON, "error": error}
              for film, error in enumerate((0.5, 8.0))]  # fmt: skip
    value = page.over_staying(Rows(framed(trials), "film", {}))
    assert value.estimate == pytest.approx(2)
    assert (value.low, value.high) == pytest.approx((0.5, 8))


def test_a_claim_speaks_of_the_worst_kind_and_its_condition_of_the_best():
    errors = dict(zip(page.WORLDS, (0.5, 0.7, 1.2, 1.4), strict=True))
    trials = [{"film": film, "world": world, "learnt": page.GO_ON, "error": error}
              for film in (0, 1) for world, error in errors.items()]  # fmt: skip
    rows = Rows(framed(trials), "film", {})
    assert page.worst(rows).estimate == pytest.approx(0.7)
    assert page.least(rows).estimate == pytest.approx(1.2)
