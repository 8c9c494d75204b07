"""Skin: histograms pixel by pixel, samples and windows one by one, faces where they were drawn."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.beliefs import ParticleSet
from robot_perception.people.skin import Cloud, SkinModel, SkinRules, SkinState, SkinTracker
from tests.people.scenes import CENTRE, FOCAL, SIZE, SKIN, WALL, directions, model, picture
from tests.unchecked import unchecked

MODEL = model()
TRACKER = SkinTracker(CENTRE, FOCAL, SIZE, MODEL)
DEGREE = np.deg2rad(1.0)
FACE = (0.7, 15 * DEGREE, 4 * DEGREE)
START = TRACKER.start()
RNG = np.random.default_rng(0)
NOISE = RNG.integers(0, 256, (*SIZE[::-1], 3), dtype=np.uint8)


def follow(images, tracker=TRACKER, state=START, seed=0, **step):
    """Return the state after some images."""
    rng = np.random.default_rng(seed)
    for image in images:
        before, (state, info) = state, tracker.step(state, image, rng=rng, **step)
        assert len(state.clouds) == len(before.clouds) + info.begun - info.ended
        assert all(cloud.images == 1 for cloud in state.clouds[len(state.clouds) - info.begun :])
    return state


# ---- the model -----------------------------------------------------------------------------------


@given(st.integers(0, 2**31), st.integers(2, 40))
def test_ratios_are_those_of_two_histograms(seed, bins):
    rng = np.random.default_rng(seed)
    skin, other = rng.integers(0, 256, (2, 300, 3), dtype=np.uint8)
    found = SkinModel.fit(skin, other, bins=bins, darkest=60, floor=1e-3)
    shares = []
    for pixels in (skin, other):
        counts, bright = np.full((bins, bins), 0.0), 0
        for blue, green, red in pixels.tolist():
            total = blue + green + red
            if total >= 60:
                bright += 1
                row, column = (min(value * bins // total, bins - 1) for value in (red, green))
                counts[row, column] += 1
        shares.append(counts / bright + 1e-3)
    np.testing.assert_allclose(found.log_ratios, np.log(shares[0] / shares[1]), atol=1e-12)


def test_the_colour_counts_and_not_its_brightness():
    skin, wall = np.array([SKIN, WALL], dtype=np.uint8)
    assert MODEL.log_ratio(skin) > 2
    assert MODEL.log_ratio(wall) < -2
    np.testing.assert_allclose(MODEL.log_ratio(skin // 2), MODEL.log_ratio(skin), atol=2.5)
    unknown = np.array([[0, 250, 0], [0, 5, 20]], dtype=np.uint8)  # a colour never seen; the dark
    np.testing.assert_array_equal(MODEL.log_ratio(unknown), [0, 0])


def test_pixels_and_tables_of_another_kind_are_refused():
    pixels = np.full((4, 3), 100, np.uint8)
    with unchecked(), pytest.raises(TypeError, match=r"skin must be an array of bytes.*float64"):
        SkinModel.fit(pixels.astype(float), pixels)
    with (
        unchecked(),
        pytest.raises(ValueError, match="other must hold a pixel as bright as darkest 45"),
    ):
        SkinModel.fit(pixels, pixels // 10)
    with unchecked(), pytest.raises(ValueError, match=r"skin must be \(n, 3\), got \(4, 2\)"):
        SkinModel.fit(pixels[:, :2], pixels)
    with unchecked(), pytest.raises(ValueError, match=r"log_ratios must be \(bins, bins\)"):
        SkinModel(np.zeros((3, 4)))
    with unchecked(), pytest.raises(ValueError, match="log_ratios must hold one bin at least"):
        SkinModel(np.zeros((0, 0)))


# ---- the image -----------------------------------------------------------------------------------


def test_samples_are_of_the_pixels_in_their_direction():
    """Sample by sample, of a picture that is the same over each pixel and its neighbours."""
    smooth = np.repeat(np.repeat(NOISE[::10, ::10], 10, axis=0), 10, axis=1)
    skin, rules = TRACKER.skin(smooth), TRACKER.rules
    rows, columns = skin.shape
    assert (rows, columns) == (86, 720)
    checked = 0
    for i, j in RNG.integers(0, skin.shape, (300, 2)):
        phi = -np.pi + 2 * np.pi * (j + 0.5) / columns
        theta = np.pi / 2 - (rules.band[0] + (i + 0.5) * rules.step)
        u = CENTRE[0] - FOCAL * theta * np.sin(phi)
        v = CENTRE[1] + FOCAL * theta * np.cos(phi)
        around = smooth[int(v - 0.05) : int(v) + 2, int(u - 0.05) : int(u) + 2].reshape(-1, 3)
        if (around == around[0]).all():
            ratio = MODEL.log_ratio(around[0])
            expected = 1 / (1 + (1 - rules.prior) / rules.prior * np.exp(-ratio))
            assert skin[i, j] == pytest.approx(float(expected))
            checked += 1
    assert checked > 150


@pytest.mark.parametrize("edge", [10 * DEGREE, 22 * DEGREE, 33 * DEGREE])
def test_a_ring_begins_and_a_sector_lies_where_they_were_drawn(edge):
    phi, elevation = directions()
    skin = (elevation > edge)[..., None]
    shown = TRACKER.skin(np.where(skin, SKIN, WALL).astype(np.uint8)) > 0.5
    begins = TRACKER.rules.band[0] + TRACKER.rules.step * (~shown).sum(axis=0).mean()
    assert begins == pytest.approx(edge, abs=0.3 * DEGREE)
    skin = (np.abs(phi - edge) < 0.4)[..., None]
    shown = TRACKER.skin(np.where(skin, SKIN, WALL).astype(np.uint8)) > 0.5
    columns = -np.pi + 2 * np.pi * (np.nonzero(shown)[1] + 0.5) / 720
    assert columns.mean() == pytest.approx(edge, abs=0.3 * DEGREE)
    assert len(columns) / 86 * 2 * np.pi / 720 == pytest.approx(0.8, abs=DEGREE)


def test_shares_are_means_over_windows_that_go_on_across_the_seam():
    rules = SkinRules(window=(5 * DEGREE, 3 * DEGREE), step=DEGREE)
    tracker = SkinTracker(CENTRE, FOCAL, SIZE, MODEL, rules)
    skin = RNG.random((43, 360))
    share = tracker._shares(skin)
    low, high = rules.band
    states = RNG.uniform([-np.pi, low], [np.pi, high], (200, 2))
    states[:4] = [[-np.pi, low], [np.pi, high], [3.14, low], [-3.14, high]]
    for state, found in zip(states, share(states), strict=True):
        column = int((state[0] + np.pi) / (2 * np.pi) * 360) % 360
        row = min(int((state[1] - low) / DEGREE), 42)
        columns = np.arange(column - 2, column + 3) % 360
        window = skin[max(row - 1, 0) : row + 2][:, columns]
        assert found == pytest.approx(window.mean())


def test_an_image_that_is_missing_or_of_another_size_is_refused():
    state, rng = TRACKER.start(), np.random.default_rng(0)
    image = picture([FACE])
    for wrong, reason in {
        "missing": (None, "image must be an array of bytes.*None"),
        "float": (image.astype(float), "image must be an array of bytes.*float64"),
        "size": (image[1:], r"image must be \(150, 160, 3\), got \(149, 160, 3\)"),
        "grey": (image[..., 0], r"image must be \(150, 160, 3\), got \(150, 160\)"),
    }.values():
        kind = TypeError if "bytes" in reason else ValueError
        with unchecked(), pytest.raises(kind, match=reason):
            TRACKER.step(state, wrong, rng=rng)
    with unchecked(), pytest.raises(ValueError, match="elapsed must not be negative"):
        TRACKER.step(state, image, rng=rng, elapsed=-1.0)


# ---- the tracker ---------------------------------------------------------------------------------


@pytest.mark.parametrize("phi", [0.0, 1.3, -2.5, np.pi, -np.pi + 0.01])
def test_a_face_is_found_where_it_is(phi):
    found = TRACKER.detect(follow([picture([(phi, 15 * DEGREE, 4 * DEGREE)])] * 15))
    assert found.mean.shape == (1, 2)
    aside = np.angle(np.exp(1j * (found.mean[0, 1] - phi)))
    assert abs(aside) < DEGREE
    assert (0.3 * DEGREE) ** 2 < found.cov[0, 1, 1] < (4 * DEGREE) ** 2
    assert found.mean[0, 0] == TRACKER.rules.distance
    assert found.cov[0, 0, 0] == TRACKER.rules.range_sigma**2
    assert found.cov[0, 0, 1] == 0


def test_directions_of_several_people_and_no_others():
    directions = np.array([-3.0, -1.2, 0.4, 2.0])
    faces = [(phi, (8 + 5 * k) * DEGREE, 4 * DEGREE) for k, phi in enumerate(directions)]
    found = TRACKER.detect(follow([picture(faces)] * 20))
    np.testing.assert_allclose(np.sort(found.mean[:, 1]), directions, atol=1.5 * DEGREE)


def test_a_face_straight_behind_has_one_cloud():
    tracker = SkinTracker(CENTRE, FOCAL, SIZE, MODEL, SkinRules(seeds=4000))
    state = SkinState()
    for k in range(8):
        state = follow([picture([(np.pi, 15 * DEGREE, 3 * DEGREE)])], tracker, state, seed=k)
        assert len(state.clouds) == 1


def test_nobody_is_found_in_an_empty_room_and_in_the_dark():
    assert TRACKER.detect(SkinState()).mean.shape == (0, 2)
    assert TRACKER.detect(follow([picture([])] * 5)).mean.shape == (0, 2)
    assert TRACKER.detect(follow([picture([FACE], light=0.05)] * 10)).mean.shape == (0, 2)


def test_a_cloud_needs_images_to_count_and_outlives_a_few_without_its_face():
    rules = SkinRules(confirm=4, patience=3, seeds=4000)
    tracker = SkinTracker(CENTRE, FOCAL, SIZE, MODEL, rules)
    face, empty = picture([FACE]), picture([])
    counts = [len(tracker.detect(follow([face] * k, tracker)).mean) for k in range(1, 6)]
    assert counts == [0, 0, 0, 1, 1]
    before = follow([face] * 5, tracker)
    once = follow([empty], tracker, before)
    assert len(tracker.detect(once).mean) == 0
    assert [cloud.missed for cloud in once.clouds] == [1]
    assert len(tracker.detect(follow([face], tracker, once, elapsed=0.02)).mean) == 1
    assert len(follow([empty] * 2, tracker, before).clouds) == 1
    assert len(follow([empty] * 3, tracker, before).clouds) == 0


def test_a_face_is_followed_round_and_its_cloud_stays_one():
    directions = np.arange(40) * 3 * DEGREE + np.pi / 2  # 22° a second, across the seam
    state, errors = follow([picture([(directions[0], 0.3, 4 * DEGREE)])] * 5), []
    for k, phi in enumerate(directions):
        state = follow([picture([(phi, 0.3, 4 * DEGREE)])], state=state, seed=k)
        found = TRACKER.detect(state).mean
        assert len(found) == 1
        errors.append(np.angle(np.exp(1j * (found[0, 1] - phi))))
    assert np.abs(errors).max() < 5 * DEGREE
    assert len(state.clouds) == 1


def test_a_turn_of_the_robot_is_taken_off():
    """Twenty degrees from one image to the next: lost, unless the tracker is told."""
    before = follow([picture([FACE])] * 6)
    after = [picture([(FACE[0] - 20 * DEGREE, *FACE[1:])])]
    told = follow(after, state=before, turned=20 * DEGREE)
    assert np.abs(TRACKER.detect(told).mean[0, 1] - FACE[0] + 20 * DEGREE) < 2 * DEGREE
    assert len(TRACKER.detect(follow(after, state=before)).mean) == 0


def test_a_pause_lets_the_particles_wander_farther():
    state = follow([picture([FACE])] * 6)
    flat = np.full((*SIZE[::-1], 3), WALL, np.uint8)
    spread = [
        follow([flat], state=state, elapsed=elapsed).clouds[0].direction[1]
        for elapsed in (0.0, 0.5, 2.0)
    ]
    start = state.clouds[0].direction[1]
    drift = TRACKER.rules.drift[0] ** 2
    assert spread[0] == pytest.approx(start, rel=0.4)
    np.testing.assert_allclose(spread[1:], start + drift * np.array([0.5, 2.0]), rtol=0.6)


def test_a_wide_face_makes_a_wide_cloud():
    sizes = np.array([3.0, 5.0, 8.0])
    spread = []
    for size in sizes:
        state = follow([picture([(0.7, 0.35, size * DEGREE)])] * 25)
        spread.append(state.clouds[0].direction[1])
    assert spread[0] < spread[1] < spread[2]


def test_clouds_that_meet_become_the_older_one():
    rules = SkinRules(apart=7 * DEGREE)
    tracker = SkinTracker(CENTRE, FOCAL, SIZE, MODEL, rules)
    around = DEGREE * np.random.default_rng(3).normal(size=(50, 2))
    old, new = (
        Cloud(ParticleSet.uniform(around + np.array([0.7 + shift, 0.3])), images=images)
        for shift, images in [(0.0, 9), (3 * DEGREE, 5)]
    )
    face = picture([(0.7, 0.3, 6 * DEGREE)])
    assert [c.images for c in follow([face], tracker, SkinState((old, new))).clouds] == [10]
    assert [c.images for c in follow([face], tracker, SkinState((new, old))).clouds] == [6]


def test_the_mean_direction_of_a_cloud_goes_round_the_circle():
    states = np.array([[3.1, 0.2], [-3.1, 0.2], [3.0, 0.2]])
    cloud = Cloud(ParticleSet(states, np.log([0.5, 0.25, 0.25])))
    z = np.exp(1j * states[:, 0])
    mean = np.angle([0.5, 0.25, 0.25] @ z)
    assert cloud.direction[0] == pytest.approx(mean)
    gaps = np.angle(z * np.exp(-1j * mean))
    assert cloud.direction[1] == pytest.approx([0.5, 0.25, 0.25] @ gaps**2)


def test_the_same_seed_gives_the_same_clouds():
    images = [picture([FACE]), NOISE] * 3
    one, two = follow(images), follow(images)
    assert len(one.clouds) == len(two.clouds) > 0
    for a, b in zip(one.clouds, two.clouds, strict=True):
        np.testing.assert_array_equal(a.particles.states, b.particles.states)


@pytest.mark.parametrize(
    ("rules", "reason"),
    [
        ({"band": (0.5, 0.1)}, "band must rise between -π/2 and π/2"),
        ({"band": (0.5, 1.7)}, "band must rise between -π/2 and π/2"),
        ({"step": 1.0}, "step must be from 0.001 to the band's 0.75"),
        ({"window": (0.1, 0.0)}, r"window must be positive, got \(0.1, 0.0\)"),
        ({"least": 1.0}, "least must be between 0 and 1, got 1.0"),
        ({"particles": 0}, "particles must be from 1 to 1000000, got 0"),
    ],
)
def test_rules_that_make_no_sense_are_refused(rules, reason):
    with unchecked(), pytest.raises(ValueError, match=reason):
        SkinRules(**rules)
