"""SLAM with tracked points: against the filter that is told all names, against the textbook where
each particle names by its own map, and laws of its accounts.
"""

from dataclasses import dataclass, fields, is_dataclass, replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.distance import cdist
from scipy.stats import chi2

from robot_perception.beliefs import normalise
from robot_perception.landmarks import DescriptorClasses
from robot_perception.landmarks.metrics import METRICS
from robot_perception.observations import Observations
from robot_perception.particles import effective_number, systematic
from robot_perception.slam import rao_blackwellised as rb
from robot_perception.slam.planar import Odometry
from robot_perception.slam.rao_blackwellised import textbook
from robot_perception.slam.visual import Options, VisualSlam
from tests.slam.rao_blackwellised.drives import MOUNT, assert_close, noises, seen_from
from tests.unchecked import unchecked

seeds = st.integers(0, 10**6)
STILL = Odometry(np.zeros(3), np.zeros((3, 3)))
LOOSE = Options(5, 2, level=1 - 1e-12)
"""Five particles, tracks of more than two frames, and a gate that lets everything pass."""
D = 4


@dataclass
class Frame:
    """What one frame has: points with tracks and descriptors, and in truth the landmark of each."""

    motion: Odometry | None
    seen: Observations
    descriptors: np.ndarray
    truth: np.ndarray

    def told(self, known):
        """Return costs by the truth, of landmarks whose true numbers are known."""
        return lambda asked: np.where(
            self.truth[asked.rows][:, None] == np.array(known)[None], 0.0, np.inf
        )


def unlike(asked):
    return cdist(asked.descriptors, asked.looks.means)


def world(rng, *, laps=2, slip=1.0):
    """Return the frames of laps round a circle: a landmark is in sight for some frames, and again.

    Each time it comes into sight it is a new track; rows are in random order.
    """
    angle = np.linspace(0, laps * 2 * np.pi, laps * 18 + 1)
    poses = np.stack([3 * np.cos(angle), 3 * np.sin(angle), angle + np.pi / 2], axis=-1)
    places = np.column_stack([rng.uniform(-6, 6, (100, 2)), rng.uniform(0.5, 1.7, 100)])
    looks = rng.integers(0, 1000, (len(places), D))
    sigma = slip * np.array([0.01, 0.005, 0.01])
    motions = [None]
    for before, after in pairwise(poses):
        shift = complex(*(after - before)[:2]) * np.exp(-1j * before[2])
        errors = sigma * rng.standard_normal(3)
        increment = np.array([shift.real, shift.imag, after[2] - before[2]])
        motions.append(Odometry(increment + errors, np.diag(sigma**2)))
    tracks, count, frames = {}, 0, []
    for pose, motion in zip(poses, motions, strict=True):
        points = seen_from(pose, places)
        ahead = (points[:, 2] > 0.5) & (points[:, 2] < 4) & (abs(points[:, 0]) < points[:, 2])
        rows = rng.permutation(np.flatnonzero(ahead))
        begun = [row for row in rows.tolist() if row not in tracks]
        tracks = {row: tracks.get(row) for row in rows.tolist()}
        for row in begun:
            tracks[row], count = count, count + 1
        covs = noises(points[rows], rng)
        errors = np.linalg.cholesky(covs) @ rng.standard_normal((len(rows), 3, 1))
        seen = Observations(np.array(list(tracks.values())), points[rows] + errors[..., 0], covs)
        drawn = looks[rows] + rng.integers(-9, 10, (len(rows), D))
        frames.append(Frame(motion, seen, drawn.astype(float), rows))
    return poses, frames


def advance(state, frame, *, options, **how):
    """Take a step to a frame."""
    slam = VisualSlam(MOUNT, options)
    return slam.step(state, frame.motion, frame.seen, frame.descriptors, **how)


def run(poses, frames, options, *, rng, told=True):
    """Return the states and the infos of all frames, and which landmark each one of the map is."""
    each = options.association == "each"
    state, known = VisualSlam(MOUNT, options).start(poses[0], length=D), []
    states, infos = [], []
    for frame in frames:
        costs = frame.told(known) if told else unlike
        state, info = advance(state, frame, costs=costs, options=options, rng=rng)
        known += frame.truth[info.made].tolist()
        assert state.tracks.names.ndim == info.names.ndim == info.new.ndim == 1 + each
        states.append(state)
        infos.append(info)
    return states, infos, known


def lengths_and_means(frames):
    """Return how long each track of each frame is by then, and its mean descriptor, by counting."""
    seen = {}
    for frame in frames:
        for track, descriptor in zip(frame.seen.ids.tolist(), frame.descriptors, strict=True):
            seen.setdefault(track, []).append(descriptor)
        own = [seen[track] for track in frame.seen.ids.tolist()]
        means = np.array([np.mean(rows, axis=0) for rows in own]).reshape(-1, D)
        yield np.array([len(rows) for rows in own], dtype=int), means


def named_filter(pose, frames, options, *, rng):
    """Yield the maps of a filter that is told the name of every point of a track that lasts."""
    maps = rb.ParticleMaps.start(pose, options.particles)
    for frame, (lengths, _) in zip(frames, lengths_and_means(frames), strict=True):
        if frame.motion is not None:
            maps = rb.predict(maps, frame.motion, rng=rng)
        look = frame.seen.named(frame.truth)[lengths > options.stable]
        old = np.isin(look.ids, maps.ids)
        ancestors, evidence = np.arange(len(maps)), 0.0
        if old.any():
            maps, seen = rb.update(maps, look[old], MOUNT)
            maps, info = rb.resample(maps, rng=rng)
            ancestors, evidence = info.ancestors, seen.log_evidence
        maps = rb.add_landmarks(maps, look[~old], MOUNT)
        yield maps, ancestors, evidence


def arrays(thing):
    """Return copies of all arrays that something holds."""
    if isinstance(thing, np.ndarray):
        return [thing.copy()]
    if isinstance(thing, rb.ParticleMaps):
        return arrays([thing.table, thing.sizes, thing.ids, *thing.blocks, thing.particles])
    if is_dataclass(thing):
        return arrays([getattr(thing, f.name) for f in fields(thing)])
    return [a for part in thing for a in arrays(part)] if isinstance(thing, list) else []


def assert_equal(some, others):
    for one, other in zip(arrays(some), arrays(others), strict=True):
        np.testing.assert_array_equal(one, other)


def look(points, *, tracks=None, variance=1e-4):
    """Return observations, without noise, of places as a robot at the origin sees them."""
    points = seen_from(np.zeros(3), np.array(points, float).reshape(-1, 3))
    tracks = np.arange(len(points)) if tracks is None else np.array(tracks)
    return Observations(tracks, points, np.tile(variance * np.eye(3), (len(points), 1, 1)))


def go(state, seen, options, *, costs=None, motion=None, descriptors=None, seed=0):
    """Take a step with equal descriptors, where landmarks cost nothing unless said."""
    descriptors = np.zeros((len(seen), 1)) if descriptors is None else np.array(descriptors, float)
    free = lambda asked: np.zeros((len(asked.rows), len(asked.looks)))  # noqa: E731
    rng = np.random.default_rng(seed)
    slam = VisualSlam(MOUNT, options)
    return slam.step(state, motion, seen, descriptors, costs=costs or free, rng=rng)


def standing(state, *poses):
    """Return the state with its particles elsewhere."""
    weights = state.maps.particles.log_weights
    return replace(state, maps=rb.belief.with_particles(state.maps, np.array(poses), weights))


def begun(seen, options):
    """Return what is known after a first frame at the origin."""
    return go(VisualSlam(MOUNT, options).start(np.zeros(3), length=1), seen, options)[0]


@given(seed=seeds, count=st.integers(1, 6), stable=st.integers(0, 3))
@settings(max_examples=5)
def test_told_the_names_it_is_the_filter_that_knows_them(seed, count, stable):
    """Poses, weights, draws and maps to the bit."""
    poses, frames = world(np.random.default_rng(seed))
    options = Options(count, stable, level=1 - 1e-12, reach=1.0)
    states, infos, known = run(poses, frames, options, rng=np.random.default_rng(1))
    theirs = named_filter(poses[0], frames, options, rng=np.random.default_rng(1))
    for state, info, (maps, ancestors, evidence) in zip(states, infos, theirs, strict=True):
        np.testing.assert_array_equal(state.maps.poses, maps.poses)
        np.testing.assert_array_equal(state.maps.particles.weights, maps.particles.weights)
        np.testing.assert_array_equal(info.resampling.ancestors, ancestors)
        assert info.resampling.log_evidence == evidence
    assert known == maps.ids.tolist()
    assert known
    np.testing.assert_array_equal(states[-1].maps.means, maps.means)
    np.testing.assert_array_equal(states[-1].maps.covs, maps.covs)


def test_the_map_of_one_particle_is_least_squares_on_its_path():
    """All that the account says was used, at once: information adds up."""
    poses, frames = world(np.random.default_rng(3))
    options = Options(1, 2, noise=1.5)
    states, infos, known = run(poses, frames, options, rng=np.random.default_rng(4))
    information, vector = np.zeros((len(known), 3, 3)), np.zeros((len(known), 3))
    for frame, state, info in zip(frames, states, infos, strict=True):
        x, y, a = state.maps.poses[0]
        turn = np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]])
        R, t = turn @ MOUNT[:3, :3], turn @ MOUNT[:3, 3] + [x, y, 0]
        for name, point, cov in zip(info.names, frame.seen.values, frame.seen.covs, strict=True):
            if name >= 0:
                weight = np.linalg.inv(1.5**2 * R @ cov @ R.T)
                information[name] += weight
                vector[name] += weight @ (R @ point + t)
    covs = np.linalg.inv(information)
    assert_close(states[-1].maps.covs[0], covs, 1e-8)
    assert_close(states[-1].maps.means[0], (covs @ vector[..., None])[..., 0], 1e-8)


@given(seed=seeds, stable=st.integers(0, 4))
@settings(max_examples=5)
def test_a_track_is_looked_up_once_by_the_mean_of_its_first_frames(seed, stable):
    poses, frames = world(np.random.default_rng(seed))
    state, known = VisualSlam(MOUNT, Options(2, stable)).start(poses[0], length=D), []
    for frame, (lengths, means) in zip(frames, lengths_and_means(frames), strict=True):
        asked, told = [], frame.told(known)
        before = state
        state, info = advance(
            before,
            frame,
            costs=lambda new, asked=asked, told=told: asked.append(new) or told(new),
            options=Options(2, stable),
            rng=np.random.default_rng(0),
        )
        np.testing.assert_array_equal(info.first, lengths == stable + 1)
        assert (lengths[info.names >= 0] > stable).all()
        assert len(asked) == (info.first.any() and len(known) > 0)
        for new in asked:
            np.testing.assert_array_equal(new.rows, np.flatnonzero(info.first))
            np.testing.assert_allclose(new.descriptors, means[info.first], rtol=1e-14)
            np.testing.assert_array_equal(new.looks.means, before.looks.means)
        known += frame.truth[info.new].tolist()
        np.testing.assert_allclose(state.looks.means[len(before.looks) :], means[info.new])
        np.testing.assert_allclose(state.tracks.means, means)
    assert known


@pytest.mark.parametrize("association", ["shared", "each"])
def test_tracks_that_are_missed_now_and_then_are_those_of_all_their_frames(association):
    """No frame shows a track whose number and its own add up to a multiple of three."""
    poses, frames = world(np.random.default_rng(3))
    thinned = []
    for k, frame in enumerate(frames):
        rows = (frame.seen.ids + k) % 3 > 0
        seen, truth = frame.seen[rows], frame.truth[rows]
        thinned.append(Frame(frame.motion, seen, frame.descriptors[rows], truth))
    options = replace(LOOSE, association=association, patience=1)
    states, infos, _ = run(poses, thinned, options, rng=np.random.default_rng(1))
    counted = lengths_and_means(thinned)
    for frame, before, state, (lengths, means) in zip(
        thinned[1:], states, states[1:], list(counted)[1:], strict=False
    ):
        ours, count = state.tracks, len(frame.seen)
        np.testing.assert_array_equal(ours.ids[:count], frame.seen.ids)
        np.testing.assert_array_equal(ours.lengths[:count], lengths)
        np.testing.assert_allclose(ours.means[:count], means, atol=1e-9)
        old = before.tracks.ids[before.tracks.missed == 0]
        assert set(ours.ids[count:]) == set(old) - set(frame.seen.ids)
        assert (ours.missed == np.r_[np.zeros(count), np.ones(len(ours.ids) - count)]).all()
        assert ours.names.shape[-1] == len(ours.ids)
    hasty = replace(options, patience=0)
    _, fewer, _ = run(poses, thinned, hasty, rng=np.random.default_rng(1))
    used, less = (sum(info.known.any() for info in one) for one in (infos, fewer))
    assert used > 2 * less


def test_a_track_keeps_its_landmark_as_long_as_it_is_waited_for():
    options = Options(1, 0, patience=2)
    never = lambda asked: np.full((len(asked.rows), len(asked.looks)), np.inf)  # noqa: E731
    for frames, name in ((0, 0), (2, 0), (3, 1)):
        state = begun(look([[2, 0, 1]], tracks=[7]), options)
        for _ in range(frames):
            state, _ = go(state, look([]), options)
        assert len(state.tracks.ids) == (frames < 3)
        _, info = go(state, look([[2, 0, 1]], tracks=[7]), options, costs=never)
        assert info.names.tolist() == [name]
        assert info.first.tolist() == [name == 1]


def test_the_names_of_a_track_that_is_waited_for_descend_with_their_particles():
    """Of two particles one recognises the tracks; the other, which does not, is drawn no more."""
    options = Options(2, 0, share=0.0, association="each", patience=1, reach=0.0, unmatched=1e-9)
    state = begun(look([[2, 0, 1], [3, 1, 1]], tracks=[1, 2], variance=1e-2), options)
    state = standing(state, [0.0, 0, 0], [0.0, 5, 0])  # the second is elsewhere
    both = look([[2, 0, 1], [3, 1, 1]], tracks=[3, 4], variance=1e-2)
    state, _ = go(state, both, options, costs=lambda asked: np.where(np.eye(2) > 0, 0.0, np.inf))
    held = state.tracks.names[:, state.tracks.ids == 4]
    assert held.ravel().tolist() == [1, 3]
    one = look([[2, 0, 1]], tracks=[3], variance=1e-2)
    after, info = go(state, one, replace(options, share=1.0))
    assert info.resampling.ancestors.tolist() == [0, 0]
    assert after.tracks.names[:, after.tracks.ids == 4].ravel().tolist() == [1, 1]


@pytest.mark.parametrize("told", [True, False])
def test_accounts_agree_with_the_maps(told):
    poses, frames = world(np.random.default_rng(5))
    states, infos, known = run(poses, frames, LOOSE, rng=np.random.default_rng(6), told=told)
    count = 0
    for frame, state, info in zip(frames, states, infos, strict=True):
        assert info.names[info.new].tolist() == list(range(count, count + info.new.sum()))
        assert (info.names[info.known] < count).all()
        used = info.names[info.names >= 0]
        assert len(set(used.tolist())) == len(used)
        assert not (info.new & ~info.first).any()
        assert not (info.first & (info.names < 0)).any()
        count += info.new.sum()
        assert state.maps.ids.tolist() == list(range(count))
        assert len(state.looks) == count
        held = dict(zip(state.tracks.ids.tolist(), state.tracks.names.tolist(), strict=True))
        for track, name in zip(frame.seen.ids.tolist(), info.names.tolist(), strict=True):
            assert name in (-1, held[track])
        assert 1 <= info.resampling.effective <= 5 * (1 + 1e-12)
        assert info.resampling.resampled == (info.resampling.effective < 2.5)
    recognised = [i for i in infos if (i.first & i.known).any()]
    assert len(recognised) > 5
    assert len(set(known)) == len(known)


def test_by_descriptors_it_finds_what_it_would_have_been_told():
    poses, frames = world(np.random.default_rng(5))
    found, told = (
        run(poses, frames, LOOSE, rng=np.random.default_rng(6), told=told)[1]
        for told in (False, True)
    )
    for one, other in zip(found, told, strict=True):
        np.testing.assert_array_equal(one.names, other.names)


def test_a_step_writes_to_nothing_and_the_same_seed_gives_the_same():
    poses, frames = world(np.random.default_rng(7))
    states, _, known = run(poses, frames[:28], LOOSE, rng=np.random.default_rng(8))
    state, before = states[-1], arrays(states[-1])
    for frame in frames[28:]:
        parts = [frame.seen, frame.descriptors]
        given_ = arrays(parts)
        how = {"costs": frame.told(known), "options": LOOSE}
        twice = [advance(state, frame, **how, rng=np.random.default_rng(9)) for _ in range(2)]
        assert_equal(list(twice[0]), list(twice[1]))
        assert_equal(parts, given_)
        assert_equal(state, before)
        state, info = twice[0]
        before = arrays(state)
        known += frame.truth[info.new].tolist()
    assert info.known.any()


def test_the_first_frame_draws_nothing():
    rng = np.random.default_rng(0)
    state = VisualSlam(MOUNT, LOOSE).start(np.ones(3), length=1)
    seen = look([[2, 0, 1]])
    slam = VisualSlam(MOUNT, LOOSE)
    after, info = slam.step(state, None, seen, np.zeros((1, 1)), costs=unlike, rng=rng)
    assert rng.random() == np.random.default_rng(0).random()
    np.testing.assert_array_equal(after.maps.poses, np.ones((5, 3)))
    assert info.resampling.effective == pytest.approx(5)
    assert not info.resampling.resampled
    assert info.names.tolist() == [-1]


@pytest.mark.parametrize(("reach", "noise"), [(0.0, 1.0), (0.3, 1.0), (0.3, 2.0), (0.0, 3.0)])
def test_the_gate_reaches_as_far_as_is_said(reach, noise):
    """A landmark from one look, seen again beside its place: variance 2 (noise σ)² + reach²."""
    options = Options(1, 0, reach=reach, noise=noise, level=0.9)
    state = begun(look([[2, 0, 1]], variance=0.01), options)
    np.testing.assert_allclose(state.maps.covs[0, 0], 0.01 * noise**2 * np.eye(3), atol=1e-15)
    edge = np.sqrt(chi2.ppf(0.9, 3) * (2 * 0.01 * noise**2 + reach**2))
    for factor, name, new in ((0.999, 0, False), (1.001, 1, True)):
        beside = look([[2, factor * edge, 1]], tracks=[7], variance=0.01)
        after, info = go(state, beside, options)
        assert (info.names.tolist(), info.new.tolist()) == ([name], [new])
        if not new:  # the reach is of the gate alone
            np.testing.assert_allclose(
                after.maps.covs[0, 0], 0.005 * noise**2 * np.eye(3), atol=1e-15
            )


def test_a_cost_up_to_the_limit_is_one_landmark_and_above_it_two():
    options, seen = Options(1, 0, limit=2.0), look([[2, 0, 1]], tracks=[7])
    state = begun(look([[2, 0, 1]]), options)
    for cost, new in ((2.0, False), (2.001, True), (np.inf, True)):
        _, info = go(state, seen, options, costs=lambda _, cost=cost: np.array([[cost]]))
        assert info.new.tolist() == [new]


def test_the_cheapest_newcomer_gets_the_landmark_and_none_gets_one_that_is_taken():
    options = Options(1, 0)
    state = begun(look([[2, 0, 1]]), options)
    two = look([[2, 0, 1], [2, 0.1, 1]], tracks=[5, 6])
    _, info = go(state, two, options, costs=lambda _: np.array([[0.2], [0.1]]))
    assert info.names.tolist() == [1, 0]
    both = look([[2, 0, 1], [2, 0.1, 1]], tracks=[5, 0])
    _, info = go(state, both, options, costs=lambda _: np.array([[0.1]]))
    assert info.names.tolist() == [1, 0]


def test_a_track_out_of_the_gate_is_no_landmark_of_its_own_and_comes_back():
    options = Options(1, 0, reach=0.0)
    state = begun(look([[2, 0, 1]]), options)
    state, info = go(state, look([[2, 1.5, 1]]), options)
    assert (info.names.tolist(), info.new.tolist(), info.first.tolist()) == ([-1], [False], [False])
    state, info = go(state, look([[2, 0, 1]]), options, costs=lambda _: 1 / 0)
    assert info.names.tolist() == [0]
    assert info.known.tolist() == [True]


def test_a_track_that_a_frame_misses_has_ended():
    """It has to last again, and is then looked up; so its number may be used anew."""
    options = Options(1, 1)
    state, seen = begun(look([[2, 0, 1]]), options), look([[2, 0, 1]])
    state, info = go(state, seen, options)
    assert info.new.tolist() == [True]
    state, _ = go(state, seen[:0], options)
    state, info = go(state, seen, options)
    assert (info.names.tolist(), info.first.tolist()) == ([-1], [False])
    state, info = go(state, seen, options)
    assert (info.names.tolist(), info.first.tolist()) == ([0], [True])
    assert len(state.looks) == 1


@pytest.mark.parametrize(
    ("options", "drawn"),
    [
        (Options(5, 2, share=0.0), {False}),
        (Options(5, 2, share=1.0), {True}),
        (Options(5, 2, share=0.0, criterion="printed"), {False}),
        (Options(5, 2, share=0.5, criterion="printed"), {True}),
        (Options(2, 2, share=0.5, criterion="printed"), None),
    ],
)
def test_when_particles_are_drawn(options, drawn):
    """What is printed is 1 but for rounding: below M/2 with five particles, at it with two."""
    poses, frames = world(np.random.default_rng(5))
    states, infos, _ = run(poses, frames, options, rng=np.random.default_rng(6))
    for state, info in zip(states, infos, strict=True):
        if options.share == 0:  # the weights are still those that were judged
            weights = state.maps.particles.weights
            assert info.resampling.effective == pytest.approx(1 / (weights**2).sum())
    seen = {info.resampling.resampled for info in infos if info.known.any()}
    assert drawn is None or seen == drawn
    assert not any(info.resampling.resampled for info in infos if not info.known.any())


def test_without_descriptors_an_oracle_is_enough():
    options = Options(1, 0)
    state = VisualSlam(MOUNT, options).start(np.zeros(3), length=0)
    seen, none = look([[2, 0, 1]]), np.empty((1, 0))
    state, _ = go(state, seen, options, descriptors=none)
    _, info = go(state, look([[2, 0, 1]], tracks=[9]), options, descriptors=none)
    assert info.names.tolist() == [0]


# Each particle by its own map ---------------------------------------------------------------------


@pytest.mark.parametrize("told", [True, False])
def test_with_one_particle_each_is_shared(told):
    poses, frames = world(np.random.default_rng(5))
    shared, each = (
        run(poses, frames, Options(1, 2, association=name), rng=np.random.default_rng(6), told=told)
        for name in ("shared", "each")
    )
    for state, own in zip(shared[0], each[0], strict=True):
        assert_equal([state.maps, state.looks], [own.maps, own.looks])
        np.testing.assert_array_equal(state.tracks.names, own.tracks.names[0])
    for info, own in zip(shared[1], each[1], strict=True):
        assert_equal(info.resampling, own.resampling)
        assert info.resampling.log_evidence == own.resampling.log_evidence
        for name in ("names", "new", "known"):
            np.testing.assert_array_equal(getattr(info, name), getattr(own, name)[0])
        np.testing.assert_array_equal(info.made, own.made)
    assert sum(info.known.sum() for info in each[1]) > 50


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0])
def test_told_the_names_each_particle_says_what_all_would_say(share):
    """To the bit, where the gate lets everything pass."""
    poses, frames = world(np.random.default_rng(5))
    options = Options(4, 2, share=share, level=1 - 1e-12, reach=1.0)
    shared, each = (
        run(poses, frames, replace(options, association=name), rng=np.random.default_rng(6))
        for name in ("shared", "each")
    )
    for state, own in zip(shared[0], each[0], strict=True):
        assert_equal([state.maps, state.looks], [own.maps, own.looks])
    for info, own in zip(shared[1], each[1], strict=True):
        np.testing.assert_array_equal(np.tile(info.names, (4, 1)), own.names)


def own_names(particle, held, frame, rows, means, looks, options):
    """Return the landmark of each row, or nothing, by loops: the cheapest pair first."""
    T = textbook.camera_pose(particle.pose, MOUNT)
    R, t, edge = T[:3, :3], T[:3, 3], chi2.ppf(options.level, 3)
    pairs = []
    for i in rows:
        track, v = int(frame.seen.ids[i]), frame.seen.values[i]
        wide = options.noise**2 * frame.seen.covs[i] + options.reach**2 * np.eye(3)
        for name in [held[track]] if track in held else particle.landmarks:
            cost = 0.0 if track in held else np.linalg.norm(means[i] - looks[name])
            if cost > options.limit:
                continue
            place = particle.landmarks[name]
            innovation = v - R.T @ (place.mean - t)
            squared = innovation @ np.linalg.solve(R.T @ place.cov @ R + wide, innovation)
            if squared <= edge:
                pairs.append((cost, i, name))
    found = {}
    for _, i, name in sorted(pairs):
        if i not in found and name not in found.values():
            found[i] = name
    return found


def one_by_one(pose, frames, options, *, rng):
    """Yield particles of the textbook that each name what they see by their own map.

    A landmark is called by the number of the track that it was made of.
    """
    particles = [textbook.Particle(pose, {}) for _ in range(options.particles)]
    held, looks = [{} for _ in particles], {}
    for frame, (lengths, means) in zip(frames, lengths_and_means(frames), strict=True):
        if frame.motion is not None:
            particles = [textbook.predict(p, frame.motion, rng=rng) for p in particles]
        rows = np.flatnonzero(lengths > options.stable).tolist()
        found = [
            own_names(p, own, frame, rows, means, looks, options)
            for p, own in zip(particles, held, strict=True)
        ]
        used = set().union(*found)
        noisy = Observations(frame.truth, frame.seen.values, options.noise**2 * frame.seen.covs)
        for m, own in enumerate(found):
            seen = noisy[list(own)].named(np.array(list(own.values()), dtype=int))
            p = textbook.update(particles[m], seen, MOUNT)
            missing = (len(used) - len(own)) * np.log(options.unmatched)
            particles[m] = replace(p, log_weight=p.log_weight + missing)
        logs = normalise(np.array([p.log_weight for p in particles]))[0]
        drawn = np.arange(len(particles))
        if used and effective_number(logs) < options.share * len(particles):
            drawn, logs = systematic(np.exp(logs), len(particles), rng=rng), 0 * logs
        particles = [replace(particles[i], log_weight=logs[k]) for k, i in enumerate(drawn)]
        held, found = [dict(held[i]) for i in drawn], [dict(found[i]) for i in drawn]
        for i in np.flatnonzero(lengths == options.stable + 1).tolist():
            track = int(frame.seen.ids[i])
            for m, own in enumerate(found):
                if i not in own:
                    new = noisy[[i]].named(np.array([track]))
                    particles[m] = textbook.add_landmarks(particles[m], new, MOUNT)
                    own[i], looks[track] = track, means[i]
                held[m][track] = own[i]
        yield particles, found


@pytest.mark.parametrize(
    ("seed", "slip", "options"),
    [
        (5, 2.0, Options(4, 1, 0.1, level=0.5, reach=0.0, noise=6.0, unmatched=0.05)),
        (6, 3.0, Options(6, 2, 0.5, level=0.6, reach=0.01, noise=10.0, unmatched=2.0)),
        (7, 2.0, Options(6, 1, 0.6, level=0.5, reach=0.0, noise=6.0, unmatched=0.05)),
    ],
)
def test_each_by_its_own_map_is_the_textbook_particle_by_particle(seed, slip, options):
    """Names, draws, poses, weights and maps, of particles that do not agree."""
    options = replace(options, association="each", limit=600.0)
    poses, frames = world(np.random.default_rng(seed), slip=slip)
    args = poses[0], frames, options
    theirs = one_by_one(*args, rng=np.random.default_rng(1))
    states, infos, _ = run(poses, frames, options, rng=np.random.default_rng(1), told=False)
    made, apart = [], 0
    for frame, state, info, (particles, found) in zip(frames, states, infos, theirs, strict=True):
        made += frame.seen.ids[info.made].tolist()
        for m, (particle, own) in enumerate(zip(particles, found, strict=True)):
            np.testing.assert_allclose(state.maps.poses[m], particle.pose, rtol=0, atol=1e-9)
            named = np.flatnonzero(info.names[m] >= 0)
            assert {i: made[info.names[m, i]] for i in named} == own
            ids, places = state.maps.landmarks(m)
            assert [made[name] for name in ids] == sorted(particle.landmarks, key=made.index)
            expected = [particle.landmarks[made[name]].mean for name in ids]
            np.testing.assert_allclose(places.mean.tolist(), expected, rtol=0, atol=1e-7)
        logs = normalise(np.array([p.log_weight for p in particles]))[0]
        np.testing.assert_allclose(state.maps.particles.weights, np.exp(logs), atol=1e-7)
        apart += (info.names != info.names[0]).any()
    assert apart > 5
    assert not states[-1].maps.known.all()


def test_a_landmark_that_one_particle_recognises_is_new_to_the_other_alone():
    """One stands a metre aside; the density says what it costs it to recognise nothing."""
    options = Options(2, 0, share=0.0, reach=0.0, association="each", unmatched=0.2)
    state = begun(look([[2, 0, 1], [2, 3, 1]]), options)
    seen = look([[2, 0, 1]], tracks=[7])
    after, info = go(standing(state, [0, 0, 0], [0, 1.0, 0]), seen, options)
    assert info.names.tolist() == [[0], [2]]
    assert info.new.tolist() == [[False], [True]]
    assert info.known.tolist() == [[True], [False]]
    assert info.made.tolist() == [True]
    assert after.maps.known.tolist() == [[True, True, False], [True, True, True]]
    assert after.tracks.names.tolist() == [[0], [2]]
    density = (2 * np.pi * 2e-4) ** -1.5  # of the first: two variances of 1e-4 in each axis
    assert after.maps.particles.weights == pytest.approx(np.array([density, 0.2]) / (density + 0.2))
    assert info.resampling.log_evidence == pytest.approx(np.log((density + 0.2) / 2))
    np.testing.assert_allclose(after.maps.means[1, 2], [2, 1, 1], atol=1e-12)
    again, info = go(after, seen, options, costs=lambda _: 1 / 0)  # each follows its own
    assert info.names.tolist() == [[0], [2]]
    assert not info.made.any()
    assert again.maps.covs[:, [0, 2], 0, 0] == pytest.approx(
        np.array([[1e-4 / 3, np.nan], [1e-4, 1e-4 / 2]]), nan_ok=True
    )


def test_each_keeps_to_what_it_took_a_track_for_where_the_gate_would_let_others_pass():
    options = Options(2, 0, share=0.0, reach=0.0, association="each")
    state = begun(look([[2, 0, 1], [2, 1, 1]]), options)
    seen = look([[2, 0, 1]], tracks=[7])
    state, info = go(standing(state, [0, 0, 0], [0, 1.0, 0]), seen, options)
    assert info.names.tolist() == [[0], [1]]
    _, info = go(state, seen, replace(options, reach=2.0))
    assert info.names.tolist() == [[0], [1]]


def test_names_descend_with_the_particles():
    """Where all come from one, all follow what it recognised."""
    options = Options(2, 0, share=1.0, reach=0.0, association="each", unmatched=1e-9)
    state = begun(look([[2, 0, 1]]), options)
    state = standing(state, [0, 1.0, 0], [0, 0, 0])
    after, info = go(state, look([[2, 0, 1]], tracks=[7]), options)
    assert info.resampling.ancestors.tolist() == [1, 1]
    assert info.names.tolist() == after.tracks.names.tolist() == [[0], [0]]
    assert not info.new.any()
    assert len(after.looks) == 1


# How landmarks look ------------------------------------------------------------------------------


def assert_are_classes(looks, stacks):
    """Compare with classes of the descriptors of each stack, one descriptor after the other."""
    assert len(looks) == len(stacks)
    for i, stack in enumerate(stacks):
        one = DescriptorClasses.of(stack[:1])
        for more in stack[1:]:
            one = one.updated(np.zeros(1, dtype=int), more[None])
        np.testing.assert_array_equal(looks.firsts[i], stack[0])
        np.testing.assert_allclose(looks.means[i], one.means[0], rtol=1e-12)
        np.testing.assert_allclose(looks.squares[i], one.squares[0], rtol=1e-9, atol=1e-9)
        assert looks.counts[i] == len(stack)


@pytest.mark.parametrize("association", ["shared", "each"])
def test_looks_are_the_classes_of_the_frames_until_a_landmark_is_made(association):
    """Of tracks by now, of landmarks of as many frames as make one stable, whatever comes later."""
    poses, frames = world(np.random.default_rng(5))
    options = Options(3, 2, association=association)
    states, infos, _ = run(poses, frames, options, rng=np.random.default_rng(6), told=False)
    stacks, made = {}, []
    for frame, state, info in zip(frames, states, infos, strict=True):
        for track, descriptor in zip(frame.seen.ids.tolist(), frame.descriptors, strict=True):
            stacks.setdefault(track, []).append(descriptor)
        made += [np.array(stacks[track]) for track in frame.seen.ids[info.made].tolist()]
        rows = [np.array(stacks[track]) for track in frame.seen.ids.tolist()]
        assert_are_classes(state.tracks.looks, rows)
    assert_are_classes(state.looks, made)
    assert made
    assert set(states[-1].looks.counts.tolist()) == {3}


@pytest.mark.parametrize("association", ["shared", "each"])
@pytest.mark.parametrize("name", METRICS)
def test_every_metric_finds_the_landmark_that_looks_the_same(name, association):
    """Four that lie within the gate of one another; the newcomers are told apart by looks alone."""
    rng = np.random.default_rng(9)
    options = Options(2, 2, reach=1.0, limit=1e9, association=association)
    places = [[2, 0, 1], [2, 0.1, 1], [2, 0.2, 1], [2, 0.3, 1]]
    own, order = rng.integers(0, 256, (4, D)), np.array([2, 0, 3, 1])
    state = VisualSlam(MOUNT, options).start(np.zeros(3), length=D)
    for tracks, rows in ((np.arange(4), np.arange(4)), (np.arange(10, 14), order)):
        for _ in range(3):
            drawn = own[rows] + rng.integers(-9, 10, (4, D))
            seen = look(np.array(places)[rows], tracks=tracks)
            state, info = go(state, seen, options, costs=METRICS[name], descriptors=drawn)
    assert np.atleast_2d(info.names).tolist() == [order.tolist()] * len(np.atleast_2d(info.names))
    assert not info.made.any()


def wrong(state, **more):
    seen = more.pop("seen", look([[2, 0, 1]], tracks=[7]))
    return go(state, seen, more.pop("options", Options(1, 0)), **more)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda s: wrong(s, seen=look([[2, 0, 1]], tracks=[-1])),
            "numbers of their tracks, got -1",
        ),
        (
            lambda s: wrong(s, seen=Observations(np.array([7]), np.ones((1, 3)))),
            "observations must be points .* with covariances",
        ),
        (lambda s: wrong(s, options=Options(2, 0)), "options must be for the 1 particles .* got 2"),
        (
            lambda s: wrong(s, descriptors=np.zeros((1, 2))),
            r"descriptors must be \(1, 1\) for 1 observations",
        ),
        (
            lambda s: wrong(s, costs=lambda _: np.zeros((2, 1))),
            r"costs\(newcomers\) must be \(1, 1\) for 1 newcomers and 1 landmarks, got \(2, 1\)",
        ),
        (lambda s: wrong(s, costs=lambda _: np.array([[-1.0]])), "costs must not be negative"),
        (lambda s: wrong(s, costs=lambda _: np.array([[np.nan]])), "costs must not be .* NaN"),
        (lambda _: Options(particles=0), "particles must be at least 1, got 0"),
        (lambda _: Options(stable=-1), "stable must be at least 0, got -1"),
        (lambda _: Options(share=1.1), "share must be from 0 to 1"),
        (lambda _: Options(criterion="sum"), "criterion must be one of 'effective', 'printed'"),
        (lambda _: Options(limit=-1.0), "limit must not be negative"),
        (lambda _: Options(level=1.0), "level must be between 0 and 1"),
        (lambda _: Options(reach=-0.1), "reach must not be negative"),
        (lambda _: Options(noise=0.0), "noise must be positive"),
        (lambda _: Options(association="all"), "association must be one of 'shared', 'each'"),
        (lambda _: Options(unmatched=0.0), "unmatched must be positive"),
        (
            lambda s: wrong(s, options=Options(1, 0, association="each")),
            "options must have the association of the state, got 'each'",
        ),
        (
            lambda _: wrong(
                VisualSlam(MOUNT, Options(1, association="each")).start(np.zeros(3), length=1)
            ),
            "options must have the association of the state, got 'shared'",
        ),
    ],
)
def test_what_is_wrong_is_said(call, message):
    state = begun(look([[2, 0, 1]]), Options(1, 0))
    with unchecked(), pytest.raises(ValueError, match=message):
        call(state)
