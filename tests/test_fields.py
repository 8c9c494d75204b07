"""Fields that are checked by their types: what is kept, what is refused, and what it is called."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Annotated

import numpy as np
import pytest
from jaxtyping import Bool, Float, Int, UInt8

from robot_perception.fields import (
    OPEN,
    Level,
    NotNegative,
    Positive,
    Share,
    above,
    above_zero,
    any_of,
    at_least,
    checked,
    copied,
    covariance,
    double,
    from_to,
    not_empty,
    numbers,
    odd,
    one_of,
    up_to,
    wholes,
    within,
)
from tests.unchecked import unchecked


@dataclass(frozen=True)
class Part:
    size: Positive = 1.0
    __post_init__ = checked


@dataclass(frozen=True, eq=False, slots=True)
class Whole:
    means: Float[np.ndarray, "n d"]
    spreads: Annotated[Float[np.ndarray, "n d"], at_least(0)]
    counts: Annotated[Int[np.ndarray, " n"], at_least(1)]
    sizes: Annotated[Float[np.ndarray, " n"], above_zero]
    far: Annotated[Float[np.ndarray, "... n"], OPEN]
    there: Bool[np.ndarray, " n"]
    bytes: UInt8[np.ndarray, "h w"]
    part: Part = Part()
    parts: tuple[Part, ...] = ()
    pair: tuple[float, int] = (1.0, 2)
    names: Mapping[str, int] = field(default_factory=dict)
    share: Level = 0.5
    lost: Annotated[int, from_to(0, 9)] = 0
    wait: NotNegative = 0.0
    part_of: Share = 1.0
    rule: Annotated[str, one_of("nearest", "all")] = "all"
    known: bool = True
    limit: float | None = None
    derived: float = field(default=0.0, init=False)
    __post_init__ = checked


def valid() -> dict:
    return {
        "means": np.arange(6.0).reshape(3, 2),
        "spreads": np.ones((3, 2)),
        "counts": np.array([1, 2, 3]),
        "sizes": np.array([0.1, 1.0, 2.0]),
        "far": np.array([[np.inf, np.nan, 1.0]]),
        "there": np.array([True, False, True]),
        "bytes": np.zeros((4, 5), dtype=np.uint8),
    }


def test_what_the_checks_return_is_kept():
    given = valid() | {
        "means": [[0, 1], [2, 3], [4, 5]],
        "share": Fraction(1, 4),
        "limit": np.float32(2),
        "pair": [Fraction(1, 2), np.int64(3)],
        "parts": [Part(), Part(2.0)],
    }
    with unchecked():
        whole = Whole(**given)
    assert whole.means.dtype == float
    np.testing.assert_array_equal(whole.means, valid()["means"])
    assert (whole.share, whole.limit, whole.pair) == (0.25, 2.0, (0.5, 3))
    assert {type(x) for x in (whole.share, whole.limit, whole.pair[0])} == {float}
    assert type(whole.parts) is tuple
    assert whole.limit is not None
    assert Whole(**valid()).limit is None


def test_arrays_of_single_precision_bytes_and_truth_values_stay_as_they_are():
    given = valid() | {"means": np.zeros((3, 2), dtype=np.float32)}
    whole = Whole(**given)
    for name in ("means", "there", "bytes"):
        assert getattr(whole, name) is given[name]


@pytest.mark.parametrize(
    ("name", "value", "kind", "said"),
    [
        ("means", np.zeros(3), ValueError, r"means must be \(n, d\), got \(3,\)"),
        ("means", np.full((3, 2), np.nan), ValueError, "means must be finite, got 6 of 6"),
        ("means", np.full((3, 2), 1e200), ValueError, r"means must be within 1e\+100, got 1e\+200"),
        ("means", "abc", TypeError, "means must be real numbers, got 'abc'"),
        (
            "spreads",
            np.ones((3, 1)),
            ValueError,
            r"spreads must be \(3, 2\) for means \(3, 2\), got \(3, 1\)",
        ),
        ("spreads", -np.ones((3, 2)), ValueError, "spreads must not be negative, got -1"),
        ("counts", np.zeros(3, int), ValueError, "counts must be at least 1, got 0"),
        ("counts", np.ones(3), ValueError, "counts must be integers"),
        ("counts", np.ones(2, int), ValueError, r"counts must be \(3,\) for means \(3, 2\)"),
        ("sizes", np.zeros(3), ValueError, "sizes must be positive, got 0$"),
        ("far", np.ones((1, 2)), ValueError, r"far must be \(…, 3\) for means \(3, 2\)"),
        ("there", np.ones(3), TypeError, "there must be an array of truth values"),
        ("there", [True] * 3, TypeError, "there must be an array of truth values"),
        ("bytes", np.ones((4, 5)), TypeError, "bytes must be an array of bytes"),
        ("part", 1.0, TypeError, "part must be a Part, got 1.0"),
        ("parts", [1.0], TypeError, r"parts\[0\] must be a Part, got 1.0"),
        ("parts", 1.0, TypeError, "parts must be a sequence, got 1.0"),
        ("pair", (1.0, 2, 3), ValueError, "pair must be 2, got"),
        ("pair", (1.0, 2.5), ValueError, r"pair\[1\] must be a whole number, got 2.5"),
        ("names", [1], TypeError, "names must be a Mapping"),
        ("names", {1: 2}, TypeError, "a key of names must be a str, got 1"),
        ("names", {"a": "b"}, TypeError, r"names\['a'\] must be a whole number, got 'b'"),
        ("share", 1.0, ValueError, "share must be between 0 and 1, got 1.0"),
        ("lost", 10, ValueError, "lost must be from 0 to 9, got 10"),
        ("wait", -1.0, ValueError, "wait must not be negative, got -1.0"),
        ("part_of", 1.5, ValueError, "part_of must be from 0 to 1, got 1.5"),
        ("rule", "none", ValueError, "rule must be one of 'nearest', 'all', got 'none'"),
        ("known", 1, TypeError, "known must be True or False, got 1"),
        ("limit", "1", TypeError, "limit must be a number, got '1'"),
        ("limit", np.inf, ValueError, "limit must be finite, got inf"),
    ],
)
def test_what_a_type_does_not_say_is_refused_by_name(name, value, kind, said):
    with unchecked(), pytest.raises(kind, match=f"^{said}"):
        Whole(**(valid() | {name: value}))


@dataclass(frozen=True, eq=False)
class Batch:
    means: Float[np.ndarray, "... n"]
    names: Int[np.ndarray, " n"]
    __post_init__ = checked


def test_axes_of_a_batch_are_counted_from_the_last():
    assert Batch(np.zeros((4, 5, 3)), np.arange(3)).means.shape == (4, 5, 3)
    with unchecked(), pytest.raises(ValueError, match=r"^names must be \(3,\) for means \(4, 5, 3"):
        Batch(np.zeros((4, 5, 3)), np.arange(5))


@dataclass(frozen=True, eq=False)
class Filter:
    rest: Annotated[Float[np.ndarray, " n"], not_empty, copied]
    scale: Annotated[float, above(1, 10)] = 1.1
    part: Annotated[Part | Batch | None, any_of(Part, Batch, type(None))] = None
    __post_init__ = checked


def test_a_copy_is_kept_and_an_object_of_any_of_some_types():
    rest = np.zeros(2)
    kept = Filter(rest, Fraction(10), Part())
    assert kept.rest is not rest
    np.testing.assert_array_equal(kept.rest, rest)
    assert (type(kept.scale), kept.scale, kept.part) == (float, 10.0, Part())
    assert Filter(rest).part is None


@pytest.mark.parametrize(
    ("name", "value", "kind", "said"),
    [
        ("rest", [], ValueError, r"rest must not be empty, got \(0,\)"),
        ("scale", 1.0, ValueError, "scale must be above 1 and at most 10, got 1.0"),
        ("scale", 10.5, ValueError, "scale must be above 1 and at most 10, got 10.5"),
        ("scale", "2", TypeError, "scale must be a number, got '2'"),
        ("part", 1.0, TypeError, "part must be a Part or a Batch or a NoneType, got 1.0"),
    ],
)
def test_what_further_checks_ask_is_said(name, value, kind, said):
    with unchecked(), pytest.raises(kind, match=f"^{said}"):
        Filter(**({"rest": np.zeros(2)} | {name: value}))


@dataclass(frozen=True, eq=False)
class Spread:
    cov: Annotated[Float[np.ndarray, "... n n"], covariance]
    mean: Annotated[Float[np.ndarray, "... n"], double]
    __post_init__ = checked


def test_a_covariance_is_kept_as_it_is():
    ones = np.ones((4, 3, 3), dtype=np.float32)
    assert Spread(ones, np.zeros((4, 3))).cov is ones
    with unchecked(), pytest.raises(ValueError, match=r"^cov must be positive semi-definite"):
        Spread(-ones, np.zeros((4, 3)))


def test_what_is_computed_with_is_of_double_precision():
    mean = np.zeros(2)
    assert Spread(np.eye(2), mean).mean is mean
    assert Spread(np.eye(2), mean.astype(np.float32)).mean.dtype == float


@dataclass(frozen=True)
class Ranges:
    size: Annotated[tuple[float, float], numbers(2, above_zero)] = (1.0, 2.0)
    picture: Annotated[tuple[int, int], wholes(2, 1)] = (3, 4)
    samples: Annotated[int, odd(3, 9)] = 5
    near: Annotated[float, up_to(100)] = 1.0
    gain: Annotated[float, within(0, 1e6)] = 0.5
    __post_init__ = checked


def test_rows_of_numbers_are_kept_as_tuples():
    with unchecked():
        kept = Ranges([1, Fraction(1, 2)], np.array([5, 6]), np.int64(9), 100, Fraction(0))
    assert kept == Ranges((1.0, 0.5), (5, 6), 9, 100.0, 0.0)
    each = (*kept.size, *kept.picture, kept.samples, kept.near, kept.gain)
    assert [type(x) for x in each] == [float, float, int, int, int, float, float]
    assert {type(kept.size), type(kept.picture)} == {tuple}
    assert Ranges(samples=3).samples == 3
    assert Ranges(gain=1e6).gain == 1e6


@pytest.mark.parametrize(
    ("name", "value", "kind", "said"),
    [
        ("size", (1.0, 0.0), ValueError, "size must be positive, got 0$"),
        ("size", 1.0, ValueError, r"size must be \(2,\), got \(\)"),
        ("size", (1.0, np.nan), ValueError, "size must be finite"),
        ("size", "abc", TypeError, "size must be real numbers, got 'abc'"),
        ("picture", (0, 4), ValueError, "picture must be at least 1, got 0"),
        ("picture", (3, 4, 5), ValueError, r"picture must be \(2,\), got \(3,\)"),
        ("picture", (3.0, 4.0), ValueError, "picture must be integers"),
        ("samples", 4, ValueError, "samples must be odd, got 4"),
        ("samples", 11, ValueError, "samples must be from 3 to 9, got 11"),
        ("samples", True, TypeError, "samples must be a whole number"),
        ("near", 0, ValueError, "near must be positive and finite, got 0"),
        ("near", 101, ValueError, "near must be at most 100, got 101"),
        ("gain", -1e-9, ValueError, "gain must be from 0 to 1e[+]06, got -1e-09"),
        ("gain", 2e6, ValueError, "gain must be from 0 to 1e[+]06, got 2e[+]06"),
        ("gain", "1", TypeError, "gain must be a number, got '1'"),
    ],
)
def test_a_range_that_is_left_is_named(name, value, kind, said):
    with unchecked(), pytest.raises(kind, match=f"^{said}"):
        Ranges(**{name: value})
