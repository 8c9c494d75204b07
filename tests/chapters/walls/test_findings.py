"""What the chapter finds, and asks its reader to do, beyond what its explorers assert."""

from itertools import pairwise

import numpy as np
import pytest

from robot_perception import walls
from robot_perception.book import walls as page
from robot_perception.book.walls import (
    SURE,
    TOLERANCE,
    band_of,
    is_sure,
    knob,
    one_scan,
    recursion,
    worst_case,
)
from tests.chapters.findings import ExplorerTests
from tests.unchecked import unchecked

CHAIN = one_scan().points


class TestExplorers(ExplorerTests):
    explorers = (page.knob, page.stand, page.replay, page.band, page.growing)


@pytest.fixture(scope="module")
def states():
    """All states of the first explorer by noise and tolerance."""
    with unchecked():
        return {(one["sigma"], one["tolerance"]): knob.state(**one) for one in knob.parameters()}


def test_no_preset_shows_an_empty_picture(states):
    for preset in knob.presets.values():
        chosen = knob.default | preset
        state = states[chosen["sigma"], chosen["tolerance"]]
        assert len(state.segments) > 0
        assert len(state.kept) > 2
    growing, replay = page.growing, page.replay
    with unchecked():
        for preset in growing.presets.values():
            assert growing.finding(growing.state(**growing.default | preset)) >= 3
    for preset in replay.presets.values():
        assert 1 < preset["step"] < len(page.asked())
    first = replay.presets["first chord kept"]["step"]
    assert [call.split for call in page.asked()[:first]] == [True] * (first - 1) + [False]


def test_between_the_steps_of_the_slider_a_tolerance_that_is_sure_finds_the_same_walls():
    with unchecked():
        for sigma in (0.005, 0.015, 0.03, 0.06):
            noise = float(np.hypot(sigma, page.ROUNDING))
            for k in np.arange(SURE[0] + 0.001, 6.1, 0.25).tolist():
                state = one_scan(k * noise, sigma)
                assert is_sure(state) == (k * noise <= SURE[1])
                assert len(state.segments) == 8 or not is_sure(state)


def test_lower_tolerances_find_too_many_walls_and_then_too_few(states):
    lowest, low, near = (len(states[1.5, e].segments) for e in (0.02, 0.03, 0.04))
    assert lowest < low < 8 < near


def test_noise_at_five_centimetres_fills_the_chain_and_takes_walls(states):
    row = [states[sigma, 0.05] for sigma in knob.controls["sigma"].values]
    assert all(len(one.kept) <= len(two.kept) for one, two in pairwise(row))
    assert all(len(one.segments) >= len(two.segments) for one, two in pairwise(row))
    assert len(row[-1].kept) > 5 * len(row[0].kept)
    assert len(row[-1].segments) < len(row[0].segments)


@pytest.mark.parametrize("sigma", knob.controls["sigma"].values)
def test_corners_are_cut_off_before_walls_are_lost(states, sigma):
    row = [states[sigma, tolerance] for tolerance in knob.controls["tolerance"].values]
    vertices = [len(state.kept) for state in row if is_sure(state)]
    assert vertices == sorted(vertices, reverse=True)
    assert vertices[-1] < 13 <= vertices[0]
    assert len(row[-1].segments) < 8


def test_a_filled_vertex_is_kept_and_a_hollow_one_closes_its_stretch_for_good():
    calls = page.asked()
    for step, call in enumerate(calls):
        before = {0, len(CHAIN) - 1, *(c.f for c in calls[:step] if c.split)}
        later = [c for c in calls[step + 1 :] if call.i <= c.i and c.j <= call.j]
        assert not call.split or call.f not in before
        assert call.split or not later
    splits = [call.f for call in calls if call.split]
    assert len(set(splits)) == len(splits) == len(walls.simplify(CHAIN, TOLERANCE)) - 2


def test_the_scan_is_far_from_the_worst_line():
    distances = walls.count_distances(CHAIN, TOLERANCE)
    assert sum(call.j - call.i - 1 for call in page.asked()) == distances
    assert distances < 6 * len(CHAIN)
    n = 16
    cuts = [call for call in recursion(worst_case(n), 0.1) if call.split]
    assert [(cut.i, cut.f) for cut in cuts] == [(k, k + 1) for k in range(n - 2)]


def test_hulls_cost_less_on_the_worst_line():
    line = worst_case(2000)
    assert walls.count_hull_steps(line, 0.08) < 0.1 * walls.count_distances(line, 0.08)


def test_near_the_readings_the_band_is_a_centimetre_and_three_metres_on_a_fan():
    half = band_of(**page.band.default).half_width
    assert half.min() < 0.01
    assert half[-1] > 0.1


def test_the_map_grows():
    with unchecked():
        frames = page.growing_map().values()
    assert all(frame.found.scans.max() <= frame.scans for frame in frames)
    lengths = [frame.found.seen_in(1).lengths.sum() for frame in frames]
    assert lengths[-1] > 5 * lengths[0]


def test_partitions_keep_both_faces():
    """Parallel walls of opposite fronts, 12 cm apart, stand beside each other in the map."""
    with unchecked():
        found = page.growing_map()[page.SCANS].found.seen_in(page.LEAST)
    normals = np.stack([np.cos(found.lines[:, 1]), np.sin(found.lines[:, 1])], axis=-1)
    apart = found.ends.mean(axis=1) @ normals.T - found.lines[:, 0]
    back = normals @ normals.T < -0.999
    assert (back & (np.abs(np.abs(apart) - 0.12) < 0.02)).sum() >= 4


def test_the_gate_without_roughness_has_many_more_walls():
    rows = page.gated.rows()
    trusted, ours, widest = (rows.where(roughness=r) for r in (0.0, 0.02, 0.6))
    assert trusted.largest("walls") > 2 * ours.largest("walls")
    assert ours.largest("walls") > 2 * widest.largest("walls")
    assert trusted.largest("believed") < 0.1 * 0.02  # the poses err many times more
    assert ours.largest("missed") < min(0.1, 0.5 * trusted.largest("missed"))
    assert min(trusted.largest("precision"), ours.largest("precision")) > 0.95
    assert widest.largest("precision") < 0.3


def test_validation_takes_what_is_unreal_and_impatience_costs_less_than_ten_scans():
    rows = page.validated.rows().where(wrong=0.02)
    unreal, missed = (
        [rows.mean(name, least=k).estimate for k in (1, 3, 10)] for name in ("unreal", "missed")
    )
    assert unreal[1] < 0.5 * unreal[0]
    assert missed[1] - missed[0] < 0.01
    assert missed[2] > 2 * missed[1]


def test_fewest_extract_more_in_the_noise_and_less_where_the_tolerance_is_that_of_furniture():
    rows = page.spent.rows()
    for tolerance, better in ((0.045, "fewest"), (0.3, "splitting")):
        worse = {"fewest", "splitting"} - {better}
        one, other = (
            rows.mean("extracted", tolerance=tolerance, way=way) for way in (better, *worse)
        )
        assert one.low > other.high


# Where the scanner stands ------------------------------------------------------------------------


def test_the_scanner_stands_free_wherever_it_is_dragged():
    starts, ends = np.moveaxis(one_scan().truth, 1, 0)
    along = ends - starts
    for place in page.stand.parameters():
        spot = np.array([place["x"], place["y"]])
        share = ((spot - starts) * along).sum(axis=1) / (along**2).sum(axis=1)
        nearest = starts + share.clip(0, 1)[:, None] * along
        assert np.hypot(*(nearest - spot).T).min() > 0.3


def test_a_scan_from_elsewhere_shows_the_same_room():
    moved = one_scan(sigma=0.0, at=(1.0, -0.5))
    shifted = moved.truth + np.array([1.0, -0.5])
    np.testing.assert_allclose(shifted, one_scan().truth, atol=1e-12)
    starts, ends = np.moveaxis(moved.truth, 1, 0)
    along = (ends - starts) / np.linalg.norm(ends - starts, axis=1, keepdims=True)
    off = moved.points[:, None] - starts
    away = np.abs(off[..., 0] * along[:, 1] - off[..., 1] * along[:, 0]).min(axis=1)
    assert np.quantile(away, 0.9) < 0.01
