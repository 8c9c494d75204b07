"""A gallery of pictures, by a detector that is told where the faces are."""

import numpy as np
import pytest

from robot_perception.companion.boxes import crop
from robot_perception.companion.faces.detection import FaceDetector
from robot_perception.companion.faces.eigenfaces import enrol
from robot_perception.companion.faces.gallery import Gallery

BOX = np.array([10.0, 6, 46, 56])
SMALL = np.array([60.0, 6, 20, 20])


@pytest.fixture(autouse=True)
def found(monkeypatch):
    """In a picture that begins black there is no face; else two, the largest first."""

    def find(self, image, window=None, sides=None):
        return np.stack([BOX, SMALL])[: 2 * bool(image[0, 0])]

    monkeypatch.setattr(FaceDetector, "find", find)


def pictures(seed, count):
    rng = np.random.default_rng(seed)
    return list(rng.integers(1, 200, (count, 80, 90), dtype=np.uint8))


@pytest.mark.parametrize("equalise", [False, True])
def test_the_gallery_is_that_of_the_largest_faces(equalise):
    people = {"ann": pictures(1, 4), "Lee, Kim": pictures(2, 3)}
    dark = np.zeros((80, 90), np.uint8)
    asked = {name: iter([*some, dark]) for name, some in people.items()}
    gallery = Gallery.learn(asked, FaceDetector(), 3, accepted=0.9, equalise=equalise)
    assert gallery.faceless == 2
    names = ["ann"] * 4 + ["Lee, Kim"] * 3
    faces = [crop(one, BOX, equalise=equalise) for some in people.values() for one in some]
    expected = enrol(np.array(faces), names, 3, accepted=0.9)
    np.testing.assert_array_equal(gallery.known.descriptors, expected.descriptors)
    assert gallery.known.most_distance == expected.most_distance
    assert gallery.known.names == tuple(names)
    same = gallery.recognise(people["ann"][2], BOX)
    assert (same.name, same.distance) == ("ann", pytest.approx(0, abs=1e-9))


@pytest.mark.parametrize("count", [2, 3])
def test_one_person_with_two_pictures_is_a_gallery(count):
    some = pictures(3, count)
    gallery = Gallery.learn({"ann": some}, FaceDetector())
    assert all(gallery.recognise(one, BOX).name == "ann" for one in some)
    assert gallery.recognise(255 - some[0], BOX).name is None


def test_who_has_too_few_faces_is_named():
    with pytest.raises(ValueError, match="got 1 of 3 of 'bob'"):
        Gallery.learn(
            {"ann": pictures(1, 2), "bob": [*pictures(2, 1), *np.zeros((2, 80, 90), np.uint8)]},
            FaceDetector(),
        )
    with pytest.raises(ValueError, match="people must be one at least, got nobody"):
        Gallery.learn({}, FaceDetector())
