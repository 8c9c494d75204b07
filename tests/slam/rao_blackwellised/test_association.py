"""Association in space and by descriptors: by hand, and against loops over everything."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import chi2

from robot_perception.beliefs import ParticleSet
from robot_perception.observations import Observations, unnamed
from robot_perception.slam.rao_blackwellised import (
    ParticleMaps,
    add_landmarks,
    associate_each,
    associate_shared,
    textbook,
)
from tests.slam.rao_blackwellised.drives import MOUNT, maps_of, noises, seen_from
from tests.unchecked import unchecked

seeds = st.integers(0, 10**6)
A, B, C = 10, 20, 30
PLACES = np.array([[4.0, 0.5, 1.0], [4.0, -0.5, 1.0], [9.0, 0.0, 1.0]])
LEVEL = chi2.cdf(9.0, 3)  # three standard deviations


def two_paths(weights=(0.75, 0.25), variance=0.02):
    """Return two particles, one a metre to the left of the other, with the same three landmarks."""
    poses = np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    covs = np.tile(variance * np.eye(3), (2, 3, 1, 1))
    particles = ParticleSet(poses, np.log(weights))
    return ParticleMaps(particles, np.array([A, B, C]), np.stack([PLACES, PLACES]), covs)


def look(*points, variance=0.02):
    """Return sights, without names, of points as the first particle sees them."""
    values = seen_from(np.zeros(3), np.array(points))
    return unnamed(values, np.tile(variance * np.eye(3), (len(points), 1, 1)))


def test_what_one_particle_takes_for_one_landmark_another_takes_for_the_other():
    """A point at B for the first particle lies at A for the second, a metre to the left."""
    maps, seen = two_paths(), look(PLACES[1])
    assert associate_each(maps, seen, MOUNT, level=LEVEL).tolist() == [[B], [A]]
    assert associate_shared(maps, seen, MOUNT, level=LEVEL, by="best").tolist() == [B]
    turned = two_paths((0.25, 0.75))
    assert associate_shared(turned, seen, MOUNT, level=LEVEL, by="best").tolist() == [A]
    assert associate_shared(turned, seen, MOUNT, level=LEVEL, by="mean").tolist() == [A]


def test_the_mixture_has_the_mean_and_the_spread_of_its_particles():
    """Innovations of B across the path: 0 and 1 m with weights 3/4 and 1/4.

    Mean 1/4, variance 0.04 + 3/16; the other axes have none. Just outside the gate there is no
    landmark, just inside there is. For one particle alone, 1 m is five standard deviations.
    """
    maps, seen = two_paths(), look(PLACES[1])
    squared = 0.25**2 / (0.04 + 3 / 16)
    for factor, found in ((0.999, -1), (1.001, B)):
        level = chi2.cdf(factor * squared, 3)
        assert associate_shared(maps, seen, MOUNT, level=level, by="mean").tolist() == [found]
    halfway = look([4.0, 0.5, 1.0])
    costs = np.array([[np.inf, 0.0, np.inf]])  # B alone: innovations 1 m and 2 m
    squared = 1.25**2 / (0.04 + 3 / 16)
    for factor, found in ((0.999, -1), (1.001, B)):
        level = chi2.cdf(factor * squared, 3)
        said = associate_shared(maps, halfway, MOUNT, costs=costs, level=level, by="mean")
        assert said.tolist() == [found]
    said = associate_shared(maps, halfway, MOUNT, costs=costs, level=LEVEL, by="best")
    assert said.tolist() == [-1]


def test_descriptors_choose_among_the_landmarks_that_the_gate_lets_pass():
    """Of two near ones the more alike, although the other is nearer; never a twin far away."""
    maps = two_paths(variance=0.2)
    seen = look([4.0, -0.1, 1.0], variance=0.2)

    def found(*costs, **more):
        return associate_shared(
            maps, seen, MOUNT, costs=np.array([costs]), level=LEVEL, by="best", **more
        ).tolist()

    assert associate_shared(maps, seen, MOUNT, level=LEVEL, by="best").tolist() == [B]
    assert found(0.1, 0.2, 9.0) == [A]
    assert found(0.2, 0.1, 9.0) == [B]
    assert found(0.2, 0.3, 0.0) == [A]
    assert found(0.2, 0.3, 0.0, limit=0.25) == [A]
    assert found(0.2, 0.3, 0.0, limit=0.2) == [A]
    assert found(0.2, 0.3, 0.0, limit=0.19) == [-1]
    assert found(np.inf, np.inf, 0.0) == [-1]


def test_each_landmark_is_given_once_the_cheapest_pair_first():
    maps = two_paths(variance=0.2)
    seen = look([4.0, 0.1, 1.0], [4.0, -0.1, 1.0], variance=0.2)
    costs = np.array([[0.3, 0.2, 9.0], [0.4, 0.1, 9.0]])
    said = associate_shared(maps, seen, MOUNT, costs=costs, level=LEVEL, by="best")
    assert said.tolist() == [A, B]
    said = associate_shared(maps, seen, MOUNT, costs=costs, limit=0.25, level=LEVEL, by="best")
    assert said.tolist() == [-1, B]


def test_a_name_is_kept_and_its_landmark_not_given_away():
    maps = two_paths(variance=0.2)
    seen = look([4.0, 0.1, 1.0], [4.0, -0.1, 1.0], [4.0, -0.4, 1.0], variance=0.2)
    seen = seen.named(np.array([77, B, -1]))
    for by in ("best", "mean"):
        assert associate_shared(maps, seen, MOUNT, by=by).tolist() == [77, B, A]
    assert associate_each(maps, seen, MOUNT).tolist()[0] == [77, B, A]
    costs = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.6, 0.0, 9.0]])
    said = [associate_shared(maps, seen, MOUNT, costs=costs, limit=k) for k in (0.5, 0.6)]
    assert [names.tolist() for names in said] == [[77, B, -1], [77, B, A]]
    assert associate_each(maps, seen[:2], MOUNT).tolist() == [[77, B], [77, B]]


def test_a_landmark_that_a_particle_does_not_have_is_not_for_it():
    maps, seen = two_paths(), look([4.0, 0.0, 2.0])
    where = np.array([[False], [True]])
    maps = add_landmarks(maps, seen.named(np.array([40])), MOUNT, where)
    assert associate_each(maps, seen, MOUNT).tolist() == [[-1], [40]]
    assert associate_shared(maps, seen, MOUNT, by="best").tolist() == [-1]
    assert associate_shared(maps, seen, MOUNT, by="mean").tolist() == [40]
    never = np.zeros((2, 1), dtype=bool)
    maps = add_landmarks(two_paths(), seen.named(np.array([40])), MOUNT, never)
    assert associate_shared(maps, seen, MOUNT, by="mean").tolist() == [-1]


def test_without_landmarks_or_observations_there_is_nothing_to_find():
    empty, seen = ParticleMaps.start(np.zeros(3), 2), look(PLACES[0])
    assert associate_shared(empty, seen, MOUNT).tolist() == [-1]
    assert associate_shared(empty, seen, MOUNT, costs=np.empty((1, 0))).tolist() == [-1]
    assert associate_each(empty, seen, MOUNT).tolist() == [[-1], [-1]]
    assert associate_each(two_paths(), seen[:0], MOUNT).shape == (2, 0)
    assert associate_shared(two_paths(), seen[:0], MOUNT, by="best").shape == (0,)


def test_what_a_particle_holds_an_observation_for_it_takes_it_for_or_for_nothing():
    maps, seen = two_paths(variance=0.2), look([4.0, -0.1, 1.0], [4.0, 0.1, 1.0], variance=0.2)
    either = associate_each(maps, seen, MOUNT, np.full((2, 2), -1))
    assert either.tolist() == associate_each(maps, seen, MOUNT).tolist()
    held = np.array([[A, -1], [-1, -1]])
    said = associate_each(maps, seen, MOUNT, held)
    assert said[0].tolist() == [-1, A]  # the other one is nearer to A and comes first
    costs = np.array([[0.0, 0.0, 9.0], [0.5, 0.4, 9.0]])
    said = associate_each(maps, seen, MOUNT, held, costs=costs)
    assert said[0].tolist() == [A, B]
    said = associate_each(maps, seen, MOUNT, np.roll(held, 1, axis=0), costs=costs)
    assert said[0].tolist() == [A, B]
    far = associate_each(maps, seen, MOUNT, np.array([[C, -1], [C, C]]), level=LEVEL)
    assert far.tolist() == [[-1, A], [-1, -1]]
    three = look([4.0, 0.0, 1.0], [4.0, -0.1, 1.0], [4.0, 0.1, 1.0], variance=0.2)
    three = three.named(np.array([77, -1, -1]))  # a name is kept, whatever is held
    said = associate_each(maps, three, MOUNT, np.array([[A, B, -1], [-1, C, C]]), level=LEVEL)
    assert said.tolist() == [[77, B, A], [77, -1, -1]]
    said = associate_each(
        maps, three.named(np.array([A, -1, -1])), MOUNT, np.array([[-1, B, -1], [-1, C, C]])
    )
    assert said.tolist() == [[A, B, -1], [A, -1, -1]]
    gone = associate_each(maps, seen, MOUNT, np.array([[77, -1], [A, -1]]))
    assert gone[0].tolist() == [-1, A]


def brute_force(maps, observations, costs, limit, level, held=None):
    """Return names for each particle by loops: all pairs, sorted by cost, each landmark once."""
    free = np.full((len(maps), len(observations)), -1)
    held = free if held is None else held
    found = np.full((len(maps), len(observations)), -1)
    squared = np.empty((len(maps), len(observations), maps.ids.size))
    for m, pose in enumerate(maps.poses):
        T = textbook.camera_pose(pose, MOUNT)
        pairs = []
        for i, (v, Q) in enumerate(zip(observations.values, observations.covs, strict=True)):
            for n in range(maps.ids.size):
                innovation = v - T[:3, :3].T @ (maps.means[m, n] - T[:3, 3])
                Z = T[:3, :3].T @ maps.covs[m, n] @ T[:3, :3] + Q
                squared[m, i, n] = innovation @ np.linalg.solve(Z, innovation)
                cost = squared[m, i, n] if costs is None else costs[i, n]
                meant = held[m, i] in (-1, maps.ids[n])
                if meant and squared[m, i, n] <= chi2.ppf(level, 3) and cost <= limit:
                    pairs.append((cost, i, n))
        for _, i, n in sorted(pairs):
            if found[m, i] == -1 and maps.ids[n] not in found[m]:
                found[m, i] = maps.ids[n]
    return found


@given(seed=seeds, described=st.booleans())
@settings(max_examples=30)
def test_each_particles_answer_is_that_of_brute_force(seed, described):
    rng = np.random.default_rng(seed)
    maps = maps_of(rng, 3, 12)
    values = seen_from(maps.poses[0], maps.means[0, :6] + 0.3 * rng.standard_normal((6, 3)))
    seen = unnamed(values, noises(values, rng))
    costs = rng.random((6, 12)) if described else None
    limit = 0.7 if described else np.inf
    expected = brute_force(maps, seen, costs, limit, 0.9)
    ours = associate_each(maps, seen, MOUNT, costs=costs, limit=limit, level=0.9)
    assert ours.tolist() == expected.tolist()
    best = associate_shared(maps, seen, MOUNT, costs=costs, limit=limit, level=0.9, by="best")
    assert best.tolist() == expected[maps.best].tolist()
    held = np.where(rng.random((3, 6)) < 0.5, maps.ids[rng.integers(0, 12, (3, 6))], -1)
    expected = brute_force(maps, seen, costs, limit, 0.9, held)
    ours = associate_each(maps, seen, MOUNT, held, costs=costs, limit=limit, level=0.9)
    assert ours.tolist() == expected.tolist()


def partly_known(rng):
    """Return three particles, each with some of nine landmarks, six sights of these, and costs.

    The landmarks lie so near to each other that several can be the one that is seen.
    """
    maps = maps_of(rng, 3, 1)
    places = rng.uniform(-5, 5, 3) + 0.05 * rng.standard_normal((9, 3))
    values = seen_from(maps.poses[0], places)
    marks = Observations(np.arange(100, 109), values, noises(values, rng))
    maps = add_landmarks(maps, marks, MOUNT, rng.random((3, 9)) < 0.5)
    some = rng.permutation(9)[:6]
    return maps, unnamed(values[some], marks.covs[some]), rng.random((6, maps.ids.size))


@given(seed=seeds, described=st.booleans())
@settings(max_examples=30)
def test_the_order_of_the_observations_does_not_matter(seed, described):
    rng = np.random.default_rng(seed)
    maps, seen, costs = partly_known(rng)
    costs = costs if described else None
    order = rng.permutation(6)
    sorted_costs = None if costs is None else costs[order]
    before = associate_each(maps, seen, MOUNT, costs=costs)
    after = associate_each(maps, seen[order], MOUNT, costs=sorted_costs)
    assert after.tolist() == before[:, order].tolist()
    for by in ("best", "mean"):
        before = associate_shared(maps, seen, MOUNT, costs=costs, by=by)
        after = associate_shared(maps, seen[order], MOUNT, costs=sorted_costs, by=by)
        assert after.tolist() == before[order].tolist()


@given(seeds)
@settings(max_examples=30)
def test_what_has_a_name_only_takes_its_landmark_away(seed):
    """The others find what they find without it where no cost allows that landmark."""
    rng = np.random.default_rng(seed)
    maps, seen, costs = partly_known(rng)
    told = rng.random(6) < 0.5
    names = np.where(told, rng.permutation(maps.ids)[:6], -1)
    rest = np.where(np.isin(maps.ids, names), np.inf, costs)[~told]
    found = associate_each(maps, seen.named(names), MOUNT, costs=costs)
    assert (found[:, told] == names[told]).all()
    assert (found[:, ~told] == associate_each(maps, seen[~told], MOUNT, costs=rest)).all()


@given(seeds)
@settings(max_examples=20)
def test_of_one_particle_the_mixture_is_the_particle(seed):
    rng = np.random.default_rng(seed)
    maps = maps_of(rng, 1, 12)
    values = seen_from(maps.poses[0], maps.means[0, :6] + 0.3 * rng.standard_normal((6, 3)))
    seen = unnamed(values, noises(values, rng))
    one = associate_shared(maps, seen, MOUNT, by="mean")
    assert one.tolist() == associate_shared(maps, seen, MOUNT, by="best").tolist()


@pytest.mark.parametrize("by", ["best", "mean"])
def test_points_and_landmarks_without_noise_are_refused(by):
    maps, seen = two_paths(variance=0.0), look(PLACES[0], PLACES[1], variance=0.0)
    if by == "best":  # the mixture has the spread of the particles across, but none along
        with pytest.raises(ValueError, match=r"observations: the covariance .* is singular"):
            associate_each(maps, seen, MOUNT)
    with pytest.raises(ValueError, match=r"observations: the covariance .* is singular"):
        associate_shared(maps, seen, MOUNT, by=by)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"costs": np.ones((1, 2))}, r"costs must be \(1, 3\) for 1 observations and 3 landmarks"),
        ({"costs": np.array([[1.0, np.nan, 1.0]])}, "costs must not be negative or NaN"),
        ({"costs": np.array([[1.0, -1.0, 1.0]])}, "costs must not be negative or NaN, got -1"),
        ({"limit": np.nan}, "limit must be a number, got nan"),
        ({"level": 1.0}, "level must be between 0 and 1, got 1"),
        ({"by": "worst"}, "by must be one of 'best', 'mean', got 'worst'"),
    ],
)
def test_what_is_wrong_is_said(wrong, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        associate_shared(two_paths(), look(PLACES[0]), MOUNT, **wrong)


@pytest.mark.parametrize(
    ("held", "message"),
    [
        (np.array([[A]]), r"held must be \(2, 1\) for 2 particles and 1 observations"),
        (np.array([[A], [-2]]), "held must be at least -1, got -2"),
        (np.array([[A], [0.5]]), "held must be integers"),
    ],
)
def test_what_is_held_wrongly_is_said(held, message):
    with unchecked(), pytest.raises(ValueError, match=message):
        associate_each(two_paths(), look(PLACES[0]), MOUNT, held)


def test_observations_need_covariances():
    bare = Observations(np.array([-1]), np.ones((1, 3)))
    with pytest.raises(ValueError, match=r"with covariances, got .* with none"):
        associate_each(two_paths(), bare, MOUNT)
