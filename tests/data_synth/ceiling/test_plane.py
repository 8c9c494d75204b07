"""What a ceiling shows, and whether it shows it where it says."""

from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

from data_synth.ceiling._fixtures import PAINTERS, Stamp, lay
from data_synth.ceiling.plane import PERIOD, RESOLUTION, TILE, Ceiling, Fixture, make_ceiling

KINDS = ("varied", "repeated", "plain")


@cache
def ceiling(kind, seed=1, side=12.0):
    return make_ceiling(kind, rng=np.random.default_rng(seed), side=side)


def likeness(texture, columns, rows):
    """Return the correlation of a texture with itself, shifted."""
    n = len(texture)
    texture = texture.astype(float)
    return np.corrcoef(
        texture[: n - rows, : n - columns].ravel(), texture[rows:, columns:].ravel()
    )[0, 1]


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_seed_paints_the_same_pixels(kind):
    again = make_ceiling(kind, rng=np.random.default_rng(1), side=12.0)
    assert (again.texture == ceiling(kind).texture).all()
    assert again.fixtures == ceiling(kind).fixtures
    assert (ceiling(kind, 2).texture != again.texture).any()
    assert again.texture.shape == (1200, 1200)
    assert again.texture.flags.c_contiguous
    assert again.side == pytest.approx(12)


def test_a_ceiling_of_repeated_fixtures_repeats_and_a_varied_one_does_not():
    shifts = [round(part / RESOLUTION) for part in PERIOD]
    for columns, rows in [(shifts[0], 0), (0, shifts[1]), shifts]:
        assert likeness(ceiling("repeated").texture, columns, rows) > 0.95
        assert likeness(ceiling("varied").texture, columns, rows) < 0.6
    lattice = ceiling("repeated").texture
    same = np.mean(lattice[shifts[1] :, shifts[0] :] == lattice[: -shifts[1], : -shifts[0]])
    assert 0.99 < same < 1  # to the texel but for the exceptions
    assert likeness(lattice, shifts[0] // 2, 0) < 0.5
    assert likeness(lattice, 0, shifts[1] // 2) < 0.5


def test_a_plain_ceiling_is_almost_blank():
    assert ceiling("plain").fixtures == ()
    assert 0 < ceiling("plain").texture.std() < 3


def test_tiles_are_joined_every_0_6_m():
    texture = ceiling("varied").texture.astype(float)
    step = round(TILE / RESOLUTION)
    for axis in (0, 1):
        dark = np.median(texture, axis=axis)
        folded = dark[: len(dark) // step * step].reshape(-1, step)
        profile = np.median(folded, axis=0)
        assert np.sort(profile)[3] > 170
        assert profile.min() < 135  # a joint of 2 cm


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_view_of_a_varied_ceiling_has_some_fixtures(seed):
    found = ceiling("varied", seed, 30.0).fixtures
    places = np.array([(f.x, f.y) for f in found])
    assert np.abs(places).max() <= 15
    corners = np.random.default_rng(seed).uniform(-15, [11, 12], (300, 2))
    inside = (places > corners[:, None]) & (places < corners[:, None] + [4, 3])
    counts = inside.all(axis=2).sum(axis=1)
    assert 4 < counts.mean() < 8
    assert np.mean(counts >= 2) > 0.95
    assert {f.kind for f in found} == {*PAINTERS, "stain"}
    turned = [abs(f.angle / (np.pi / 2) - round(f.angle / (np.pi / 2))) > 1e-6 for f in found]
    assert 0.1 < np.mean(turned) < 0.4


@pytest.mark.parametrize("seed", [1, 2])
def test_fixtures_keep_apart(seed):
    found = [f for f in ceiling("varied", seed, 30.0).fixtures if f.kind != "stain"]
    points, owners = [], []
    for k, f in enumerate(found):
        along, aside = np.meshgrid(
            np.linspace(-0.5, 0.5, 2 + int(f.length / 0.05)) * f.length,
            np.linspace(-0.5, 0.5, 2 + int(f.width / 0.05)) * f.width,
        )
        cos, sin = np.cos(f.angle), np.sin(f.angle)
        points.append(
            np.column_stack(
                [
                    (f.x + cos * along - sin * aside).ravel(),
                    (f.y + sin * along + cos * aside).ravel(),
                ]
            )
        )
        owners += [k] * along.size
    owners = np.array(owners)
    pairs = cKDTree(np.concatenate(points)).query_pairs(0.08, output_type="ndarray")
    assert (owners[pairs[:, 0]] == owners[pairs[:, 1]]).all()


@pytest.mark.parametrize("seed", [1, 2])
def test_lamps_shine_where_the_ceiling_says_they_are(seed):
    painted = ceiling("varied", seed, 30.0)
    for f in painted.fixtures:
        if f.kind != "luminaire" or max(abs(f.x), abs(f.y)) > 14:
            continue
        along = np.linspace(-0.4, 0.4, 60) * f.length
        aside = np.linspace(-0.5, 0.5, 40) * (f.width - 0.04)
        a, b = (part.ravel() for part in np.meshgrid(along, aside))
        cos, sin = np.cos(f.angle), np.sin(f.angle)
        inside = np.stack([f.x + cos * a - sin * b, f.y + sin * a + cos * b], axis=1)
        columns, rows = np.rint(painted.texels(inside)).astype(int).T
        assert np.median(painted.texture[rows, columns]) > 195
        for way in (-1, 1):  # the frame, then the ceiling
            for half, side in ((f.length, (cos, sin)), (f.width, (-sin, cos))):
                rim = np.array([f.x, f.y]) + way * (half / 2 - 0.012) * np.array(side)
                column, row = np.rint(painted.texels(rim[None])[0]).astype(int)
                assert painted.texture[row - 1 : row + 2, column - 1 : column + 2].min() < 160


@pytest.mark.parametrize("seed", [1, 2])
def test_what_stands_along_the_grid_fills_whole_tiles(seed):
    ends = []
    for f in ceiling("varied", seed, 30.0).fixtures:
        quarter = f.angle / (np.pi / 2)
        if f.kind in ("luminaire", "vent", "hatch") and abs(quarter - round(quarter)) < 1e-9:
            sides = np.array([f.length, f.width])[:: -1 if round(quarter) % 2 else 1]
            for way, (at, size) in enumerate(zip((f.x, f.y), sides, strict=True)):
                if abs(size / TILE - round(size / TILE)) < 1e-9:
                    ends.append((way, (at - size / 2) / TILE))
    for way in (0, 1):
        turns = np.array([np.exp(2j * np.pi * end) for w, end in ends if w == way])
        assert len(turns) > 50
        assert np.abs(turns - turns[0]).max() < 1e-9


@pytest.mark.parametrize("seed", range(4))
def test_exceptions_of_a_repeated_ceiling_are_each_elsewhere_and_painted(seed):
    painted = ceiling("repeated", seed, 30.0)
    odd = [f for f in painted.fixtures if f.kind not in ("luminaire", "vent")]
    assert len({(round(f.x, 3), round(f.y, 3)) for f in odd}) == len(odd) == 5
    for f in odd:
        column, row = np.rint(painted.texels(np.array([[f.x, f.y]]))[0]).astype(int)
        texture = painted.texture.astype(int)
        view = texture[row - 5 : row + 6, column - 5 : column + 6]
        other = column + (240 if column < 1500 else -240)
        assert np.abs(view - texture[row - 5 : row + 6, other - 5 : other + 6]).mean() > 8


def test_lamps_of_a_repeated_ceiling_lie_between_texels_as_they_should():
    painted = ceiling("repeated")  # whose lamp is the same from either end
    lamp = next(f for f in painted.fixtures if f.kind == "luminaire")
    column, row = painted.texels(np.array([[lamp.x, lamp.y]]))[0] + 0.5
    part = painted.texture[
        round(row) - 30 : round(row) + 30, round(column) - 60 : round(column) + 60
    ]
    assert part.std() > 30
    assert np.abs(part.astype(int) - part[:, ::-1]).max() < 8
    assert np.abs(part.astype(int) - part[::-1]).max() < 8


def test_stamps_lie_where_they_are_laid():
    rng = np.random.default_rng(0)
    rows, columns = np.mgrid[:120, :160]
    for _ in range(20):
        ground = np.zeros((120, 160), dtype=np.float32)
        stamp = Stamp(0.5, 0.2, 0)
        stamp.disc(0.15, 0.05, 0.04, 200)
        at, angle = rng.uniform([60, 50], [100, 70]), rng.uniform(-np.pi, np.pi)
        lay(ground, stamp, (at[0], at[1]), angle, 100.0)
        middle = np.array([(ground * columns).sum(), (ground * rows).sum()]) / ground.sum()
        cos, sin = np.cos(angle), np.sin(angle)
        wanted = at + 100 * np.array([cos * 0.15 - sin * 0.05, sin * 0.15 + cos * 0.05])
        assert middle == pytest.approx(wanted, abs=0.05)
        assert ground.sum() == pytest.approx(200 * np.pi * 4**2, rel=0.05)


def test_stamps_cover_what_they_say_and_no_more():
    for scale in (100.0, 60.0):
        for angle in (0.0, 0.4):
            ground = np.full((150, 150), 50, dtype=np.float32)
            lay(ground, Stamp(0.6, 0.3, 150), (75.2, 74.6), angle, scale)
            rows, columns = np.mgrid[:150, :150]
            middle = [
                ((ground - 50) * part).sum() / (ground - 50).sum() for part in (columns, rows)
            ]
            assert middle == pytest.approx([75.2, 74.6], abs=0.03)
            assert (ground - 50).sum() / 100 == pytest.approx(0.18 * scale**2, rel=0.02)
            assert ground.max() == pytest.approx(150, abs=0.5)
            assert ground.min() == 50
    lay(ground, Stamp(0.6, 0.3, 10), (-500.0, 30.0), 0.0, 100.0)
    assert ground.min() == 50


@pytest.mark.parametrize("name", PAINTERS)
def test_every_painter_has_several_looks_within_its_box(name):
    stamps = [PAINTERS[name][0](rng) for rng in np.random.default_rng(0).spawn(6)]
    assert len({(s.greys.shape, s.greys.tobytes()) for s in stamps}) > 1
    for stamp in stamps:
        rows, columns = np.nonzero(stamp.cover)
        assert np.ptp(columns) / 400 == pytest.approx(stamp.length, abs=0.012)
        assert np.ptp(rows) / 400 == pytest.approx(stamp.width, abs=0.012)
        assert stamp.greys[stamp.cover > 200].std() > 15


def test_texels_and_places_are_each_others_inverse():
    painted = ceiling("plain")
    np.testing.assert_allclose(painted.texels(np.zeros((1, 2))), [[599.5, 599.5]])
    np.testing.assert_allclose(painted.places(np.array([[600.0, 599.5]])), [[0.005, 0]])
    points = np.random.default_rng(0).uniform(-6, 6, (9, 2))
    np.testing.assert_allclose(painted.places(painted.texels(points)), points)


def test_bad_ceilings_are_named():
    with pytest.raises(ValueError, match="kind must be one of varied"):
        make_ceiling("painted", rng=np.random.default_rng(0))
    with pytest.raises(ValueError, match="side"):
        make_ceiling("plain", rng=np.random.default_rng(0), side=1.0)
    with pytest.raises(ValueError, match="texture must be"):
        Ceiling(np.zeros((4, 5), dtype=np.uint8), (), "plain")
    with pytest.raises(TypeError, match="texture must be of 8 bits"):
        Ceiling(np.zeros((4, 4)), (), "plain")
    with pytest.raises(ValueError, match="width"):
        Fixture("vent", 0.0, 0.0, 0.0, -1.0, 1.0)
