"""Scans with marked legs: read back, what did not come back is infinite, damage named."""

import numpy as np
import pytest

from robot_perception.datasets import CorruptLog, Sector, read_leg_scans

PLAIN = {
    "stamp": np.array([3.0, 3.1, 3.2]),
    "ranges": np.array([[1.0, 0.0, 2.0], [np.nan, -np.inf, 8.5], [0.05, np.inf, 8.0]], np.float32),
    "angle_min": np.float64(-0.5),
    "angle_increment": np.float64(0.25),
    "range_min": np.float64(0.1),
    "range_max": np.float64(8.0),
}
MARKED = PLAIN | {
    "leg_scan": np.array([0, 2, 2], np.int32),
    "leg_xy": np.array([[1.0, 0.1], [2.0, -0.25], [2.5, 0.0]], np.float32),
    "label_sector_deg_m": np.array([-15, 30, 5], np.float32),
}


def written(folder, arrays):
    np.savez(folder / "legs.npz", **arrays)
    return folder / "legs.npz"


def test_every_number_is_read_back(tmp_path):
    scans = read_leg_scans(written(tmp_path, MARKED))
    assert len(scans) == 3
    np.testing.assert_array_equal(scans.times, MARKED["stamp"])
    inf = np.inf
    np.testing.assert_array_equal(scans.ranges, [[1, inf, 2], [inf, inf, inf], [inf, inf, 8]])
    np.testing.assert_array_equal(scans.angles, [-0.5, -0.25, 0])
    np.testing.assert_array_equal(scans.scans_of_legs, [0, 2, 2])
    np.testing.assert_array_equal(scans.legs, MARKED["leg_xy"])
    assert scans.sector == Sector(np.deg2rad(-15), np.deg2rad(30), 5.0)


def test_a_scanner_without_a_farthest_range_reads_all_that_is_a_distance(tmp_path):
    ranges = np.array([[1.0, np.inf, 3e38], [np.nan, 0.05, 90.0], [2.0, 0.0, -np.inf]])
    scans = read_leg_scans(written(tmp_path, PLAIN | {"range_max": np.inf, "ranges": ranges}))
    inf = np.inf
    np.testing.assert_array_equal(scans.ranges, [[1, inf, inf], [inf, inf, 90], [2, inf, inf]])


def test_a_full_turn_of_float32_is_one(tmp_path):
    beams = np.float32(2 * np.pi) / np.float32(719)
    turn = {"angle_min": np.float32(-np.pi), "angle_increment": beams, "ranges": np.ones((3, 720))}
    assert read_leg_scans(written(tmp_path, PLAIN | turn)).angles[-1] == pytest.approx(np.pi)


def test_a_recording_without_marks_has_no_sector(tmp_path):
    scans = read_leg_scans(written(tmp_path, PLAIN))
    assert scans.sector is None
    assert scans.legs.shape == (0, 2)


def test_a_sector_holds_what_lies_within():
    within = np.array([[1.0, 0.0], [4.9, 0.0], [1.0, 0.3]])
    outside = np.array([[5.1, 0.0], [1.0, -0.3], [-1.0, 0.0], [4.9, 1.5], [1.0, 0.6]])
    sector = Sector(np.deg2rad(-15), np.deg2rad(30), 5.0)
    assert sector.holds(within).all()
    assert not sector.holds(outside).any()


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"leg_xy": None}, "has no array leg_xy"),
        ({"stamp": None, "ranges": None}, "has no array stamp, ranges"),
        ({"stamp": np.array([3.0, 3.0, 3.1])}, "stamp must rise"),
        ({"stamp": np.array([3.0, np.nan, 3.1])}, "stamp must be finite"),
        ({"ranges": np.ones((2, 3))}, r"ranges must be \(3, beams\), got \(2, 3\)"),
        ({"ranges": np.array(["a"])}, "ranges must be real numbers"),
        ({"angle_increment": np.float64(0.0)}, "angle_increment must be positive"),
        ({"range_max": np.nan}, "range_max must be above range_min, got nan and 0.1"),
        ({"range_max": 0.1}, "range_max must be above range_min, got 0.1 and 0.1"),
        ({"angle_min": -135.0}, "beams must lie within a turn, got from -135 to -134.5"),
        ({"angle_increment": 45.0}, "beams must lie within a turn, got from -0.5 to 89.5"),
        ({"leg_scan": np.array([0, 2, 1])}, "leg_scan must not fall, and be below 3"),
        ({"leg_scan": np.array([0, 2, 3])}, "leg_scan must not fall, and be below 3"),
        ({"leg_scan": np.array([0, 2])}, r"leg_xy must be \(2, 2\), got \(3, 2\)"),
        ({"label_sector_deg_m": np.ones(2)}, r"label_sector_deg_m must be \(3,\), got \(2,\)"),
    ],
)
def test_what_is_missing_or_wrong_is_named(tmp_path, changes, reason):
    arrays = {name: value for name, value in (MARKED | changes).items() if value is not None}
    with pytest.raises(CorruptLog, match=rf"legs\.npz: .*{reason}"):
        read_leg_scans(written(tmp_path, arrays))


def test_a_damaged_file_is_named(tmp_path):
    path = written(tmp_path, MARKED)
    content = path.read_bytes()
    for broken in (b"", b"not an archive", content[:200], content[: len(content) // 2]):
        path.write_bytes(broken)
        with pytest.raises(CorruptLog, match=r"legs\.npz: no NumPy archive, or a damaged one"):
            read_leg_scans(path)
    np.save(tmp_path / "one.npy", np.ones(3))
    with pytest.raises(CorruptLog, match=r"one\.npy: "):
        read_leg_scans(tmp_path / "one.npy")
    with pytest.raises(FileNotFoundError):
        read_leg_scans(tmp_path / "none.npz")
