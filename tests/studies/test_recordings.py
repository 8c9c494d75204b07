"""A chapter shows the stored result while code and recording are the same, and says which it is."""

import hashlib
import json
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from importlib.metadata import version

import numpy as np
import pytest
from jaxtyping import Float

from robot_perception import datasets
from studies.files import DamagedFile
from studies.keys import versions
from studies.keys.versions import here
from studies.stored import recordings, storage
from studies.stored.recordings import Read, Recording


@dataclass(frozen=True, eq=False)
class Found:
    walls: Float[np.ndarray, "n 2"]
    count: int
    folder: str


@dataclass(frozen=True, eq=False)
class More:
    walls: Float[np.ndarray, "n 2"]
    doors: int


@dataclass(frozen=True, eq=False)
class Timed:
    count: int
    seconds: Float[np.ndarray, " n"] = field(metadata={"timed": True})


def find(folder):
    """Do what a chapter does."""
    return Found(np.array([[0.123456789, 2.0]]), len(list(folder.iterdir())), folder.name)


SCANS = b"scan 1 2 3"
OURS = f"scans.log {hashlib.sha256(SCANS).hexdigest()}\n"


def of_modules(*asked: str) -> str:
    """Stand for the digest of what is asked for, of whole modules."""
    return f"of {sorted({one.partition(':')[0] for one in asked})}"


@pytest.fixture
def recording(tmp_path, monkeypatch):
    """A recording of one file; it is known, but not on this computer."""
    (tmp_path / "data").mkdir()
    (tmp_path / "registry.txt").write_text(f"attic/{OURS}")
    (tmp_path / "sets.toml").write_text(
        '[attic]\ntitle = "t"\nlicence = "l"\norigin = "o"\nbytes = 10\n'
    )
    monkeypatch.setenv("ROBOT_PERCEPTION_DATA", str(tmp_path))
    monkeypatch.setenv("ROBOT_PERCEPTION_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(recordings, "records", lambda: tmp_path / "data")
    monkeypatch.setattr(recordings, "code_digest", of_modules)
    return Recording("attic", find, Found, "test-store")


@pytest.fixture
def recorded(recording, tmp_path):
    """The same with the file there, and a result stored by another day."""
    (tmp_path / "attic").mkdir()
    (tmp_path / "attic/scans.log").write_bytes(SCANS)
    summary = recording.write().with_suffix(".json")
    text = summary.read_text()
    summary.write_text(text.replace(json.loads(text)["date"], "2025-06-01"))
    return recording


def test_a_recording_without_a_stored_result_is_computed(recorded, tmp_path):
    read = Recording("attic", find, Found, "nobodys").read()
    assert read.live
    assert read.result.folder == "attic"
    assert "Computed" in read.note


def test_the_stored_result_is_shown_while_code_and_recording_are_the_same(recorded):
    other = Recording("attic", partial(fail), Found, "test-store")
    assert recorded.is_current()
    assert other.is_current()  # by the digest that stands for all code here
    read = other.read()
    assert not read.live
    assert (read.result.folder, read.result.count) == ("attic", 1)
    assert read.note == "Computed from the recording `attic` on 2025-06-01, by this code."


def fail(folder):
    raise AssertionError("computed, although it is stored")


def changed_code(root, monkeypatch):
    monkeypatch.setattr(recordings, "code_digest", lambda *modules: "of other code")


def changed_file(root, monkeypatch):
    (root / "attic/scans.log").write_bytes(SCANS + b" 4")


def changed_registry(root, monkeypatch):
    (root / "attic/scans.log").write_bytes(b"other")
    ours = (root / "registry.txt").read_text()
    theirs = hashlib.sha256(b"other").hexdigest()
    (root / "registry.txt").write_text(ours.replace(hashlib.sha256(SCANS).hexdigest(), theirs))


def no_keys(root, monkeypatch):
    summary = root / "data/test-store.json"
    stored = json.loads(summary.read_text())
    summary.write_text(json.dumps({k: v for k, v in stored.items() if k not in ("code", "data")}))


def replaced_numbers(root, monkeypatch):
    other = Found(np.array([[9.0, 2.0]]), 1, "attic")
    storage.save(root / "data/test-store.npz", other)


def code_of_a_notebook(root, monkeypatch):
    def unknown(*modules):
        raise ValueError("no module '__main__'")

    monkeypatch.setattr(recordings, "code_digest", unknown)


CHANGES = [changed_code, changed_file, changed_registry, no_keys, replaced_numbers]
CHANGES += [code_of_a_notebook]
OTHER_CODE = "what is stored was computed by other code"
OTHER_FILES = "what is stored was computed from other files"
WHY = {
    changed_code: OTHER_CODE,
    code_of_a_notebook: OTHER_CODE,
    no_keys: OTHER_CODE,
    changed_file: OTHER_FILES,
    changed_registry: OTHER_FILES,
    replaced_numbers: "test-store.npz is not what was stored",
}


@pytest.mark.parametrize("change", CHANGES)
def test_it_is_computed_anew_after(
    change: Callable[..., None], recorded: Recording, tmp_path, monkeypatch: pytest.MonkeyPatch
):
    change(tmp_path, monkeypatch)
    assert not recorded.is_current()
    read = recorded.read()
    assert read.live
    assert read.note.startswith("Computed on this machine from the recording `attic`: ")
    assert read.note.endswith(f"{WHY[change]}.")
    if change is not changed_file and change is not code_of_a_notebook:
        recorded.write()
        assert recorded.is_current()


def test_the_code_is_that_of_function_and_result(recorded, monkeypatch):
    asked = []
    monkeypatch.setattr(recordings, "code_digest", lambda *modules: asked.append(modules) or "x")
    Recording("attic", partial(partial(find), folder=1), Read, "test-store").is_current()
    assert set(asked[0]) == {f"{__name__}:find", "studies.stored.recordings:Read"}


CELLS = (
    """from dataclasses import dataclass
from functools import partial
import numpy as np
from studies.stored.recordings import Recording
""",
    """@dataclass(frozen=True, eq=False)
class Counted:
    counts: np.ndarray
""",
    """LEAST = 2


def count(folder, pattern, least=LEAST):
    return Counted(np.array([max(len(list(folder.glob(pattern))), least)]))


def logs(pattern):
    return Recording("attic", partial(count, pattern=pattern), Counted, "test-store")


LOGS = logs("*.log")
""",
)
EDITS = (("counts", "numbers"), ("LEAST = 2", "LEAST = 3"), ("*.log", "*.txt"), ("max(", "min("))


def edited(old: str, new: str) -> list[str]:
    """Return the cells with a text replaced."""
    assert any(old in text for text in CELLS)
    return [text.replace(old, new) for text in CELLS]


@pytest.fixture
def in_cells(recorded, book):
    """The same recording, computed by study cells, and what is stored of it."""
    made = book.made(*CELLS)
    made.LOGS.write()
    return made


def test_what_study_cells_compute_of_a_recording_is_stored(in_cells, book):
    read = in_cells.LOGS.read()
    assert not read.live
    assert read.result.counts.tolist() == [2]
    assert isinstance(read.result, in_cells.Counted)
    moved = book.made(*CELLS[:2], "MORE = 1", CELLS[2] + "def other():\n    return MORE\n")
    assert moved.LOGS.is_current()


@pytest.mark.parametrize(("old", "new"), EDITS)
def test_it_is_computed_anew_by_other_study_cells(in_cells, book, old, new):
    """Function, result, what they reach, and what the function is given."""
    other = book.made(*edited(old, new))
    assert not other.LOGS.is_current()
    assert other.LOGS.read().live


@pytest.mark.parametrize(("old", "new"), EDITS)
def test_a_reader_who_edits_a_study_cell_sees_what_it_computes(in_cells, live, old, new):
    assert not live(*CELLS).LOGS.read().live
    read = live(*edited(old, new)).LOGS.read()
    assert read.live
    assert "Computed on this machine" in read.note


@pytest.mark.parametrize("module", ["robot_perception.book.walls", "__main__"])
def test_the_code_of_study_cells_is_what_function_and_result_reach(recorded, monkeypatch, module):
    def of_cells(folder):
        return find(folder)

    of_cells.__module__ = module
    code = {"of_cells": "reaches these cells", "Found": "has these fields"}
    monkeypatch.setattr(recordings, "code_of", lambda one: code[one.__name__])
    monkeypatch.setattr(recordings, "code_digest", lambda *modules: pytest.fail("no module of it"))
    cells = Recording("attic", partial(of_cells), Found, "test-store")
    cells.write()
    assert cells.is_current()
    for name in code:
        for edited in ("edited", None):
            with monkeypatch.context() as now:
                now.setitem(code, name, edited)
                assert not cells.is_current()
    assert cells.is_current()


def test_of_measured_times_only_the_shape_must_be_the_same(recorded):
    def timed(*seconds, count=3):
        result = Timed(count, np.array(seconds))
        return Recording("attic", lambda folder: result, Timed, "test-times")

    timed(0.1, 0.2).write()
    assert timed(0.3, 0.4).renew()
    assert not timed(0.1, 0.2, 0.3).renew()
    assert not timed(0.1, 0.2, count=4).renew()
    np.testing.assert_array_equal(timed(0.3, 0.4).stored().result.seconds, [0.1, 0.2])


def test_keys_are_renewed_only_if_the_result_is_the_same(recorded, tmp_path, monkeypatch):
    before = (tmp_path / "data/test-store.npz").read_bytes()
    changed_code(tmp_path, monkeypatch)
    nearly = find(tmp_path / "attic")
    nearly.walls[0, 0] += 1e-12
    assert Recording("attic", lambda folder: nearly, Found, "test-store").renew()
    assert recorded.is_current()
    assert (tmp_path / "data/test-store.npz").read_bytes() == before
    assert "2025-06-01" in recorded.read().note
    summary = (tmp_path / "data/test-store.json").read_text()
    changed_file(tmp_path, monkeypatch)
    for other in (
        Found(nearly.walls + 1e-6, 1, "attic"),
        Found(nearly.walls, 2, "attic"),
        Found(nearly.walls, 1, "cellar"),
        Found(np.vstack([nearly.walls] * 2), 1, "attic"),
        More(nearly.walls, 1),
    ):
        assert not Recording("attic", lambda _, other=other: other, Found, "test-store").renew()
    assert (tmp_path / "data/test-store.json").read_text() == summary
    assert not Recording("attic", find, Found, "nobodys").renew()


def test_absent_recording_shows_the_stored_result_and_says_how_to_get_it(recorded, tmp_path):
    (tmp_path / "attic/scans.log").unlink()
    read = recorded.read()
    assert not read.live
    assert "The recording `attic` is not on this machine" in read.note
    assert "stored result of 2025-06-01" in read.note
    assert "datasets info attic" in read.note
    assert isinstance(read.result, Found)
    np.testing.assert_array_equal(read.result.walls, [[0.123456789, 2.0]])
    summary = json.loads((tmp_path / "data/test-store.json").read_text())
    assert summary["dataset"] == "attic"
    assert summary["result"]["count"] == "1"
    with pytest.raises(datasets.DatasetMissing):
        recorded.renew()


def test_numbers_that_nobody_stored_are_refused_where_the_recording_is_absent(
    recorded, tmp_path, monkeypatch
):
    (tmp_path / "attic/scans.log").unlink()
    assert recorded.read().result.count == 1
    replaced_numbers(tmp_path, monkeypatch)
    for show in (recorded.read, recorded.stored):
        with pytest.raises(DamagedFile, match=r"not what was stored, .*git checkout.*test-store"):
            show()
    assert not recorded.is_what_was_stored()


def test_a_result_of_other_packages_is_shown_and_says_so(recorded, tmp_path, monkeypatch):
    assert json.loads((tmp_path / "data/test-store.json").read_text())["versions"] == here()
    monkeypatch.setattr(versions, "installed", lambda: {"numpy": "9.9", "scipy": "9.8"})
    numpy, scipy = (version(name) for name in ("numpy", "scipy"))
    others = f"numpy {numpy} (here 9.9), scipy {scipy} (here 9.8)"
    assert recorded.other_packages() == others
    assert recorded.is_current()
    assert recorded.read().note.endswith(f"by this code with {others}.")
    assert recorded.renew()
    assert recorded.other_packages() == ""


def test_non_finite_results_are_not_stored(recorded, tmp_path):
    broken = Recording(
        "attic", lambda folder: Found(np.array([[np.nan, 0]]), 1, ""), Found, "broken"
    )
    with pytest.raises(ValueError, match="walls must be finite, got 1 of 2"):
        broken.write()
    assert not (tmp_path / "data/broken.npz").exists()


def test_a_stored_result_of_another_type_names_the_command_that_mends_it(recorded):
    other = Recording("attic", find, More, "test-store")
    with pytest.raises(ValueError, match=r"no More \(doors is missing\).*store --only test-store"):
        other.stored()
