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
    at_least,
    checked,
    from_to,
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
    known: bool = True
    limit: float | None = None
    derived: float = field(default=0.0, init=False)
    __post_init__ = checked


def valid() -> dict:
    return {
        "means": np.arange(6.0).reshape(3, 2),
        "spreads": np.ones((3, 2)),
        "counts": np.array([1, 2, 3]),
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
