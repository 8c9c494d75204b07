"""The films of the chapter: what is drawn, and what stands where the recording is missing."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from robot_perception.book import head_tracking as heads
from robot_perception.chapters.head_tracking import films


@pytest.fixture
def drawn():
    """Three pictures, two ellipses and an overlap, drawn as frames of a film."""
    pictures = np.zeros((3, 60, 80, 3), dtype=np.uint8)
    rings = {"truth": np.array([[40.0, 30.0, 8.0, 10.0]] * 3)}
    rings["fixed model"] = rings["truth"] + [[0, 0, 0, 0], [5, 0, 0, 0], [10, 0, 0, 0]]
    shown = films.frames(pictures, rings, {"fixed model": np.array([1.0, 0.6, 0.2])}, 1, 3.0)
    found = [(fig, [line.get_xydata() for ax in fig.axes for line in ax.lines]) for fig in shown]
    yield found
    plt.close(found[0][0])


def test_a_frame_has_the_ellipses_of_its_picture_and_the_overlap_so_far(drawn):
    for k, (_, (truth, fixed, overlap)) in enumerate(drawn):
        np.testing.assert_allclose(truth.min(axis=0), [32, 20], atol=0.1)
        np.testing.assert_allclose(fixed - truth, np.tile([5.0 * k, 0.0], (len(truth), 1)))
        np.testing.assert_array_equal(overlap[:, 1], [1.0, 0.6, 0.2][: k + 1])


def test_the_film_shows_what_its_words_tell():
    """The fixed model loses the head after seven seconds; the adapted one stays with it."""
    seen = heads.light_film()
    fixed, adapted = (seen.overlaps[f"{name} model"] for name in ("fixed", "adapted"))
    assert (fixed[:90] > heads.OFF).all()
    assert (fixed[130:] < 0.05).all()
    assert (adapted < heads.OFF).mean() < 0.1


def test_without_the_recording_the_film_says_so(monkeypatch):
    monkeypatch.setattr(films.datasets, "find", lambda name: None)
    words = films.girl(heads.GIRL.dataset, heads.GIRL.stored().result)._repr_mimebundle_()[
        "text/plain"
    ]
    assert heads.GIRL.dataset in words
    assert "not on this machine" in words
