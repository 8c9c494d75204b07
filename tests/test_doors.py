"""Every room says what it is for, and its door opens: at once, and on what stands in it."""

import json
import re
import subprocess
import sys
from importlib import import_module
from inspect import getdoc
from pathlib import Path

import pytest

import robot_perception
from robot_perception.doors import door

ROOMS = (
    "walls",
    "slam",
    "landmarks",
    "people",
    "appearance",
    "ceiling",
    "companion",
    "companion.faces",
    "companion.hands",
    "arms",
    "day",
    "evaluation",
    "datasets",
    "geometry",
)
LAZY = tuple(room for room in ROOMS if room not in {"walls", "landmarks", "datasets", "geometry"})


def package(room: str):
    return import_module(f"robot_perception.{room}")


def test_every_package_of_the_library_is_a_room_or_lies_in_one():
    lib = Path(robot_perception.__file__).parent
    outside = {"book", "chapters", "teaching", "cli", "_data"}
    found = {file.parent.name for file in lib.glob("*/__init__.py")} - outside
    assert found == {room for room in ROOMS if "." not in room}


@pytest.mark.parametrize("room", ROOMS)
def test_a_room_says_in_a_sentence_what_it_is_for(room):
    first = getdoc(package(room)).split("\n")[0]
    assert re.fullmatch(r"[A-Z].{20,}\.", first), first


@pytest.mark.parametrize("room", ROOMS)
def test_a_door_opens_on_what_it_names(room):
    there = package(room)
    assert there.__all__ == sorted(set(there.__all__))
    assert set(there.__all__) <= set(dir(there))
    for name in there.__all__:
        assert getattr(there, name) is not None
    with pytest.raises(AttributeError, match=rf"'robot_perception\.{room}' has no attribute 'wal'"):
        _ = there.wal


@pytest.mark.parametrize("room", LAZY)
def test_a_name_is_what_its_module_calls_so_and_no_module_as_well(room):
    there = package(room)
    modules = [name for name in there.__all__ if hasattr(getattr(there, name), "__spec__")]
    for name in set(there.__all__) - set(modules):
        homes = [module for module in modules if hasattr(getattr(there, module), name)]
        assert any(getattr(getattr(there, home), name) is getattr(there, name) for home in homes)
    for module in modules:
        assert getattr(there, module) is import_module(f"{there.__name__}.{module}")


def test_a_door_costs_nothing_until_it_opens():
    names = [f"robot_perception.{room}" for room in LAZY]
    code = (
        "import importlib, json, sys\n"
        f"for name in {names}: importlib.import_module(name)\n"
        "print(json.dumps(sorted({name.partition('.')[0] for name in sys.modules})))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(json.loads(run.stdout))
    assert "robot_perception" in loaded
    assert not loaded & {"numpy", "scipy", "numba", "cv2", "sympy"}


def test_a_door_asks_for_the_module_that_holds_a_name():
    asked = []

    def by(name):
        asked.append(name)
        return import_module("math")

    find, listed, everything = door("house.hall", {"rooms": ("pi",), "attic": ()}, by)
    assert listed() == everything == ["attic", "pi", "rooms"]
    assert asked == []
    assert find("pi") == pytest.approx(3.14159, abs=1e-5)
    assert find("attic") is import_module("math")
    assert asked == ["house.hall.rooms", "house.hall.attic"]
    with pytest.raises(AttributeError, match=r"module 'house\.hall' has no attribute 'tau'"):
        find("tau")
