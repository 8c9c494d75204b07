"""Damaged files give the right content or one error of ours, and no file is written by half."""

import json
import logging
import os
import shutil
import stat
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from PIL import Image

from robot_perception import datasets
from robot_perception.datasets import entries
from robot_perception.slam import planar
from studies.files import UNFINISHED, DamagedFile, destination, reading, written
from studies.ledger import Ledger
from studies.records import records
from studies.stored import recordings, results, storage

TRIES = 90


@dataclass(eq=False)
class Stored:
    numbers: np.ndarray
    words: str
    count: int
    picture: np.ndarray = field(metadata={"webp": 100})


def stored(rng: np.random.Generator) -> Stored:
    picture = rng.integers(0, 255, (20, 30)).astype(np.uint8)
    return Stored(rng.normal(size=100), "wörds", 7, picture)


def damaged(whole: bytes, tries: int = TRIES) -> Iterator[bytes]:
    """Yield contents with one bit that fell over, or, each third time, cut off somewhere."""
    rng = np.random.default_rng(len(whole))
    for k in range(tries):
        at, broken = int(rng.integers(len(whole))), bytearray(whole)
        broken[at] ^= 1 << int(rng.integers(8))
        yield whole[:at] if k % 3 == 2 else bytes(broken)


def same(one: Any, other: Any) -> bool:
    if hasattr(one, "__dataclass_fields__"):
        return all(same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    return np.array_equal(one, other, equal_nan=np.asarray(one).dtype.kind == "f")


def make_stored(file: Path) -> None:
    storage.save(file, stored(np.random.default_rng(0)))


def make_legs(file: Path) -> None:
    ends = {"angle_min": -1.0, "angle_increment": 0.1, "range_min": 0.1, "range_max": 9.0}
    np.savez_compressed(file, stamp=np.arange(9.0), ranges=np.ones((9, 20)), **ends)


def make_ledger(file: Path) -> None:
    entries_ = Ledger.read(records() / "claims.json").entries[:3]
    Ledger(entries_).write(file)


def make_registry(file: Path) -> None:
    for name in (entries.SETS, entries.REGISTRY):
        shutil.copy(entries.BOOK / name, file.with_name(name))


def read_registry(file: Path) -> Any:
    entries._parse.cache_clear()
    return dict(entries._load(file.parent))


def make_ranges(file: Path) -> None:
    np.save(file, np.random.default_rng(0).uniform(0.5, 9, (6, 10)))


def read_ranges(file: Path) -> np.ndarray:
    return datasets.read_ranges(file, max_range=20.0)


def make_picture(file: Path) -> None:
    Image.fromarray(np.random.default_rng(0).integers(0, 255, (24, 32)).astype(np.uint8)).save(file)


def make_gps(file: Path) -> None:
    wide = np.random.default_rng(0).normal(size=(2, 30))
    content = {"timeGps": np.arange(30) * 1e3, "Lo_m": wide[0], "La_m": wide[1]}
    scipy.io.savemat(file, content, do_compression=True)


KINDS: dict[str, tuple[str, Callable, Callable, bool, int]] = {
    # name of the file, what makes it, what reads it, whether all damage can be seen, tries
    "stored result": ("result.npz", make_stored, lambda f: storage.load(f, Stored), True, 120),
    "leg scans": ("legs.npz", make_legs, datasets.read_leg_scans, True, TRIES),
    "ledger": ("claims.json", make_ledger, Ledger.read, False, TRIES),
    "data sets": ("sets.toml", make_registry, read_registry, False, TRIES),
    "hashes": ("registry.txt", make_registry, read_registry, False, TRIES),
    "ranges": ("ranges.npy", make_ranges, read_ranges, False, TRIES),
    "GPS": ("gps.mat", make_gps, datasets.read_fixes, True, 12),
    "png": ("a.png", make_picture, datasets.read_image, True, TRIES),
    **{
        kind: (f"a.{kind}", make_picture, datasets.read_image, False, TRIES)
        for kind in ("jpg", "webp", "tif", "bmp", "gif", "pgm")
    },
}


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_file_is_read_right_or_named(kind, tmp_path):
    name, make, read, seen, tries = KINDS[kind]
    file = tmp_path / name
    make(file)
    right, whole = read(file), file.read_bytes()
    refused = []
    for content in damaged(whole, tries):
        file.write_bytes(content)
        try:
            found = read(file)
        except DamagedFile as error:  # anything else lets the test fail
            refused.append(str(error))
        else:
            assert not seen or same(found, right)
    assert len(refused) >= tries / 4
    assert all(name in text or str(tmp_path) in text for text in refused)


def test_readings_no_laser_gives_are_refused(tmp_path):
    for wrong in (1e296, -1e7, np.frombuffer(b"\x01\0\0\0\0\0\xf0\x7f")[0]):
        np.save(tmp_path / "a.npy", np.array([[1.0, wrong]]))
        with pytest.raises(datasets.CorruptLog, match=r"a\.npy: .*no distance in metres"):
            read_ranges(tmp_path / "a.npy")
    for right in (np.nan, np.inf, 0.0, np.finfo(np.float32).max):
        np.save(tmp_path / "a.npy", np.array([[1.0, right]]))
        assert read_ranges(tmp_path / "a.npy")[0, 0] == 1.0


@pytest.mark.parametrize("kind", ["eps", "pdf", "dds", "tga", "pcx"])
def test_pictures_are_of_a_closed_list_of_formats(kind, tmp_path):
    file = tmp_path / f"picture.{kind}"
    make_picture(file)
    with pytest.raises(datasets.CorruptImage, match=rf"picture\.{kind}: no picture"):
        datasets.read_image(file)


def test_a_kept_result_that_cannot_be_read_is_computed_anew(tmp_path, caplog):
    file = tmp_path / "kept.npz"
    right = np.arange(3000) * 0.37, "text" * 50
    results._write(file, right)
    whole, refused = file.read_bytes(), 0
    for content in damaged(whole, 80):
        caplog.clear()
        file.write_bytes(content)
        found = results._read(file)
        if found is None:
            refused += 1
            assert f"{file}: " in caplog.text
            assert "computed anew" in caplog.text
        else:  # a bit of the archive's dates
            assert same(found[0][0], right[0])
            assert found[0][1] == right[1]
    assert refused > 60


@pytest.mark.parametrize("part", ["npz", "json"])
def test_a_stored_result_that_is_damaged_is_computed_from_the_recording(
    part, tmp_path, monkeypatch, caplog
):
    monkeypatch.setattr(recordings, "records", lambda: tmp_path)
    monkeypatch.setattr(datasets, "find", lambda name: tmp_path)
    made = stored(np.random.default_rng(3))
    recording = recordings.Recording("mine", lambda folder: made, Stored, "mine-store")
    monkeypatch.setattr(recordings.Recording, "_code", lambda self: "code")
    monkeypatch.setattr(recordings.Recording, "_data", lambda self: "data")
    monkeypatch.setattr(datasets, "path", lambda name: tmp_path)
    recording.write()
    assert not recording.read().live
    file = tmp_path / f"mine-store.{part}"
    file.write_bytes(file.read_bytes()[:40])
    with caplog.at_level(logging.WARNING):
        found = recording.read()
    assert found.live
    assert found.result is made
    assert f"mine-store.{part}" in caplog.text
    monkeypatch.setattr(datasets, "find", lambda name: None)
    with pytest.raises(DamagedFile, match=rf"mine-store\.{part}"):
        recording.read()


@pytest.mark.parametrize("name", ["\ud800", "a\0b"])
def test_a_name_that_no_file_can_have_is_refused(name, tmp_path):
    with pytest.raises(ValueError, match="path must be a name that a file can have") as refused:
        destination(f"{tmp_path}/{name}", overwrite=True)
    assert not isinstance(refused.value, UnicodeError)


def test_reading_lets_through_that_there_is_no_file_and_what_is_named(tmp_path):
    with pytest.raises(FileNotFoundError), reading("a", "bad"):
        (tmp_path / "a").read_bytes()
    with pytest.raises(DamagedFile, match=r"^named$"), reading("a", "bad"):
        raise DamagedFile("named")
    with pytest.raises(DamagedFile, match=r"^a: bad \(MemoryError\)$"), reading("a", "bad"):
        raise MemoryError
    with pytest.raises(KeyboardInterrupt), reading("a", "bad"):
        raise KeyboardInterrupt


@pytest.mark.parametrize("before", [None, b"old"])
@pytest.mark.parametrize("stop", [KeyboardInterrupt, OSError, SystemExit])
def test_a_write_that_is_interrupted_leaves_the_old_file_or_none(before, stop, tmp_path):
    file = tmp_path / "file.txt"
    if before is not None:
        file.write_bytes(before)

    def interrupted() -> None:
        with written(file) as beside:
            beside.write_bytes(b"half")
            raise stop

    with pytest.raises(stop):
        interrupted()
    assert (file.read_bytes() if file.exists() else None) == before
    assert list(tmp_path.iterdir()) == ([] if before is None else [file])
    with written(file) as beside:
        beside.write_bytes(b"new")
    assert file.read_bytes() == b"new"
    assert list(tmp_path.iterdir()) == [file]


@pytest.mark.parametrize("mode", [0o600, 0o640, 0o664, 0o755])
def test_a_file_that_is_written_again_keeps_who_may_read_it(mode, tmp_path):
    file = tmp_path / "file.txt"
    file.touch()
    file.chmod(mode)
    with written(file) as beside:
        beside.write_bytes(b"new")
    assert stat.S_IMODE(file.stat().st_mode) == mode
    fresh = tmp_path / "fresh.txt"
    with written(fresh) as beside:
        beside.write_bytes(b"new")
    (tmp_path / "plain.txt").touch()
    assert fresh.stat().st_mode == (tmp_path / "plain.txt").stat().st_mode


def test_what_a_kill_has_left_goes_a_day_later(tmp_path):
    names = [".unfinished-a1b2c3d4", ".unfinished-x0x0x0x0", ".mine"]
    for name, hours in zip(names, (25, 23, 1000), strict=True):
        (tmp_path / name).mkdir()
        (tmp_path / name / "file.txt").write_text("half")
        then = time.time() - hours * 3600
        os.utime(tmp_path / name, (then, then))
    with written(tmp_path / "file.txt") as beside:
        assert beside.parent.name.startswith(UNFINISHED)
        beside.write_bytes(b"new")
    assert {file.name for file in tmp_path.iterdir()} == {"file.txt", *names[1:]}


def history() -> planar.History:
    belief = planar.MapBelief.start(np.zeros(3), np.eye(3) * 1e-4)
    step = planar.Step(planar.Odometry(np.array([0.1, 0, 0]), np.eye(3) * 1e-4), time=1.0)
    return planar.run_filter(belief, [step], planar.Settings(planar.CartesianSensor(np.eye(2))))


def save_result(file: Path) -> None:
    storage.save(file, stored(np.random.default_rng(5)))


WRITERS: dict[str, tuple[Callable, str]] = {
    "stored result": (save_result, "studies.stored.storage._bytes"),
    "kept result": (lambda f: results._write(f, 1), "studies.stored.storage._bytes"),
    "ledger": (lambda f: Ledger(()).write(f), "pathlib.Path.write_text"),
    "trajectory": (lambda f: history().to_csv(f, overwrite=True), "numpy.savetxt"),
    "trajectory for tools": (lambda f: history().to_tum(f, overwrite=True), "numpy.savetxt"),
    "registry": (lambda f: entries._append(f, ["a"]), "pathlib.Path.write_text"),
}


@pytest.mark.parametrize("kind", WRITERS)
def test_every_writer_leaves_the_old_file_when_it_is_interrupted(kind, tmp_path, monkeypatch):
    write, inside = WRITERS[kind]
    file = tmp_path / "file"
    file.write_text("old")

    def half(path: Any, *args: Any, **options: Any) -> None:
        if isinstance(path, Path):
            with path.open("w") as stream:
                stream.write("half")
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(inside, half)
        with pytest.raises(KeyboardInterrupt):
            write(file)
    assert file.read_text() == "old"
    assert list(tmp_path.iterdir()) == [file]


def test_a_summary_that_is_interrupted_stays_the_old_one(tmp_path, monkeypatch):
    monkeypatch.setattr(recordings, "records", lambda: tmp_path)
    recording = recordings.Recording("mine", lambda folder: None, Stored, "mine-store")
    monkeypatch.setattr(recordings.Recording, "_code", lambda self: "code")
    monkeypatch.setattr(recordings.Recording, "_data", lambda self: "data")
    recording._describe("2001-02-03", {"a": "1"})
    with monkeypatch.context() as patch:
        patch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(KeyboardInterrupt))
        with pytest.raises(KeyboardInterrupt):
            recording._describe("2002-02-03", {"a": "2"})
    assert json.loads((tmp_path / "mine-store.json").read_text())["date"] == "2001-02-03"
