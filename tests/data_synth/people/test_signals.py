"""Readings of a session: their rhythm, what they show, and the truth beside them."""

from functools import cache
from itertools import islice, pairwise

import numpy as np
import pytest

from data_synth.people import (
    LASER_ANGLES,
    SONAR_ANGLES,
    STEP,
    FisheyeImage,
    LaserScan,
    Moment,
    Person,
    Rig,
    Sensing,
    SonarScan,
    Wander,
    World,
    make_session,
    readings,
    truth,
    walk,
)
from data_synth.sonar import SonarRing
from data_synth.wheels import true_increments
from tests.data_synth.offices import office

OFFICE = office(1)
RIG = Rig()
MIDDLE = (OFFICE.rooms[4, :2] + OFFICE.rooms[4, 2:]) / 2


@cache
def session_of(robot):
    return make_session(OFFICE, rng=np.random.default_rng(3), duration=6.0, robot=robot)


def moment(places, facing=None, *, heading=0.0, gazes=None, time=0.0):
    """People at places ahead and left of a robot in the middle of a room; they face the robot."""
    places = np.asarray(places, dtype=float)
    turn = np.array([[np.cos(heading), -np.sin(heading)], [np.sin(heading), np.cos(heading)]])
    world = MIDDLE + places @ turn.T
    back = np.arctan2(*(MIDDLE - world).T[::-1])
    facing = back if facing is None else np.asarray(facing, dtype=float)
    gazes = facing if gazes is None else gazes
    still = np.zeros(len(places))
    robot = np.array([*MIDDLE, heading])
    return Moment(time, robot, world, facing, gazes, still, still, np.ones(len(places), bool))


def look(now, people, kind, *, seed=0, lights_out=None):
    """The first reading of a kind of people who stay as they are."""
    later = Moment(now.time + 1.0, *(getattr(now, f) for f in list(Moment.__slots__)[1:]))
    sensing = Sensing(OFFICE, people, RIG, rng=np.random.default_rng(seed), lights_out=lights_out)
    return next(r for r in sensing.due(now, later) if isinstance(r, kind))


def test_readings_come_in_order_each_sensor_in_its_rhythm():
    times = {LaserScan: [], SonarScan: [], FisheyeImage: []}
    before = -1.0
    for reading in readings(session_of("stands"), RIG, rng=np.random.default_rng(0)):
        assert reading.time > before
        before = reading.time
        times[type(reading)].append(reading.time)
    assert [len(t) for t in times.values()] == [60, 30, 45]
    for found, rate, delay in zip(times.values(), RIG.rates, RIG.delays, strict=True):
        np.testing.assert_allclose(found, delay + np.arange(len(found)) / rate)


def test_readings_have_the_shapes_that_the_angles_have():
    for reading in islice(readings(session_of("drives"), RIG, rng=np.random.default_rng(0)), 8):
        if isinstance(reading, LaserScan):
            assert reading.ranges.shape == LASER_ANGLES.shape == (181,)
            assert not np.isnan(reading.ranges).any()
            finite = reading.ranges[np.isfinite(reading.ranges)]
            assert (finite <= 8.0).all()
        elif isinstance(reading, SonarScan):
            assert reading.ranges.shape == SONAR_ANGLES.shape == (16,)
            assert ((reading.ranges < 2.0) | np.isinf(reading.ranges)).all()
        else:
            assert reading.image.shape == (320, 320, 3)
            assert reading.image.dtype == np.uint8


def test_the_same_seed_gives_the_same_readings_and_a_stream_forgets_nothing():
    one, other = (
        list(islice(readings(session_of("drives"), RIG, rng=np.random.default_rng(5)), 12))
        for _ in "ab"
    )
    for a, b in zip(one, other, strict=True):
        for name in ("ranges", "image"):
            if hasattr(a, name):
                np.testing.assert_array_equal(getattr(a, name), getattr(b, name))


def test_readings_of_a_running_world_are_those_of_its_moments():
    rng = np.random.default_rng(1)
    world = World(OFFICE, [Person()] * 2, [Wander()] * 2, np.array([*MIDDLE, 0.3]), rng=rng)
    sensing = Sensing(OFFICE, world.people, RIG, rng=rng)
    times = []
    for _ in range(10):
        world.advance(2 * STEP)
        times += [r.time for r in sensing.due(world.before, world.now)]
    assert times == sorted(times)
    assert len(times) == 10 + 5 + 8
    assert times[-1] <= 1.0


def test_a_scan_shows_both_legs_where_they_are():
    person = Person(stance=0.26, leg=(0.06, 0.06))
    scan = look(moment([[1.5, 0.0]]), [person], LaserScan).ranges
    legs = np.abs(LASER_ANGLES) < np.arctan2(0.19, 1.5)
    near = legs & (scan < 1.6)
    ahead, left = scan * np.cos(LASER_ANGLES), scan * np.sin(LASER_ANGLES)
    assert near.sum() >= 6
    for side in (-1, 1):
        leg = near & (np.abs(left - side * 0.13) < 0.075)
        away = np.hypot(ahead[leg] - 1.5, left[leg] - side * 0.13)
        assert away == pytest.approx(0.06, abs=0.05)
        assert np.abs(LASER_ANGLES[leg]).min() > 0.03


def test_truth_tells_distance_and_direction():
    polar = np.array([[1.2, 0.5], [1.8, -2.6], [1.0, 3.1]])
    places = polar[:, :1] * np.stack([np.cos(polar[:, 1]), np.sin(polar[:, 1])], axis=-1)
    now = moment(places, heading=0.8)
    known = truth(OFFICE, [Person()] * 3, now, RIG)
    np.testing.assert_allclose(known.polar, polar)
    assert known.clear.all()
    np.testing.assert_array_equal(known.beams > 0, [True, False, False])  # the others are behind
    assert (known.cones > 0).all()
    ahead = np.array([np.cos(SONAR_ANGLES[8]), np.sin(SONAR_ANGLES[8])])
    far = truth(OFFICE, [Person()], moment([2.8 * ahead]), RIG)
    assert far.clear.all()
    assert far.beams[0] > 0
    assert far.cones[0] == 0  # beyond the reach of the sonars


def test_truth_tells_who_is_hidden():
    people = [Person(skirt=True), Person(), Person()]
    outside = OFFICE.doors[4, 0] + [4.0, 0.0] - MIDDLE
    now = moment([[1.0, 0.0], [1.7, 0.0], outside])
    known = truth(OFFICE, people, now, RIG)
    assert known.beams[0] > 10
    assert known.beams[1] == 0  # behind the skirt
    assert known.cones[1] == 0
    assert known.face[0] > 5 * known.face[1]
    np.testing.assert_array_equal(known.clear, [True, True, False])
    assert known.face[2] == known.beams[2] == known.cones[2] == 0
    away = Moment(*(getattr(now, f) for f in list(Moment.__slots__)[:-1]), np.zeros(3, bool))
    gone = truth(OFFICE, people, away, RIG)
    assert not gone.clear.any()
    assert gone.face.sum() == gone.beams.sum() == gone.cones.sum() == 0


def test_a_face_turned_away_shows_little_skin():
    facing = truth(OFFICE, [Person()], moment([[1.2, 0.4]]), RIG).face[0]
    back = truth(OFFICE, [Person()], moment([[1.2, 0.4]], gazes=np.array([0.3])), RIG).face[0]
    assert facing > 60
    assert back < 0.3 * facing


def test_the_image_shows_the_face_in_its_direction():
    bearing = 2.0
    place = 1.2 * np.array([np.cos(bearing), np.sin(bearing)])
    people = [Person(tone=0.3, head=1.7)]
    now = moment([place], heading=0.4)
    seen = look(now, people, FisheyeImage).image.astype(float)
    gone = Moment(*(getattr(now, f) for f in list(Moment.__slots__)[:-1]), np.zeros(1, bool))
    change = np.abs(seen - look(gone, people, FisheyeImage).image).max(axis=2) > 60
    rows, columns = np.nonzero(change)
    pixels = np.stack([columns, rows], axis=-1)
    turns = RIG.camera.bearing(pixels)
    assert np.angle(np.exp(1j * (turns - bearing)).mean()) == pytest.approx(0, abs=0.08)
    highest = np.rad2deg(RIG.camera.elevation(pixels).max())
    assert highest == pytest.approx(np.rad2deg(np.arctan2(0.63, 1.15)), abs=5)


def test_images_get_dark_when_the_lights_go_out():
    out = np.full(len(OFFICE.rooms), -1.0)
    now = moment([[1.2, 0.4]])
    bright = look(now, [Person()], FisheyeImage).image.astype(float)
    dark = look(now, [Person()], FisheyeImage, lights_out=out).image.astype(float)
    assert dark.mean() < 0.7 * bright.mean()
    assert dark.mean() > 5


def test_exposure_follows_the_light():
    session = make_session(
        OFFICE, rng=np.random.default_rng(3), duration=3.0, people=0, lights_out=0.6
    )
    images = [
        r.image.mean()
        for r in readings(session, RIG, rng=np.random.default_rng(0))
        if isinstance(r, FisheyeImage)
    ]
    assert images[5] < 0.75 * images[3]
    assert images[-1] > 1.1 * images[5]


def test_sonars_hear_who_stands_before_them():
    quiet = Rig(ring=SonarRing(crosstalk=0.0, loudness=0.0, range_sigma=0.0))
    bearing = SONAR_ANGLES[10]
    now = moment([1.0 * np.array([np.cos(bearing), np.sin(bearing)])])
    later = Moment(1.0, *(getattr(now, f) for f in list(Moment.__slots__)[1:]))
    sensing = Sensing(OFFICE, [Person()], quiet, rng=np.random.default_rng(0))
    heard = next(r for r in sensing.due(now, later) if isinstance(r, SonarScan)).ranges
    assert heard[10] == pytest.approx(1.0 - 0.22 - 0.06, abs=0.1)


def test_the_truth_has_no_cone_of_a_sonar_beyond_its_cut():
    bearing = SONAR_ANGLES[10]
    now = moment([1.2 * np.array([np.cos(bearing), np.sin(bearing)])])
    legs = 1.2 - SonarRing().radius
    for cut, met in ((legs - 0.2, False), (legs + 0.2, True)):
        found = truth(OFFICE, [Person()], now, Rig(ring=SonarRing(cut=cut)))
        assert (found.cones > 0).tolist() == [met]


@pytest.mark.parametrize("robot", ["stands", "drives"])
def test_a_session_is_kept_on_its_grid(robot):
    session = session_of(robot)
    np.testing.assert_allclose(np.diff(session.times), STEP)
    assert session.positions.shape == (121, 3, 2)
    assert session.present.dtype == bool
    for k in (0, 60, 120):
        now = session.at(float(session.times[k]))
        np.testing.assert_allclose(now.robot, session.robot[k], atol=1e-9)
        np.testing.assert_allclose(now.positions, session.positions[k])
    middle = session.at(float(session.times[7:9].mean()))
    np.testing.assert_allclose(middle.positions, session.positions[7:9].mean(axis=0))
    steps = true_increments(session.robot)
    assert session.odometry.increments.shape == steps.shape
    assert (session.robot == session.robot[0]).all() == (robot == "stands")


def test_a_driving_robot_gets_somewhere_and_keeps_clear_of_people():
    session = make_session(OFFICE, rng=np.random.default_rng(8), duration=40.0, robot="drives")
    gone = np.hypot(*np.diff(session.robot[:, :2], axis=0).T)
    assert gone.sum() > 3.0
    assert gone.max() <= 0.4 * STEP + 1e-9
    assert (OFFICE.free(session.robot[:, :2]) > 0.2).all()
    gaps = np.hypot(*(session.positions - session.robot[:, None, :2]).transpose(2, 0, 1))
    assert gaps[session.present].min() > 0.45
    error = session.odometry.increments - true_increments(session.robot)
    assert 0 < np.abs(error).max() < 0.02


def test_scripts_can_be_recorded():
    script = walk(MIDDLE + np.array([[1.0, -1.0], [1.0, 1.0]]), np.array([0.0, 3.0]))
    world = World(
        OFFICE, [Person()], [script], np.array([*MIDDLE, 0.0]), rng=np.random.default_rng(0)
    )
    places = [world.advance(STEP).positions[0] for _ in range(60)]
    for before, after in pairwise(places):
        assert (after - before)[0] == pytest.approx(0, abs=1e-9)
        assert (after - before)[1] >= -1e-12


@pytest.mark.parametrize("robot", ["flies", ""])
def test_bad_robots_are_named(robot):
    with pytest.raises(ValueError, match="robot must be stands or drives"):
        make_session(OFFICE, rng=np.random.default_rng(0), duration=1.0, robot=robot)
