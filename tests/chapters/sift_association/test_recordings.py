"""Pairs and drives that are written here, of which every match is known; and what is stored."""

import cv2
import numpy as np
import pytest

from data_synth import stereo
from data_synth.stereo import Rig
from data_synth.textured_building import drive, make_textured_building
from robot_perception.chapters.sift_association import recordings
from robot_perception.chapters.sift_association.recordings import FAR, RIGHT_PX, Pair, choose
from robot_perception.datasets import CorruptImage, DatasetMissing
from robot_perception.geometry import se3
from tests.datasets.writing import row, save, write
from tests.landmarks.worlds import descriptors, texture
from tests.unchecked import unchecked

RNG = np.random.default_rng
ANY = 1e4
STORED = (recordings.ALOE, recordings.GRAF, recordings.STRAIGHT, recordings.TURN)


def hand_made(count=40, seed=0) -> Pair:
    """Features, some of whose partners look different, lie on another row or are not known."""
    rng = RNG(seed)
    pixels, looks = rng.uniform(10, 200, (count, 2)), descriptors(count, rng)
    truth = pixels - [20.0, 0.0]
    others = truth + rng.normal(0, 1.2, (count, 2))
    noise = rng.normal(0, rng.uniform(2, 30, (count, 1)), (count, 128))
    truth[::5] = FAR
    return Pair(
        texture(1),
        pixels,
        others,
        looks.astype(np.uint8),
        np.clip(looks + noise, 0, 255).astype(np.uint8),
        truth,
    )


@pytest.mark.parametrize("ratio", [1.0, 0.8])
@pytest.mark.parametrize("threshold", [150.0, ANY])
@pytest.mark.parametrize("rows", [1.0, 10.0, ANY])
def test_features_are_chosen_as_by_hand(rows, threshold, ratio):
    pair = hand_made()
    found = choose(pair, rows, threshold, ratio)
    for k, look in enumerate(pair.descriptors.astype(float)):
        apart = np.linalg.norm(pair.other_descriptors - look, axis=1)
        apart[np.abs(pair.others[:, 1] - pair.pixels[k, 1]) > rows] = np.inf
        first, second = np.sort(apart)[:2]
        good = first <= threshold and pair.truth[k, 0] != FAR
        if ratio < 1:
            good = good and first <= ratio * second
        assert found.others[k] == (apart.argmin() if good else -1)
        gap = np.linalg.norm(pair.others[apart.argmin()] - pair.truth[k])
        assert found.right[k] == (good and gap <= RIGHT_PX)
    assert 0 < found.right.sum() < len(pair.pixels)
    assert found.share == found.right.sum() / (found.others >= 0).sum()


def test_nothing_chosen_is_nothing_wrong():
    found = choose(hand_made(), 1.0, 1e-6, 1.0)
    assert (found.others == -1).all()
    assert not found.right.any()
    assert found.share == 1.0


def test_features_that_are_known_and_those_with_a_partner():
    pair = hand_made()
    assert (pair.known == (np.arange(40) % 5 > 0)).all()
    gaps = np.linalg.norm(pair.others[:, None] - pair.truth, axis=-1).min(axis=0)
    assert (pair.there == (pair.known & (gaps <= RIGHT_PX))).all()
    assert 0 < pair.there.sum() < pair.known.sum()


# ---- pairs that are written here -----------------------------------------------------------------


def test_a_shifted_pair_is_matched_at_half_its_size(tmp_path):
    """All shifted by 12 px, of which the lower part is said to be unknown."""
    wide = texture(2, (600, 400))
    save(tmp_path / "aloeL.jpg", wide)
    save(tmp_path / "aloeR.jpg", np.roll(wide, -12, axis=1))
    shift = np.full(wide.shape, 12, np.uint8)
    shift[300:] = 0
    save(tmp_path / "aloeGT.png", shift)
    pair = recordings.aloe(tmp_path)
    assert pair.first.shape == (200, 300)
    assert (pair.known == (np.rint(2 * pair.pixels[:, 1] + 0.5) < 300)).all()
    assert pair.truth[pair.known] == pytest.approx(pair.pixels[pair.known] - [6.0, 0.0])
    found = choose(pair, 2.0, 200.0, 1.0)
    assert found.share > 0.9
    assert (found.others >= 0).sum() > 100


def test_a_turned_wall_is_matched_by_its_homography(tmp_path):
    first = texture(3, (400, 300))
    matrix = np.array([[0.95, -0.1, 30.0], [0.1, 0.95, -10.0], [1e-5, 0.0, 1.0]])
    save(tmp_path / "graf1.png", first)
    save(tmp_path / "graf3.png", cv2.warpPerspective(first, matrix, (400, 300)))
    numbers = " ".join(map(repr, matrix.ravel().tolist()))
    xml = (
        "<?xml version='1.0'?><opencv_storage><H13 type_id='opencv-matrix'><rows>3</rows>"
        f"<cols>3</cols><dt>d</dt><data>{numbers}</data></H13></opencv_storage>"
    )
    (tmp_path / "H1to3p.xml").write_text(xml)
    pair = recordings.graf(tmp_path)
    assert 0 < np.count_nonzero(~pair.known) < len(pair.known) / 2  # they leave the picture
    homogeneous = np.column_stack([pair.pixels, np.ones(len(pair.pixels))]) @ matrix.T
    expected = homogeneous[:, :2] / homogeneous[:, 2:]
    assert pair.truth[pair.known] == pytest.approx(expected[pair.known])
    assert choose(pair, ANY, 200.0, 0.8).share > 0.9


def write_drive(path, frames=7):
    """Write a drive through the rendered building as one of KITTI's."""
    rig, building = Rig(), make_textured_building(rng=RNG(1))
    poses = drive(building, rng=RNG(2), poses=1500)[:frames]
    taken = stereo.frames(building.scene, rig, poses, rng=RNG(3))
    for k, frame in enumerate(taken):
        save(path / "image_l" / f"{k:03}.png", frame.left)
        save(path / "image_r" / f"{k:03}.png", frame.right)
    (u, v), f = rig.centre_px, rig.focal_px
    left = np.array([[f, 0, u, 0], [0, f, v, 0], [0, 0, 1, 0]])
    right = left.copy()
    right[0, 3] = -f * rig.baseline
    cameras = [se3.compose(se3.from_se2(pose), rig.T_robot_camera) for pose in poses]
    write(path / "calib.txt", [row(left), row(right)])
    write(path / "poses.txt", [row(T[:3], b"%d " % k) for k, T in enumerate(cameras)])
    return path


def test_a_rendered_drive_is_assigned_by_the_poses_that_made_it(tmp_path):
    folder = write_drive(tmp_path)
    with unchecked():
        found = recordings.kitti(folder, tracked=(3,), gap=2)
    assert found.landmarks[0] > 100
    assert found.descriptors[0] > 50
    right = {name: float(found.right[name][0]) for name in recordings.MODELS}
    assert right["Euclid"] > 80
    assert right["pooled"] > 80
    assert right["raw"] < right["Euclid"]
    table = found.table()
    assert table["raw", "p = 3"] == right["raw"]
    assert "2 frames after the track" in table.about
    (folder / "image_r" / "004.png").unlink()
    with pytest.raises(CorruptImage, match=r"image_r: .*missing: 4"):
        recordings.kitti(folder)


def test_a_drive_too_short_for_its_tracks_tests_nothing(tmp_path):
    with unchecked():
        found = recordings.kitti(write_drive(tmp_path, 3), tracked=(3,), gap=3)
    assert (found.landmarks[0], found.descriptors[0]) == (0, 0)


# ---- absent and damaged recordings ---------------------------------------------------------------


@pytest.fixture
def nothing(monkeypatch, tmp_path):
    """A computer without recordings."""
    monkeypatch.setenv("ROBOT_PERCEPTION_DATA", str(tmp_path))
    monkeypatch.setenv("ROBOT_PERCEPTION_CACHE", str(tmp_path))


@pytest.mark.usefixtures("nothing")
@pytest.mark.parametrize("recording", STORED, ids=lambda r: r.store)
def test_without_the_recording_the_stored_result_is_shown_and_said_to_be(recording):
    read = recording.read()
    assert not read.live
    assert f"datasets info {recording.dataset}" in read.note
    assert isinstance(read.result, recording.result)
    with pytest.raises(DatasetMissing, match=recording.dataset):
        recording.write()


@pytest.mark.parametrize("recording", STORED[:2], ids=lambda r: r.store)
def test_stored_pairs_hold_features_in_their_pictures(recording):
    pair = recording.stored().result
    high, wide = pair.first.shape
    assert len(pair.pixels) == len(pair.descriptors) == len(pair.truth) >= recordings.MOST.most
    assert ((pair.pixels >= -1) & (pair.pixels <= [wide, high])).all()
    assert 0.2 < pair.there.sum() / pair.known.sum() <= 1
    assert choose(pair, ANY, 200.0, 0.8).share > choose(pair, ANY, 300.0, 1.0).share


@pytest.mark.parametrize("recording", STORED[2:], ids=lambda r: r.store)
def test_stored_shares_are_shares_of_what_was_tested(recording):
    found = recording.stored().result
    assert set(found.right) == set(recordings.MODELS)
    for shares in found.right.values():
        assert len(shares) == len(found.tracked) == len(found.descriptors)
        assert ((shares > 0) & (shares <= 100)).all()
    assert (found.descriptors > 100).all()
    rows = found.table().rows
    assert list(rows) == list(recordings.MODELS)


@pytest.mark.parametrize("name", ["aloeL.jpg", "aloeGT.png"])
def test_a_damaged_picture_of_a_pair_is_named(tmp_path, name):
    for file in ("aloeL.jpg", "aloeR.jpg", "aloeGT.png"):
        save(tmp_path / file, texture(2))
    whole = (tmp_path / name).read_bytes()
    (tmp_path / name).write_bytes(whole[: len(whole) // 2])
    with pytest.raises(CorruptImage, match=name):
        recordings.aloe(tmp_path)
