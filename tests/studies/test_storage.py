"""What is stored comes back as the same type with the same bits, and the same bytes each time."""

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from jaxtyping import Float, UInt8

from studies.stored import storage


@dataclass(frozen=True, eq=False, slots=True)
class Inner:
    path: Float[np.ndarray, "n 2"]
    name: str


@dataclass(frozen=True, eq=False, slots=True)
class Outer:
    error: float
    count: int
    good: bool
    names: tuple[str, ...]
    values: Float[np.ndarray, " n"]
    robots: Mapping[int, Inner]
    rates: Mapping[str, float]
    photo: UInt8[np.ndarray, "h w 3"] = field(metadata={"webp": 100})
    grey: UInt8[np.ndarray, "h w"] = field(metadata={"webp": 100})


def example(seed=0):
    rng = np.random.default_rng(seed)
    return Outer(
        1 / 3,
        7,
        True,
        ("plain", "anchored"),
        rng.normal(size=5),
        {3: Inner(rng.normal(size=(4, 2)), "three"), 1: Inner(np.empty((0, 2)), "")},
        {"all": 0.1, "half of them": 0.2},
        rng.integers(0, 255, (6, 9, 3), dtype=np.uint8),
        rng.integers(0, 255, (5, 4), dtype=np.uint8),
    )


def test_everything_comes_back_with_its_type_and_every_bit(tmp_path):
    before = example()
    storage.save(tmp_path / "a.npz", before)
    after = storage.load(tmp_path / "a.npz", Outer)
    for name in ("error", "count", "good", "names", "rates"):
        assert getattr(after, name) == getattr(before, name)
        assert type(getattr(after, name)) is type(getattr(before, name))
    np.testing.assert_array_equal(after.values, before.values)
    np.testing.assert_array_equal(after.photo, before.photo)
    np.testing.assert_array_equal(after.grey, before.grey)
    assert list(after.robots) == [3, 1]
    np.testing.assert_array_equal(after.robots[3].path, before.robots[3].path)
    assert after.robots[1].path.shape == (0, 2)


def test_bytes_depend_on_the_numbers_alone(tmp_path):
    for name in "ab":
        storage.save(tmp_path / name, example())
    storage.save(tmp_path / "c", example(1))
    a, b, c = ((tmp_path / name).read_bytes() for name in "abc")
    assert a == b != c
    with zipfile.ZipFile(tmp_path / "a") as archive:  # nor on the hour
        assert {part.date_time for part in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        pictures = [name for name in archive.namelist() if not name.endswith(".npy")]
    assert pictures == ["photo.webp", "grey.grey.webp"]


def test_plain_numpy_reads_the_arrays(tmp_path):
    storage.save(tmp_path / "a.npz", example())
    np.testing.assert_array_equal(np.load(tmp_path / "a.npz")["values"], example().values)


def test_summary_says_what_a_diff_should_show(tmp_path):
    summary = storage.save(tmp_path / "a.npz", example())
    assert summary["error"] == "0.3333333333"
    assert summary["names"] == "2: plain, anchored"
    values = example().values
    told = f"{values.min():.10g} to {values.max():.10g}, mean {values.mean():.10g}"
    assert summary["values"] == f"5 float64, {told}"
    for count, more in ((8, ""), (9, " …")):
        many = replace(example(), names=tuple("abcdefghi"[:count]))
        told = storage.save(tmp_path / "b.npz", many)["names"]
        assert told == f"{count}: a, b, c, d, e, f, g, h{more}"
    assert summary["robots/1/path"] == "0 × 2 float64"


@dataclass(frozen=True)
class Less:
    error: float


@dataclass(frozen=True)
class Other:
    mistake: float


def test_another_type_is_not_read(tmp_path):
    storage.save(tmp_path / "a.npz", Less(1.0))
    with pytest.raises(ValueError, match="mistake is missing"):
        storage.load(tmp_path / "a.npz", Other)
    storage.save(tmp_path / "a.npz", example())
    with pytest.raises(ValueError, match=r"no field takes: count, good, grey, names"):
        storage.load(tmp_path / "a.npz", Less)


@pytest.mark.parametrize(
    ("bad", "error", "match"),
    [
        (
            replace(example(), values=np.array([1.0, np.nan])),
            ValueError,
            "values must be finite, got 1 of 2",
        ),
        ({"x": 1.0}, TypeError, "a result is a dataclass, got dict"),
        (3.0, TypeError, "a result is a dataclass, got float"),
        (Less(object()), TypeError, "error cannot be stored: object"),
        (replace(example(), rates={"a/b": 1.0}), TypeError, "rates has a key .* 'a/b'"),
    ],
)
def test_what_cannot_be_stored_is_named(tmp_path, bad, error, match):
    with pytest.raises(error, match=match):
        storage.save(tmp_path / "a.npz", bad)
