"""What is left of a function beside its equation compiles, and computes the same."""

import ast
import importlib
import inspect
import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from textwrap import dedent

import numpy as np
import pytest

from robot_perception import checks
from robot_perception.slam.planar.sensors import checked_sensor
from robot_perception.teaching.pages.listings import reduced, validates
from tests.hostile.surface import room_of
from tests.unchecked import unchecked

BOOK = Path(__file__).parents[2] / "book"
SHOWS = "show_source"
LONGEST = 40
WIDEST = 100


def cells(notebook: Path) -> list[ast.Module]:
    """Return the code of a notebook that shows the source of functions."""
    text = notebook.read_text("utf-8")
    found = json.loads(text)["cells"] if f"{SHOWS}(" in text else []
    return [ast.parse("".join(c["source"])) for c in found if c["cell_type"] == "code"]


def shown_in(notebook: Path) -> list:
    """Return the functions whose source a notebook shows."""
    names, functions, code = {}, [], cells(notebook)
    for node in (node for cell in code for node in cell.body):
        if isinstance(node, ast.Import | ast.ImportFrom):
            exec(compile(ast.Module([node], []), notebook.name, "exec"), names)
    for node in (node for cell in code for node in ast.walk(cell)):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == SHOWS:
            functions.append(eval(ast.unparse(node.args[0]), names))
    return functions


SHOWN = {
    f"{notebook.stem}: {function.__module__}.{function.__qualname__}": function
    for notebook in sorted(BOOK.glob("*.ipynb"))
    for function in shown_in(notebook)
}


def valid_call(function):
    """Return the valid call of a function, ``None`` of one that is neither public nor here."""
    room = room_of(function.__module__)
    if room == "chapters":
        return None  # a chapter's function does not validate
    calls = importlib.import_module(f"tests.hostile.calls.{room}").CALLS
    return calls[function]() if function in calls else None


def python(function):
    """Return the Python of a function that may be compiled or wrapped."""
    return inspect.unwrap(getattr(function, "py_func", function))


def from_listing(function):
    """Return the function that its listing defines, in the module of the original."""
    names = dict(python(function).__globals__)
    exec(compile(reduced(python(function)), "listing", "exec"), names)
    return names[function.__name__]


def same(one, other):
    """Tell whether two results are the same in type and value, to the last bit."""
    one, other = (v.item() if isinstance(v, np.generic) else v for v in (one, other))
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other, equal_nan=True)
    if is_dataclass(one):
        return all(same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if slots := getattr(one, "__slots__", ()):
        return all(same(getattr(one, name), getattr(other, name)) for name in slots)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, Mapping):
        return list(one) == list(other) and all(map(same, one.values(), other.values()))
    return one == other


def test_the_book_shows_sources():
    assert any(name.startswith("monobot: robot_perception.kalman.") for name in SHOWN)


@pytest.mark.parametrize("name", SHOWN)
def test_what_is_left_computes_the_same(name):
    function = SHOWN[name]
    found = valid_call(function)
    if found is None:  # nothing stood there that could be left out
        assert not validates(python(function))
        (before,) = ast.parse(dedent(inspect.getsource(python(function)))).body
        (after,) = ast.parse(reduced(python(function))).body
        rest = before.body[ast.get_docstring(before) is not None :]
        assert [ast.dump(line) for line in after.body] == [ast.dump(line) for line in rest]
        return
    args, kwargs = found
    again, named = valid_call(function)
    assert same(from_listing(function)(*again, **named), function(*args, **kwargs))
    assert all(map(same, again, args)), "an argument was changed"


@pytest.mark.parametrize("room", ["gating", "geometry", "kalman", "slam", "walls"])
def test_what_is_left_of_any_function_of_a_room_computes_the_same(room):
    calls = importlib.import_module(f"tests.hostile.calls.{room}").CALLS
    functions = [f for f in calls if inspect.isfunction(python(f)) and "." not in f.__qualname__]
    assert functions
    for function in functions:
        (args, kwargs), (again, named) = calls[function](), calls[function]()
        with unchecked():  # as for a reader; a call may have whole numbers for numbers
            both = from_listing(function)(*again, **named), function(*args, **kwargs)
            found, expected = (tuple(one) if inspect.isgenerator(one) else one for one in both)
        assert same(found, expected), function.__qualname__


@pytest.mark.parametrize("name", SHOWN)
def test_what_is_left_has_no_validation_no_annotation_and_no_docstring(name):
    code = reduced(python(SHOWN[name]))
    (node,) = ast.parse(code).body
    assert ast.get_docstring(node) is None
    assert not [n for n in ast.walk(node) if isinstance(n, ast.Raise | ast.AnnAssign)]
    assert not [n for n in ast.walk(node) if isinstance(n, ast.arg) and n.annotation is not None]
    assert "checks." not in code
    assert len(code.splitlines()) <= LONGEST
    assert max(map(len, code.splitlines())) <= WIDEST


ZERO = 0.0


def example(
    x: np.ndarray,  # positions
    gain: "float" = 2.0,
    *,
    names: tuple[str, ...] = (),
) -> np.ndarray:  # eq. (1)
    """Return something."""
    checks.instances("names", names, str)
    gain = checks.positive("gain", gain)
    y = checks.array("x", x, ("n",))  # the states
    limit = 1e3
    outside = np.abs(y) > limit
    # a comment on the guard
    if outside.any():
        first = int(np.argmax(outside))
        raise ValueError(f"entry {first} is too large")
    last = None
    for name, value in (("x", y), ("gain", gain)):
        if value is None:
            raise ValueError(f"{name} is None after {last}")
        if name != "gain":
            last = name

    count: int = len(y)
    scale = gain if gain is None else checks.number("gain", gain + 0) * count
    if count > 3:
        checks.check_finite("x", y)
    else:
        count += 1
    return y * scale + checks.number("ZERO", ZERO)  # eq. (2)


def test_everything_that_is_left_out_and_everything_that_stays():
    assert validates(example)
    assert reduced(example) == (
        "def example(x, gain=2.0, *, names=()):  # eq. (1)\n"
        "    y = x  # the states\n\n"
        "    count = len(y)\n"
        "    scale = gain if gain is None else (gain + 0) * count\n"
        "    if count > 3:\n"
        '        checks.check_finite("x", y)\n'
        "    else:\n"
        "        count += 1\n"
        "    return y * scale + ZERO  # eq. (2)\n"
    )


def converted(x: float | np.ndarray, *values: float) -> np.ndarray:
    """Return an array; a number that is given in its place needs the conversion."""
    x = checks.array("x", x)
    checks.shown(*values)
    return x.reshape(-1) * checks.number(*("x", 2.0))


def test_what_converts_a_number_into_an_array_stays():
    assert reduced(converted) == (
        "def converted(x, *values):\n"
        '    x = checks.array("x", x)\n'
        '    return x.reshape(-1) * checks.number(*("x", 2.0))\n'
    )


def own(checked_sensor, x):
    """Return what a variable gives that is named like a check which its module has."""
    checked_sensor("x", x)
    return checked_sensor("x", x)


def test_a_variable_is_no_check():
    assert not validates(own)
    line = 'checked_sensor("x", x)'
    assert reduced(own).splitlines()[1:] == [f"    {line}", f"    return {line}"]


def nested(gain: float, scale: float) -> float:
    """Return a product of what was checked twice, and in one of two cases."""
    twice = checks.number("gain", checks.positive("gain", gain))
    once = checks.positive("scale", scale) if scale > 1 else scale
    return twice * once


def test_checks_of_a_check_and_in_a_choice_go_as_a_whole():
    assert reduced(nested).splitlines()[1:] == [
        "    twice = gain",
        "    once = scale",
        "    return twice * once",
    ]
    assert from_listing(nested)(2.0, 3.0) == nested(2.0, 3.0)


def tallied(values: list[float]) -> list[float]:
    """Count what a check has read, and what it has not."""
    count = 0
    if len(values) < count:
        raise ValueError("values must not be empty")
    for _ in values:
        count += 1
    return values


def test_a_name_that_is_only_counted_up_stays_bound():
    assert validates(tallied)
    assert from_listing(tallied)([1.0, 2.0]) == [1.0, 2.0]


def test_a_function_that_only_checks_is_shown_whole():
    for check in (checks.check_finite, checked_sensor):
        assert not validates(check)
        (node,) = ast.parse(reduced(check)).body
        assert len(node.body) == 2


def test_a_long_definition_is_broken():
    def function_with_a_name_that_fills_a_line_almost_alone(
        one_parameter: int, another_parameter_of_the_kind: int
    ) -> int:
        return one_parameter + another_parameter_of_the_kind

    assert reduced(function_with_a_name_that_fills_a_line_almost_alone).splitlines() == [
        "def function_with_a_name_that_fills_a_line_almost_alone(",
        "    one_parameter, another_parameter_of_the_kind",
        "):",
        "    return one_parameter + another_parameter_of_the_kind",
    ]
