"""Ranges of fields in the signatures of the library's pages: in words, and without addresses."""

import inspect
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import pytest
from jaxtyping import Float
from sphinx.util.inspect import stringify_signature

from robot_perception.companion.faces.detection import FaceDetector
from robot_perception.fields import (
    OPEN,
    Level,
    Positive,
    above,
    above_zero,
    at_least,
    from_to,
    one_of,
)
from robot_perception.teaching.pages.signatures import said, with_ranges, worded


@pytest.mark.parametrize(
    ("check", "words"),
    [
        (from_to(2), "2 or more"),
        (from_to(1, 10), "1 to 10"),
        (at_least(0), "0 or more"),
        (above(1, 10), "above 1, at most 10"),
        (one_of("a", "b"), "'a' or 'b'"),
        (above_zero, "above zero"),
        (OPEN, ""),
        (lambda name, value: value, ""),
    ],
)
def test_a_check_is_said(check, words):
    assert said(check) == words


@dataclass
class Some:
    much: Positive
    share: Level | None = None
    ends: tuple[Positive, Positive] = (1.0, 2.0)
    rows: Annotated[Float[np.ndarray, "n 2"], above_zero] = None
    plain: int = 3


def test_a_signature_says_type_and_range():
    with_ranges(None, Some.__init__, True)
    shown = stringify_signature(inspect.signature(Some))
    for part in (
        "much: float (positive)",
        "share: float (level) | None = None",
        "ends: tuple[float (positive), float (positive)] = (1.0, 2.0)",
        "rows: Float[ndarray, 'n 2'] (above zero) = None",
        "plain: int = 3",
    ):
        assert part in shown


def test_no_address_is_shown_of_a_class_of_the_library():
    types = {name: worded(hint) for name, hint in FaceDetector.__init__.__annotations__.items()}
    shown = " ".join(getattr(kind, "__qualname__", "") for kind in types.values())
    assert "int (1 to 4)" in shown
    assert "0x" not in shown
