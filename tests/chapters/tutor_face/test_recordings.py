"""What is computed from real faces, and what the page says of it."""

import numpy as np
import pytest

from robot_perception.chapters.tutor_face import recordings
from studies.files import DamagedFile


def test_forty_eigenimages_recognise_what_is_known_of_the_recording():
    """The figure that is known of it: 95 of 100, first five pictures against last five."""
    stored = recordings.ORL.read().result
    assert stored.asked.tolist() == [100, 75]
    assert stored.right[-1] == 95
    assert (np.diff(stored.right) > 0).all()
    assert (np.diff(stored.strangers) < 0).all()
    assert stored.strangers[-1] > 0


def test_every_face_of_the_other_recording_is_found():
    stored = recordings.YALE.read().result
    assert stored.pictures.sum() == stored.found.sum() == 87
    rows = stored.table().rows
    assert sum(row[0] for row in rows.values()) == 87


def test_of_faces_that_do_not_vary_within_a_person_all_are_right_and_strangers_are_far():
    rng = np.random.default_rng(0)
    person = rng.uniform(size=(20, 1, 6, 5))
    faces = person + 0.001 * rng.standard_normal((20, 10, 6, 5))
    names = np.repeat([[f"{k}"] for k in range(20)], 10, axis=1)
    right, known, strangers = recordings._asked(faces, names, 15, 14)
    assert right == 75
    assert known > 60
    assert strangers == 0


def test_most_faces_of_the_photographs_are_found_and_nothing_else():
    stored = recordings.CROWD.read().result
    assert stored.faces.sum() == 18
    assert 12 <= stored.found.sum() <= 15
    assert stored.false.sum() == 0
    assert stored.table()["all", "faces"] == 18


def test_a_damaged_file_of_marks_is_named(tmp_path):
    file = tmp_path / "marks.xml"
    for text in ("<dataset><image", "<d><image file='a.jpg'><box top='x'/></image></d>"):
        file.write_text(text)
        with pytest.raises(DamagedFile, match=r"marks\.xml"):
            recordings.marked(file)
    file.write_text("<d><image file='a.jpg'/></d>")
    assert recordings.marked(file)["a.jpg"].shape == (0, 4)
