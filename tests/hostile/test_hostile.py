"""Hostile calls: whatever a caller gets wrong ends in an error that names the parameter.

Public is what the pages in ``book/library`` document, and every module of ``data_synth``: the
``__all__`` of a package, else what a module defines without an underscore. Of a class these are the
constructor and the methods, not those of protocols (somebody else writes them) or exceptions.
A class that the library alone makes and hands out, and that checks nothing, needs no call: nobody
calls its constructor. A method in ``INNER`` is one half of a protocol: the library calls it, at
every step, with arrays that it has made or checked.

``calls/<room>.py`` has a valid call for each, but for types whose objects other calls are given:
theirs follow. The sweep replaces one argument after the other by
each of a fixed set of wrong values, unchecked, as a user calls. A world is called by chapters
alone: of `data_synth` only what a chapter names is swept, by wrong numbers, shapes and words. Right
answers are

* a ``ValueError`` or ``TypeError`` of our own or of the built-in classes (not NumPy's
  ``LinAlgError``) whose message holds the name of the parameter;
* an ``OSError``, or a ``LookupError`` of our own, that the docstring names;
* a result without a NaN where that of the valid call has none; what is no number may be accepted
  only where the signature says so.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from tests.hostile.surface import calls, made, modules, public, room_of
from tests.hostile.sweep import call, sweep, sweep_huge, wrong_numbers, wrong_values
from tests.unchecked import unchecked

ROOMS = sorted(p.stem for p in Path(__file__).with_name("calls").glob("[!_]*.py"))


def test_every_room_has_calls():
    assert set(ROOMS) == {room_of(name) for name in modules()}


@pytest.mark.parametrize("room", ROOMS)
def test_every_public_function_has_a_valid_call(room):
    table, names = import_module(f"tests.hostile.calls.{room}"), public(room)
    told = {*calls(room), *getattr(table, "INNER", set())}
    assert not [name for thing, name in names.items() if thing not in told | made(room)]
    assert not [thing for thing in told if thing not in names]


@pytest.mark.slow  # `make check` sweeps the rooms that a change reaches
@pytest.mark.parametrize("room", ROOMS)
@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_wrong_arguments_are_named(room, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # "abc" is a file that can be written
    table, names = import_module(f"tests.hostile.calls.{room}"), public(room)
    for variable, value in getattr(table, "ENVIRONMENT", {}).items():
        monkeypatch.setenv(variable, value)
    valid = calls(room)
    swept = {thing: name for thing, name in names.items() if thing in valid}
    with unchecked():
        failures = sweep(valid, swept, wrong_numbers if room == "data_synth" else wrong_values)
    assert not failures, f"{len(failures)} failures\n" + "\n".join(failures)


@pytest.mark.slow
@pytest.mark.parametrize("room", ROOMS)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_the_ends_of_floating_point_end_in_no_foreign_error(room, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    table, names = import_module(f"tests.hostile.calls.{room}"), public(room)
    for variable, value in getattr(table, "ENVIRONMENT", {}).items():
        monkeypatch.setenv(variable, value)
    valid = calls(room)
    swept = {thing: name for thing, name in names.items() if thing in valid}
    with unchecked():
        failures = sweep_huge(valid, swept)
    assert not failures, f"{len(failures)} failures\n" + "\n".join(failures)


def half(value: float) -> float:
    """Return a half, or raise ``ValueError``."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        raise ValueError(f"value must be a finite number, got {value!r}")
    return value / 2


def unnamed(value: float) -> float:
    if not isinstance(value, float):
        raise ValueError("must be a number")
    return value


def loose(value: int) -> float:
    return 0.5


def foreign(value: list[int]) -> int:
    return [1, 2][value]


def silent(value: float) -> dict[str, list]:
    return {"there": [np.sqrt(np.square(value)) if isinstance(value, float) else 0.5]}


def endless(value: int) -> int:
    if value != 1:
        while True:
            pass
    return value


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (half, ""),
        (unnamed, "ValueError: must be a number"),
        (loose, "(value=a class): accepted, not <class 'int'>"),
        (foreign, "(value=10**30): IndexError"),
        (silent, "(value=nan): a NaN in silence"),
        (endless, "(value=-1): Ran: ran for"),
    ],
)
def test_the_sweep_finds(function: Callable, said: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("tests.hostile.sweep.SECONDS", 0.01)
    valid = 0.5 if function is not endless else 1
    valid = 1 if function is foreign else valid
    failures = sweep({function: lambda: call(valid)}, {function: function.__name__})
    assert any(said in line for line in failures) if said else not failures


def test_the_surface_holds_functions_classes_and_methods_but_no_protocols():
    names = set(public("slam").values())
    some = {"planar.update", "planar.textbook.update", "planar.Settings", "planar.MapBelief.start"}
    assert {f"slam.{name}" for name in some} <= names
    assert not [name for name in names if name.endswith(("Workspace", "Formula", "StateSensor"))]


@dataclass
class Taken:
    gain: float


@dataclass
class Inside:
    ends: tuple[float, float]


@dataclass
class Given:
    inner: list[Inside]


@dataclass
class Asked:
    gain: float

    def __post_init__(self):
        """Check."""


def made_of(taken: Taken, ask: Callable[[Asked], float]) -> tuple[Given, ...]:
    return ()


def test_what_is_handed_out_unchecked_needs_no_call_and_what_is_taken_does(monkeypatch):
    things = dict.fromkeys((Taken, Inside, Given, Asked, made_of), "")
    monkeypatch.setattr("tests.hostile.surface.public", lambda room: things)
    assert made("any") == {Given, Inside}
