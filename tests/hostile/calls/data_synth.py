"""Valid calls of the worlds."""

from dataclasses import fields

import numpy as np

from data_synth import (
    building,
    fisheye,
    floor_plans,
    laser,
    monobot,
    office,
    posts,
    sonar,
    stereo,
    textured_building,
    textures,
    wheels,
)
from data_synth.ceiling import camera as ceiling_camera
from data_synth.ceiling import clutter, grille_patch, patch, superimpose
from data_synth.ceiling import plane as ceiling_plane
from data_synth.ceiling import robot as ceiling_robot
from data_synth.coloured import beetles, discs, heads, lamp, sequences, snails
from data_synth.people import bodies, session, signals, staging, stories, world
from data_synth.people import office as people_office
from data_synth.people import sound as people_sound
from tests.hostile.calls import _arms_world, _companion_world, _day_world
from tests.hostile.sweep import call

FLOOR = office.make_office(rng=np.random.default_rng(0), rooms=2)
HOUSE = building.make_building(rng=np.random.default_rng(0))
POSES = np.array([[0.0, 0, 0], [0.2, 0, 0.1]])
SCANNER = laser.Scanner(beams=5)
FACES = np.array([[[2.0, -9], [2, 9]], [[-2, 9], [-2, -9]], [[9, 2], [-9, 2]], [[-9, -2], [9, -2]]])
PLAN = np.array([0.0, 1.0, 2.0])
AT = np.array([3.0, 5.0])
CARD = stereo.Surface([2.0, 0.5, 1.5], [0.0, -1, 0], [0.0, 0, -1], 0)
SCENE = stereo.make_scene([CARD], [np.full((4, 4), 90.0)])
RIG = stereo.Rig(size=(8, 6))
LIT = textured_building.make_textured_building(rng=np.random.default_rng(0))
SMALL = people_office.make_people_office(rng=np.random.default_rng(0))
ROBOT = np.array([*(SMALL.rooms[0, :2] + SMALL.rooms[0, 2:]) / 2, 0.1])
CORRIDOR = np.linspace(*SMALL.exits, 120)
PAIR = [bodies.Person(), bodies.Person(skirt=True)]
EYE = fisheye.Fisheye(size=16, focal_px=4.5)
SENSORS = signals.Rig(camera=EYE)
GREYS = np.zeros((16, 16, 3))
LEGS = np.array([[1.0, 0.0, 0.1, 0.2, 0.3]])
NOON = np.array([0.0, 1.0])
SIGMAS = {"start_deviation": 0.1, "motion_deviation": 0.1, "measurement_deviation": 0.1}
MOUNT = ceiling_camera.Mount(size=(8, 6), focal=5.0)
PAINTED = ceiling_plane.Ceiling(np.full((9, 9), 120, dtype=np.uint8), (), "plain", 0.5)
LOOKING = ceiling_camera.CeilingCamera(PAINTED, MOUNT)
PICTURE = np.full((9, 8), 70, dtype=np.uint8)
ABOVE = ceiling_camera.Occluder(0.1, 0.2, 0.3, 1.0, 40.0)


def rng() -> np.random.Generator:
    return np.random.default_rng(1)


def crowd() -> world.World:
    return world.World(SMALL, PAIR, [world.Wander(), world.Visit()], ROBOT, rng=rng())


def aside() -> stories.StepsAside:
    return stories.StepsAside(np.array([[0.0, 0], [0, 1]]), NOON)


def shown() -> fisheye.Bodies:
    return bodies.figures(
        PAIR, ROBOT[:2] + NOON[:, None], NOON, NOON, NOON, NOON / 5, NOON > 0, np.array([0, 1])
    )


def some_session() -> session.Session:
    return session.make_session(SMALL, rng=rng(), duration=0.2, people=PAIR)


def parts(thing: object) -> tuple:
    """Return the fields of an object, of which it can be made again."""
    return tuple(getattr(thing, field.name) for field in fields(thing))


def says() -> people_sound.Conversation:
    return people_sound.Conversation(
        *(np.full(2, 120.0), np.array([0]), np.zeros(1), np.ones(1), np.array([7]))
    )


CALLS = (
    {
        ceiling_plane.Ceiling: lambda: call(
            PICTURE[:8], (ceiling_plane.Fixture("vent", 0.1, 0.2, 0.3, 0.6, 0.6),), "plain", 0.01
        ),
        ceiling_plane.Ceiling.texels: lambda: call(PAINTED, AT[None]),
        ceiling_plane.Ceiling.places: lambda: call(PAINTED, AT[None]),
        ceiling_plane.make_ceiling: lambda: call("varied", rng=rng(), side=2.0),
        ceiling_camera.Mount: lambda: call(
            *(2.5, 200.0, (320, 240), (160.0, 118.5), 0.1, 0.2, 0.3, 0.05, 0.1, (-0.1, 0.02))
        ),
        ceiling_camera.Exposure: lambda: call(1.1, 4.0, 2.0, 0.3),
        ceiling_camera.Occluder: lambda: call(0.1, 0.2, 0.3, 1.0, 40.0),
        ceiling_camera.CeilingCamera: lambda: call(PAINTED, MOUNT),
        ceiling_camera.CeilingCamera.image: lambda: call(
            *(LOOKING, POSES[1]),
            rng=rng(),
            exposure=ceiling_camera.Exposure(noise=2.0),
            occluders=[ABOVE],
        ),
        ceiling_camera.CeilingCamera.points_seen: lambda: call(LOOKING, POSES[1], AT[None]),
        ceiling_robot.drive: lambda: call(POSES[1], 0.5, 0.2, 1.0, wheels.SMALL, rng=rng()),
        ceiling_robot.taught_path: lambda: call("corner", step=0.1, rng=rng()),
        clutter: lambda: call((16, 12), rng=rng()),
        grille_patch: lambda: call(rng=rng(), side=24, pitch=6.0),
        patch: lambda: call(rng=rng(), side=16),
        superimpose: lambda: call(
            PICTURE, PICTURE, np.array([3.0, 4, 0.2, 1.1]), centre=(3.0, 4.0)
        ),
        sequences.Camera: lambda: call(0.01, 0.001, 0.3, 2, 0.5),
        discs.circles: lambda: call(
            rng=rng(), frames=2, others=1, colour_step=0.1, camera=sequences.Camera(parts=1)
        ),
        lamp.rectangle: lambda: call(rng=rng(), frames=1, light="steady"),
        beetles.beetle: lambda: call(rng=rng(), frames=1, light="steady", legs=True, clutter=False),
        snails.snail: lambda: call(rng=rng(), frames=1, light="steady", neck=True, clutter=False),
        heads.HeadScene: lambda: call("steady", 1, True, False, True, 0.3, 2.0),
        heads.head: lambda: call(rng=rng(), frames=1, scene=heads.HeadScene(others=0)),
        bodies.make_person: lambda: call(rng=rng(), skirt=True),
        bodies.skin: lambda: call(0.3),
        bodies.legs: lambda: call(PAIR[0], NOON, 0.2, 0.3, 0.1),
        bodies.figures: lambda: call(
            PAIR, ROBOT[:2] + NOON[:, None], NOON, NOON, NOON, NOON / 5, NOON > 0, np.array([0, 1])
        ),
        fisheye.Fisheye.project: lambda: call(EYE, np.array([[1.0, 2, 3], [-1, 0.5, 1.2]])),
        fisheye.Fisheye.bearing: lambda: call(EYE, np.array([[3.0, 4], [9, 9]])),
        fisheye.Fisheye.elevation: lambda: call(EYE, np.array([[3.0, 4], [9, 9]])),
        fisheye.Bodies: lambda: call(*parts(shown())),
        fisheye.linear: lambda: call(np.array([10.0, 20, 30])),
        fisheye.view: lambda: call(EYE, SMALL.stage, ROBOT, shown(), SMALL.light(0.0)),
        fisheye.expose: lambda: call(EYE, np.full((16, 16, 3), 0.3), 1.0, rng=rng()),
        fisheye.Stage.light_at: lambda: call(SMALL.stage, np.array([[1.0, 2], [3, 4]])),
        people_office.make_people_office: lambda: call(rng=rng(), distractors=False),
        people_office.PeopleOffice.section: lambda: call(SMALL, 0.3),
        people_office.PeopleOffice.room_of: lambda: call(SMALL, ROBOT[:2]),
        people_office.PeopleOffice.free: lambda: call(SMALL, ROBOT[None, :2]),
        people_office.PeopleOffice.light: lambda: call(SMALL, 3.0, np.full(7, 2.0)),
        session.make_session: lambda: call(
            SMALL,
            rng=rng(),
            duration=0.2,
            people=1,
            robot="drives",
            act=world.Wander(),
            lights_out=0.1,
        ),
        session.record: lambda: call(
            crowd(), [crowd().now, crowd().advance(0.1)], rng=rng(), lights_out=np.full(7, 2.0)
        ),
        session.readings: lambda: call(some_session(), SENSORS, rng=rng()),
        session.Session.at: lambda: call(some_session(), 0.1),
        signals.Rig: lambda: call(
            *(laser.Scanner(beams=181), 0.3, sonar.SonarRing(), 0.2, EYE),
            *((10.0, 5.0, 7.5), (0.0, 0.01, 0.02)),
        ),
        signals.Sensing: lambda: call(SMALL, PAIR, SENSORS, rng=rng(), lights_out=np.full(7, 2.0)),
        signals.Sensing.due: lambda: call(
            signals.Sensing(SMALL, PAIR, SENSORS, rng=rng()), crowd().now, crowd().advance(0.1)
        ),
        signals.truth: lambda: call(SMALL, PAIR, crowd().now, SENSORS),
        staging.Config: lambda: call(
            *(3, 5.0, "drives", 2.0, ("laser",), False, True, 0.5, 0.1, 1.0),
        ),
        staging.rig: lambda: call(("laser", "camera"), sonar.SonarRing()),
        staging.staged: lambda: call(staging.Config(3, 0.2)),
        staging.truths: lambda: call(some_session(), [0.1, 0.15]),
        stories.TurnedRing: lambda: call(16, 0.2, 0.26, 2.0, 0.1, 0.2, 1.4, 0.5, 0.01, 0.5, 0.1),
        stories.StepsAside.ask: lambda: call(aside(), 1.0),
        stories.StepsAside.position: lambda: call(aside(), 1.0),
        stories.ask_aside: lambda: call(crowd()),
        stories.make_story: lambda: call(
            "guide", rng=rng(), comes=4.5, strays=9.0, gap=1.2, pace=0.5, beside=False
        ),
        stories.meeting_place: lambda: call(SMALL, CORRIDOR),
        people_sound.MicrophoneArray: lambda: call(np.eye(2), 1.2, 16000.0),
        people_sound.Acoustics: lambda: call(60.0, 45.0, 35.0, 0.7, 0.4, 0.25),
        people_sound.converse: lambda: call(
            some_session(), rng=rng(), manners=people_sound.Manners(pause=(0.1, 0.1))
        ),
        people_sound.paths: lambda: call(
            SMALL, np.array([*ROBOT[:2] + 0.5, 1.5]), np.array([*ROBOT[:2], 1.2])
        ),
        people_sound.own_noise: lambda: call(
            people_sound.MicrophoneArray(), people_sound.Acoustics(), rng=rng()
        ),
        people_sound.hear: lambda: call(
            *(some_session(), says(), people_sound.EARS, people_sound.Acoustics(window=0.1)),
            rng=rng(),
        ),
        world.walk: lambda: call(np.array([[0.0, 0], [1, 0]]), NOON + 1, facing="robot"),
        world.Walk.position: lambda: call(world.walk(np.array([[0.0, 0], [1, 0]]), NOON), 0.5),
        world.between: lambda: call(crowd().now, crowd().advance(0.1), 0.05),
        world.World.way: lambda: call(crowd(), ROBOT[:2], ROBOT[:2] + 0.5),
        world.World.ask: lambda: call(crowd(), 1),
        world.World.advance: lambda: call(crowd(), 0.1, (0.1, 0.2)),
        building.make_building: lambda: call(rng=rng(), pole_radius=0.15),
        building.drive: lambda: call(HOUSE, step=1.0, beyond=2.0, radius=1.0),
        building.first_leg: lambda: call(HOUSE, radius=1.0),
        laser.Scanner: lambda: call(5, 0.01, 12.0, 0.01, 0.004, 0.1),
        laser.scan: lambda: call(FACES, POSES, SCANNER, rng=rng()),
        laser.sight: lambda: call(FACES, POSES, SCANNER, reach=5.0),
        laser.scan_moving: lambda: call(FACES, POSES[0], (1.0, 0.1), 0.1, SCANNER, rng=rng()),
        laser.measure: lambda: call(laser.sight(FACES, POSES, SCANNER), SCANNER, rng=rng()),
        monobot.planned_path: lambda: call("sine", 5, start=0.0, reach=1.0),
        monobot.simulate_rail: lambda: call(PLAN, AT, 2, rng=rng(), **SIGMAS),
        office.make_office: lambda: call(
            rng=rng(), rooms=2, length=20.0, corridor=2.0, depth=4.5, door=1.0, furniture=1
        ),
        office.drive: lambda: call(FLOOR, step=1.0, turn=0.5),
        posts.make_posts: lambda: call(40.0, rng=rng(), apart=3.0),
        posts.glimpse: lambda: call(AT[None], POSES, sigma=0.1, reach=6.0, rng=rng()),
        stereo.Surface: lambda: call(
            *np.array([[2.0, 0.5, 1.5], [0, -1, 0], [0, 0, -1]]), 0, (1.0, 2.0), 1.0, -1
        ),
        stereo.Rig: lambda: call(280.0, 0.1, (8, 6), 1.0, 0.6, 0.7, 1.2, 0.01, 0.1, 0.02),
        stereo.make_scene: lambda: call([CARD], [np.full((4, 4), 90.0)]),
        stereo.left_frames: lambda: call(SCENE, RIG, POSES, rng=rng()),
        stereo.render_left: lambda: call(SCENE, RIG, POSES[0], exposure=1.1, rng=rng()),
        stereo.frames: lambda: call(SCENE, RIG, POSES, rng=rng()),
        stereo.ideal_image: lambda: call(SCENE, RIG, POSES[0], across=0.05),
        stereo.surface_points: lambda: call(
            SCENE, RIG, POSES[0], np.array([[3.5, 2.5], [99.0, 0]])
        ),
        stereo.project: lambda: call(RIG, POSES[0], np.array([[2.0, 0, 1], [3, 1, 1]])),
        stereo.visible: lambda: call(SCENE, RIG, POSES[0], np.array([[2.0, 0, 1], [3, 1, 1]])),
        floor_plans.make_floor: lambda: call(3, alike=True, rng=rng()),
        textured_building.make_textured_building: lambda: call(rng=rng()),
        textured_building.drive: lambda: call(LIT, rng=rng(), poses=20, radius=0.8, wander=0.05),
        textures.paint: lambda: call("sign", rng=rng()),
        wheels.Slip: lambda: call(0.1, 0.1, 0.1, 0.1),
        wheels.roll: lambda: call(POSES, wheels.SMALL, rng=rng()),
    }
    | _companion_world.CALLS
    | _arms_world.CALLS
    | _day_world.CALLS
)

INNER = _day_world.INNER
