"""Face spaces against scikit-learn, and by laws."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.decomposition import PCA

from robot_perception.companion.faces.eigenfaces import Eigenfaces, enrol

RNG = np.random.default_rng(0)
PEOPLE = 6


def gallery(rng=None, each=4, people=PEOPLE, size=(9, 7), noise=0.1):
    """Return pictures and names: a pattern a person, with noise."""
    rng = np.random.default_rng(1) if rng is None else rng
    kinds = rng.uniform(0, 1, (people, *size))
    faces = kinds.repeat(each, axis=0) + noise * rng.standard_normal((people * each, *size))
    return faces, [f"p{k}" for k in range(people) for _ in range(each)], kinds


FACES, NAMES, KINDS = gallery()
MODEL = Eigenfaces.learn(FACES, NAMES, 10)


@pytest.mark.parametrize("count", [1, 5, 23])
def test_the_same_space_as_scikit_learn(count):
    ours = Eigenfaces.learn(FACES, NAMES, count)
    theirs = PCA(count, svd_solver="full").fit(FACES.reshape(24, -1))
    flat = ours.images.reshape(count, -1)
    signs = np.sign((flat * theirs.components_).sum(axis=1))
    np.testing.assert_allclose(flat, signs[:, None] * theirs.components_, atol=1e-9)
    np.testing.assert_allclose(ours.mean.ravel(), theirs.mean_)
    np.testing.assert_allclose(ours.deviations**2, theirs.explained_variance_)
    face = RNG.uniform(0, 1, (9, 7))
    expected = theirs.transform(face.reshape(1, -1))[0]
    np.testing.assert_allclose(ours.describe(face), signs * expected, atol=1e-9)
    again = theirs.inverse_transform(expected[None])[0].reshape(9, 7)
    np.testing.assert_allclose(ours.rebuild(face), again, atol=1e-9)


def test_descriptors_of_the_gallery_are_those_of_its_pictures():
    np.testing.assert_allclose([MODEL.describe(face) for face in FACES], MODEL.descriptors)


def test_eigenimages_are_orthonormal_and_all_of_them_rebuild_the_gallery():
    full = Eigenfaces.learn(FACES, NAMES, 23)
    flat = full.images.reshape(23, -1)
    np.testing.assert_allclose(flat @ flat.T, np.eye(23), atol=1e-9)
    for face in FACES:
        np.testing.assert_allclose(full.rebuild(face), face, atol=1e-9)
        assert full.recognise(face).from_space < 1e-7


@given(st.integers(0, 10**6))
@settings(max_examples=30, deadline=None)
def test_more_eigenimages_rebuild_no_worse(seed):
    face = np.random.default_rng(seed).uniform(0, 1, (9, 7))
    errors = [np.linalg.norm(face - MODEL.rebuild(face, k)) for k in range(11)]
    assert (np.diff(errors) <= 1e-12).all()
    np.testing.assert_allclose(MODEL.rebuild(face, 0), MODEL.mean)
    expected = errors[-1] / np.sqrt(face.size)
    assert MODEL.recognise(face).from_space == pytest.approx(expected)


def test_known_people_are_recognised_in_new_pictures():
    rng = np.random.default_rng(5)
    for k, kind in enumerate(KINDS):
        face = kind + 0.1 * rng.standard_normal(kind.shape)
        found = MODEL.recognise(face)
        assert (found.name, found.nearest) == (f"p{k}", f"p{k}")
        np.testing.assert_array_equal(found.descriptor, MODEL.describe(face))
        assert found.distance == MODEL.distances(found.descriptor).min()


def test_distances_are_in_the_deviations_of_each_direction_or_in_one():
    plain, white = MODEL, replace(MODEL, whiten=True)
    at = MODEL.descriptors[3] + 2.0 * MODEL.deviations
    assert white.distances(at)[3] == pytest.approx(2.0)
    root = np.sqrt((4 * MODEL.deviations**2).mean())
    assert plain.distances(at)[3] == pytest.approx(root)


def test_strangers_and_what_is_no_face_are_refused_by_the_two_thresholds():
    rng = np.random.default_rng(8)
    model = enrol(FACES, NAMES, 10)
    known = [model.recognise(k + 0.1 * rng.standard_normal(k.shape)).name for k in KINDS]
    assert known.count(None) <= 1
    strangers = [model.recognise(rng.uniform(0, 1, (9, 7))) for _ in range(20)]
    assert sum(found.name is None for found in strangers) >= 19
    inside = model.mean + (4 * model.deviations @ model.images.reshape(10, -1)).reshape(9, 7)
    far = model.recognise(inside)  # in face space, but far from everybody
    assert far.from_space < model.most_from_space
    assert far.name is None
    out = replace(model, most_distance=np.inf).recognise(KINDS[0] + rng.uniform(-2, 2, (9, 7)))
    assert out.name is None
    assert out.from_space > model.most_from_space


def test_thresholds_accept_the_share_that_is_asked_for():
    """Of pictures drawn as the gallery's: some 90 % by each threshold, here both together."""
    faces, names, kinds = gallery(each=8)
    model = enrol(faces, names, 10, accepted=0.9)
    rng = np.random.default_rng(2)
    found = [
        model.recognise(k + 0.1 * rng.standard_normal(k.shape)) for k in kinds for _ in range(60)
    ]
    for name in ("distance", "from_space"):
        share = np.mean([getattr(f, name) <= getattr(model, f"most_{name}") for f in found])
        assert 0.82 < share < 0.97
    loose = enrol(faces, names, 10, accepted=1.0)
    assert loose.most_distance > model.most_distance
    assert loose.most_from_space > model.most_from_space


def test_the_same_picture_twice_gives_no_direction_of_its_own():
    twice = np.concatenate([FACES[:3], FACES[:3]])
    assert len(Eigenfaces.learn(twice, ["a"] * 6, 5).images) == 2


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (lambda: Eigenfaces.learn(FACES[:1], ["a"]), "faces must be two at least, got 1"),
        (lambda: Eigenfaces.learn(FACES, NAMES[:3]), "names must be 24, as the faces, got 3"),
        (lambda: Eigenfaces.learn(FACES, NAMES, 24), "count must be"),
        (lambda: Eigenfaces.learn(FACES * np.nan, NAMES, 4), "faces must be finite"),
        (lambda: Eigenfaces.learn(FACES[:2] * 0, ["a", "b"], 1), "faces must differ"),
        (lambda: Eigenfaces.learn(FACES[[0] * 7] * 0.1, [*"aaabbbb"], 3), "faces must differ"),
        (
            lambda: Eigenfaces.learn(
                np.stack([FACES[0] / 255, FACES[0] * (1 / 255)]), ["a", "a"], 1
            ),
            "faces must differ",
        ),
        (lambda: enrol(FACES[[3] * 5] / 3, ["a"] * 5, 2), "faces must differ"),
        (lambda: MODEL.describe(np.zeros((9, 8))), "face must be"),
        (lambda: MODEL.rebuild(FACES[0], 11), "count must be"),
        (lambda: MODEL.distances(np.zeros(3)), "descriptor must be"),
        (lambda: enrol(FACES[:5], [*"aaabc"], 2), r"one only of \['b', 'c'\]"),
        (lambda: enrol(FACES, NAMES, 4, accepted=1.5), "accepted must be"),
        (lambda: enrol(FACES, NAMES, 4, folds=1), "folds must be"),
        (lambda: replace(MODEL, deviations=-MODEL.deviations), "deviations must be positive"),
        (lambda: replace(MODEL, most_distance=-1.0), "most_distance must not be negative"),
        (lambda: replace(MODEL, names=()), "names must be 24"),
    ],
)
def test_what_is_wrong_is_named(wrong, text):
    with pytest.raises(ValueError, match=text):
        wrong()


@pytest.mark.parametrize("scale", [1.0, 1e-12, 1e6])
@pytest.mark.parametrize("rows", [(0, 0, 1), (0, 0, 0, 1), (0, 1, 1), (0, 0, 1, 1), (0, 1, 0, 1)])
def test_a_gallery_may_hold_equal_pictures(rows, scale):
    """Each of them is known again, whichever picture the folds leave alone with its copies."""
    faces = FACES[list(rows)] * scale
    known = enrol(faces, ["ann"] * len(rows), len(rows) - 1, accepted=1.0)
    assert len(known.images) == 1
    assert [known.recognise(face).name for face in faces] == ["ann"] * len(rows)
    assert known.recognise(-20 * faces[0]).name is None


def test_who_has_copies_of_one_picture_only_is_known_by_that_picture():
    faces = FACES[[0, 0, 12, 12]] / 7
    known = enrol(faces, ["ann", "ann", "bob", "bob"], 3)
    assert [known.recognise(face).name for face in faces] == ["ann", "ann", "bob", "bob"]


def test_two_pictures_of_one_person_are_as_far_apart_as_a_third_may_be():
    """Half-way lies nobody nearer than the two, and twice as far away somebody unknown."""
    one, two = FACES[:2]
    known = enrol(FACES[:2], ["ann", "ann"], 1)
    assert known.most_distance == pytest.approx(np.linalg.norm(two - one))
    assert known.most_from_space == pytest.approx(np.sqrt(np.mean((two - one) ** 2)))
    assert known.recognise((one + two) / 2).name == "ann"
    assert known.recognise(two + 0.9 * (two - one)).name == "ann"
    assert known.recognise(two + 1.1 * (two - one)).name is None


def test_pictures_of_one_occasion_are_left_out_together():
    """Each person has two pictures of one occasion and two of another, in their order."""
    rng = np.random.default_rng(4)
    occasions = rng.uniform(0, 1, (6, 1, 9, 7))
    faces = (occasions + 1e-3 * rng.standard_normal((6, 2, 9, 7))).reshape(12, 9, 7)
    names = [name for name in "abc" for _ in range(4)]
    apart = np.sqrt(((occasions[::2] - occasions[1::2]) ** 2).mean(axis=(1, 2, 3))).min()
    known = enrol(faces, names, 5, accepted=0.5, folds=2)
    assert np.hypot(known.most_distance, known.most_from_space) > 0.3 * apart


@pytest.mark.parametrize("whiten", [True, False])
def test_thresholds_are_those_of_spaces_that_measure_as_the_gallery_does(whiten):
    """Each picture is left out alone, and its distances are computed by scikit-learn's space."""
    faces, names, _ = gallery(np.random.default_rng(5), each=3, people=4)
    whose, flat, nearest = np.array(names), faces.reshape(12, -1), []
    for fold in range(3):
        out = np.arange(12) % 3 == fold  # three pictures a person, three folds
        space = PCA(5, svd_solver="full", whiten=whiten).fit(flat[~out])
        learnt, asked = space.transform(flat[~out]), space.transform(flat[out])
        for one, name in zip(asked, whose[out], strict=True):
            same = learnt[whose[~out] == name]
            nearest.append(np.sqrt(((same - one) ** 2).mean(axis=1)).min())
    known = enrol(faces, names, 5, accepted=0.8, folds=3, whiten=whiten)
    assert known.most_distance == pytest.approx(np.quantile(nearest, 0.8))


def test_an_eigenimage_is_not_darker_than_its_negative():
    """Of both signs of a direction the one with a positive sum is taken, so that two runs agree."""
    sums = [
        Eigenfaces.learn(*gallery(np.random.default_rng(seed))[:2], 12).images.sum(axis=(1, 2))
        for seed in range(4)
    ]
    assert (np.concatenate(sums) >= 0).all()


def test_a_limit_is_learnt_from_pictures_of_the_same_person_and_no_twin():
    """Each picture has a near twin of the other person; of its own the nearest is far."""
    rng = np.random.default_rng(2)
    kinds = rng.uniform(0, 1, (6, 9, 7))
    twins = (kinds + 0.01 * rng.standard_normal(kinds.shape))[::-1]  # left out at other times
    faces = np.concatenate([kinds, twins])
    model = enrol(faces, ["ann"] * 6 + ["bob"] * 6, 5, folds=6)
    apart = np.array([model.distances(one)[:6] for one in model.descriptors[:6]])
    nearest = (apart + 1e9 * np.eye(6)).min()
    assert model.most_distance > 0.5 * nearest
    assert model.most_distance > 5 * model.distances(model.descriptors[0])[11]
