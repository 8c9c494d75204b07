"""One at a time: nothing is lost, who waits says so, and without a place for locks nobody waits."""

import logging
import os
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import chdir

import pytest

from robot_perception.datasets.store import CACHE_VARIABLE
from studies.stored import locks
from studies.stored.locks import alone, changing


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "cache"))
    return tmp_path / "cache"


def test_what_is_read_and_written_by_many_loses_nothing(cache, tmp_path):
    file = tmp_path / "number"
    file.write_text("0")
    (tmp_path / "link").symlink_to(file)

    def add(name):
        with changing(tmp_path / name):
            before = int(file.read_text())
            time.sleep(0.002)
            file.write_text(str(before + 1))

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(add, ["number", "link"] * 20))
    assert file.read_text() == "40"


def test_a_file_has_the_same_lock_from_every_folder(cache, tmp_path):
    with changing(tmp_path / "file"), chdir(tmp_path):
        other = threading.Thread(
            target=lambda: changing(locks.Path("file")).__enter__(), daemon=True
        )
        other.start()
        other.join(0.3)
        assert other.is_alive()


def test_who_waits_says_for_what(tmp_path, monkeypatch, caplog):
    monkeypatch.setattr(locks, "SOON", 0.05)
    inside, free = threading.Event(), threading.Event()

    def hold():
        with alone(tmp_path / "a.lock", "the walls"):
            inside.set()
            free.wait(10)

    holder = threading.Thread(target=hold)
    holder.start()
    inside.wait(10)
    threading.Timer(0.3, free.set).start()
    with alone(tmp_path / "a.lock", "the walls"):
        assert free.is_set()
    holder.join()
    assert caplog.messages == ["another process works on the walls; waiting until it ends"]


def test_an_error_inside_frees_the_lock(tmp_path):
    with pytest.raises(OSError, match="full"), alone(tmp_path / "a.lock", "it"):
        raise OSError("full")
    with alone(tmp_path / "a.lock", "it"):
        pass


def test_without_a_place_nobody_waits(tmp_path, monkeypatch, caplog):
    (tmp_path / "cache").touch()
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "cache"))
    with caplog.at_level(logging.WARNING), changing(tmp_path / "file"):
        pass
    assert f"no lock for {tmp_path / 'file'} (" in caplog.text
    assert os.listdir(tmp_path) == ["cache"]
