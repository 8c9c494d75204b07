"""What the chapter tells a reader to find, beyond what its explorers assert themselves."""

from itertools import pairwise, product

import numpy as np
import pytest

from explorables.figures import figure
from robot_perception.book import anchored_slam as page
from robot_perception.book.recordings_robots import UTIAS
from robot_perception.chapters.anchored_slam import figures as draw

# Worlds moved


def test_picture_and_words_say_what_was_computed():
    for state in page.shift.parameters(amount=2):
        world, said = page.shift.state(**state), page.shift.described(**state)
        texts = [text.get_text() for text in page.shift.drawn(**state).texts]
        (words,) = [text for text in texts if text.startswith("largest")]
        assert f"{world.metres:.2f} m" in words
        assert words.removeprefix("largest residual ") in said
        assert ("heading" in words) == (world.radians > 0)
        turned = state["direction"].startswith("turn")
        assert ("by 30°." if turned else "by 2 m.") in said


# The references


def test_anchor_and_camera_have_one_band_and_not_one_error():
    for deviation in page.DEVIATIONS:
        one, other = (page.refer(kind, deviation, 0.1) for kind in page.SIGNS)
        np.testing.assert_allclose(one.deviations, other.deviations, rtol=1e-9)
        assert not np.allclose(one.landmark_errors, other.landmark_errors)


@pytest.mark.parametrize("kind", page.SIGNS)
def test_the_band_shrinks_and_more_slowly_with_a_worse_reference(kind):
    bands = [page.refer(kind, deviation, 0.1).deviations[:, 1] for deviation in page.DEVIATIONS]
    assert all((np.diff(one) < 0).all() for one in bands)
    assert all((a[1:] < b[1:]).all() for a, b in pairwise(bands))


def test_no_innovation_complains_of_a_wrong_place():
    """By the innovations of the reference, which the page does not keep."""
    for kind, deviation, offset in product(page.SIGNS, page.DEVIATIONS, page.OFFSETS[1:]):
        robot, squares = page.referenced(kind, deviation), []
        rng = np.random.default_rng(7)
        r, z = page.drive(page.monobot(**page.FIG4), 30, rng)
        z = page.observed(robot, r, z, np.random.default_rng(rng.integers(2**32)), offset)
        found = page.filtered(robot, z)
        for k in range(10, 100):
            mean = found.means[:, k] + np.array([robot.u[k], 0.0])
            innovation = z[:, k + 1, 0] - mean @ robot.H[0]
            squares.append(innovation**2 / found.S[k, 0, 0])
        assert 0.9 < np.mean(squares) < 1.1


def test_errors_and_gains_stay_in_the_picture():
    for setting in page.fan.parameters():
        found = page.fan.state(**setting)
        assert np.abs(found.landmark_errors).max() < 0.6
        assert -0.5 < found.gains.min() <= found.gains.max() < 1


def test_four_fifths_of_the_first_error_stay_without_a_reference():
    assert page.remaining(page.referenced())[-1] ** 0.5 == pytest.approx(0.8, abs=0.01)


def test_the_ledgers_tables_of_references_order_them_by_noise():
    for fig in (page.FIG5, page.FIG6):
        table = page.with_noises(fig)
        left = [table[f"{d} m", "left"] for d in page.NOISES]
        assert left == sorted(left)
        assert left[0] < page.UNSEEN < left[-1]


def test_without_a_reference_the_claims_would_fail():
    for study, name in ((page.anchored, "anchor"), (page.watched, "external sensor")):
        found = study.rows()
        table = page.with_and_without(found, name)
        assert table["none", "left"].low > page.FADED.high
        assert table[name, "left"] == page.share_left(found)


# Pictures


def test_side_by_side_draws_the_same_scales_and_stays_finite():
    seed = np.random.default_rng(1)
    r, z = page.drive(page.monobot(**page.FIG4), 2, seed)
    results = {
        name: page.on_rail(robot, r, page.observed(robot, r, z, own))
        for (name, robot), own in zip(page.figures().items(), seed.spawn(3), strict=True)
    }
    _, axes = figure(4, 3, width=7.2, height=7.2)
    draw.side_by_side.on(axes, results, 0)
    for row in axes:
        assert len({ax.get_ylim() for ax in row}) == 1
        for ax in row:
            for line in ax.lines:
                assert np.isfinite(np.asarray(line.get_ydata(), dtype=float)).all()
    (error,) = (line.get_ydata() for line in axes[2, 1].lines if len(line.get_ydata()) == 101)
    anchored = results["Fig. 5: anchor"]
    np.testing.assert_allclose(error, anchored.means[0, :, 1] - 1.0)


def test_drawings_of_the_circles_show_the_numbers():
    found = page.along_the_circles()
    _, ax = figure()
    draw.claimed_information.on(ax, {kind: one.gains for kind, one in found.items()})
    lines = [line.get_ydata() for line in ax.lines if len(line.get_ydata()) > 2]
    for line, one in zip(lines, found.values(), strict=True):
        np.testing.assert_array_equal(line, np.median(one.gains, axis=0))
    _, axes = figure(1, 3, width=7.4)
    draw.heading_honesty.on(axes, {kind: (one.stated, one.rms) for kind, one in found.items()})
    for panel, one in zip(axes, found.values(), strict=True):
        np.testing.assert_allclose(panel.lines[1].get_ydata(), one.rms)


# Robot 2


def test_robot_2_by_the_number_of_anchors():
    errors = UTIAS.stored().result.errors["lasting"]
    ate, aligned = errors.ate[1], errors.ate_aligned[1]
    assert (aligned[:2] < ate[:2] / 2).all()  # most of it is not the shape of the map
    assert page.robot_2.found() == page.five.found(robot=2) == ate.tolist()


def test_gains_along_the_circles_begin_with_what_was_known_at_the_start():
    for kind, found in page.along_the_circles().items():
        assert (found.gains[:, 0] == 1).all(), kind
        assert found.gains.shape[1] == len(found.rms) + 1 == page.STEPS + 1
