"""Two rooms that look alike: what is taken for what, and how the rooms are chosen."""

import numpy as np

from data_synth.stereo import Rig
from robot_perception.book import sift_association as page
from tests.chapters.sift_association.worlds import features, places
from tests.landmarks.worlds import descriptors
from tests.unchecked import unchecked

RNG = np.random.default_rng


def test_matches_are_near_and_far_nearer_than_the_second():
    looks = descriptors(4, RNG(0)).astype(float)
    looks[2] = looks[1]
    looks[2, 0] += 100.0
    near, twins = looks[0] + 1.0, (looks[1] + looks[2]) / 2
    far = looks[3].copy()
    far[:2] += 150.0
    here = features(np.zeros((3, 2)), descriptors=np.stack([near, twins, far]))
    there = features(np.zeros((4, 2)), descriptors=looks)
    rows, others = page.taken_for(here, there)
    assert (rows.tolist(), others.tolist()) == ([0], [0])


def test_alike_are_the_same_spot_of_one_print_far_away_of_like_size():
    one = places([[0, 0, 0]], prints=[[3, 0.5, 0.5]])

    def count(point, shown=(3, 0.5, 0.5), **other):
        return page.alike(one, places([point], prints=[shown], **other))

    assert count([5, 0, 0]) == 1
    assert count([0.9, 0, 0]) == 0
    assert count([5, 0, 0], (2, 0.5, 0.5)) == 0
    assert count([5, 0, 0], (3, 0.53, 0.53)) == 0
    assert count([5, 0, 0], sizes=0.015) == 0
    assert count([5, 0, 0], carriers=-1) == 0
    assert page.alike(one, places([])) == page.alike(places([]), one) == 0


def test_a_short_drive_has_its_pair():
    with unchecked():
        found = page.doors.__wrapped__(1, 12)
    rig = Rig()
    wide, high = rig.size
    assert found.image.shape == (high, 2 * wide + page.GAP)
    assert (found.image[:, wide : wide + page.GAP] == 255).all()
    assert found.metres > page.FAR_AWAY
    assert len(found.here) == len(found.there) == len(found.right) > 0
    assert (found.there[:, 0] < wide).all()
    assert (found.here[:, 0] >= wide + page.GAP - 1).all()
