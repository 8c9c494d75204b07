"""Where patches lie on their grounds, against centroids; how they shrink and how they end."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from data_synth.ceiling.clutter import clutter, grille_patch, patch, superimpose

DARK = np.zeros((240, 320), dtype=np.uint8)


def blob(at, size=(65, 65), deviation=3.0, height=240):
    """Return a picture of size (columns, rows), black, with a soft dot at a column and row."""
    rows, columns = np.mgrid[: size[1], : size[0]]
    away = (columns - at[0]) ** 2 + (rows - at[1]) ** 2
    return np.rint(height * np.exp(-away / (2 * deviation**2))).astype(np.uint8)


def moments(image):
    """Return middle (2,) and spread along the columns of light."""
    rows, columns = np.mgrid[: image.shape[0], : image.shape[1]]
    image = image / image.sum(dtype=float)
    middle = np.array([(image * columns).sum(), (image * rows).sum()])
    return middle, np.sqrt((image * (columns - middle[0]) ** 2).sum())


@given(
    st.floats(120, 200),
    st.floats(90, 150),
    st.floats(-3.1, 3.1),
    st.floats(0.4, 2.5),
    st.tuples(st.floats(-14, 14), st.floats(-14, 14)),
    st.sampled_from([(64, 64), (65, 64), (70, 61)]),
)
@settings(deadline=None)
def test_points_of_a_patch_are_found_where_the_state_says(x, y, angle, scale, p, size):
    middle = (np.array(size) - 1) / 2
    image = superimpose(DARK, blob(middle + p, size), np.array([x, y, angle, scale]))
    cos, sin = np.cos(angle), np.sin(angle)
    wanted = np.array([x, y]) + scale * np.array([[cos, -sin], [sin, cos]]) @ p
    assert moments(image)[0] == pytest.approx(wanted, abs=0.05)


def test_another_centre_is_the_point_that_lies_at_the_place():
    image = superimpose(
        DARK, blob((40, 22)), np.array([100.25, 80.5, 0.7, 1.3]), centre=(40.0, 22.0)
    )
    assert moments(image)[0] == pytest.approx([100.25, 80.5], abs=0.05)


def test_pixels_on_pixels_are_the_patch_itself():
    rng = np.random.default_rng(0)
    noise = rng.integers(0, 256, (31, 20), dtype=np.uint8)
    ground = rng.integers(0, 256, (90, 80), dtype=np.uint8)
    before = ground.copy(), noise.copy()
    image = superimpose(ground, noise, np.array([9.5 + 30, 15.0 + 40, 0, 1]))
    assert (image[40:71, 30:50] == noise).all()
    image[40:71, 30:50] = ground[40:71, 30:50]
    assert (image == ground).all()
    turned = superimpose(ground, noise, np.array([15.0 + 30, 9.5 + 40, np.pi / 2, 1]))
    assert (turned[40:60, 30:61] == np.rot90(noise, -1)).all()  # columns turn to rows
    assert (before[0] == ground).all()
    assert (before[1] == noise).all()


@pytest.mark.parametrize("scale", [0.3, 0.5, 0.8, 1.0, 1.7])
def test_a_patch_is_averaged_over_its_new_pixels(scale):
    image = superimpose(DARK, blob((32, 32), deviation=4.0), np.array([160.0, 120, 0.4, scale]))
    variance = 16 * scale**2 + max(1 - scale**2, 0) / 12
    assert moments(image)[1] == pytest.approx(np.sqrt(variance), rel=0.01)


def test_what_is_too_fine_for_the_new_pixels_becomes_grey():
    stripes = np.tile(np.array([40, 200], dtype=np.uint8), (64, 32))
    for angle in (0.0, 0.3):
        image = superimpose(DARK, stripes, np.array([160.3, 120, angle, 0.25]))
        inside = image[115:126, 155:166]
        assert inside.std() < 12
        assert inside.mean() == pytest.approx(120, abs=3)


@given(st.floats(-3, 3), st.floats(0.3, 3), st.floats(0, 1), st.floats(0, 1))
@settings(deadline=None)
def test_a_patch_covers_its_area_and_ends_within_a_pixel(angle, scale, x, y):
    white = np.full((41, 30), 250, dtype=np.uint8)
    image = superimpose(DARK, white, np.array([160 + x, 120 + y, angle, scale]))
    share = image / 250
    assert share.sum() == pytest.approx(41 * 30 * scale**2, abs=0.06 * 142 * scale)
    rows, columns = np.mgrid[:240, :320]
    east, south = columns - 160 - x, rows - 120 - y
    cos, sin = np.cos(angle), np.sin(angle)
    out = np.maximum(
        np.abs(cos * east + sin * south) - 15 * scale,
        np.abs(cos * south - sin * east) - 20.5 * scale,
    )
    assert (share[out < -0.51] == 1).all()
    assert (share[out > 0.51] == 0).all()
    assert share.max() <= 1


def test_a_patch_beyond_the_ground_is_cut_off():
    white = np.full((21, 21), 250, dtype=np.uint8)
    corner = superimpose(DARK, white, np.array([0.0, 0.0, 0, 1]))
    assert (corner[:11, :11] == 250).all()
    assert corner.sum(dtype=int) == 250 * 121
    end = superimpose(DARK, white, np.array([319.0, 239.0, 0, 1]))
    assert end.sum(dtype=int) == 250 * 121
    assert (superimpose(DARK, white, np.array([-500.0, 90, 1, 1])) == 0).all()


def test_grounds_are_cluttered_and_each_is_another():
    one, same, other = (clutter((320, 240), rng=np.random.default_rng(k)) for k in (1, 1, 2))
    assert one.shape == (240, 320)
    assert one.dtype == np.uint8
    assert (one == same).all()
    assert abs(np.corrcoef(one.ravel(), other.ravel())[0, 1]) < 0.2
    assert np.percentile(one, 5) < 70
    assert np.percentile(one, 95) > 190
    steep = np.hypot(*np.gradient(one.astype(float))) > 25
    blocks = steep.reshape(6, 40, 8, 40).mean(axis=(1, 3))
    assert (blocks > 0.02).mean() > 0.9  # edges nearly everywhere


@pytest.mark.parametrize("side", [32, 64])
def test_patches_show_something_in_the_middle_of_a_ceiling(side):
    seen = [patch(rng=rng, side=side) for rng in np.random.default_rng(0).spawn(30)]
    assert {(p.shape, p.dtype.str) for p in seen} == {((side, side), "|u1")}
    low, high = side // 5, side - side // 5
    inside = np.mean([p[low:high, low:high].std() for p in seen])
    corner = np.median([p[: side // 8, : side // 8] for p in seen])
    assert inside > 30
    assert corner == pytest.approx(186, abs=4)
    assert (patch(rng=np.random.default_rng(3)) == patch(rng=np.random.default_rng(3))).all()


@pytest.mark.parametrize("scale", [0.0, -1.0, 51.0])
def test_bad_scales_are_named(scale):
    with pytest.raises(ValueError, match="state must have a scale"):
        superimpose(DARK, DARK, np.array([0.0, 0, 0, scale]))


def changes(image):
    """Return how often each line of greys crosses its middle, rows and columns of contrast."""
    greys = image.astype(float)
    lines = [line for line in (*greys, *greys.T) if np.ptp(line) > 60]
    above = [line > (line.min() + line.max()) / 2 for line in lines]
    return [int((one[1:] != one[:-1]).sum()) for one in above]


def test_a_grille_has_many_stripes_and_its_plate_few():
    each = [changes(grille_patch(rng=rng, side=88)) for rng in np.random.default_rng(0).spawn(30)]
    assert np.median([max(one) for one in each]) >= 8
    assert np.median([min(one) for one in each]) <= 4


def test_stripes_at_half_the_pitch_are_more():
    counts = [
        np.median(
            [
                np.percentile(changes(grille_patch(rng=rng, side=256, pitch=pitch)), 90)
                for rng in np.random.default_rng(1).spawn(20)
            ]
        )
        for pitch in (4.0, 8.0)
    ]
    assert counts[0] > 1.4 * counts[1]


def test_the_same_generator_paints_the_same_grille():
    one, other = (grille_patch(rng=np.random.default_rng(3), side=40) for _ in range(2))
    assert (one == other).all()
