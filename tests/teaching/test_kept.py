"""What is kept is read, unless what it depends on has changed."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from robot_perception.datasets.store import CACHE_VARIABLE
from robot_perception.teaching import kept as module
from robot_perception.teaching import storage
from robot_perception.teaching.kept import kept

CALLS = []


@dataclass(frozen=True)
class Sum:
    values: np.ndarray


def compute(first: float, second: float) -> Sum:
    CALLS.append((first, second))
    return Sum(np.array([first, second]))


def told(size: "Size") -> Sum:
    CALLS.append(size.inner.ends)
    return Sum(np.array(size.inner.ends))


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    CALLS.clear()
    return tmp_path / "computed"


def test_is_computed_once_and_read_afterwards(folder):
    first, second = (kept(compute, Sum, 1.0, 2.0, code=[storage]) for _ in range(2))
    assert CALLS == [(1.0, 2.0)]
    np.testing.assert_array_equal(first.values, second.values)
    assert len(list(folder.iterdir())) == 1


def test_other_arguments_are_another_result():
    kept(compute, Sum, 1.0, 2.0, code=[storage])
    assert kept(compute, Sum, 2.0, 1.0, code=[storage]).values[0] == 2.0
    assert len(CALLS) == 2


@dataclass(frozen=True)
class Size:
    name: str
    ends: tuple[float, ...]
    inner: object = 0.0


@pytest.mark.parametrize("value", [np.zeros(2), [1.0], None, Size("a", (1.0,), [2]), Size])
def test_arguments_whose_text_may_not_say_all_are_refused(value):
    with pytest.raises(TypeError, match="arguments must be numbers, texts or dataclasses"):
        kept(compute, Sum, 1.0, value, code=[storage])
    assert not CALLS


def test_dataclasses_of_dataclasses_are_arguments():
    for ends in ((1.0,), (2.0,), (1.0,)):
        kept(told, Sum, Size("a", (), Size("b", ends)), code=[storage])
    assert CALLS == [(1.0,), (2.0,)]


def test_a_change_of_the_code_is_another_result(tmp_path, monkeypatch):
    source = tmp_path / "room.py"
    source.write_text("a = 1")
    monkeypatch.setattr(storage, "__file__", str(source))
    kept(compute, Sum, 1.0, 2.0, code=[storage])
    kept(compute, Sum, 1.0, 2.0, code=[storage])
    assert len(CALLS) == 1
    source.write_text("a = 2")
    kept(compute, Sum, 1.0, 2.0, code=[storage])
    assert len(CALLS) == 2


@contextmanager
def guard() -> Iterator[None]:
    """Do nothing; as a decorator, it is written in another file, as a check of shapes is."""
    yield


def test_a_decorator_changes_nothing():
    kept(compute, Sum, 1.0, 2.0, code=[storage])
    kept(guard()(compute), Sum, 1.0, 2.0, code=[storage])
    assert len(CALLS) == 1


def test_all_modules_of_a_package_count(tmp_path, monkeypatch):
    (tmp_path / "inner").mkdir()
    for name in ("__init__.py", "inner/deep.py"):
        (tmp_path / name).write_text("")
    monkeypatch.setattr(storage, "__file__", str(tmp_path / "__init__.py"))
    kept(compute, Sum, 1.0, 2.0, code=[storage])
    (tmp_path / "inner" / "deep.py").write_text("b = 1")
    kept(compute, Sum, 1.0, 2.0, code=[storage])
    assert len(CALLS) == 2


def test_another_version_of_a_library_is_another_result(monkeypatch):
    kept(compute, Sum, 1.0, 2.0, code=[storage])
    monkeypatch.setattr(module, "version", lambda name: "0.0")
    kept(compute, Sum, 1.0, 2.0, code=[storage])
    assert len(CALLS) == 2


def test_a_damaged_file_is_computed_again(folder):
    kept(compute, Sum, 1.0, 2.0, code=[storage])
    (file,) = folder.iterdir()
    file.write_bytes(file.read_bytes()[:40])
    assert kept(compute, Sum, 1.0, 2.0, code=[storage]).values[1] == 2.0
    assert len(CALLS) == 2
    kept(compute, Sum, 1.0, 2.0, code=[storage])
    assert len(CALLS) == 2


def test_without_a_place_to_keep_it_is_computed_each_time(tmp_path, monkeypatch):
    monkeypatch.setenv(CACHE_VARIABLE, str(Path(__file__)))
    for _ in range(2):
        assert kept(compute, Sum, 1.0, 2.0, code=[storage]).values[0] == 1.0
    assert len(CALLS) == 2


def test_what_is_no_function_is_refused():
    with pytest.raises(TypeError, match="compute must be a function"):
        kept(Sum, Sum, code=[storage])
