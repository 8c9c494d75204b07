"""What the chapter finds, and asks its reader to do, in every state of its explorers."""

from itertools import pairwise

import numpy as np
import pytest

from robot_perception import walls
from robot_perception.chapters.walls import bets, explorers, growth, office, splitting
from robot_perception.teaching.explore import MOST_STATES
from tests.chapters.findings import limits, presets_that_show_the_default
from tests.unchecked import unchecked

CHAIN = splitting.one_scan().points
EXPLORERS = ("knob", "stand", "band", "replay", "growing")


def shown(name):
    """Return an explorer by its name; two of them are made when they are asked for."""
    found = getattr(explorers, name)
    with unchecked():
        return found() if callable(found) else found


@pytest.fixture(scope="module")
def knob():
    """All states of the first explorer by noise and tolerance."""
    with unchecked():
        return {(state.sigma, state.tolerance): state for state in explorers.knob_states()}


@pytest.fixture(scope="module")
def near():
    """What is found between the steps of the slider."""
    with unchecked():
        return explorers.near_the_noise()


# Presets -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", EXPLORERS)
def test_presets_differ_from_the_default_and_from_one_another(name):
    one = shown(name)
    assert not presets_that_show_the_default(one)
    states = [one.default | dict(preset) for preset in one.presets.values()]
    assert len({tuple(values.items()) for values in states}) == len(states)
    assert len(list(one.parameters())) <= MOST_STATES


def test_no_preset_shows_an_empty_picture(knob):
    for preset in explorers.knob.presets.values():
        chosen = explorers.knob.default | preset
        state = knob[chosen["sigma"] / 100, chosen["tolerance"]]
        assert len(state.segments) > 0
        assert len(state.kept) > 2
    growing, replay = shown("growing"), shown("replay")
    for preset in growing.presets.values():
        assert growing.finding(growing.state(**growing.default | preset)) >= 3
    for preset in replay.presets.values():
        assert 1 < preset["step"] < len(splitting.asked())


@pytest.mark.parametrize("name", EXPLORERS)
def test_axes_are_fixed_over_the_states(name):
    one = shown(name)
    states = list(one.parameters())
    with unchecked():
        seen = {limits(one.drawn(**state)) for state in states[:: max(1, len(states) // 6)]}
    assert len(seen) == 1


# The tolerance -----------------------------------------------------------------------------------


def test_between_noise_and_furniture_the_tolerance_does_not_matter(knob, near):
    found = explorers.plateau()
    low, high, beyond = (found[name] for name in ("low", "high", "beyond"))
    states = [*knob.values(), *near]
    inside = [len(s.segments) for s in states if s.deviations >= low and s.tolerance <= high]
    assert len(inside) > 30
    assert set(inside) == {found["walls"]} == {8}
    nearer = {len(state.segments) for state in states if state.deviations < low}
    assert max(nearer) == found["most"] > 8 > min(nearer)
    assert 3 < low < 3.5
    assert high == 0.4
    assert {len(state.segments) for state in knob.values() if state.tolerance > high} == {beyond}
    assert beyond < 8


def test_lower_tolerances_find_too_many_walls_and_then_too_few(knob):
    lowest, low, near, *_ = (
        len(knob[0.015, tolerance].segments) for tolerance in splitting.TOLERANCES
    )
    assert lowest < low < 8 < near


@pytest.mark.parametrize(("deviations", "enough"), [(1, False), (2, False), (5, True)])
def test_replies_of_the_first_bet_are_true_of_the_opening_scan(deviations, enough):
    scan = splitting.one_scan(deviations * 0.015)
    assert (len(scan.segments) == 8) == enough
    assert (bets.TOLERANCE["right"] == f"ε = {deviations}σ") == enough


def test_noise_at_five_centimetres_fills_the_chain_and_takes_walls(knob):
    row = [knob[value / 100, 0.05] for value in explorers.knob.controls["sigma"].values]
    assert all(len(one.kept) <= len(two.kept) for one, two in pairwise(row))
    assert all(len(one.segments) >= len(two.segments) for one, two in pairwise(row))
    assert len(row[-1].kept) > 5 * len(row[0].kept)
    assert len(row[-1].segments) < len(row[0].segments)


@pytest.mark.parametrize("sigma", explorers.knob.controls["sigma"].values)
def test_corners_are_cut_off_before_walls_are_lost(knob, sigma):
    row = [knob[sigma / 100, tolerance] for tolerance in splitting.TOLERANCES]
    plain = [state for state in row if state.deviations > 3.3 and state.tolerance <= 0.4]
    assert {len(state.segments) for state in plain} == {8}
    vertices = [len(state.kept) for state in plain]
    assert vertices == sorted(vertices, reverse=True)
    assert vertices[-1] < 13 <= vertices[0]
    assert len(row[-1].segments) < 8


# The replay --------------------------------------------------------------------------------------


def test_a_filled_vertex_is_kept_and_a_hollow_one_closes_its_stretch_for_good():
    calls = splitting.asked()
    for step, call in enumerate(calls):
        before = {0, len(CHAIN) - 1, *(c.f for c in calls[:step] if c.split)}
        later = [c for c in calls[step + 1 :] if call.i <= c.i and c.j <= call.j]
        assert not call.split or call.f not in before
        assert call.split or not later
    splits = [call.f for call in calls if call.split]
    assert len(set(splits)) == len(splits) == len(walls.simplify(CHAIN, splitting.TOLERANCE)) - 2


def test_the_scan_is_far_from_the_worst_line():
    distances = walls.count_distances(CHAIN, splitting.TOLERANCE)
    assert sum(call.j - call.i - 1 for call in splitting.asked()) == distances
    assert distances < 6 * len(CHAIN)
    n = 16
    cuts = [call for call in splitting.recursion(growth.worst_case(n), 0.1) if call.split]
    assert [(cut.i, cut.f) for cut in cuts] == [(k, k + 1) for k in range(n - 2)]
    assert walls.count_distances(growth.worst_case(n), 0.1) == (n - 1) * (n - 2) // 2


def test_hulls_cost_more_on_the_scan_and_less_on_the_worst_line():
    line = growth.worst_case(2000)
    plain, hulls = (
        [count(chain, 0.08) for chain in (CHAIN, line)]
        for count in (walls.count_distances, walls.count_hull_steps)
    )
    assert hulls[0] > 2 * plain[0]
    assert bets.HULLS["right"] == "they cost more steps"
    assert hulls[1] < 0.1 * plain[1]


# The search range --------------------------------------------------------------------------------


def far_end(state):
    return explorers.band_of(**state).half_width[-1]


def test_twice_the_readings_close_the_fan_more_than_half_the_noise_which_closes_it_by_half():
    for state in explorers.band.parameters(rough=False):
        quieter = state | {"sigma": state["sigma"] / 2}
        halved = far_end(quieter) / far_end(state)
        assert halved == pytest.approx(0.5, rel=0.1)
        longer = state | {"readings": 2 * state["readings"]}
        if longer["readings"] in explorers.band.controls["readings"].values:
            assert far_end(longer) / far_end(state) < 0.85 * halved


def test_the_band_is_never_thinner_than_the_wall_is_flat():
    assert min(half.min() for half in explorers.band.found(rough=True)) > 2.57 * 0.02


def test_near_the_readings_the_band_is_a_centimetre_and_three_metres_on_a_fan():
    half = explorers.band_of(**explorers.band.default).half_width
    assert half.min() < 0.01
    assert half[-1] > 0.1


# The map -----------------------------------------------------------------------------------------


def test_the_map_grows_and_asking_for_more_scans_never_adds_walls():
    with unchecked():
        frames = office.growing_map()
    for frame in frames:
        counts = [len(frame.found.seen_in(least)) for least in (1, 3, 10)]
        assert counts == sorted(counts, reverse=True)
        assert frame.found.scans.max() <= frame.scans
    lengths = [frame.found.seen_in(1).lengths.sum() for frame in frames]
    assert lengths[-1] > 5 * lengths[0]


def test_walls_seen_seldom_are_less_often_real():
    with unchecked():
        seldom = office.seldom_study()
    assert 0 < seldom["gone"] < seldom["all"]
    assert 0 < seldom["cost"] < seldom["before"] - seldom["after"]


def test_partitions_keep_both_faces():
    """Parallel walls of opposite fronts, 12 cm apart, stand beside each other in the map."""
    found = office.office_run().found
    normals = np.stack([np.cos(found.lines[:, 1]), np.sin(found.lines[:, 1])], axis=-1)
    apart = found.ends.mean(axis=1) @ normals.T - found.lines[:, 0]
    back = normals @ normals.T < -0.999
    assert (back & (np.abs(np.abs(apart) - 0.12) < 0.02)).sum() >= 4


def test_the_gate_without_roughness_has_many_more_walls():
    with unchecked():
        study = office.gate_study()
    trusted, ours, widest = (study.roughness == r for r in (0.0, 0.02, 0.6))
    assert study.walls[trusted] > 2 * study.walls[ours]
    assert study.walls[ours] > 2 * study.walls[widest]
    assert study.believed[trusted] < 0.1 * 0.02  # the error of the poses is many times larger
    assert study.missed[ours] < 0.5 * min(study.missed[trusted], study.missed[widest])
    assert study.missed[ours] < 0.1
    assert study.precision[study.roughness <= 0.02].min() > 0.95
    assert study.precision[widest] < 0.3
    assert bets.GATE["right"] == "many more walls"


# Where the scanner stands ------------------------------------------------------------------------


def test_the_scanner_stands_free_wherever_it_is_dragged():
    starts, ends = np.moveaxis(splitting.one_scan().truth, 1, 0)
    along = ends - starts
    for place in explorers.stand.parameters():
        spot = np.array([place["x"], place["y"]])
        share = ((spot - starts) * along).sum(axis=1) / (along**2).sum(axis=1)
        nearest = starts + share.clip(0, 1)[:, None] * along
        assert np.hypot(*(nearest - spot).T).min() > 0.3


def test_a_scan_from_elsewhere_shows_the_same_room():
    moved = splitting.one_scan(sigma=0.0, at=(1.0, -0.5))
    shifted = moved.truth + np.array([1.0, -0.5])
    np.testing.assert_allclose(shifted, splitting.one_scan().truth, atol=1e-12)
    starts, ends = np.moveaxis(moved.truth, 1, 0)
    along = (ends - starts) / np.linalg.norm(ends - starts, axis=1, keepdims=True)
    off = moved.points[:, None] - starts
    away = np.abs(off[..., 0] * along[:, 1] - off[..., 1] * along[:, 0]).min(axis=1)
    assert np.quantile(away, 0.9) < 0.01


def test_walls_found_depend_on_the_place_and_are_few_beside_furniture():
    counts = explorers.stand.found()
    assert counts[-1] == min(counts) < max(counts)
