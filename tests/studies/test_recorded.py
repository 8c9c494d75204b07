"""States that are stored with the book: read while they are what the code computes, else not."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from robot_perception import chapters
from robot_perception.beliefs import Gaussian
from robot_perception.ceiling.mosaic import Links
from studies.keys import versions
from studies.keys.versions import here
from studies.records import records
from studies.stored import recorded as module
from studies.stored.recorded import Recorded, recorded
from studies.stored.structures import Packed, packed, unpacked
from studies.verdicts import Verdict


@dataclass(frozen=True, eq=False)
class Other:
    """None of the book's."""

    number: float


class Pair(NamedTuple):
    one: float
    two: int


def picture(seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 256, (6, 8, 3)).astype(np.uint8)


TABLE = np.zeros((2,), [("at", "<f8", (3,)), ("hit", "?"), ("name", "<U2"), ("n", "<i4")])
TABLE["at"], TABLE["name"], TABLE["n"] = np.arange(6.0).reshape(2, 3), ["ab", "c"], [7, -1]
VALUES = [
    None,
    True,
    3,
    0.1,
    -np.inf,
    "words, “quoted”",
    (1, (2.5, "a"), [None, False]),
    {("left", 0.5): 1.0, "x": {2: []}},
    np.arange(6.0).reshape(2, 3),
    np.array([np.nan, np.inf, -0.0]),
    np.array([[True, False]]),
    np.array(2.0),
    np.array(["ab", "c"]),
    np.array(["ab", "c"], dtype="<U9"),
    np.zeros((0, 2), dtype="<U3"),
    np.zeros((0, 2)),
    np.arange(4, dtype=np.int32),
    np.float32(0.1),
    np.int64(7),
    np.bool_(True),
    picture(),
    np.asfortranarray(picture()),
    Verdict.REFUTED,
    TABLE,
    TABLE[:0],
    TABLE.view(np.recarray),
    Gaussian(np.array([[1.0, 2.0]]), np.eye(2)[None]),
]


def the_same(one: object, other: object) -> bool:
    """Tell whether two values are the same, of the same types, to the last bit."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray | np.generic):
        return one.dtype == other.dtype and one.shape == other.shape and bool(
            np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
        )  # fmt: skip
    if isinstance(one, dict):
        return list(one) == list(other) and all(the_same(one[key], other[key]) for key in one)
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(the_same, one, other))
    if isinstance(one, Gaussian):
        return the_same(one.mean, other.mean) and the_same(one.cov, other.cov)
    return one == other


@pytest.mark.parametrize("value", VALUES, ids=lambda value: type(value).__name__)
@pytest.mark.parametrize("pictures", [True, False])
def test_a_value_is_made_again_of_its_text_and_its_numbers(value, pictures):
    assert the_same(unpacked(packed(value, pictures=pictures)), value)


def test_all_values_together_are_made_again():
    for ours, theirs in zip(unpacked(packed(VALUES)), VALUES, strict=True):
        assert the_same(ours, theirs)


def test_fields_that_no_argument_sets_are_stored_too():
    there = {"a": np.array([1.0, 2, 0.1, 1]), "b": np.array([3.0, 2, 0.2, 1])}
    links = Links().add(there, np.zeros(2), 0.1)
    (again,) = unpacked(packed([links]))
    (found,) = again.means().values()
    (true,) = links.means().values()
    np.testing.assert_array_equal(found.pose, true.pose)


def test_what_stands_in_it_twice_is_stored_once():
    long = np.arange(1000.0)
    parts = packed([long, long, long.copy()])
    assert len(parts.arrays["f8"]) == 2000
    one, two, three = unpacked(parts)
    assert one is two
    assert one is not three


@pytest.mark.parametrize("value", [{1, 2}, lambda: 0, np.array([object()]), 1j, [Ellipsis]])
def test_what_cannot_be_stored_is_refused(value):
    with pytest.raises(TypeError, match="cannot be stored: "):
        packed(value)


@pytest.mark.parametrize("value", [Other(1.0), Pair(1.0, 2)])
def test_no_value_of_another_package_is_stored(value):
    with pytest.raises(TypeError, match=f"cannot be stored: {__name__}"):
        packed(value)


@pytest.mark.parametrize("plan", [["object", "os", "stat_result", {}], ["member", "re", "A", "A"]])
def test_no_class_of_another_package_is_ever_made(plan):
    with pytest.raises(ValueError, match="is none of the packages"):
        unpacked(Packed(json.dumps(plan), {}))


@pytest.mark.parametrize("how", [["object", {}], ["member", "A"]])
@pytest.mark.parametrize("name", ["reading", "os.system", "DamagedFile"])
def test_nothing_is_called_but_dataclasses(how, name):
    text = json.dumps([how[0], "studies.files", name, how[1]])
    with pytest.raises(ValueError, match="is no dataclass"):
        unpacked(Packed(text, {}))


@pytest.mark.parametrize(
    ("one", "other", "alike"),
    [
        (1.0, 1.0 + 1e-12, True),
        (1.0, 1.0 + 1e-7, False),
        (np.nan, np.nan, True),
        (1.0, np.nan, False),
        (1.0, 1, False),
        ("a", "b", False),
        ([1.0], (1.0,), False),
        ([1.0, 2.0], [1.0], False),
    ],
)
def test_values_are_alike_to_rounding(one, other, alike):
    assert packed(one).alike(packed(other)) == alike


# What is stored ----------------------------------------------------------------------------------

COMPUTED: list[tuple[int, float]] = []


def compute(count: int, scale: float = 2.0) -> tuple[float, ...]:
    """Count."""
    COMPUTED.append((count, scale))
    return tuple(scale * k for k in range(count))


CALLS = ((3,), (4, 0.5))


def made(function: Callable = compute, calls: tuple = CALLS) -> Recorded:
    """Return a function as a chapter has it, in a process that has read nothing yet."""
    return recorded("test-states", calls)(function)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """A place for what is stored, and code that has one hash."""
    monkeypatch.setattr(module, "records", lambda: tmp_path)
    monkeypatch.setattr(module, "code_digest", lambda name: f"code of {name.partition(':')[0]}")
    COMPUTED.clear()
    return tmp_path


@pytest.fixture
def stored(folder) -> Path:
    """The results of two calls, stored; nothing is computed so far."""
    file = made().write()
    COMPUTED.clear()
    return file


def test_without_what_is_stored_it_is_computed_once():
    function = made()
    assert not function.is_current()
    assert function(3) == function(count=3) == (0.0, 2.0, 4.0)
    assert COMPUTED == [(3, 2.0)]


def test_what_is_stored_is_not_computed(stored):
    function = made()
    assert function.is_current()
    assert function(3) == function(3, 2.0) == (0.0, 2.0, 4.0)
    assert function(4, scale=0.5) == (0.0, 0.5, 1.0, 1.5)
    assert COMPUTED == []
    assert function(5) == (0.0, 2.0, 4.0, 6.0, 8.0)
    assert COMPUTED == [(5, 2.0)]


def test_what_is_no_number_is_stored_too(folder):
    made(lambda count, scale=2.0: (np.nan, np.array([np.inf])), ((3,),)).write()
    one, two = made(calls=((3,),))(3)
    assert np.isnan(one)
    assert np.isinf(two).all()


def other_code(file: Path, monkeypatch: pytest.MonkeyPatch) -> Recorded:
    monkeypatch.setattr(module, "code_digest", lambda name: "other code")
    return made()


def other_numbers(file: Path, monkeypatch: pytest.MonkeyPatch) -> Recorded:
    module.storage.save(file, packed({"(3, 2.0)": (7.0,), "(4, 0.5)": (8.0,)}))
    return made()


def damaged(file: Path, monkeypatch: pytest.MonkeyPatch) -> Recorded:
    file.write_bytes(file.read_bytes()[:-20])
    return made()


def no_summary(file: Path, monkeypatch: pytest.MonkeyPatch) -> Recorded:
    file.with_suffix(".json").unlink()
    return made()


def half_a_summary(file: Path, monkeypatch: pytest.MonkeyPatch) -> Recorded:
    file.with_suffix(".json").write_text("{")
    return made()


def other_calls(file: Path, monkeypatch: pytest.MonkeyPatch) -> Recorded:
    return made(calls=(*CALLS, (5,)))


WHY = {
    other_code: "the code has changed since they were stored on 2",
    other_numbers: "test-states.npz is not what was stored",
    damaged: "test-states.npz is not what was stored",
    no_summary: "test-states.npz is not what was stored",
    half_a_summary: "test-states.json: no summary of states",
    other_calls: "test-states.npz is not what was stored for these calls",
}
"""What a reader is told."""


@pytest.mark.parametrize("change", WHY)
def test_it_is_computed_after(change, stored, monkeypatch, caplog):
    function = change(stored, monkeypatch)
    COMPUTED.clear()
    if change is not half_a_summary:
        assert not function.is_current()
    assert function(3) == (0.0, 2.0, 4.0)
    assert COMPUTED == [(3, 2.0)]
    function(4, 0.5)
    (line,) = caplog.messages  # once
    assert line.startswith("test-states: states are computed anew, for ")
    assert WHY[change] in line


def test_in_a_notebook_the_cell_says_why_it_computes(stored, monkeypatch, caplog, capsys):
    monkeypatch.setattr(module, "shell", object)
    made()(3)
    assert capsys.readouterr().out == ""
    other_code(stored, monkeypatch)(3)
    assert "test-states: states are computed anew, for the code has" in capsys.readouterr().out
    assert not caplog.messages


def test_states_of_other_packages_are_read(stored, monkeypatch):
    assert json.loads(stored.with_suffix(".json").read_text())["versions"] == here()
    monkeypatch.setattr(versions, "installed", lambda: {"numpy": "9.9"})
    function = made()
    assert function.is_current()
    assert function(3) == (0.0, 2.0, 4.0)
    assert COMPUTED == []
    assert function.other_packages() == f"numpy {np.__version__} (here 9.9)"
    assert function.renew()
    assert made().other_packages() == ""


def test_the_code_is_that_of_the_function(stored, monkeypatch):
    said = json.loads(stored.with_suffix(".json").read_text())
    assert said["code"] == f"code of {__name__}"
    assert said["function"] == f"{__name__}.compute"
    asked = []
    monkeypatch.setattr(module, "code_digest", lambda name: asked.append(name) or "other")
    assert not made().is_current()
    assert asked == [f"{__name__}:compute"]


def test_the_code_of_a_function_of_study_cells_is_what_it_reaches(folder, monkeypatch):
    def of_cells(count: int, scale: float = 2.0) -> tuple[float, ...]:
        return compute(count, scale)

    of_cells.__module__ = "robot_perception.book.tutor_following"
    monkeypatch.setattr(module, "code_of", lambda function: f"cells of {function.__name__}")
    file = made(of_cells).write()
    assert json.loads(file.with_suffix(".json").read_text())["code"] == "cells of of_cells"
    assert made(of_cells).is_current()
    monkeypatch.setattr(module, "code_of", lambda function: "edited")
    assert not made(of_cells).is_current()


def test_keys_are_renewed_only_if_the_results_are_the_same(stored, monkeypatch):
    before = stored.read_bytes()
    monkeypatch.setattr(module, "code_digest", lambda name: "other code")
    nearly = made(lambda count, scale=2.0: tuple(x * (1 + 1e-13) for x in compute(count, scale)))
    assert nearly.renew()
    assert nearly.is_current()
    assert stored.read_bytes() == before
    monkeypatch.setattr(module, "code_digest", lambda name: "third code")
    wrong = made(lambda count, scale=2.0: tuple(x + 1e-6 for x in compute(count, scale)))
    assert not wrong.renew()
    assert not wrong.is_current()


def test_nothing_is_renewed_that_is_not_stored():
    assert not made().renew()


def test_what_would_be_read_otherwise_is_not_stored(folder, monkeypatch):
    monkeypatch.setattr(module, "unpacked", lambda parts: {"(3, 2.0)": (0.0,)})
    with pytest.raises(TypeError, match="test-states: what is read would not be what was stored"):
        made().write()
    assert not list(folder.iterdir())


def test_it_keeps_the_words_of_the_function():
    assert made().__doc__ == "Count."
    assert made().__name__ == "compute"


# Those of the book -------------------------------------------------------------------------------

LARGEST = 1_000_000  # bytes
ALL = chapters.states()


def test_stored_results_have_names_of_their_own():
    names = [found.store for found in (*chapters.recordings(), *ALL)]
    assert len(set(names)) == len(names) > len(ALL) > 0


@pytest.mark.parametrize("found", ALL, ids=lambda found: found.store)
def test_what_the_book_reads_is_what_was_stored(found: Recorded, monkeypatch):
    monkeypatch.undo()
    assert found.is_stored()
    assert (records() / f"{found.store}.npz").stat().st_size <= LARGEST


@pytest.mark.parametrize("ask", [chapters.states, chapters.recordings])
def test_an_unknown_chapter_has_nothing_stored(ask):
    with pytest.raises(ValueError, match="no chapter 'sailing'"):
        ask(["sailing"])


def test_recordings_are_found_in_packages_and_in_study_cells():
    found = [one.store for one in chapters.recordings(["tutor_face", "tutor_following"])]
    assert {"faces-yale", "handless-hall", "hands-hgr1", "girl-patches"} <= set(found)
    assert len(found) == len(set(found))
