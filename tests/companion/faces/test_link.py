"""Who keeps the link, case by case."""

import numpy as np
import pytest

from robot_perception.companion.faces.eigenfaces import enrol
from robot_perception.companion.faces.link import (
    Link,
    LinkRules,
    SeenFace,
    keep_link,
    same_descriptor,
)


def face(name, u=100.0, side=40.0):
    return SeenFace(np.array([u - side / 2, 80.0, side, side]), name)


def run(pictures, **rules):
    """Return who is held in each picture, by place, and the links."""
    link, held = None, []
    for faces in pictures:
        link, info = keep_link(link, faces, LinkRules(**rules))
        held.append(None if info.held is None else float(faces[info.held].box[0]) + 20)
    return held, link


def test_a_stranger_begins_nothing_and_the_largest_tutor_begins_it():
    assert keep_link(None, [face(None, side=90.0)])[0] is None
    faces = [face(None, 60, 90.0), face("ann", 160, 40.0), face("bob", 240, 50.0)]
    link, info = keep_link(None, faces)
    assert (link.name, info.held, info.began) == ("bob", 2, True)


def test_the_verified_link_does_not_go_over_to_who_comes_near():
    pictures = [[face("ann")], [face("ann", 110), face("bob", 104)], [face("bob", 112)]]
    assert run(pictures)[0] == [100, 110, None]
    assert run(pictures, policy="nearest")[0] == [100, 104, 112]
    stranger = [[face("ann")], [face(None, 102)]]
    assert run(stranger)[0] == [100, None]
    assert run(stranger, policy="nearest")[0] == [100, 102]


def test_the_largest_of_any_tutor_commutes():
    pictures = [[face("ann", 60), face("bob", 200, 40.0 + grow)] for grow in (-4.0, 4.0, -4.0, 4.0)]
    assert run(pictures, policy="largest")[0] == [60, 198, 60, 198]
    assert set(run(pictures)[0]) == {60.0}


def test_a_link_waits_and_then_another_tutor_may_begin_one():
    away = [[face("bob", 220)]] * 4
    held, link = run([[face("ann")], *away], patience=3)
    assert held == [100, None, None, None, None]
    assert link is None
    link, info = keep_link(Link("ann", face("ann"), 3), away[0], LinkRules(patience=3))
    assert (link, info.ended) == (None, True)
    held, link = run([[face("ann")], *away, [face("bob", 220)]], patience=3)
    assert (held[-1], link.name) == (220, "bob")


def test_a_face_may_have_moved_further_the_longer_it_was_missed():
    far = [face("ann", 100 + 90)]
    link = Link("ann", face("ann"))
    assert keep_link(link, far)[1].held is None
    assert keep_link(Link("ann", face("ann"), 2), far)[1].held == 0
    assert keep_link(link, far, LinkRules(reach=3.0))[1].held == 0


def test_the_nearer_of_two_faces_of_that_name_is_taken():
    faces = [face("ann", 130), face("ann", 104)]
    assert keep_link(Link("ann", face("ann")), faces)[1].held == 1


def test_the_user_may_verify_by_something_else():
    def by_descriptor(link, other):
        return bool(np.linalg.norm(link.face.descriptor - other.descriptor) < 1)

    start = SeenFace(face("ann").box, "ann", np.zeros(2))
    close = SeenFace(face(None).box, None, np.array([0.5, 0.0]))
    apart = SeenFace(face("ann").box, "ann", np.array([2.0, 0.0]))
    link, info = keep_link(Link("ann", start), [apart, close], verify=by_descriptor)
    assert info.held == 1
    assert link.face is close
    assert link.name == "ann"


@pytest.fixture(scope="module")
def gallery():
    """Twenty pictures of two people, who differ from each other more than from themselves."""
    rng = np.random.default_rng(3)
    people = rng.uniform(size=(2, 1, 12, 10))
    faces = people + 0.1 * rng.standard_normal((2, 10, 12, 10))
    return enrol(faces.reshape(20, 12, 10), ["ann"] * 10 + ["bob"] * 10, 10), people[:, 0]


def test_a_descriptor_is_verified_against_those_of_the_tutor_who_began(gallery):
    known, (ann, bob) = gallery
    verify, link = same_descriptor(known), Link("ann", face("ann"))

    def described(picture, name=None):
        return SeenFace(face(None).box, name, known.describe(picture))

    assert verify(link, described(ann))
    assert not verify(link, described(bob, "ann"))  # whatever name it was given
    assert verify(Link("bob", face("bob")), described(bob))
    far = ann + 5 * (ann - bob)
    assert not verify(link, described(far))  # nearest to ann of all, and still too far
    mine = known.distances(known.describe(far))
    assert mine[:10].min() < mine[10:].min()


def test_a_face_without_a_descriptor_is_nobodys_and_a_link_is_with_somebody_known(gallery):
    verify = same_descriptor(gallery[0])
    assert not verify(Link("ann", face("ann")), face("ann"))
    with pytest.raises(ValueError, match="link must be of somebody in the gallery, got 'eve'"):
        verify(Link("eve", face("eve")), face("eve"))


def test_missed_pictures_are_counted_until_the_face_is_seen():
    link = Link("ann", face("ann"))
    for k in range(3):
        link, _ = keep_link(link, [])
        assert link.missed == k + 1
    assert keep_link(link, [face("ann")])[0].missed == 0


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (lambda: LinkRules("loudest"), "policy must be"),
        (lambda: LinkRules(patience=-1), "patience must be"),
        (lambda: LinkRules(reach=0.0), "reach must be"),
        (lambda: SeenFace(np.zeros(4), "ann"), "box must have"),
        (lambda: Link("ann", face("ann"), -1), "missed must be"),
    ],
)
def test_what_is_wrong_is_named(wrong, text):
    with pytest.raises(ValueError, match=text):
        wrong()


def test_a_verification_that_gives_no_truth_is_named():
    with pytest.raises(TypeError, match="verify"):
        keep_link(Link("ann", face("ann")), [face("ann")], verify=lambda link, other: 1)


def test_a_face_that_grows_about_its_middle_stays_where_it_is():
    pictures = [[face("ann", side=40.0)], [SeenFace(np.array([70.0, 70.0, 60.0, 60.0]), "ann")]]
    for policy in ("verified", "nearest"):
        assert run(pictures, policy=policy, reach=0.05)[1].face.box[2] == 60
