"""Checks return what is right and name what is wrong: `ValueError`, or of a type `TypeError`."""

from fractions import Fraction

import numpy as np
import pytest

from robot_perception import checks

NAN, INF = np.nan, np.inf


@pytest.mark.parametrize(
    ("check", "value", "result"),
    [
        (lambda v: checks.whole("k", v, 1), np.int8(3), 3),
        (lambda v: checks.whole("k", v, 1, 3), 1, 1),
        (lambda v: checks.whole("k", v), -(2**53), -(2**53)),
        (lambda v: checks.number("x", v), Fraction(1, 2), 0.5),
        (lambda v: checks.number("x", v, finite=False), np.float32(-INF), -INF),
        (lambda v: checks.not_negative("x", v), 0, 0.0),
        (lambda v: checks.share("x", v), 1, 1.0),
        (lambda v: checks.flag("x", v), np.True_, True),
        (lambda v: checks.one_of("x", v, ("a", "b")), "b", "b"),
        (lambda v: checks.array("x", v, ("n", 2)).tolist(), [[1, 2], (3, Fraction(9, 2))], None),
        (lambda v: checks.array("x", v, ()).tolist(), 10**30, 1e30),
        (lambda v: checks.array("x", v, (..., "n", "n")).shape, np.ones((4, 2, 2)), (4, 2, 2)),
        (lambda v: checks.array("x", v, finite=False).tolist(), [INF], [INF]),
        (lambda v: checks.integers("x", v, ("n",), 0).tolist(), [], []),
        (lambda v: checks.instances("x", v, int, str), iter([1, "a"]), (1, "a")),
        (lambda v: checks.covariance("x", v).tolist(), [[0, 0], [0, 2]], [[0.0, 0.0], [0.0, 2.0]]),
    ],
)
def test_what_is_right_comes_back_in_one_type(check, value, result):
    found = check(value)
    assert found == ([[1.0, 2.0], [3.0, 4.5]] if result is None else result)
    assert type(found) is type(result) or result is None


@pytest.mark.parametrize(
    ("check", "message"),
    [
        (lambda: checks.whole("k", 1.5, 1), "k must be a whole number, got 1.5"),
        (lambda: checks.whole("k", 2.0, 1), "k must be a whole number, got 2.0"),
        (lambda: checks.whole("k", NAN, 1), "k must be a whole number, got nan"),
        (lambda: checks.whole("k", 0, 1), "k must be at least 1, got 0"),
        (lambda: checks.whole("k", 10**30, 1), "k must be from 1 to 9007199254740992, got 1000"),
        (lambda: checks.whole("k", np.int64(7), 1, 6), "k must be from 1 to 6, got 7"),
        (lambda: checks.number("x", NAN, finite=False), "x must be a number, got nan"),
        (lambda: checks.number("x", 10**400), "x must be finite, got 1000"),
        (lambda: checks.positive("x", 0), "x must be positive and finite, got 0"),
        (lambda: checks.positive("x", INF), "x must be positive and finite, got inf"),
        (lambda: checks.positive("x", 1e-200), "x must be at least 1e-100, got 1e-200"),
        *(
            (lambda check=check: check("x", 1e200), r"x must be within 1e\+100, got 1e\+200")
            for check in (checks.number, checks.positive, checks.not_negative, checks.array)
        ),
        (lambda: checks.array("x", [-1e200]), r"x must be within 1e\+100, got 1e\+200"),
        (lambda: checks.not_negative("x", np.float32(-0.5)), "x must not be negative, got -0.5"),
        (lambda: checks.share("x", np.nextafter(1, 2)), "x must be from 0 to 1, got 1.0000"),
        (lambda: checks.level("x", 1.0), "x must be between 0 and 1, got 1.0"),
        (lambda: checks.one_of("x", "c", ("a", "b")), "x must be one of 'a', 'b', got 'c'"),
        (lambda: checks.one_of("x", int, ["a"], " or 1"), "x must be one of 'a' or 1, got <class"),
        (lambda: checks.array("x", [1, 2], ("k", 3)), r"x must be \(k, 3\), got \(2,\)"),
        (lambda: checks.array("x", 3.0, (..., "n")), r"x must be \(…, n\), got \(\)"),
        (lambda: checks.array("x", [3.0], ()), r"x must be one number, got \(1,\)"),
        (lambda: checks.array("x", np.ones((2, 3)), ("n", "n")), r"x must be \(n, n\), got \(2, 3"),
        (lambda: checks.array("x", np.ones(3), (2,)), r"x must be \(2,\), got \(3,\)"),
        (lambda: checks.array("x", [[1], [1, 2]]), r"x must be an array, got unequal rows, \[\[1"),
        (lambda: checks.array("x", [NAN, 1.0]), "x must be finite, got 1 of 2 entries"),
        (lambda: checks.array("x", 10**400), "x must be finite, got 1000"),
        (lambda: checks.integers("x", [0.5]), r"x must be integers, got \[0.5\]"),
        (lambda: checks.integers("x", [-1], least=0), "x must be at least 0, got -1"),
        (
            lambda: checks.integers("x", np.array([2**64 - 1], dtype=np.uint64), least=0),
            "x must be at most 9223372036854775807, got 18446744073709551615",
        ),
        (
            lambda: checks.typed("x", np.ones(2), np.floating, (3,), "y"),
            r"x must be \(3,\) for y, got \(2,\)",
        ),
        (lambda: checks.covariance("x", -np.eye(2)), "x must be positive semi-definite, smallest"),
    ],
)
def test_a_wrong_value_is_named(check, message):
    with pytest.raises(ValueError, match=message):
        check()


@pytest.mark.parametrize(
    ("check", "message"),
    [
        (lambda: checks.whole("k", True), "k must be a whole number, got True"),
        (lambda: checks.whole("k", "3"), "k must be a whole number, got '3'"),
        (lambda: checks.number("x", None), "x must be a number, got None"),
        (lambda: checks.number("x", np.True_), "x must be a number, got True"),
        (lambda: checks.number("x", 1j), "x must be a number, got 1j"),
        (lambda: checks.flag("x", 1), "x must be True or False, got 1"),
        (lambda: checks.generator("rng", 3), "rng must be a Generator, got 3"),
        (lambda: checks.generator("rng", np.random.Generator), "rng must be a Generator, got <cla"),
        (lambda: checks.instance("x", 1, str, Fraction), "x must be a str or a Fraction, got 1"),
        (lambda: checks.instances("x", [1, "a"], int), r"x\[1\] must be an int, got 'a'"),
        (lambda: checks.instances("x", 3, int), "x must be a sequence, got 3"),
        (lambda: checks.array("x", None), "x must be real numbers, got None"),
        (lambda: checks.array("x", ["1"]), r"x must be real numbers, got \['1'\]"),
        (lambda: checks.array("x", np.ones(2) + 1j), r"x must be real numbers, got array\("),
        (lambda: checks.array("x", [True]), r"x must be real numbers, got \[True\]"),
        (lambda: checks.integers("x", [True]), r"x must be integers, got \[True\]"),
        (lambda: checks.typed("x", [1.0], np.floating), "x must be an array of floating-point"),
        (lambda: checks.typed("x", np.ones(2), np.uint8), "x must be an array of bytes, got"),
        (lambda: checks.typed("x", np.ones(2), np.bool_), "x must be an array of truth values"),
    ],
)
def test_a_wrong_type_is_named(check, message):
    with pytest.raises(TypeError, match=message):
        check()


def test_what_is_shown_of_a_value_stays_short():
    for value in (np.zeros((100, 100)), "a" * 1000, list(range(1000)), {1: "b" * 500}, object()):
        assert len(checks.shown(value)) < 200
        assert "\n" not in checks.shown(value)
