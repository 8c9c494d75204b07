"""One protocol for all that follows something over time: `start` gives a state, `step` the next.

The trackers are found in the rooms, never listed by hand, and called as `tests.hostile.calls` does.
"""

import inspect
from collections.abc import Callable, Iterator, Mapping
from copy import deepcopy
from dataclasses import fields, is_dataclass
from functools import cache
from importlib import import_module
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np
import pytest

from tests.hostile.surface import modules, public, room_of
from tests.hostile.test_hostile import ROOMS

STEP = (".step", ".step_all")


@cache
def steps() -> dict[str, Callable]:
    """Return what steps, by its name."""
    rooms = dict.fromkeys(room_of(name) for name in modules())
    every = {name: thing for room in rooms for thing, name in public(room).items()}
    return {name: thing for name, thing in every.items() if name.endswith(STEP)}


TRACKERS = sorted(steps())


def owner(name: str) -> type:
    """Return the class of a method, or whatever else holds a function."""
    step = steps()[name]
    held = inspect.unwrap(step).__qualname__.rpartition(".")[0]
    return getattr(import_module(step.__module__), held) if held else type(step)


def valid(method: Callable) -> tuple[tuple, dict]:
    """Return arguments of a valid call."""
    calls = (import_module(f"tests.hostile.calls.{room}").CALLS for room in ROOMS)
    return next(table[method]() for table in calls if method in table)


def parts(value: Any) -> Iterator[Any]:
    """Yield what an object is made of: arrays as bytes, the rest as it is."""
    if isinstance(value, np.ndarray):
        yield value.dtype, value.shape, value.tobytes()
    elif isinstance(value, Mapping):
        for key, inner in value.items():
            yield key
            yield from parts(inner)
    elif isinstance(value, tuple | list):
        for inner in value:
            yield from parts(inner)
    elif is_dataclass(value):
        for field in fields(value):
            yield from parts(getattr(value, field.name))
    elif hasattr(value, "__slots__") and type(value).__module__.startswith("robot_perception"):
        for slot in value.__slots__:
            yield from parts(getattr(value, slot))
    else:
        yield type(value) if callable(value) else value


def test_the_rooms_have_trackers():
    assert {room_of(f"robot_perception.{name}") for name in TRACKERS} == {
        "appearance", "arms", "ceiling", "companion", "day", "people", "slam", "walls"
    }  # fmt: skip
    assert len(TRACKERS) > 15


@pytest.mark.parametrize("name", TRACKERS)
def test_a_step_is_one_of_a_tracker_that_holds_its_rules(name):
    kind = owner(name)
    assert is_dataclass(kind), f"{name} is a bare function"
    assert kind.__dataclass_params__.frozen
    assert callable(kind.start)


@pytest.mark.parametrize("name", TRACKERS)
def test_start_gives_a_state_and_step_the_next_one_with_an_info(name):
    start, step = (get_type_hints(getattr(owner(name), part)) for part in ("start", "step"))
    first = list(inspect.signature(owner(name).step).parameters)[1]
    assert first == "state"
    assert get_origin(start["return"]) is not tuple
    assert step["state"] == start["return"]
    after, info = get_args(step["return"])
    assert after == start["return"]
    assert is_dataclass(info)
    assert info.__name__.endswith("Info")


@pytest.mark.parametrize("part", ["start", "step"])
@pytest.mark.parametrize("name", TRACKERS)
def test_chance_comes_by_a_keyword_that_must_be_given(name, part):
    for word, parameter in inspect.signature(getattr(owner(name), part)).parameters.items():
        if word == "rng" or parameter.annotation is np.random.Generator:
            assert word == "rng"
            assert parameter.kind is parameter.KEYWORD_ONLY
            assert parameter.default is parameter.empty


@pytest.mark.parametrize("name", TRACKERS)
def test_a_step_changes_nothing_that_it_is_given_and_gives_the_same_again(name):
    (tracker, state, *seen), words = valid(steps()[name])
    again = deepcopy(words)
    before = list(parts(state))
    one = tracker.step(state, *seen, **words)
    assert list(parts(state)) == before
    assert list(parts(one)) == list(parts(tracker.step(state, *seen, **again)))
    hints = get_type_hints(owner(name).step)["return"]
    for found, hint in zip(one, get_args(hints), strict=True):
        assert isinstance(found, get_origin(hint) or hint)
    made = owner(name).start
    args, more = valid(made)
    hint = get_type_hints(made)["return"]
    assert isinstance(made(*args, **more), get_origin(hint) or hint)
