"""A chapter reads a recording where it is, else its stored result, and says which."""

import json
from dataclasses import dataclass

import numpy as np
import pytest
from jaxtyping import Float

from robot_perception import datasets
from robot_perception.teaching import recordings
from robot_perception.teaching.recordings import Recording


@dataclass(frozen=True, eq=False)
class Found:
    walls: Float[np.ndarray, "n 2"]
    count: int
    folder: str


@dataclass(frozen=True, eq=False)
class More:
    walls: Float[np.ndarray, "n 2"]
    doors: int


@pytest.fixture
def recording(tmp_path, monkeypatch):
    monkeypatch.setattr(recordings, "records", lambda: tmp_path)
    monkeypatch.setattr(datasets, "path", lambda name: tmp_path / name)
    monkeypatch.setattr(datasets, "find", lambda name: None)
    return Recording(
        "carmen_fr079",
        lambda folder: Found(np.array([[0.123456789, 2.0]]), 2, folder.name),
        Found,
        "test-store",
    )


def test_present_recording_is_computed(recording, tmp_path, monkeypatch):
    monkeypatch.setattr(datasets, "find", lambda name: tmp_path / name)
    read = recording.read()
    assert read.live
    assert read.result.folder == "carmen_fr079"
    assert "Computed" in read.note


def test_absent_recording_shows_the_stored_result_and_says_how_to_get_it(recording):
    summary = json.loads(recording.write().with_suffix(".json").read_text())
    assert summary["dataset"] == "carmen_fr079"
    assert summary["result"]["count"] == "2"
    read = recording.read()
    assert not read.live
    assert "datasets info carmen_fr079" in read.note
    assert isinstance(read.result, Found)
    np.testing.assert_array_equal(read.result.walls, [[0.123456789, 2.0]])
    assert read.result.count == 2


def test_non_finite_results_are_not_stored(recording, tmp_path):
    broken = Recording(
        "carmen_fr079", lambda folder: Found(np.array([[np.nan, 0]]), 1, ""), Found, "broken"
    )
    with pytest.raises(ValueError, match="walls must be finite, got 1 of 2"):
        broken.write()
    assert not (tmp_path / "broken.npz").exists()


def test_a_stored_result_of_another_type_names_the_command_that_mends_it(recording):
    recording.write()
    other = Recording("carmen_fr079", recording.compute, More, "test-store")
    with pytest.raises(ValueError, match=r"no More \(doors is missing\).*store --only test-store"):
        other.stored()
