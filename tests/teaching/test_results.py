"""What is kept is computed once, and never stale: code, libraries and arguments are in its name."""

import multiprocessing
import time
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

import numpy as np
import pytest

from robot_perception.datasets.store import CACHE_VARIABLE
from robot_perception.teaching import results
from robot_perception.teaching.results import kept

LIBRARY = "robot_perception.kalman"
"""For whose function those of the tests are taken."""


@dataclass(frozen=True)
class Sum:
    values: np.ndarray
    about: dict | None = None


@dataclass(frozen=True)
class Size:
    name: str
    ends: tuple[float, ...]
    inner: object = 0.0


class Kind(Enum):
    A = "a"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    monkeypatch.setattr(results, "WORTH_KEEPING", 0.0)
    return tmp_path / "computed"


def counted():
    """Return a function as another process has it, nothing in its memory, and its calls."""
    calls = []

    def add(first, second=2.0, *, third=0.0):
        calls.append((first, second))
        return Sum(np.array([first, second, third]), {"name": "x", "more": [np.nan, None]})

    add.__module__ = LIBRARY
    return kept(add), calls


def files(folder: Path) -> list[Path]:
    return [file for file in folder.iterdir() if file.suffix != ".lock"]


def test_is_computed_once_by_two_processes(folder):
    (one, first), (other, second) = counted(), counted()
    made, read = one(1.0), other(1.0, second=2.0)
    assert (first, second) == ([(1.0, 2.0)], [])
    np.testing.assert_array_equal(made.values, read.values)
    assert read.about["more"][1] is None
    assert one(1.0) is made  # in memory
    assert len(files(folder)) == 1


def slow(seconds):
    time.sleep(seconds)
    return time.time()


def kept_slow(seconds):
    slow.__module__ = LIBRARY
    return kept(slow)(seconds)


def test_a_second_process_waits_for_the_first():
    with multiprocessing.get_context("fork").Pool(2) as pool:
        first, second = pool.map(kept_slow, [0.6, 0.6], chunksize=1)
    assert first == second


def test_other_arguments_are_another_result():
    one, calls = counted()
    assert one(1.0).values[0] == 1.0
    assert one(3.0).values[0] == 3.0
    assert one(1.0, third=1.0).values[2] == 1.0
    assert len(calls) == 3


@pytest.mark.parametrize("value", [np.zeros(2), [1.0], Size("a", (1.0,), [2]), Size, object()])
def test_arguments_whose_text_may_not_say_all_are_refused(value):
    one, calls = counted()
    with pytest.raises(TypeError, match=r"arguments must be|unhashable"):
        one(value)
    assert not calls


def test_dataclasses_of_dataclasses_are_arguments():
    seen = []

    def told(size):
        seen.append(size.inner.ends)
        return size.name

    told = kept(told)
    for ends in ((1.0,), (2.0,), (1.0,)):
        told(Size("a", (), Size("b", ends, (Kind.A, None))))
    assert seen == [(1.0,), (2.0,)]


@pytest.mark.parametrize("what", ["code", "library"])
def test_other_code_and_other_libraries_are_another_result(what, monkeypatch):
    one, first = counted()
    one(1.0)
    if what == "code":
        monkeypatch.setattr(results, "code_digest", lambda module: "other")
    else:
        monkeypatch.setattr(results, "version", lambda name: "0.0")
    other, second = counted()
    other(1.0)
    assert len(first) == len(second) == 1


@pytest.mark.parametrize("at", [0, 31, 32, 100, -1])
def test_a_damaged_file_is_computed_again_with_a_word_about_it(folder, at, caplog):
    one, _ = counted()
    one(1.0)
    (file,) = files(folder)
    content = bytearray(file.read_bytes())
    content[at] ^= 1
    file.write_bytes(content if at != 100 else content[:100])
    other, calls = counted()
    assert other(1.0).values[1] == 2.0
    assert len(calls) == 1
    assert "is damaged and computed anew" in caplog.text


def test_without_a_place_to_keep_it_is_computed_each_time(monkeypatch):
    monkeypatch.setenv(CACHE_VARIABLE, str(Path(__file__)))
    for _ in range(2):
        one, calls = counted()
        assert one(1.0).values[0] == 1.0
        assert len(calls) == 1


def test_what_takes_no_time_is_not_stored(folder, monkeypatch):
    monkeypatch.setattr(results, "WORTH_KEEPING", 60.0)
    one, _ = counted()
    one(1.0)
    assert not files(folder)


def test_a_function_of_a_readers_own_is_kept_in_memory_alone(folder):
    calls = []

    @kept
    def own(value):
        calls.append(value)
        return value

    assert [own(1.0), own(1.0)] == [1.0, 1.0]
    assert calls == [1.0]
    assert not folder.exists()


CELLS = (
    "from robot_perception.teaching.results import kept\nLEVEL, CALLS = 2.0, []",
    "@kept\ndef scaled(x):\n    CALLS.append(x)\n    return LEVEL * x",
    "@kept\ndef other(x):\n    return x",
)


def test_a_function_of_a_notebook_is_kept_by_the_code_that_it_reaches(book):
    """Another function may change, and a second process reads what the first has computed."""
    book.made(*CELLS).scaled(3)
    same = book.made(CELLS[0], CELLS[1], CELLS[2].replace("return x", "return -x"))
    assert (same.scaled(3), same.CALLS) == (6.0, [])
    changed = book.made(CELLS[0].replace("2.0", "2.5"), *CELLS[1:])
    assert (changed.scaled(3), changed.CALLS) == (7.5, [3])


def test_in_a_notebook_it_is_that_of_the_book_until_it_is_edited(book, live):
    book.made(*CELLS).scaled(3)
    own = live(*CELLS)
    assert (own.scaled(3), own.CALLS) == (6.0, [])
    edited = live("LEVEL = 3.0")
    assert (edited.scaled(3), edited.scaled(3), edited.CALLS) == (9.0, 9.0, [3])
