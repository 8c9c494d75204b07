"""What is kept is computed once, and never stale: code, libraries and arguments are in its name."""

import multiprocessing
import os
import pickle
import time
from dataclasses import dataclass
from enum import Enum
from pathlib import Path

import numpy as np
import pytest

from robot_perception.datasets.store import CACHE_VARIABLE
from studies.keys.dependencies import known_packages
from studies.stored import results, structures
from studies.stored.results import kept

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
    known = (*known_packages(), __name__.partition(".")[0])
    monkeypatch.setattr(structures, "known_packages", lambda: known)
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
        monkeypatch.setattr(results, "installed", lambda: {"numpy": "0.0"})
    other, second = counted()
    other(1.0)
    assert len(first) == len(second) == 1


@pytest.mark.parametrize("at", [0, 50, 100, -22])
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
    assert "computed anew" in caplog.text


class Planted:
    """Runs code where a pickle of it is read."""

    def __reduce__(self):
        return exec, ("raise SystemExit('a planted file was run')",)


def test_a_planted_file_runs_nothing(folder, caplog):
    one, _ = counted()
    one(1.0)
    (file,) = files(folder)
    np.savez(file, structure=np.array(Planted(), dtype=object))
    for content in (file.read_bytes(), pickle.dumps(Planted())):
        file.write_bytes(content)
        other, calls = counted()
        assert other(1.0).values[1] == 2.0
        assert len(calls) == 1
        assert "computed anew" in caplog.text


@pytest.mark.parametrize("made", [{1, 2}, lambda: 0, np.random.default_rng(0)])
def test_what_no_file_can_hold_is_kept_in_memory_alone(folder, made, caplog):
    def make(number):
        return made

    make.__module__ = LIBRARY
    assert kept(make)(1) is made
    assert not files(folder)
    assert "is not kept: cannot be stored" in caplog.text


def test_locks_go_when_their_work_is_done(folder):
    one, _ = counted()
    one(1.0)
    assert [file.suffix for file in folder.iterdir()] == [".npz"]


HOURS = {
    "computed/new-1.npz": 100,
    "computed/old-2.npz": 31 * 24,
    "computed/pickled-3": 25,
    "computed/pickled-4": 23,
    "computed/held-5.lock": 23,
    "computed/left-6.lock": 25,
    "computed/.unfinished-a1b2c3d4/half.npz": 9999,
    "trials/walls.some-7.json": 29 * 24,
    "trials/walls.some-8.json": 31 * 24,
    "trials-anew/walls.some-9.json": 31 * 24,
    "locks/claims.json-10.lock": 25,
    "carmen_intel/intel.log": 9999,
}
STAY = {0, 3, 4, 6, 7, 11}


def cached(tmp_path, size=10):
    for place, hours in HOURS.items():
        file = tmp_path / place
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(bytes(size))
        then = time.time() - hours * 3600
        os.utime(file, (then, then))


def left(tmp_path):
    return [k for k, place in enumerate(HOURS) if (tmp_path / place).exists()]


def test_what_nobody_has_used_for_long_is_removed(tmp_path):
    cached(tmp_path)
    done = results.prune()
    assert left(tmp_path) == sorted(STAY)
    assert (done.removed, done.removed_bytes, done.left, done.left_bytes) == (6, 60, 4, 40)
    assert results.prune().removed == 0


def test_of_too_much_the_oldest_goes(tmp_path, monkeypatch):
    cached(tmp_path)
    monkeypatch.setattr(results, "MOST_BYTES", 35)
    assert results.prune().left_bytes == 30
    assert left(tmp_path) == sorted(STAY - {7})


def test_what_is_used_stays(tmp_path, folder):
    one, _ = counted()
    one(1.0)
    (file,) = files(folder)
    os.utime(file, (0, 0))
    other, calls = counted()
    other(1.0)
    assert not calls
    assert results.prune().removed == 0


def test_what_a_download_that_was_killed_has_left_goes_a_day_later(tmp_path):
    lost, fresh = (tmp_path / "hall" / f".unfinished-{k}" for k in "ab")
    for place in (lost, fresh):
        place.mkdir(parents=True)
        (place / "scans.log").touch()
    os.utime(lost, (0, 0))
    results.prune()
    assert (lost.exists(), fresh.exists()) == (False, True)


def test_an_empty_cache_has_nothing_to_remove(tmp_path, monkeypatch):
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "nowhere"))
    assert results.prune() == results.Pruned(0, 0, 0, 0)


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
    "from studies.stored.results import kept\nLEVEL, CALLS = 2.0, []",
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
