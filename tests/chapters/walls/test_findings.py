"""What the chapter finds, and asks its reader to do, in every state of its explorers."""

from itertools import pairwise, product

import numpy as np
import pytest

from robot_perception import walls
from robot_perception.chapters.walls import explorers, growth, office, splitting
from robot_perception.chapters.walls import figures as draw
from robot_perception.teaching.figures import figure

CHAIN = splitting.one_scan().points
CALLS = [c for c in splitting.recursion(CHAIN, splitting.TOLERANCE) if c.j > c.i + 1]


@pytest.fixture(scope="module")
def knob():
    """All states of the first explorer by noise and tolerance."""
    return {(state.sigma, state.tolerance): state for state in explorers.knob_states()}


@pytest.fixture(scope="module")
def frames():
    return office.growing_map()


def controls(spec):
    return {name: value for name, value in spec.items() if name != "presets"}


def states(spec):
    names = controls(spec)
    grid = product(*(control.values for control in names.values()))
    return [dict(zip(names, values, strict=True)) for values in grid]


# Presets -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["knob", "band", "replay", "map"])
def test_presets_differ_from_the_default_and_from_one_another(name, frames):
    spec = {
        "knob": explorers.KNOB,
        "band": explorers.BAND,
        "replay": explorers.replay(CALLS),
        "map": explorers.growing(frames),
    }[name]
    default = {key: c.values[c.default] for key, c in controls(spec).items()}
    shown = [default | dict(preset) for preset in spec["presets"].values()]
    for preset in spec["presets"].values():
        for key, value in preset.items():
            assert value in spec[key].values
    assert default not in shown
    assert len({tuple(values.items()) for values in shown}) == len(shown)


def test_no_preset_shows_an_empty_picture(frames):
    for preset in explorers.KNOB["presets"].values():
        chosen = {"tolerance": splitting.TOLERANCE, "sigma": 1.5} | preset
        scan = splitting.one_scan(chosen["tolerance"], chosen["sigma"] / 100)
        assert len(scan.segments) > 0
        assert len(scan.kept) > 2
    by_scans = {frame.scans: frame for frame in frames}
    for preset in explorers.growing(frames)["presets"].values():
        chosen = {"scans": frames[-1].scans, "least": 3} | preset
        assert len(by_scans[chosen["scans"]].found.seen_in(chosen["least"])) >= 3
    for preset in explorers.replay(CALLS)["presets"].values():
        assert 1 < preset["step"] < len(CALLS)


def test_axes_are_fixed_over_the_states(frames, knob):
    _, ax = figure()

    def limits(drawn):
        ax.clear()
        drawn()
        return (*ax.get_xlim(), *ax.get_ylim())

    scans = {
        limits(lambda k=key: draw.scan_state(ax, splitting.one_scan(k[1], k[0]), CHAIN))
        for key in list(knob)[::7]
    }
    points = office.office_run().points
    maps = {
        limits(lambda f=frame, n=least: draw.map_state(ax, f, n, points))
        for frame in (frames[0], frames[9], frames[-1])
        for least in (1, 10)
    }
    bands = {
        limits(lambda s=state: draw.search_range(ax, explorers.band(**s)))
        for state in states(explorers.BAND)[::9]
    }
    steps = {
        limits(lambda n=n: draw.recursion_state(ax, CHAIN, CALLS[:n])) for n in (1, 5, len(CALLS))
    }
    assert [len(found) for found in (scans, maps, bands, steps)] == [1, 1, 1, 1]


# The tolerance -----------------------------------------------------------------------------------


def test_between_noise_and_furniture_the_tolerance_does_not_matter(knob):
    found = explorers.plateau()
    states = [*knob.values(), *explorers.near_the_noise()]
    inside = [s.walls for s in states if s.deviations >= found.low and s.tolerance <= found.high]
    assert len(inside) > 30
    assert set(inside) == {found.walls} == {8}
    nearer = {state.walls for state in states if state.deviations < found.low}
    assert max(nearer) == found.most > 8 > min(nearer)
    assert 3 < found.low < 3.5
    assert found.high == 0.4
    assert {state.walls for state in knob.values() if state.tolerance > 0.4} == {found.beyond}
    assert found.beyond < 8


def test_lower_tolerances_find_too_many_walls_and_then_too_few(knob):
    lowest, low, near, *_ = (knob[0.015, tolerance].walls for tolerance in splitting.TOLERANCES)
    assert lowest < low < 8 < near


@pytest.mark.parametrize(("deviations", "enough"), [(1, False), (2, False), (5, True)])
def test_replies_of_the_first_bet_are_true_of_the_opening_scan(deviations, enough):
    scan = splitting.one_scan(deviations * 0.015)
    assert (len(scan.segments) == 8) == enough


def test_noise_at_five_centimetres_fills_the_chain_and_takes_walls(knob):
    row = [knob[value / 100, 0.05] for value in explorers.KNOB["sigma"].values]
    assert all(one.vertices <= two.vertices for one, two in pairwise(row))
    assert all(one.walls >= two.walls for one, two in pairwise(row))
    assert row[-1].vertices > 5 * row[0].vertices
    assert row[-1].walls < row[0].walls


@pytest.mark.parametrize("sigma", explorers.KNOB["sigma"].values)
def test_corners_are_cut_off_before_walls_are_lost(knob, sigma):
    row = [knob[sigma / 100, tolerance] for tolerance in splitting.TOLERANCES]
    plain = [state for state in row if state.deviations > 3.3 and state.tolerance <= 0.4]
    assert {state.walls for state in plain} == {8}
    vertices = [state.vertices for state in plain]
    assert vertices == sorted(vertices, reverse=True)
    assert vertices[-1] < 13 <= vertices[0]
    assert row[-1].walls < 8


# The replay --------------------------------------------------------------------------------------


def test_a_filled_vertex_is_kept_and_a_hollow_one_closes_its_stretch_for_good():
    for step, call in enumerate(CALLS):
        before = {0, len(CHAIN) - 1, *(c.f for c in CALLS[:step] if c.split)}
        later = [c for c in CALLS[step + 1 :] if call.i <= c.i and c.j <= call.j]
        assert not call.split or call.f not in before
        assert call.split or not later
    splits = [call.f for call in CALLS if call.split]
    assert len(set(splits)) == len(splits) == len(walls.simplify(CHAIN, splitting.TOLERANCE)) - 2


def test_the_scan_is_far_from_the_worst_line():
    distances = walls.count_distances(CHAIN, splitting.TOLERANCE)
    assert sum(call.j - call.i - 1 for call in CALLS) == distances
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
    assert hulls[1] < 0.1 * plain[1]


# The search range --------------------------------------------------------------------------------


def far_end(state):
    return explorers.band(**state).half_width[-1]


def test_twice_the_readings_close_the_fan_more_than_half_the_noise_which_closes_it_by_half():
    for state in states(explorers.BAND):
        if state["rough"]:
            continue
        quieter = state | {"sigma": state["sigma"] / 2}
        halved = far_end(quieter) / far_end(state)
        assert halved == pytest.approx(0.5, rel=0.1)
        longer = state | {"readings": 2 * state["readings"]}
        if longer["readings"] in explorers.BAND["readings"].values:
            assert far_end(longer) / far_end(state) < 0.85 * halved


def test_the_band_is_never_thinner_than_the_wall_is_flat():
    for state in states(explorers.BAND):
        if state["rough"]:
            assert explorers.band(**state).half_width.min() > 2.57 * 0.02


def test_near_the_readings_the_band_is_a_centimetre_and_three_metres_on_a_fan():
    default = {name: c.values[c.default] for name, c in controls(explorers.BAND).items()}
    half = explorers.band(**default).half_width
    assert half.min() < 0.01
    assert half[-1] > 0.1


# The map -----------------------------------------------------------------------------------------


def test_the_map_grows_and_asking_for_more_scans_never_adds_walls(frames):
    for frame in frames:
        counts = [len(frame.found.seen_in(least)) for least in (1, 3, 10)]
        assert counts == sorted(counts, reverse=True)
        assert frame.found.scans.max() <= frame.scans
    lengths = [frame.found.seen_in(1).lengths.sum() for frame in frames]
    assert lengths[-1] > 5 * lengths[0]


def test_walls_seen_seldom_are_less_often_real(frames):
    seldom = office.seldom_study()
    assert 0 < seldom.gone < seldom.all
    assert seldom.after > seldom.before
    assert 0 < seldom.cost < seldom.after - seldom.before


def test_partitions_keep_both_faces():
    """Parallel walls of opposite fronts, 12 cm apart, stand beside each other in the map."""
    found = office.office_run().found
    normals = np.stack([np.cos(found.lines[:, 1]), np.sin(found.lines[:, 1])], axis=-1)
    apart = found.ends.mean(axis=1) @ normals.T - found.lines[:, 0]
    back = normals @ normals.T < -0.999
    assert (back & (np.abs(np.abs(apart) - 0.12) < 0.02)).sum() >= 4


def test_the_gate_without_roughness_has_many_more_walls():
    study = office.gate_study((0.0, 0.02, 0.6))
    assert study.walls[0] > 2 * study.walls[1]
    assert study.walls[1] > 2 * study.walls[2]
    assert study.believed[0] < 0.1 * 0.02  # the error of the poses is many times larger
    assert study.missed[1] < 0.5 * min(study.missed[0], study.missed[2])
    assert (study.precision[:2] > 0.95).all()
    assert study.precision[2] < 0.3
