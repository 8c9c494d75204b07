"""A chapter reads a recording where it is, else its stored result, and says which."""

import json

import numpy as np
import pytest

from robot_perception import datasets
from robot_perception.teaching import recordings
from robot_perception.teaching.recordings import Recording


@pytest.fixture
def recording(tmp_path, monkeypatch):
    monkeypatch.setattr(recordings, "records", lambda: tmp_path)
    return Recording(
        "carmen_fr079",
        lambda folder: {"walls": np.array([[0.123456, 2.0]]), "count": 2, "name": folder.name},
        "test-store",
    )


def test_present_recording_is_computed(recording, tmp_path, monkeypatch):
    monkeypatch.setattr(datasets, "find", lambda name: tmp_path / name)
    read = recording.read()
    assert read.live
    assert read.result["name"] == "carmen_fr079"
    assert "Computed" in read.note


def test_absent_recording_shows_the_stored_result_and_says_how_to_get_it(
    recording, tmp_path, monkeypatch
):
    monkeypatch.setattr(datasets, "path", lambda name: tmp_path / name)
    monkeypatch.setattr(datasets, "find", lambda name: None)
    file = recording.write()
    assert json.loads(file.read_text())["dataset"] == "carmen_fr079"
    read = recording.read()
    assert not read.live
    assert "datasets info carmen_fr079" in read.note
    np.testing.assert_array_equal(read.result["walls"], [[0.1235, 2.0]])
    assert read.result["count"] == 2


def test_non_finite_results_are_not_stored(recording, tmp_path, monkeypatch):
    monkeypatch.setattr(datasets, "path", lambda name: tmp_path / name)
    broken = Recording("carmen_fr079", lambda folder: {"x": np.array([np.nan])}, "broken")
    with pytest.raises(ValueError, match="JSON"):
        broken.write()
    assert not (tmp_path / "broken.json").exists()
