"""Laws of the rules that are exchanged, and oracles for what is measured."""

from dataclasses import replace
from itertools import product
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from robot_perception.appearance.colour_histograms import intersection, intersection_of_shares
from robot_perception.book import exchanged_parts as page
from robot_perception.companion.cues import bhattacharyya
from robot_perception.people.aggregation import AggregationRules
from robot_perception.people.tracker import PeopleTracker
from studies.intervals import exact
from studies.rows import Rows

HEAD = arrays(float, 6, elements=st.integers(0, 40).map(float)).filter(lambda M: M.sum() > 0)
SHARE = arrays(float, 6, elements=st.sampled_from([0.0, 0.5, 1.0]))


# Colours -----------------------------------------------------------------------------------------


@given(HEAD, SHARE)
def test_by_the_printed_rule_whatever_lies_inside_the_head_is_perfect(M, kept):
    C = M * kept
    if C.sum() > 0:
        assert page.printed(C, M) == pytest.approx(1)
        assert page.printed(C, M) == pytest.approx(intersection(C, M))


@given(HEAD, HEAD, HEAD)
def test_by_the_rule_of_swain_and_ballard_a_larger_ellipse_is_never_worse(C, more, M):
    assert page.ballard(C + more, M) >= page.ballard(C, M) - 1e-12
    assert page.ballard(C + M, M) == pytest.approx(1)


@given(HEAD, HEAD)
def test_shares_and_roots_are_those_of_the_library_and_know_no_size(C, M):
    shares = C / C.sum(), M / M.sum()
    assert page.of_shares(C, M) == pytest.approx(intersection_of_shares(*shares))
    D = bhattacharyya(shares[0][None, None], shares[1][None, None])[0, 0]
    assert page.coefficient(C, M) == pytest.approx(1 - D**2, abs=1e-7)
    for compare in (page.of_shares, page.coefficient):
        assert compare(3 * C, M) == pytest.approx(compare(C, 5 * M))
        assert compare(M, M) == pytest.approx(1)
        assert -1e-12 <= compare(C, M) <= 1 + 1e-12


@pytest.fixture(scope="module")
def short():
    """Films of four seconds."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(page.heads, "FRAMES", 60)
        page.heads.filmed.cache_clear()
        yield
    page.heads.filmed.cache_clear()


@pytest.mark.usefixtures("short")
def test_a_pixel_a_frame_is_all_that_a_size_may_change():
    """By the printed rule an ellipse shrinks."""
    shown = page.heads.filmed(page.FILM, page.heads.LIGHT)
    true, rows = page.true_sizes(shown), page.sized.one(page.FILM, page.PRINTED)
    assert rows["frame"].tolist() == list(page.sized_frames())
    assert rows["size"][-1] < 0.5
    widths = np.r_[round(true[0]), rows["size"] * true[list(page.sized_frames())]]
    assert np.abs(np.diff(widths)).max() <= page.EVERY + 1e-9
    assert widths == pytest.approx(np.rint(widths))


@pytest.mark.usefixtures("short")
def test_the_ellipse_that_is_tried_has_the_shape_of_the_true_one():
    shown = page.heads.filmed(page.FILM, page.heads.LIGHT)
    inside = page.inside(shown, 0, round(page.true_sizes(shown)[0]))
    truth = page.heads.insides(shown)[0]
    assert (inside & truth).sum() > 0.85 * (inside | truth).sum()


def test_films_are_counted_by_how_they_end():
    ends = {page.PRINTED: 0.3, page.BALLARD: 4.0, page.ROOT: 1.2}
    table = [
        {"film": page.FILM, "measure": measure, "frame": frame, "size": size}
        for measure, end in ends.items()
        for frame, size in zip(page.sized_frames()[-2:], (1.0, end), strict=True)
    ]
    rows = Rows(pd.DataFrame(table), "film", {})
    assert page.small(rows).estimate == 1
    assert page.large(rows).estimate == 1
    assert page.small(rows, page.BALLARD).estimate == 0
    assert page.lost(rows, page.PRINTED).estimate == 1
    assert page.small(rows, page.ROOT).estimate == 0  # it ends near the true size
    assert page.large(rows, page.ROOT).estimate == page.lost(rows, page.ROOT).estimate == 0
    alone = rows.where(measure=page.BALLARD)
    assert page.small(alone).estimate == 0  # a sabotage has one rule, whichever it is


@pytest.mark.usefixtures("short")
def test_a_size_that_is_told_is_nearer_than_one_that_never_changes():
    off = {rule: page.near.trial(film=page.FILM, rule=rule)["off"] for rule in page.NEAR}
    assert off[page.NEAREST] < 0.05 < off[page.FIRST]
    assert off[page.NEAREST] <= min(off.values())


# Faces -------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def few():
    with pytest.MonkeyPatch.context() as patch:
        for name, value in {"KNOWN": 3, "STRANGERS": 2, "LATER": 3}.items():
            patch.setattr(page, name, value)
        page.photographed.cache_clear()
        yield
    page.photographed.cache_clear()


def test_classes_have_the_means_and_squares_of_their_views():
    views = np.random.default_rng(1).normal(size=(4, 7, 5))
    classes = page.classes_of(views)
    assert classes.means == pytest.approx(views.mean(axis=1))
    assert classes.squares == pytest.approx(7 * views.var(axis=1))
    assert classes.counts.tolist() == [7] * 4


@pytest.mark.parametrize("p", [5, 7, 12])
def test_a_new_view_is_as_far_from_its_class_as_the_law_says(p):
    rng, k, classes = np.random.default_rng(2), 20, 40_000
    found = page.classes_of(30 * rng.normal(size=(classes, p, k)))
    new = 30 * rng.normal(size=(classes, k))
    variances = page.VARIANCES[page.OWN](found)
    L = ((new - found.means) ** 2 / variances).sum(axis=1)
    assert L.mean() == pytest.approx(k * (1 + 1 / p) * (p - 1) / (p - 3), rel=0.03)


def test_squared_distances_are_those_of_each_view_from_each_class():
    rng = np.random.default_rng(3)
    views, classes = rng.normal(size=(2, 3, 4)), page.classes_of(rng.normal(size=(5, 6, 4)))
    variances = rng.uniform(1, 2, (5, 4))
    found = page.squared(views, classes, variances)
    assert found.shape == (2, 3, 5)
    expected = sum((views[1, 2, j] - classes.means[4, j]) ** 2 / variances[4, j] for j in range(4))
    assert found[1, 2, 4] == pytest.approx(expected)


@pytest.mark.usefixtures("few")
def test_faces_are_named_and_a_gallery_that_is_told_lets_no_stranger_in():
    rows = page.named.run(world=(117,), kind=(page.PLAIN, page.SHRUNK)).table
    assert (rows["right"] > 0.5).all()
    told = page.named.but(told=True).run(world=(117,), kind=(page.PLAIN, page.SHRUNK)).table
    assert told["let in"][1] == 0
    assert told["let in"][0] == rows["let in"][0]
    assert (told["right"] == rows["right"]).all()


@pytest.mark.usefixtures("few")
def test_a_limit_lets_nineteen_of_twenty_of_ones_own_in_and_fewer_pictures_make_a_space():
    state = page.described(117, 4)
    assert [part.shape[:2] for part in state] == [(3, 4), (3, 3), (2, 3)]
    assert page.described(117)[1] == pytest.approx(page.described(117, page.ENROLLED)[1])


# Guesses -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "tracker",
    # the film of two arms takes as long as all other tests of this chapter
    [*page.TRACKERS[:2], pytest.param(page.TRACKERS[2], marks=pytest.mark.slow)],
)
def test_the_truth_is_likelier_than_what_is_three_deviations_off(tracker):
    log_likelihood, size = page.sees(tracker, 700)
    off = np.random.default_rng(4).standard_normal((20, size))
    off *= 3 / np.linalg.norm(off, axis=1, keepdims=True)
    logs = log_likelihood(np.vstack([np.zeros(size), off]))
    assert (logs[1:] < logs[0]).mean() > 0.8
    assert size == (8 if "8" in tracker else 4)


@pytest.fixture
def told_all(monkeypatch):
    """Make no films for an eye that is told the coordinates; it asks for their number alone."""
    for name, size in {"sees_pattern": 4, "sees_person": 4, "sees_arms": 8}.items():
        monkeypatch.setattr(page, name, lambda world, size=size: (None, size))


@pytest.mark.usefixtures("told_all")
def test_an_eye_that_knows_every_coordinate_takes_the_nearest_guess():
    rows = page.stepped.but(told=0.05).run(world=(700,)).table
    assert rows["over"].to_numpy() == pytest.approx(1, abs=0.02)
    assert (rows["over"] == rows["error"] / rows["nearest"]).all()
    assert (rows["effective"] >= 1).all()
    assert sorted(set(rows["moved"])) == list(page.MOVED)


@pytest.mark.usefixtures("told_all")
def test_of_many_guesses_the_mean_is_that_of_kalman():
    step = page.stepped.but(told=1.0, moved=(2.0,))
    rows = step.run(world=range(700, 706), tracker=page.TRACKERS[:1])
    error = rows.of("error", count=max(page.COUNTS)).mean()
    # half way, since guess and eye know as much; to three standard errors of six worlds
    assert error == pytest.approx(2.0 / 2, abs=0.1)


@pytest.mark.usefixtures("told_all")
def test_the_nearest_of_more_guesses_is_nearer():
    rows = page.stepped.but(told=1.0, moved=(4.0,)).run(world=range(700, 706))
    near = [rows.of("nearest", count=count).mean() for count in page.COUNTS]
    assert near == sorted(near, reverse=True)


@pytest.mark.usefixtures("told_all")
@pytest.mark.parametrize(("told", "size"), [(0.5, 4), (1.0, 8)])
def test_shares_of_independent_coordinates_multiply(told, size):
    tracker = page.TRACKERS[2 if size == 8 else 0]
    rows = page.shared.but(told=told).run(world=(700,), tracker=(tracker,))
    found = rows.table.iloc[0]
    h = told**-2
    alone = np.sqrt(1 + 2 * h) / (1 + h)  # of a normal walk and a normal likelihood
    assert found["product"] == pytest.approx(alone**size, rel=0.35)
    assert found["whole"] == pytest.approx(alone**size, rel=0.35)
    assert found["over"] == pytest.approx(found["whole"] / found["product"])
    assert found["least"] == pytest.approx(alone, rel=0.15)


def test_of_ratios_the_one_is_taken_that_is_furthest_from_one_as_a_factor():
    ratios = [exact(one) for one in (1.5, 0.5, 1.9)]
    assert page.furthest(ratios) is ratios[1]


# Copies ------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def told():
    return page.people.page_session()


@pytest.mark.slow
def test_people_and_hypotheses_are_counted_as_in_the_chapter_of_the_committee(told):
    counts = page.people.tally(page.people.committee(told), {"everywhere": page.people.EVERYWHERE})
    found = page.judged(told, page.repeated(told, page.people.RULES, 1))
    assert [found[name] for name in ("people", "found", "matched")] == [
        counts[name][0] for name in ("people", "found", "matched")
    ]


def test_copies_are_what_a_tracker_makes_of_readings_one_after_the_other(told):
    tracker = PeopleTracker(page.people.RULES, page.people.STATIC)
    state, known = tracker.start(told.reckoned[0]), []
    for k in range(40):
        for again in reversed(range(3 if told.sensors[k] == page.CAMERA_NUMBER else 1)):
            one = told.found(k)
            one = replace(one, time=one.time - again * page.APART)
            state, _ = tracker.step(state, one, told.reckoned[k])
        if k in told.judged:
            known.append(state.hypotheses)
    ours = page.repeated(told, page.people.RULES, 3).found[: len(known)]
    assert [one.weight.tolist() for one in ours] == [one.weight.tolist() for one in known]
    assert [one.mean.tolist() for one in ours] == [one.mean.tolist() for one in known]


@given(st.integers(1, 9))
def test_an_alpha_that_is_shared_leaves_after_all_copies_what_one_reading_leaves(copies):
    camera = page.people.RULES.sensors["camera"]
    shared = page.among(page.people.RULES, copies).sensors["camera"]
    for name in ("alpha", "alpha_behind"):
        left = (1 - getattr(shared, name)) ** copies
        assert left == pytest.approx(1 - getattr(camera, name))
    assert shared.patience == camera.patience


@pytest.mark.slow
def test_said_four_times_weights_rise_and_kalman_is_surer(told):
    once, often = (page.repeated(told, page.people.RULES, k) for k in (1, 4))
    assert sum(f.weight.sum() for f in often.found) > sum(f.weight.sum() for f in once.found)
    surer = page.repeated(told, page.TOLD[page.BY_KALMAN], 4)
    area = [np.median(np.linalg.det(np.concatenate([f.cov for f in run.found])))
            for run in (once, often, surer)]  # fmt: skip
    assert area[1] > 0.8 * area[0]
    assert area[2] < 0.5 * area[0]


def test_honest_hypotheses_have_a_mean_squared_error_of_one(told):
    """Put each person's hypothesis off by a draw of its covariance, and judge."""
    rng, sigma = np.random.default_rng(5), np.array([0.05, 0.02])

    def persons():
        for row in range(len(told.judged)):
            people = told.polar[row][told.present[row] & told.clear[row]]
            off = sigma * rng.standard_normal(people.shape)
            cov = np.tile(np.diag(sigma**2), (len(people), 1, 1))
            yield row, SimpleNamespace(mean=people + off, cov=cov), None

    found = page.judged(told, SimpleNamespace(persons=persons))
    assert found["errors"] / found["matched"] == pytest.approx(1, abs=0.15)
    assert found["matched"] == found["people"]


def test_ratios_are_those_of_copies_over_one():
    columns = {
        "session": [1, 1, 2, 2],
        "rules": [page.BY_KALMAN] * 4,
        "copies": [1, 4] * 2,
        "found": [10, 12, 8, 10],
        "matched": [8, 9, 6, 5],
        "errors": [8.0, 27, 9, 20],
    }
    rows = Rows(pd.DataFrame(columns), "session", {})
    assert page.nees(rows, page.BY_KALMAN).estimate == pytest.approx((3 + 4) / (1 + 1.5))
    wrong = (3 / 12 + 5 / 10) / (2 / 10 + 2 / 8)
    assert page.made_up(rows, page.BY_KALMAN).estimate == pytest.approx(wrong)
    assert page.TOLD[page.STRICT].person == 0.85
    assert isinstance(page.TOLD[page.BY_KALMAN], AggregationRules)


# Thresholds --------------------------------------------------------------------------------------


def histograms(*seeds):
    found = [np.random.default_rng(k).uniform(0.1, 1, (4, 3, 8)) for k in seeds]
    return [one / one.sum(axis=-1, keepdims=True) for one in found]


def test_gates_ask_the_model_or_the_most_different_of_the_last_pictures():
    seen, model, before = histograms(1, 2, 3)
    far = bhattacharyya(seen, before).mean(axis=-1)
    assert page.by_score(seen, model, [seen]) == pytest.approx(
        bhattacharyya(seen, model).mean(axis=-1)
    )
    assert page.by_change(seen, model, [seen, before]) == pytest.approx(far)
    assert page.by_change(seen, model, [seen]) == pytest.approx(0, abs=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize(("threshold", "rate"), [(-1.0, 0.0), (1.0, page.RATE)])
def test_gates_that_never_or_always_let_learn_are_the_trackers_of_the_other_chapter(
    threshold, rate
):
    shown = page.walks.walk(101, page.DARKER)
    shown = replace(shown, frames=shown.frames[:25], boxes=shown.boxes[:25])
    rules = page.TutorRules(rate=rate, **page.walks.FREE)
    tracker = page.TutorTracker(page.walks.MODELS["four"], rules)
    theirs = page.walks.follow(shown, tracker, 101)
    ours = page.learning(shown, page.by_score, threshold, np.random.default_rng([101, 1]))
    assert ours == pytest.approx(theirs)


def test_what_a_threshold_for_one_event_costs_in_the_other_is_counted_film_by_film():
    loose, tight = {page.SCORE: 0.35, page.CHANGE: 0.25}, dict.fromkeys(page.GATES, 0.1)
    table = [
        {"film": film, "event": event, "gate": gate, "threshold": at, "lost": lost}
        for film, event, gate in product((1, 2), (page.DARKER, page.STOPS), page.GATES)
        for at, lost in (
            (tight[gate], event == page.DARKER),
            (loose[gate], event == page.STOPS and film == 1),
        )
    ]
    found = page.costs(Rows(pd.DataFrame(table), "film", {}))
    for gate in page.GATES:
        assert found[gate, page.DARKER].estimate == 1
        assert found[gate, page.STOPS].estimate == 0.5
    assert page.least(found.values()).estimate == 0.5


def test_a_row_tells_of_each_gate_and_threshold_and_of_models_without_one(monkeypatch):
    monkeypatch.setattr(page.walks, "walk", lambda film, event: None)
    monkeypatch.setattr(page.walks, "held", lambda boxes, shown: boxes < 0.2)
    monkeypatch.setattr(page, "learning", lambda shown, asks, threshold, rng: threshold)
    rows = page.gated.but(thresholds=(0.2,), event=(page.STOPS,)).run(film=(100,)).table
    assert rows["gate"].tolist() == [page.NEVER, page.ALWAYS, page.SCORE, page.CHANGE]
    assert rows["threshold"].tolist() == [-1, 1, 0.2, 0.2]
    assert rows["lost"].tolist() == [False, True, True, True]
