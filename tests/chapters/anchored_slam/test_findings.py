"""What the chapter tells a reader to find, in every state of its explorers."""

import itertools

import numpy as np
import pytest

from robot_perception.chapters.anchored_slam import gauge, invented, rails, recordings
from robot_perception.chapters.anchored_slam.figures import gauge as draw_gauge
from robot_perception.chapters.anchored_slam.figures import rails as draw_rails
from robot_perception.chapters.anchored_slam.figures import recordings as draw_recordings
from robot_perception.chapters.anchored_slam.gauge import AT_REST, TURN
from robot_perception.teaching.figures import figure
from tests.chapters.findings import default, limits, presets_that_show_the_default, states

RNG = np.random.default_rng


@pytest.fixture(scope="module")
def settings():
    return rails.studies(rng=RNG(7))


def worst(state):
    world = gauge.move_world(**state)
    return max(world.metres, world.radians)


# The turned world


def test_turned_by_whatever_nothing_differs():
    for degrees in (-30, -15, 0, 15, 30):
        assert worst({"sensing": "one anchor", "direction": TURN, "amount": degrees / 15}) < 1e-12


def test_red_where_the_text_says_so_and_nowhere_else():
    for state in states(gauge.CONTROLS):
        sensing, direction = state["sensing"], state["direction"]
        seen = worst(state) > 0.1
        if sensing == "one anchor":
            assert seen == (direction != TURN)
        elif sensing in ("two anchors", "anchor + compass", "position sensor"):
            assert seen
        elif sensing == AT_REST:
            assert seen == (direction != "turn about the robot")
        else:
            assert not seen


def test_presets_of_the_moved_world():
    assert not presets_that_show_the_default(gauge.PRESETS, gauge.CONTROLS)
    for preset in gauge.PRESETS.values():
        world = gauge.move_world(**default(gauge.CONTROLS) | preset)
        assert not np.allclose(world.moved_poses, world.poses)


def test_axes_of_the_moved_world_stay():
    _, ax = figure()
    seen = set()
    for state in states(gauge.CONTROLS):
        seen.add(limits(draw_gauge.moved_world(ax, gauge.move_world(**state))))
    assert len(seen) == 1


# The references


def test_anchor_and_camera_have_one_band(settings):
    for state in states(rails.CONTROLS):
        if state["reference"] == "anchor":
            twin = settings["external sensor", state["deviation"], state["offset"]]
            own = settings["anchor", state["deviation"], state["offset"]]
            np.testing.assert_allclose(own.deviations, twin.deviations, rtol=1e-9)


def test_the_band_shrinks_and_more_slowly_with_a_worse_reference(settings):
    for kind in ("anchor", "external sensor"):
        for offset in rails.CONTROLS["offset"].values:
            bands = [
                settings[kind, d, offset].deviations[:, 1]
                for d in rails.CONTROLS["deviation"].values
            ]
            assert all((np.diff(one) < 0).all() for one in bands)
            assert all((a[1:] < b[1:]).all() for a, b in itertools.pairwise(bands))


def test_a_wrong_place_goes_into_the_map_and_no_innovation_complains(settings):
    for (kind, deviation, offset), result in settings.items():
        if kind == "none" or not offset:
            continue
        moved = result.last_errors - settings[kind, deviation, 0.0].last_errors
        assert (0.8 * offset <= moved).all()
        assert (moved < 1.05 * offset).all()
        filtered = result.filtered
        squared = filtered.innovations[..., 0] ** 2 / filtered.innovation_covs[..., 0, 0]
        assert 0.9 < squared[:, 10:].mean() < 1.1


def test_presets_and_axes_of_the_references(settings):
    assert not presets_that_show_the_default(rails.PRESETS, rails.CONTROLS)
    _, axes = figure(2, 1)
    seen = set()
    for result in settings.values():
        draw_rails.fan_and_gains(axes, result, reach=0.5)
        seen.add(tuple(limits(ax) for ax in axes))
    assert len(seen) == 1


def test_share_of_the_first_error_is_what_the_bet_says():
    deviations = rails.covariances(rails.FIG5).deviations[0, :, 1]
    assert 1 / 20 < deviations[-1] / deviations[0] < 1 / 10
    plain = rails.covariances(rails.Config()).deviations[0, :, 1]
    assert plain[-1] / plain[0] == pytest.approx(0.8, abs=0.01)


def test_set_up_says_what_is_run():
    rows = rails.setup_table().rows
    assert rows["measurements"][1] == str(rails.FIG4.steps)
    assert rows["noise of the camera"][1] == f"{100 * rails.FIG6.deviation:g} cm"


# The invented information


def test_the_less_was_known_the_more_is_invented():
    table = invented.start_table((1, 3, 10), rng=RNG(gauge.planar_anchor.seed))
    for column in table.columns:
        values = [table[row, column] for row in table.rows]
        assert values == sorted(values)
    assert table["±1°", "information"] <= 1 < table["±3°", "information"]


# Robot 2


def test_robot_2_by_the_number_of_anchors():
    found = recordings.UTIAS.stored().result
    ate, aligned = found.errors["lasting"].ate[1], found.errors["lasting"].ate_aligned[1]
    assert (np.diff(ate) < 0).all()
    assert (aligned[:2] < ate[:2] / 2).all()  # most of it is not the shape of the map
    _, ax = figure()
    assert len({limits(draw_recordings.robot_path(ax, found, 2, k)) for k in range(3)}) == 1
