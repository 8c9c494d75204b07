"""Pictures and their reduced copies."""

import numpy as np
import pytest

from data_synth.textures import KINDS, make_atlas, paint


@pytest.mark.parametrize("kind", KINDS)
def test_pictures_follow_their_generator_and_differ_between_draws(kind):
    rng = np.random.default_rng(1)
    one, two = paint(kind, rng=rng), paint(kind, rng=rng)
    assert one.dtype == np.uint8
    np.testing.assert_array_equal(one, paint(kind, rng=np.random.default_rng(1)))
    assert (one != two).any()
    assert all(n & (n - 1) == 0 for n in one.shape)


@pytest.mark.parametrize("kind", KINDS[:7])
def test_what_repeats_has_no_seam(kind):
    picture = paint(kind, rng=np.random.default_rng(2)).astype(float)
    for axis in (0, 1):
        steps = np.abs(np.roll(picture, 1, axis=axis) - picture).mean(axis=1 - axis)
        assert steps[0] <= steps[1:].max() + 1


def test_a_bare_wall_is_bare():
    assert paint("plaster", rng=np.random.default_rng(0)).std() < 2
    assert paint("poster", rng=np.random.default_rng(0)).std() > 40


def test_copies_are_means_of_blocks():
    rng = np.random.default_rng(3)
    pictures = [rng.integers(0, 256, shape).astype(float) for shape in ((16, 8), (2, 32), (1, 1))]
    atlas = make_atlas(pictures)
    assert atlas.starts.shape == (3, 6)
    for p, picture in enumerate(pictures):
        for level in range(6):
            down, across = (min(2**level, n) for n in picture.shape)
            blocks = picture.reshape(-1, down, picture.shape[1] // across, across)
            wanted = blocks.mean(axis=(1, 3))
            rows, columns = atlas.sizes[p, level]
            assert (rows, columns) == wanted.shape
            start = atlas.starts[p, level]
            found = atlas.texels[start : start + rows * columns].reshape(rows, columns)
            np.testing.assert_allclose(found, wanted, atol=0.5)
    assert atlas.texels.size == sum(
        atlas.sizes[p, : int(np.log2(max(pic.shape))) + 1].prod(axis=-1).sum()
        for p, pic in enumerate(pictures)
    )


@pytest.mark.parametrize(
    ("pictures", "said"),
    [
        ([np.zeros((3, 4))], r"power of two, got \(3, 4\)"),
        ([np.zeros(4)], r"got \(4,\)"),
        ([np.full((2, 2), 256.0)], "from 0 to 255"),
        ([np.full((2, 2), np.nan)], "from 0 to 255"),
    ],
)
def test_pictures_of_wrong_shape_or_value_are_refused(pictures, said):
    with pytest.raises(ValueError, match=said):
        make_atlas(pictures)
