"""Findings as plain data: what JSON keeps of them is what a predicate can be asked of again."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from explorables.snapshots import finding_of, plain, snapshot

FINDING = (
    np.float32(0.5),
    np.int64(3),
    np.bool_(True),
    None,
    "held",
    [1.0, (2, "a")],
    np.array([[1.0, np.inf], [2.0, 3.0]]),
    SimpleNamespace(inside=0.25, names=("a",)),
    {"laser": True, 3: 1 / 3},
)


def test_a_finding_comes_back_from_json_with_tuples_for_lists():
    number, count, true, none, word, several, array, fields, entries = finding_of(
        json.loads(json.dumps(plain(FINDING)))
    )
    assert (number, count, true, none, word) == (0.5, 3, True, None, "held")
    assert isinstance(count, int)
    assert several == (1.0, (2, "a"))
    np.testing.assert_array_equal(array, FINDING[6])
    assert fields == SimpleNamespace(inside=0.25, names=("a",))
    assert entries == {"laser": True, 3: 0.333333333}


def test_nine_digits_are_kept():
    assert plain([123456789.4, 1.23456789e-20, -2 / 3]) == [
        123456789.0,
        1.23456789e-20,
        -0.666666667,
    ]


def test_a_finding_that_is_no_plain_data_is_refused():
    with pytest.raises(TypeError, match="got set"):
        plain(({1},))


def test_a_snapshot_has_the_findings_and_the_words_in_their_order():
    said = snapshot("slope", [(np.float64(1), "One."), ((2,), "Two.")])
    assert said == {"name": "slope", "findings": [1.0, [2]], "words": ["One.", "Two."]}
