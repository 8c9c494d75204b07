"""States that say something else than what is recorded are named; other processors may round."""

import json
from typing import Any

import pytest

from explorables.controls import slider
from explorables.explorations import Exploration
from explorables.snapshots import snapshot
from tests.book import states

SAID = [
    ((0.1, True, "kept"), "Off by 0.1 m, and held."),
    ((0.2, True, "kept"), "Off by 0.2 m, and held."),
    ((0.4, False, "lost"), "Lost after −3.5 m."),
]


def described(said: list[tuple[Any, str]], count: int = 3) -> dict[str, Any]:
    """Return what is recorded of an explorer that says this."""
    explorer = Exploration(
        draw=lambda ax, state: None,
        state=lambda k: k,
        alt="A line that says nothing.",
        controls={"k": slider("K", range(count), 0)},
    )
    return states.described(explorer, snapshot("some", said))


def changed(state: int, finding: Any = None, words: str | None = None) -> dict[str, Any]:
    """Return what is recorded where one state says something else."""
    said = list(SAID)
    said[state] = finding or said[state][0], words or said[state][1]
    return described(said)


def test_texts_are_kept_once_without_their_numbers():
    some = described(SAID)
    assert list(some["controls"]) == ["k"]
    assert some["texts"] == ["Off by # m, and held.", "Lost after # m."]
    assert some["states"][2] == [[0.4, False, "lost"], 1, "−3.5"]


def test_a_file_has_a_line_for_each_state_and_reads_as_it_was_written():
    some = described(SAID) | {"finds": {"true": [], "false": [0]}}
    text = states.written("AVX2", {"some": some})
    assert json.loads(text) == {"processor": "AVX2", "explorers": {"some": some}}
    assert '    [[0.2, true, "kept"], 0, "0.2"],\n' in text


@pytest.mark.parametrize(
    ("now", "here", "there"),
    [
        (changed(1, (0.2 + 1e-8, True, "kept")), "", ""),  # of 0.4
        (changed(1, (0.200001, True, "kept")), "state 1, finding 0: 0.200001, recorded 0.2", ""),
        (changed(1, (0.69, True, "kept")), "state 1", ""),
        (changed(1, (0.71, True, "kept")), "state 1", "state 1, finding 0: 0.71, beyond"),
        (changed(1, (-0.21, True, "kept")), "state 1", "state 1"),
        (changed(1, (float("nan"), True, "kept")), "state 1", "state 1, finding 0: nan"),
        (changed(1, (0.2, False, "kept")), "state 1, finding 1: False, recorded True", ""),
        (changed(1, (0.2, True, "gone")), "state 1, finding 2: gone", "state 1, finding 2: gone"),
        (changed(1, (0.2, True)), "state 1: finding [0.2, True]", ""),
        (changed(1, words="Off by 0.3 m, and held."), "state 1: 'Off by 0.3 m", ""),
        (changed(1, words="Lost after 0.2 m."), "state 1: 'Lost after 0.2 m.'", ""),
        (changed(1, words="Off by 0.2 cm, and held."), "state 1: 'Off", "state 1: 'Off by # cm"),
        (described(SAID[:2], 2), "controls", "controls"),
    ],
)
def test_what_differs_is_named_here_and_on_another_processor(now: Any, here: str, there: str):
    for elsewhere, said in ((False, here), (True, there)):
        lines = states.differences(described(SAID), now, elsewhere)
        assert len(lines) == bool(said)
        assert "".join(lines).startswith(said)


def test_a_number_that_is_zero_but_for_rounding_may_be_another():
    words = "Nothing but zero here."
    zero, other = (described([(value, words), (0.0, words)], 2) for value in (1e-15, -3e-14))
    assert not states.differences(zero, other, False)


def test_the_numbers_of_an_array_are_one_column():
    some = {"array": [[1.0, 2.0], [3.0, 4.0]]}
    assert list(states.leaves([some, {"fields": {"a": 5}}, {"entries": [["b", 6]]}])) == [
        *((("0",), value) for value in (1.0, 2.0, 3.0, 4.0)),
        (("1", "a"), 5),
        (("2", "b"), 6),
    ]
