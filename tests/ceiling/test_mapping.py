"""The mapper: its frame, its map against the truth, and each part against its law."""

import math
from dataclasses import replace
from functools import lru_cache
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_perception.ceiling import mapping
from robot_perception.ceiling.contours import ContourRules
from robot_perception.ceiling.mapping import (
    AS_PRINTED,
    Mapper,
    MapRules,
    MapState,
    PatternTrackers,
    Sought,
    View,
    agreeing,
    consistent,
    inside,
    located,
    look_for,
    retrace,
)
from robot_perception.ceiling.mosaic import (
    Links,
    Mosaic,
    NoCommonPattern,
    adjust,
    camera_pose,
    in_camera,
)
from robot_perception.ceiling.mosaic import pieces as pieces_of
from robot_perception.ceiling.mosaic import place as beside
from robot_perception.ceiling.patterns import PatternRules, WindowRules, make_pattern
from robot_perception.ceiling.recognition import recognise
from robot_perception.ceiling.tracker import PatternTracker, TrackerRules
from robot_perception.geometry import se2
from tests.ceiling.ceilings import (
    BLANK,
    CENTRE,
    MOUNT,
    SCALE,
    TILTED,
    camera,
    corrects,
    driven,
    film,
    mapped,
    run,
)
from tests.ceiling.pictures import SIZE, cluttered, drawn, rectangle
from tests.unchecked import unchecked

SHAPE = BLANK.shape
DRIVES = ((0.0, 3), (-0.02, 5))  # turn at each step, rad, and the ceiling's seed


def gen(seed=0):
    return np.random.default_rng(seed)


@lru_cache
def busy():
    """Return a drive on which patterns are made again and again."""
    return mapped(film(turn=-0.02, seed=5)[:9], MapRules(enough=6))


def seen(pose, pattern, scale=SCALE):
    """Return the sighting of a pattern from a pose, by complex numbers."""
    away = complex(*np.subtract(pattern, pose)[:2]) * np.exp(-1j * pose[2]) / scale
    turn = math.remainder(pattern[2] - pose[2], 2 * math.pi)
    return np.array([CENTRE[0] + away.real, CENTRE[1] + away.imag, turn, 1.0])


# The map ------------------------------------------------------------------------------------------


def test_the_first_pattern_is_the_frame():
    state, info = run()[0]
    first, *others = info.new
    assert first == "0"
    assert [*state.mosaic.poses] == [*state.patterns] == [*state.tracked] == [*info.new]
    assert not state.mosaic.poses["0"].any()
    origin = info.sightings["0"]
    for name in others:  # its windows stand upright in one picture
        expected = (info.sightings[name] - origin)[:3] * [SCALE, SCALE, 1]
        np.testing.assert_allclose(state.mosaic.poses[name], expected, atol=1e-12)
    np.testing.assert_allclose(state.pose, [*(CENTRE - origin[:2]) * SCALE, 0], atol=1e-12)
    assert not state.motion.any()
    assert info.located
    assert state.count == 1


@pytest.mark.parametrize(("turn", "seed"), DRIVES)
def test_the_map_is_that_of_the_ceiling(turn, seed):
    """Within two pixels, 25 mm, and 1.5°: the worst of 24 other drives was 20 mm and 1.3°."""
    path, made = driven(14, 0.05, turn), {}
    start = run(turn=turn, seed=seed)[0][0].pose
    for pose, (state, info) in zip(path, run(turn=turn, seed=seed), strict=True):
        assert info.located
        assert not info.closed
        error = se2.between(start, state.pose) - se2.between(path[0], pose)
        assert np.hypot(*error[:2]) < 2 * SCALE
        assert abs(error[2]) < math.radians(1.5)
        for name in info.new:
            there = (info.sightings[name][:3] - [*CENTRE, 0]) * SCALE  # its windows are upright
            made[name] = se2.compose(pose, there)
        for name, place in info.sightings.items():  # where the world shows its centre
            (pixel,) = camera("varied", seed).points_seen(pose, made[name][None, :2])
            assert np.hypot(*(pixel - place[:2])) < 3
            assert abs(math.remainder(place[2] - made[name][2] + pose[2], 2 * math.pi)) < 0.06
    reference = made["0"]
    for name, pose in state.mosaic.poses.items():
        error = pose - se2.between(reference, made[name])
        assert np.hypot(*error[:2]) < 2 * SCALE
        assert abs(error[2]) < math.radians(1.5)


def test_new_patterns_are_placed_by_the_pose():
    """Eq. (3), wherever a pattern was made on the way; windows stand upright when it is."""
    found = [(state, info) for state, info in busy() if info.new]
    assert len(found) > 1  # the first and another
    for state, info in found:
        for name in info.new:
            place = info.sightings[name]
            assert (place[2:] == [0, 1]).all()
            again = seen(state.pose, state.mosaic.poses[name])
            np.testing.assert_allclose(again, place, atol=1e-9)
            taken = [one.pose for other, one in state.tracked.items() if other != name]
            away = np.hypot(*(np.array(taken) - place)[:, :2].T)
            assert away.min() >= MapRules().windows.apart


def test_without_the_scale_the_map_is_the_same_in_pixels():
    """Exactly, as the factor is a power of two."""
    pictures = film()[:7]
    for (px, shown), (m, told) in zip(
        mapped(pictures, scale=1.0), mapped(pictures, scale=2.0**-6), strict=True
    ):
        unit = np.array([2.0**-6, 2.0**-6, 1])
        np.testing.assert_array_equal(px.pose * unit, m.pose)
        np.testing.assert_array_equal(px.motion * unit, m.motion)
        assert [*px.mosaic.poses] == [*m.mosaic.poses]
        for name, pose in px.mosaic.poses.items():
            np.testing.assert_array_equal(pose * unit, m.mosaic.poses[name])
        assert (shown.new, shown.lost, shown.found) == (told.new, told.lost, told.found)


def test_the_same_seed_gives_the_same_numbers():
    pictures = film()[:3]
    first, second = run()[2], mapped(pictures)[-1]
    np.testing.assert_array_equal(first[0].pose, second[0].pose)
    for name, place in first[1].sightings.items():
        np.testing.assert_array_equal(place, second[1].sightings[name])
    mapper, other = Mapper(SCALE, CENTRE), gen(2)
    state, _ = mapper.step(mapper.start(), pictures[0], rng=other)
    state, _ = mapper.step(state, pictures[1], rng=other)
    assert (run()[1][0].pose != state.pose).any()


def test_a_step_changes_nothing_that_it_is_given():
    state, _ = run()[0]
    before = state.pose.copy(), dict(state.tracked), dict(state.mosaic.poses)
    one, two = (Mapper(SCALE, CENTRE).step(state, film()[1], rng=gen(7))[0] for _ in range(2))
    np.testing.assert_array_equal(one.pose, two.pose)
    np.testing.assert_array_equal(state.pose, before[0])
    assert (dict(state.tracked), dict(state.mosaic.poses)) == before[1:]
    with pytest.raises(TypeError):
        state.tracked["x"] = None


def test_links_hold_each_pair_as_often_as_it_was_seen():
    """Those that were made in a picture, too."""
    counts = {}
    for _, info in busy():
        for pair in combinations(sorted(info.sightings), 2):
            counts[pair] = counts.get(pair, 0) + 1
    state = busy()[-1][0]
    assert {pair: link.count for pair, link in state.links.means().items()} == counts
    for (a, b), link in state.links.means().items():
        error = se2.between(state.mosaic.poses[a], state.mosaic.poses[b]) - link.pose
        assert np.hypot(*error[:2]) < 3 * SCALE


def test_pose_and_motion_are_those_of_the_sightings():
    for (before, _), (state, info) in zip(run(), run()[1:], strict=False):
        if not info.found:
            known = {n: at for n, at in info.sightings.items() if n not in info.new}
            np.testing.assert_allclose(state.pose, before.mosaic.locate(known)[0], atol=1e-12)
        step = complex(*(state.pose - before.pose)[:2]) * np.exp(-1j * before.pose[2])
        turn = math.remainder(state.pose[2] - before.pose[2], 2 * math.pi)
        np.testing.assert_allclose(state.motion, [step.real, step.imag, turn], atol=1e-12)
        assert state.count == before.count + 1


# Rules --------------------------------------------------------------------------------------------


@pytest.fixture
def pieces(monkeypatch):
    """Count the pictures whose contours are found, and what is looked for."""
    run()
    told = []
    inner = mapping.look_for

    def noted(expected, patterns, sought, rules, *, rng):
        told.append(dict(expected))
        return inner(expected, patterns, sought, rules, rng=rng)

    monkeypatch.setattr(mapping, "look_for", noted)
    return told


@pytest.mark.parametrize("every", [1, 3])
def test_known_patterns_are_looked_for_in_every_so_many_pictures(every, pieces):
    asked = []
    mapper, rng = Mapper(SCALE, CENTRE, MapRules(every=every)), gen(1)
    state, _ = mapper.step(mapper.start(), film()[0], rng=rng)
    for picture in film()[1:7]:
        before = len(pieces)
        state, _ = mapper.step(state, picture, rng=rng)
        asked.append(len(pieces) - before)
    assert asked == [int(count % every == 0) for count in range(2, 8)]


def test_only_what_is_not_tracked_and_should_be_in_view_is_looked_for(pieces):
    """Known are two that are in view, one at the border and one beyond it; one is tracked."""
    state, info = run()[0]
    names = [*state.tracked][:2]
    pose = state.pose
    away = {"edge": [25.0, 120, 0, 1], "out": [-50.0, 120, 0, 1]}
    mosaic = state.mosaic
    for name, place in away.items():
        there = (np.array(place[:3]) - [*CENTRE, 0]) * [SCALE, SCALE, 1]
        mosaic = mosaic.with_pattern(name, se2.compose(pose, there))
    patterns = {**state.patterns, **dict.fromkeys(away, state.patterns["0"])}
    tracked = {name: one for name, one in state.tracked.items() if name not in names[1:]}
    state = replace(state, mosaic=mosaic, patterns=patterns, tracked=tracked)
    _, after = Mapper(SCALE, CENTRE, MapRules(every=1)).step(state, film()[0], rng=gen())
    (told,) = pieces
    assert [*told] == names[1:]
    np.testing.assert_allclose(told[names[1]], info.sightings[names[1]], atol=1.0)
    assert after.found == tuple(names[1:])
    assert not after.closed


def test_new_patterns_are_made_where_fewer_are_seen_than_enough():
    """And where there are as many, no window is sought."""
    for many, states in ((6, busy()), (4, run(turn=-0.02, seed=5))):
        for _, info in states[1:]:
            assert not info.new or len(info.sightings) - len(info.new) < many
    state, info = run()[0]
    four = replace(state, tracked=dict([*state.tracked.items()][:4]))
    for enough in (4, 5):
        _, after = Mapper(SCALE, CENTRE, MapRules(enough=enough)).step(four, film()[0], rng=gen())
        assert bool(after.new) == (enough > 4)


def test_what_is_tracked_but_not_seen_is_not_enough():
    state, _ = run()[0]
    after, info = Mapper(SCALE, CENTRE).step(state, camera("varied", 5).image(POSE), rng=gen())
    assert len(after.tracked) >= 4
    assert not info.located
    assert info.new


def test_repeated_windows_are_taken_only_where_nothing_better_is_in_view():
    """Of two things that look the same one is a pattern only if a rival may be that similar."""
    twins = [
        ("area", rectangle(u, 120, 50, 40, 0.2), 60) for u in (90.0, 230.0)
    ]  # and nothing else
    picture = drawn(twins)

    def first(picture, share):
        mapper = Mapper(1.0, CENTRE, MapRules(repeated=share))
        return mapper.step(mapper.start(), picture, rng=gen())[1]

    assert not first(picture, 0.3).new
    assert len(first(picture, 1.0).new) == 2
    strict, lax = (first(cluttered(4), share) for share in (0.0, 1.0))
    assert len(strict.new) > 1
    assert strict.new == lax.new


def test_blank_pictures_give_no_map_and_the_first_other_one_begins_it():
    mapper, rng = Mapper(SCALE, CENTRE), gen(1)
    state = mapper.start()
    for _ in range(3):
        state, info = mapper.step(state, BLANK, rng=rng)
        assert (state.mosaic.poses, state.count) == ({}, 0)
        assert (info.located, info.new, info.sightings) == (False, (), {})
    state, info = mapper.step(state, film()[0], rng=rng)
    first, told = run()[0]
    assert info.located
    assert state.count == first.count == 1
    assert info.new == told.new == (*state.mosaic.poses,)
    for name, place in told.sightings.items():
        np.testing.assert_array_equal(info.sightings[name], place)
    np.testing.assert_array_equal(state.mosaic.poses["0"], np.zeros(3))


def test_a_blank_picture_later_lets_the_motion_go_on():
    mapper, rng = Mapper(SCALE, CENTRE), gen(3)
    state, _ = run()[4]
    names = {*state.tracked}
    lost = []
    for blank in range(1, 4):
        before = state
        state, info = mapper.step(state, BLANK, rng=rng)
        assert not info.located
        assert not info.sightings
        assert not info.new
        np.testing.assert_array_equal(state.pose, se2.compose(before.pose, before.motion))
        np.testing.assert_array_equal(state.motion, before.motion)
        assert all(one.lost == blank for one in state.tracked.values())
        lost += info.lost
    assert {*lost} == names  # after the third picture, if not at the border before
    assert not state.tracked
    assert state.links.means().keys() == run()[4][0].links.means().keys()
    state, info = mapper.step(
        state, film()[8], rng=rng
    )  # not one in which they are looked for anyway
    assert info.located
    assert len(info.found) >= 2
    error = se2.between(run()[0][0].pose, state.pose) - driven(9, 0.05, 0.0)[-1]
    assert np.hypot(*error[:2]) < 2 * SCALE


# A camera that is mounted anyhow ------------------------------------------------------------------

SIDE = np.zeros(SHAPE, bool)  # only the left two thirds show the ceiling
SIDE[:, :210] = True


@lru_cache
def tilted(turn=0.0, seed=3, *, corrected=True):
    """Return a drive with a camera tilted by 6° and 5° and 18 cm aside."""
    pictures = film(turn=turn, seed=seed, mount=TILTED)
    return mapped(pictures, correction=corrects(TILTED) if corrected else None)


@pytest.mark.parametrize(("turn", "seed"), DRIVES)
def test_corrected_a_tilted_camera_makes_the_map_that_a_level_one_makes(turn, seed):
    """Within a pixel and 0.6° of the truth; not corrected it is further off."""
    path = driven(14, 0.05, turn)

    def off(drive):
        way = np.array([state.pose for state, _ in drive])
        return se2.between(way[0], way) - se2.between(path[0], path)

    level, fixed = off(run(turn=turn, seed=seed)), off(tilted(turn, seed))
    raw = off(tilted(turn, seed, corrected=False))
    for found in (level, fixed):
        assert np.hypot(*found[:, :2].T).max() < SCALE
        assert np.abs(found[:, 2]).max() < math.radians(0.6)
    assert np.hypot(*(fixed - level)[:, :2].T).max() < SCALE
    assert np.hypot(*raw[:, :2].T).max() > 1.3 * SCALE


def test_nothing_is_made_or_kept_where_the_camera_sees_nothing():
    fix = corrects(TILTED)
    assert not fix.seen.all()
    away = np.array(np.nonzero(~fix.seen)).T[:, ::-1]
    made = 0
    for turn, seed in DRIVES:
        for state, info in tilted(turn, seed):
            for one in state.tracked.values():
                assert np.abs(away - one.pose[:2]).max(axis=1).min() > 30
            for name in info.new:  # whole vectors
                pattern, at = state.patterns[name], info.sightings[name]
                phi = pattern.places[:, 2]
                half = pattern.step * (pattern.vectors.shape[1] // 2)
                for side in (-half, half):
                    ends = pattern.seen(at) + side * np.stack([np.cos(phi), np.sin(phi)], axis=-1)
                    u, v = np.rint(ends).astype(int).T
                    assert fix.seen[v, u].all()
                made += 1
    assert made > 6


def test_a_correction_that_changes_nothing_changes_nothing():
    for (state, info), (after, told) in zip(
        run(), mapped(film(), correction=corrects(MOUNT)), strict=True
    ):
        np.testing.assert_array_equal(after.pose, state.pose)
        assert (told.new, told.lost, told.found) == (info.new, info.lost, info.found)


def test_edges_near_to_what_is_not_seen_are_none():
    picture = cluttered(4)
    whole = Sought.of(picture)
    part = Sought.of(picture, None, SIDE, 12)
    np.testing.assert_array_equal(part.edges.mask[:, :198], whole.edges.mask[:, :198])
    assert whole.edges.mask[:, 198:].any()
    assert not part.edges.mask[:, 198:].any()
    np.testing.assert_array_equal(part.edges.gradient, whole.edges.gradient)
    assert all(piece.points(3.0)[:, 0].max() < 199 for piece in part.contours)
    assert whole.seen is None
    some = part.windows(WindowRules(), np.empty((0, 2)), 30.0)
    assert some
    assert all(one.centre[0] < 210 - 30 for one in some)
    rules = WindowRules(strength=0.0, rival=1.0, most=400, apart=10.0)
    beside = {one.centre[0] for one in part.windows(rules, np.empty((0, 2)), 0.0)}
    assert max(beside) > 210 - 30


def test_a_pattern_beyond_what_is_seen_is_let_go_and_not_found():
    state, info = run()[0]
    at = dict(info.sightings)
    half = {name for name, place in at.items() if place[0] < 210 - 31}
    assert 0 < len(half) < len(at)
    trackers = PatternTrackers(state.patterns, MapRules().tracker, 30.0, seen=SIDE)
    after, told = trackers.step(trackers.start(at), film()[0], rng=gen())
    assert {*after} == half == {*at} - {*told.lost}
    sought = Sought.of(film()[0], None, SIDE, 0)
    assert {*look_for(at, state.patterns, sought, MapRules(), rng=gen())} <= half
    with pytest.raises(ValueError, match="seen must be"):
        trackers.step(trackers.start(at), film()[0][:100], rng=gen())
    with pytest.raises(TypeError, match="seen must be an array of truth values, got"), unchecked():
        PatternTrackers(state.patterns, seen=np.ones(SHAPE))


def test_what_is_expected_beyond_what_is_seen_is_not_looked_for(pieces):
    state, _ = tilted()[0]
    fix = corrects(TILTED)
    edge = np.array([np.nonzero(fix.seen[120])[0][-1] - 25.0, 120.0, 0.0, 1.0])
    assert inside(edge, SHAPE, 30.0)
    far = edge - np.array([20.0, 0, 0, 0])
    mosaic = state.mosaic
    for name, place in {"edge": edge, "in": far}.items():
        there = (place[:3] - [*CENTRE, 0]) * [SCALE, SCALE, 1]
        mosaic = mosaic.with_pattern(name, se2.compose(state.pose, there))
    patterns = {**state.patterns, **dict.fromkeys(("edge", "in"), state.patterns["0"])}
    mapper = Mapper(SCALE, CENTRE, MapRules(every=1), fix)
    state = replace(state, mosaic=mosaic, patterns=patterns)
    mapper.step(state, film(mount=TILTED)[0], rng=gen())
    assert [*pieces[-1]] == ["in"]


@given(
    st.integers(-20, 100),
    st.integers(-20, 80),
    st.sampled_from([0.0, 1, 2.5, 4]),
    st.integers(0, 30),
)
def test_a_place_keeps_off_what_is_not_seen(x, y, border, seed):
    """In quarters of a pixel; a pixel that is reached in part counts."""
    seen, (x, y) = gen(seed).uniform(size=(16, 21)) < 0.97, (x / 4, y / 4)
    place = np.array([x, y, 0.3, 1.0])
    within = border <= x <= 20 - border and border <= y <= 15 - border
    near = [
        abs(u - x) < border + 1 and abs(v - y) < border + 1 and (u, v)
        for v, u in np.argwhere(~seen)
    ]
    assert inside(place, seen.shape, border) == within
    assert inside(place, seen.shape, border, seen) == (within and not any(near))


@pytest.mark.parametrize(("at", "reach"), [((5.0, 5.0), (3, 7)), ((5.5, 5.5), (3, 8))])
def test_one_pixel_that_is_not_seen_is_enough_in_the_border_and_nowhere_else(at, reach):
    low, high = reach
    for v, u in np.ndindex(12, 12):
        seen = np.ones((12, 12), bool)
        seen[v, u] = False
        near = low <= u <= high and low <= v <= high
        assert inside(np.array([*at, 0.0, 1.0]), seen.shape, 2.0, seen) == (not near), (u, v)


def test_a_known_pattern_is_found_again_only_where_all_round_it_is_seen():
    state, info = run()[0]
    at = dict(info.sightings)
    name = max(at, key=lambda name: at[name][0])
    cut = np.zeros(SHAPE, bool)
    cut[:, : int(at[name][0] + MapRules().border) + 10] = True
    for seen, there in ((cut, True), (np.roll(cut, -25, axis=1) & cut, False)):
        sought = replace(Sought.of(film()[0]), seen=seen)
        found = look_for({name: at[name]}, state.patterns, sought, MapRules(), rng=gen())
        assert (name in found) == there


def test_windows_keep_off_what_is_not_seen():
    """With edges all over the picture, so that the mask alone keeps them off."""
    part = replace(Sought.of(cluttered(4)), seen=SIDE)
    rules = WindowRules(strength=0.0, rival=1.0, most=400, apart=10.0)
    across = {border: [one.centre[0] for one in part.windows(rules, np.empty((0, 2)), border)]
              for border in (0.0, 30.0)}  # fmt: skip
    assert max(across[30.0]) <= 210 - 30 < max(across[0.0]) < 210


def test_a_mapper_tracks_within_what_its_correction_shows():
    fix = corrects(TILTED)
    trackers = View(fix, MapRules()).trackers({})
    assert not fix.seen.all()
    assert trackers.seen is fix.seen
    assert trackers.border == MapRules().border


def test_a_view_is_checked_and_a_mapper_takes_a_correction():
    with unchecked():
        with pytest.raises(TypeError, match="correction must be a Correction"):
            Mapper(SCALE, CENTRE, MapRules(), 5)
        with pytest.raises(TypeError, match="rules must be a MapRules, got 5"):
            View(None, 5)
    fix = corrects(TILTED)
    view = View(fix, MapRules())
    np.testing.assert_array_equal(view.corrected(film()[0]), fix.apply(film()[0]))
    np.testing.assert_array_equal(View(None, MapRules()).corrected(film()[0]), film()[0])
    assert View(None, MapRules()).seen is None
    assert View(corrects(MOUNT), MapRules()).seen is None
    with pytest.raises(ValueError, match=r"image must be \(240, 320\) pixels, got"):
        Mapper(SCALE, CENTRE, MapRules(), fix).step(
            Mapper(SCALE, CENTRE).start(), BLANK[:100], rng=gen()
        )
    rules = MapRules(rigid=False)
    sightings = {
        name: at + np.array([50.0, 0, 0, 0]) * (name == "3")
        for name, at in run()[0][1].sightings.items()
    }
    kept, slid = agreeing(run()[0][0].mosaic, sightings, rules)
    assert ([*kept], slid) == ([*sightings], ())
    assert agreeing(run()[0][0].mosaic, sightings, MapRules())[1] == ("3",)


# As printed ---------------------------------------------------------------------------------------

HOW = {"centre": np.array(CENTRE), "scale": SCALE}
SIX = WindowRules(most=6)


def chosen(by, mosaic, seen, at=CENTRE):
    """Return the pattern that a word names."""
    if by == "nearest":
        return min(seen, key=lambda n: math.dist(seen[n][:2], at))
    known = [name for name in mosaic.poses if name in seen]
    return known[0] if by == "oldest" else known[-1]


@lru_cache
def printed(by="oldest", **changed):
    """Return a drive as printed, by that pattern."""
    return mapped(film(turn=-0.02, seed=5)[:9], replace(AS_PRINTED, by=by, enough=6, **changed))


@pytest.mark.parametrize("by", ["oldest", "newest", "nearest"])
def test_by_one_pattern_pose_and_map_are_eqs_2_and_3(by):
    """Without the new ones, which are placed after, whichever is seen."""
    moved = 0
    for (before, _), (state, info) in zip(printed(by), printed(by)[1:], strict=False):
        known = {n: at for n, at in info.sightings.items() if n not in info.new}
        assert known
        one = chosen(by, before.mosaic, known)
        pose = camera_pose(before.mosaic.poses[one], in_camera(known[one], **HOW))
        np.testing.assert_array_equal(state.pose, pose)
        for name, there in before.mosaic.poses.items():
            np.testing.assert_array_equal(state.mosaic.poses[name], there)
        for name in info.new:
            at = info.sightings[name]
            one = chosen(by, before.mosaic, known, at[:2])
            there = beside(before.mosaic.poses[one], known[one], at, **HOW)
            np.testing.assert_array_equal(state.mosaic.poses[name], there)
            moved += 1
    assert moved


def test_one_known_pattern_is_enough_and_gives_what_all_would():
    """Least squares of one pattern are eq. (2), and the pose places a new one by eq. (3)."""
    state, _ = run()[0]
    one = {"2": state.tracked["2"]}
    for by in ("all", "oldest", "newest", "nearest"):
        mapper = Mapper(SCALE, CENTRE, MapRules(by=by, windows=SIX))
        after, told = mapper.step(replace(state, tracked=one), film()[1], rng=gen(2))
        assert told.new
        known = told.sightings["2"]
        pose = camera_pose(state.mosaic.poses["2"], in_camera(known, **HOW))
        np.testing.assert_allclose(after.pose, pose, atol=1e-12)
        for name in told.new:
            there = beside(state.mosaic.poses["2"], known, told.sightings[name], **HOW)
            np.testing.assert_allclose(after.mosaic.poses[name], there, atol=1e-12)


def test_in_the_first_picture_others_are_placed_by_the_first_pattern():
    for by in ("oldest", "newest", "nearest"):
        state, info = printed(by)[0]
        assert not state.mosaic.poses["0"].any()
        np.testing.assert_allclose(
            state.pose, camera_pose(np.zeros(3), in_camera(info.sightings["0"], **HOW)), atol=1e-12
        )
        for name in info.new[1:]:
            there = beside(np.zeros(3), info.sightings["0"], info.sightings[name], **HOW)
            np.testing.assert_allclose(state.mosaic.poses[name], there, atol=1e-12)


def test_where_nothing_known_is_seen_a_new_pattern_is_placed_by_the_guess():
    state, _ = run()[0]
    state = replace(state, motion=np.array([0.1, 0.0, 0.0]))
    mapper = Mapper(SCALE, CENTRE, MapRules(by="oldest"))
    after, info = mapper.step(state, camera("varied", 5).image(POSE), rng=gen())
    assert info.new
    assert not info.located
    np.testing.assert_array_equal(after.pose, se2.compose(state.pose, state.motion))
    for name in info.new:
        there = se2.compose(after.pose, in_camera(info.sightings[name], **HOW))
        np.testing.assert_allclose(after.mosaic.poses[name], there, atol=1e-12)


def test_as_printed_nothing_slides_and_nothing_is_closed_up():
    """Two patterns ten px off in the map stay, are tracked on, and move no other."""
    state, _, names = slipped()
    every = replace(AS_PRINTED, tracker=MapRules().tracker, every=1)
    for by, expected in (("oldest", "0"), ("newest", names[-1])):
        after, told = Mapper(SCALE, CENTRE, replace(every, by=by)).step(state, film()[0], rng=gen())
        assert told.closed
        assert {*told.found} == {*names}
        assert not told.lost
        assert {*after.tracked} == {*told.sightings} >= {*state.tracked, *names}
        pose = camera_pose(state.mosaic.poses[expected], in_camera(told.sightings[expected], **HOW))
        np.testing.assert_array_equal(after.pose, pose)
        for name, there in state.mosaic.poses.items():
            np.testing.assert_array_equal(after.mosaic.poses[name], there)


def test_a_robot_is_located_by_the_pattern_that_is_named():
    poses = {"b": np.array([1.0, 0, 0.5]), "a": np.array([0.0, 1, 0.2]), "c": np.array([2.0, 2, 0])}
    mosaic = Mosaic(poses, SCALE, np.array(CENTRE))
    seen = {
        "x": np.array([*CENTRE, 0, 1]),
        "c": np.array([100.0, 0, 0, 1]),
        "a": np.array([150.0, 90, 0.3, 1]),
        "b": np.array([10.0, 20, 0.1, 1]),
    }
    for by, one in (("oldest", "b"), ("newest", "c"), ("nearest", "a")):
        pose = camera_pose(poses[one], in_camera(seen[one], **HOW))
        np.testing.assert_array_equal(located(mosaic, seen, by), pose)
        with pytest.raises(
            NoCommonPattern, match=r"must have a pattern of the mosaic, got \['x'\]"
        ):
            located(mosaic, {"x": seen["x"]}, by)
    np.testing.assert_array_equal(located(mosaic, seen), mosaic.locate(seen)[0])
    with pytest.raises(ValueError, match="by must be"):
        located(mosaic, seen, "last")


def test_as_printed_is_what_the_paper_prints():
    tracker, patterns = AS_PRINTED.tracker, AS_PRINTED.patterns
    assert tracker.particles == 200
    np.testing.assert_allclose(tracker.sigmas, (5, 5, math.radians(3), 0.1))
    assert (tracker.passes, tracker.bad, tracker.smoothing) == (0, "left out", "scale")
    assert (patterns.fall, patterns.centred, patterns.curve, patterns.own) == (
        "padded", False, "line", True,
    )  # fmt: skip
    assert (AS_PRINTED.by, AS_PRINTED.rigid, AS_PRINTED.closing) == ("oldest", False, "none")


def test_as_printed_a_short_drive_is_mapped():
    """Within ten pixels: the printed tracker is coarser."""
    path, start = driven(14, 0.05, -0.02), printed()[0][0].pose
    for pose, (state, info) in zip(path, printed(), strict=False):
        error = se2.between(start, state.pose) - se2.between(path[0], pose)
        assert info.located
        assert np.hypot(*error[:2]) < 10 * SCALE


# Coming back --------------------------------------------------------------------------------------

SLIP = np.array([8.0, 6.0, 0.0]) * SCALE  # ten px


def slipped():
    """Return a state in which two patterns in view are not tracked, and ten px off in the map."""
    state, info = run()[0]
    names = tuple(info.new[-2:])
    mosaic = state.mosaic
    for name in names:
        mosaic = mosaic.with_pattern(name, mosaic.poses[name] + SLIP)
    tracked = {name: one for name, one in state.tracked.items() if name not in names}
    return replace(state, mosaic=mosaic, tracked=tracked), info, names


def test_a_closed_loop_is_adjusted():
    """All poses become those that fit all pictures best; the first pattern stays where it is."""
    state, info, names = slipped()
    state = replace(state, motion=np.array([0.01, 0.0, 0.0]))
    mapper = Mapper(SCALE, CENTRE, MapRules(every=1))
    after, told = mapper.step(state, film()[0], rng=gen(4))
    assert told.closed
    assert {*told.found} == {*names}
    links = state.links.add(told.sightings, centre=np.array(CENTRE), scale=SCALE)
    expected, _ = adjust(state.mosaic, links, fixed="0", loss="cauchy")
    for name, pose in after.mosaic.poses.items():
        np.testing.assert_allclose(pose, expected.poses[name], atol=1e-9)
        true = (info.sightings[name] - info.sightings["0"])[:2] * SCALE
        assert np.hypot(*(pose[:2] - true)) < 1.5 * SCALE
    assert not after.mosaic.poses["0"].any()
    np.testing.assert_allclose(after.pose, after.mosaic.locate(told.sightings)[0], atol=1e-12)
    np.testing.assert_array_equal(after.motion, state.motion)  # a jump is no motion
    assert {*after.tracked} == {*state.tracked, *names}
    pairs = combinations(sorted(info.new), 2)
    assert {p: way.count for p, way in after.links.means().items()} == dict.fromkeys(pairs, 2)


@pytest.mark.parametrize("first", [False, True])
def test_what_no_picture_joins_to_the_loop_is_not_adjusted(first):
    """As after a time without sight; whether the loop or the rest is older."""
    state, *_ = slipped()
    poses = dict(state.mosaic.poses)
    lonely = {"x": np.array([9.0, 9, 1]), "y": np.array([8.0, 9, 2])}
    mosaic = replace(state.mosaic, poses=lonely | poses if first else poses | lonely)
    apart = {name: np.array([9.0, 9, 0, 1]) for name in lonely}
    links = state.links.add(apart, np.array(CENTRE), SCALE)
    patterns = {**state.patterns, **dict.fromkeys(lonely, state.patterns["0"])}
    other = replace(state, mosaic=mosaic, patterns=patterns, links=links)
    mapper = Mapper(SCALE, CENTRE, MapRules(every=1))
    after, told = mapper.step(other, film()[0], rng=gen(4))
    expected, _ = mapper.step(state, film()[0], rng=gen(4))
    assert told.closed
    assert [*after.mosaic.poses] == [*mosaic.poses]
    for name, pose in (expected.mosaic.poses | lonely).items():
        np.testing.assert_allclose(after.mosaic.poses[name], pose, atol=1e-9)


def test_a_closed_loop_stays_as_it_was_chained():
    """The robot is where the pattern says that it knew before; what was chained since goes."""
    state, info, names = slipped()
    mapper = Mapper(SCALE, CENTRE, MapRules(every=1, closing="chain"))
    after, told = mapper.step(state, film()[0], rng=gen(4))
    assert told.closed
    assert {*told.found} == {*names}
    for name, pose in state.mosaic.poses.items():
        np.testing.assert_array_equal(after.mosaic.poses[name], pose)
    known = {name: told.sightings[name] for name in names}
    np.testing.assert_array_equal(after.pose, state.mosaic.locate(known)[0])
    assert np.hypot(*(after.pose - state.pose - SLIP)[:2]) < 1.5 * SCALE
    assert {*after.tracked} == {*told.sightings} == {*names, *told.new}
    together = {pair for pair, link in after.links.means().items() if link.count == 2}
    assert together == {*combinations(sorted(info.new), 2)}


@pytest.mark.parametrize("closing", ["adjust", "chain"])
def test_what_is_found_within_the_gate_closes_nothing(closing):
    state, _, names = slipped()
    mapper = Mapper(SCALE, CENTRE, MapRules(every=1, gate=15.0, closing=closing))
    after, told = mapper.step(state, film()[0], rng=gen(4))
    assert not told.closed
    assert {*told.found} == {*names}
    assert {*after.tracked} == {*state.tracked, *names}
    for name, pose in state.mosaic.poses.items():
        np.testing.assert_array_equal(after.mosaic.poses[name], pose)
    np.testing.assert_allclose(after.pose, state.mosaic.locate(told.sightings)[0], atol=1e-12)
    assert (after.motion != state.motion).any()


def test_what_slid_is_let_go():
    state, info = run()[0]
    mosaic = state.mosaic.with_pattern("3", state.mosaic.poses["3"] + SLIP)
    after, told = Mapper(SCALE, CENTRE).step(replace(state, mosaic=mosaic), film()[0], rng=gen())
    assert told.lost == ("3",)
    assert "3" not in after.tracked
    assert "3" not in told.sightings
    assert "3" in told.tracking
    np.testing.assert_allclose(after.pose, state.pose, atol=SCALE)
    assert {*after.tracked} == {*info.new} - {"3"}


# Pieces -------------------------------------------------------------------------------------------


@lru_cache
def broken(back=False):
    """Return a drive below one ceiling that goes on, after a jump, below another, and back."""
    last = film()[5:9] if back else film(seed=5)[3:6]
    pictures = np.concatenate([film()[:4], film(seed=5)[:3], last])
    return mapped(pictures, MapRules(every=100))  # blind, it looks for known ones all the same


def test_a_mosaic_in_two_pieces_says_so():
    """What was made after the jump is joined to nothing before, and the pose there is a guess."""
    before, after = broken()[:4], broken()[4:]
    first = {*before[-1][0].mosaic.poses}
    for state, info in before:
        assert (info.located, info.piece) == (True, 0)
        assert state.pieces == ((*state.mosaic.poses,),)
    jump, *others = [info for _, info in after]
    assert (jump.located, jump.piece) == (False, None)
    assert jump.new
    for info in others:
        assert info.sightings
        assert (info.located, info.piece) == (False, 1)
    one, two = after[-1][0].pieces
    assert {*one} == first
    assert {*two} == {*after[-1][0].mosaic.poses} - first >= {*jump.new}


def test_back_below_the_first_ceiling_it_is_located_again():
    state, info = broken(back=True)[-1]
    assert len(state.pieces) == 2
    assert (info.located, info.piece) == (True, 0)
    error = se2.between(run()[0][0].pose, state.pose) - driven(9, 0.05, 0.0)[-1]
    assert np.hypot(*error[:2]) < 3 * SCALE


def test_blank_pictures_are_of_no_piece():
    mapper = Mapper(SCALE, CENTRE)
    state, info = mapper.step(mapper.start(), BLANK, rng=gen())
    assert (info.located, info.piece, state.pieces) == (False, None, ())
    _, info = mapper.step(run()[4][0], BLANK, rng=gen())
    assert (info.located, info.piece) == (False, None)


def test_pieces_that_are_seen_together_are_one():
    state, _ = run()[0]
    apart = replace(state, links=Links())
    assert apart.pieces == tuple((name,) for name in state.mosaic.poses)
    after, info = Mapper(SCALE, CENTRE).step(apart, film()[1], rng=gen(2))
    assert after.pieces == ((*after.mosaic.poses,),)
    assert (info.located, info.piece) == (True, 0)


# Parts --------------------------------------------------------------------------------------------

PICTURE = cluttered(4)
AT = np.array([160.0, 120, 0, 1])
PATTERN = make_pattern(PICTURE, (160.0, 120.0), (64.0, 64.0))
RULES = TrackerRules(sigmas=(2.0, 2.0, 0.02, 0.01))


BOTH = PatternTrackers({"a": PATTERN, "b": PATTERN}, RULES)


def followed(states, picture, **more):
    after, info = replace(BOTH, **more).step(states, picture, rng=gen())
    return after, info.patterns, info.lost


def test_several_are_followed_one_after_the_other():
    tracker, places = PatternTracker(PATTERN, RULES), {"b": AT, "a": AT + np.array([1.0, 2, 0, 0])}
    states = BOTH.start(places)
    after, infos, lost = followed(states, PICTURE)
    assert [*states] == [*after] == [*infos] == ["b", "a"]
    assert not lost
    draw = gen()
    for name, place in places.items():
        state, info = tracker.step(tracker.start(place), PICTURE, rng=draw)
        np.testing.assert_array_equal(after[name].particles.states, state.particles.states)
        np.testing.assert_array_equal(infos[name].correlation, info.correlation)
        assert np.hypot(*(after[name].pose - AT)[:2]) < 2


def test_a_pattern_is_let_go_where_it_is_unseen_or_at_the_border():
    states = {"a": PatternTracker(PATTERN, RULES).start(AT)}
    for patience in (1, 2, 3):
        now = states
        for blank in range(1, patience + 1):
            after, infos, lost = followed(now, BLANK, patience=patience)
            assert infos["a"].lost
            assert lost == (("a",) if blank == patience else ())
            assert [*after] == ([] if lost else ["a"])
            now = after
    after, infos, lost = followed(states, PICTURE, border=115.0)
    assert not lost
    after, infos, lost = followed(states, PICTURE, border=125.0)
    assert lost == ("a",)
    assert not after
    assert not infos["a"].lost


def test_what_is_followed_has_a_pattern():
    with pytest.raises(ValueError, match=r"state must have patterns, got none for \['c'\]"):
        followed({"c": PatternTracker(PATTERN, RULES).start(AT)}, PICTURE)
    with pytest.raises(ValueError, match=r"poses must have patterns, got none for \['c'\]"):
        BOTH.start({"c": AT})
    with pytest.raises(ValueError, match="pose must have a positive scale"):
        BOTH.start({"a": AT * [1, 1, 1, -1]})


LOOK = MapRules(tracker=RULES, border=20.0)


SOUGHT = Sought.of(PICTURE)
FITS = recognise(PATTERN, SOUGHT.field, SOUGHT.contours, LOOK.recognition)


def looked(at, sought=SOUGHT, **rules):
    return look_for({"a": at}, {"a": PATTERN}, sought, replace(LOOK, **rules), rng=gen())


@pytest.mark.parametrize(
    ("off", "there"),
    [
        ([0, 0, 0], True),
        ([19.9, 0, 0], True),
        ([20.1, 0, 0], False),
        ([0, -19.9, 0], True),
        ([0, -20.1, 0], False),
        ([-14, 14, 0], True),
        ([-14.3, 14.3, 0], False),
        ([0, 0, 0.29], True),
        ([0, 0, 0.31], False),
        ([0, 0, -0.29], True),
        ([0, 0, -0.31], False),
        ([0, 0, 2 * np.pi - 0.29], True),
    ],
)
def test_a_pattern_is_looked_for_near_where_it_is_expected(off, there):
    """Up to 20 px and 0.3 rad from where its contours fit."""
    best = FITS[0].pose
    np.testing.assert_allclose(best, AT, atol=2.0)
    found = looked(best + np.array([*off, 0]), search=20.0, turn=0.3)
    assert [*found] == (["a"] if there else [])
    if there:
        np.testing.assert_allclose(found["a"].pose, AT, atol=2.0)
        assert found["a"].lost == 0


def test_a_pattern_at_the_border_is_not_looked_for():
    assert looked(AT, border=115.0)
    assert not looked(AT, border=125.0)


def test_what_is_not_in_the_picture_is_not_found():
    assert not looked(AT, Sought.of(BLANK))
    assert not looked(AT, Sought.of(cluttered(5)), search=200.0, turn=3.0)


def twins():
    """Return a picture with two boxes whose outlines are the same, and their places."""
    inner = rectangle(0, 0, 12, 20, 0.4)
    shapes = []
    for u, grey in ((100.0, 60), (220.0, 130)):
        shapes += [
            ("area", rectangle(u, 120, 50, 40), 40),
            ("area", inner + np.array([u - 5, 120]), grey),
        ]
    return drawn(shapes), [np.array([u, 120.0, 0, 1]) for u in (100.0, 220.0)]


@pytest.mark.parametrize("which", [0, 1])
def test_of_several_places_grey_vectors_choose(which):
    """Contours say two places; the pattern is where its greys are."""
    picture, places = twins()
    pattern = make_pattern(picture, tuple(places[which][:2]), (64.0, 64.0))
    sought, rules = Sought.of(picture), replace(LOOK, search=300.0, turn=0.3)
    candidates = recognise(pattern, sought.field, sought.contours, rules.recognition)
    near = [np.hypot(*(one.pose - place)[:2]) < 3 for one in candidates for place in places]
    assert sum(near) >= 2
    (found,) = look_for({"a": places[1 - which]}, {"a": pattern}, sought, rules, rng=gen()).values()
    np.testing.assert_allclose(found.pose[:2], places[which][:2], atol=1.0)


@pytest.mark.parametrize("outside", [0, 1])
def test_of_two_candidates_the_one_half_outside_loses(outside, monkeypatch):
    """What lies outside of the picture matches nothing, however well the rest does."""
    one, *_ = FITS
    fits, tried = [one, replace(one, pose=one.pose + np.array([3, 0, 0, 0]))], []
    monkeypatch.setattr(mapping, "recognise", lambda *_: fits)
    step = PatternTracker.step

    def half_outside(self, state, image, *, rng):
        after, info = step(self, state, image, rng=rng)
        there = np.full(len(info.correlation), 0.9)
        tried.append(after)
        if len(tried) == 1 + outside:
            there[: len(there) // 2] = np.nan
            there[len(there) // 2 :] = 1.0
        return after, replace(info, correlation=there, lost=False)

    monkeypatch.setattr(PatternTracker, "step", half_outside)
    assert looked(AT)["a"] is tried[1 - outside]


def test_only_so_many_candidates_are_tried(monkeypatch):
    tried = []
    step = PatternTracker.step

    def noted(self, state, image, *, rng):
        tried.append(state.pose)
        return step(self, state, image, rng=rng)

    monkeypatch.setattr(PatternTracker, "step", noted)
    wide = {"search": 500.0, "turn": 4.0}
    lax = replace(LOOK.recognition, least=0.0)
    fits = recognise(PATTERN, SOUGHT.field, SOUGHT.contours, lax)
    for most in (1, 3, 10**4):
        tried.clear()
        looked(AT, candidates=most, recognition=lax, **wide)
        assert len(tried) == min(most, len(fits))
        expected = np.array([one.pose for one in fits[:most]])
        np.testing.assert_allclose(np.array(tried)[:, :2], expected[:, :2], atol=1e-9)
    assert len(fits) > 3


PLACES = {name: np.array(pose) for name, pose in zip("abcde", [
    (0.0, 0, 0), (1, 0, 0.5), (0.4, 0.9, -1), (-0.7, 0.6, 2), (0.1, -0.8, 3)
], strict=True)}  # fmt: skip
POSE = np.array([0.2, 0.1, 0.4])


def sighted(scale, off):
    """Return a mosaic of a scale, and what is seen from a pose, some of it off by so many px."""
    unit = np.array([scale / SCALE, scale / SCALE, 1])
    mosaic = Mosaic({n: p * unit for n, p in PLACES.items()}, scale, np.array(CENTRE))
    image = {n: seen(POSE, p) + np.array([*off.get(n, (0, 0)), 0, 0]) for n, p in PLACES.items()}
    return mosaic, image


@pytest.mark.parametrize("scale", [1.0, SCALE])
def test_what_is_off_goes_one_by_one_until_the_rest_agrees(scale):
    """The worst first; what it pulled off comes back in. The gate is in px, whatever the scale."""
    mosaic, image = sighted(scale, {})
    assert consistent(mosaic, image, 0.01)[1] == ()
    mosaic, image = sighted(scale, {"b": (30, 0), "d": (0, 14)})
    kept, slid = consistent(mosaic, image, 6.0)
    assert slid == ("b", "d")
    assert [*kept] == ["a", "c", "e"]
    assert consistent(mosaic, image, 100.0) == (image, ())
    assert [*image] == [*"abcde"]


def misses(mosaic, image):
    """Return how far each is from where the pose of all says it is, px."""
    pose, _ = mosaic.locate(image)
    return {name: np.hypot(*(seen(pose, PLACES[name]) - at)[:2]) for name, at in image.items()}


def test_two_that_contradict_each_other_both_stay():
    mosaic, image = sighted(SCALE, {"b": (90, 0)})
    both = {name: image[name] for name in "ab"}
    assert consistent(mosaic, both, 6.0) == (both, ())
    assert consistent(mosaic, {}, 6.0) == ({}, ())
    three = {name: image[name] for name in "abc"}
    kept, slid = consistent(mosaic, three, 0.0)
    assert (len(kept), len(slid)) == (2, 1)


@settings(max_examples=30)
@given(
    st.dictionaries(st.sampled_from("abcde"), st.tuples(*2 * [st.floats(-40, 40)])),
    st.floats(0.1, 30),
)
def test_what_is_kept_agrees(off, gate):
    mosaic, image = sighted(SCALE, off)
    kept, slid = consistent(mosaic, image, gate)
    assert {*kept} | {*slid} == {*image}
    assert len(kept) + len(slid) == len(image)
    assert len(kept) >= 2
    assert len(kept) == 2 or max(misses(mosaic, kept).values()) <= gate + 1e-9
    for last in slid[::-1]:  # before it went it was the worst, and too far off
        kept = kept | {last: image[last]}
        off_px = misses(mosaic, kept)
        assert off_px[last] > gate
        assert off_px[last] >= max(off_px.values()) - 1e-9


def test_unknown_sightings_are_refused():
    mosaic, image = sighted(SCALE, {})
    with pytest.raises(ValueError, match=r"sightings must be of the mosaic, got \['z'\]"):
        consistent(mosaic, image | {"z": image["a"]}, 6.0)
    with pytest.raises(ValueError, match=r"expected must have patterns, got none for \['z'\]"):
        look_for({"z": AT}, {"a": PATTERN}, Sought.of(PICTURE), LOOK, rng=gen())


@pytest.mark.parametrize("border", [0.0, 1.0, 2.5])
def test_inside_is_a_rectangle(border):
    for u in np.arange(-1, 9, 0.5):
        for v in np.arange(-1, 7, 0.5):
            far = min(u, 7 - u, v, 5 - v)  # of a picture of 8 by 6 pixels
            assert inside(np.array([u, v, 0, 1]), (6, 8), border) == (far >= border)


def test_what_is_sought_in_is_a_picture_with_its_contours():
    many, few = (Sought.of(PICTURE, ContourRules(shortest=least)) for least in (12, 40))
    assert many.image is PICTURE
    assert many.field.size == SIZE
    assert len(many.contours) > len(few.contours)
    at = np.argwhere(few.edges.mask)[:20, ::-1].astype(float)
    assert (few.field.look(at)[0] == 0).all()
    faint = Sought.of(PICTURE, ContourRules(high=60.0))
    assert faint.edges.mask.sum() < few.edges.mask.sum()


# Bad input ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"repeated": 1.5}, "repeated must be from 0 to 1, got 1.5"),
        ({"closing": "open"}, "closing must be one of 'chain', 'adjust', 'none', got"),
        ({"by": "last"}, "by must be one of 'all', 'oldest', 'newest', 'nearest', got 'last'"),
        ({"enough": 0}, "enough must be from 1 to 10000, got 0"),
        ({"every": 0}, "every must be from 1 to 10000, got 0"),
        ({"candidates": 0}, "candidates must be from 1 to 10000, got 0"),
        ({"border": -1.0}, "border must not be negative, got -1"),
        ({"search": -2.0}, "search must not be negative, got -2"),
        ({"turn": -0.5}, "turn must not be negative, got -0.5"),
        ({"gate": -3.0}, "gate must not be negative, got -3"),
    ],
)
def test_rules_out_of_range_are_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        MapRules(**wrong)


@pytest.mark.parametrize("name", ["tracker", "patterns", "windows", "contours", "recognition"])
def test_rules_of_another_kind_are_refused(name):
    with pytest.raises(TypeError, match=f"{name} must be a.* got 5"), unchecked():
        MapRules(**{name: 5})


def test_rules_hand_down_those_of_their_parts():
    rules = MapRules(
        patterns=PatternRules(most=25), windows=WindowRules(most=2, size=(48, 40)), enough=1
    )
    mapper = Mapper(SCALE, CENTRE, rules)
    state, info = mapper.step(mapper.start(), film()[0], rng=gen())
    assert len(info.new) == 2
    for pattern in state.patterns.values():
        assert len(pattern.places) <= 25
        assert pattern.size == (48, 40)
    assert rules.border == 30.0


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"scale": 0.0}, "scale must be positive and finite, got 0"),
        ({"scale": -0.1}, "scale must be positive and finite, got -0.1"),
        ({"centre": (1.0, math.nan)}, "centre must be finite, got"),
        ({"centre": (1.0, 2.0, 3.0)}, r"centre must be \(2,\), got \(3,\)"),
    ],
)
def test_a_mapper_needs_scale_and_centre(wrong, said):
    with pytest.raises(ValueError, match=said), unchecked():
        Mapper(**({"scale": SCALE, "centre": CENTRE} | wrong))


def test_a_mapper_needs_its_kinds():
    with unchecked():
        with pytest.raises(TypeError, match="rules must be a MapRules, got 5"):
            Mapper(SCALE, CENTRE, 5)
        with pytest.raises(TypeError, match="state must be a MapState, got 5"):
            Mapper(SCALE, CENTRE).step(5, BLANK, rng=gen())
        with pytest.raises(TypeError, match="rng must be a Generator, got 5"):
            Mapper(SCALE, CENTRE).step(Mapper(SCALE, CENTRE).start(), BLANK, rng=5)
        with pytest.raises(ValueError, match=r"image must be \('?height'?, '?width'?\), got"):
            Mapper(SCALE, CENTRE).step(Mapper(SCALE, CENTRE).start(), BLANK[0], rng=gen())


@pytest.mark.parametrize(
    ("wrong", "error", "said"),
    [
        ({"mosaic": 5}, TypeError, "mosaic must be a Mosaic, got 5"),
        ({"patterns": {"a": 5}}, TypeError, r"patterns\['a'\] must be a Pattern, got 5"),
        ({"patterns": 5}, TypeError, "patterns must be a Mapping, got 5"),
        ({"tracked": {"a": 5}}, TypeError, r"tracked\['a'\] must be a PatternState, got 5"),
        ({"pose": np.zeros(2)}, ValueError, r"pose must be \(3,\), got \(2,\)"),
        ({"motion": np.full(3, np.inf)}, ValueError, "motion must be finite, got"),
        ({"links": 5}, TypeError, "links must be a Links, got 5"),
        ({"count": -1}, ValueError, "count must be at least 0, got -1"),
    ],
)
def test_a_state_is_checked(wrong, error, said):
    parts = {"mosaic": Mosaic({}, 1.0, np.zeros(2)), "patterns": {}, "tracked": {}}
    parts |= {"pose": np.zeros(3), "motion": np.zeros(3), "links": Links()}
    MapState(**parts)
    with pytest.raises(error, match=said), unchecked():
        MapState(**(parts | wrong))


def test_the_size_of_a_picture_is_that_of_the_camera():
    assert MOUNT.size[::-1] == SHAPE


# Where the camera was -----------------------------------------------------------------------------


def test_a_way_in_two_pieces_is_retraced_in_the_frame_of_each():
    """What slid is left out; a picture of both pieces, or of nothing, is refused."""
    poses = {name: np.array(p) for name, p in zip("abcde", np.eye(5, 3) + 0.2, strict=True)}
    links = Links()
    for group in ("abc", "de"):
        links = links.add({name: np.ones(4) for name in group}, np.array(CENTRE), SCALE)
    parts = pieces_of(Mosaic(poses, SCALE, np.array(CENTRE)), links)
    truth = [np.array([0.3, -0.2, 0.5]), np.array([0.1, 0.4, -1.0])]
    images = [
        {name: seen(pose, pattern) for name, pattern in part.poses.items()}
        for part, pose in zip(parts, truth, strict=True)
    ]
    numbers, way = retrace(parts, images, 6.0)
    assert numbers.tolist() == [0, 1]
    np.testing.assert_allclose(way, truth, atol=1e-9)
    images[0]["c"] = images[0]["c"] + [400, 0, 0, 0]
    np.testing.assert_allclose(retrace(parts, images, 6.0)[1], truth, atol=1e-9)
    for wrong in ({}, images[0] | images[1], {"z": np.ones(4)}):
        with pytest.raises(ValueError, match="seen must be patterns of one of the pieces, got"):
            retrace(parts, [wrong], 6.0)
    assert retrace(parts, [], 6.0)[1].shape == (0, 3)
