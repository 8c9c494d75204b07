"""Valid calls of the worlds."""

import numpy as np

from data_synth import (
    building,
    laser,
    monobot,
    office,
    posts,
    stereo,
    textured_building,
    textures,
    wheels,
)
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
SIGMAS = {"start_deviation": 0.1, "motion_deviation": 0.1, "measurement_deviation": 0.1}


def rng() -> np.random.Generator:
    return np.random.default_rng(1)


def runs() -> monobot.RailRuns:
    return monobot.simulate_rail(PLAN, AT, 2, rng=rng(), **SIGMAS)


RESULTS = {
    building.Building,
    laser.Scans,
    laser.Sight,
    monobot.RailRuns,
    office.Office,
    posts.Posts,
    stereo.Scene,
    stereo.Sight,
    stereo.StereoFrame,
    textured_building.TexturedBuilding,
    textures.Atlas,
    wheels.Odometry,
}
CALLS = {
    building.make_building: lambda: call(rng=rng(), pole_radius=0.15),
    building.drive: lambda: call(HOUSE, step=1.0, beyond=2.0, radius=1.0),
    building.first_leg: lambda: call(HOUSE, radius=1.0),
    laser.Scanner: lambda: call(5, 0.01, 12.0, 0.01, 0.004, 0.1),
    laser.cast: lambda: call(np.zeros((2, 2)), np.array([0.1, 0.2]), FACES),
    laser.scan: lambda: call(FACES, POSES, SCANNER, rng=rng()),
    laser.sight: lambda: call(FACES, POSES, SCANNER, reach=5.0),
    laser.scan_moving: lambda: call(FACES, POSES[0], (1.0, 0.1), 0.1, SCANNER, rng=rng()),
    laser.measure: lambda: call(laser.sight(FACES, POSES, SCANNER), SCANNER, rng=rng()),
    monobot.planned_path: lambda: call("sine", 5, start=0.0, reach=1.0),
    monobot.simulate_rail: lambda: call(PLAN, AT, 2, rng=rng(), **SIGMAS),
    monobot.measure_anchor: lambda: call(runs(), 1.0, 0.1, rng=rng()),
    monobot.watch_vehicle: lambda: call(runs(), 1.0, 0.1, rng=rng()),
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
    stereo.render: lambda: call(SCENE, RIG, POSES[0], exposure=1.1, rng=rng()),
    stereo.frames: lambda: call(SCENE, RIG, POSES, rng=rng()),
    stereo.ideal_image: lambda: call(SCENE, RIG, POSES[0], across=0.1),
    stereo.surface_points: lambda: call(SCENE, RIG, POSES[0], np.array([[3.5, 2.5], [99.0, 0]])),
    stereo.project: lambda: call(RIG, POSES[0], np.array([[2.0, 0, 1], [3, 1, 1]])),
    stereo.visible: lambda: call(SCENE, RIG, POSES[0], np.array([[2.0, 0, 1], [3, 1, 1]])),
    textured_building.make_textured_building: lambda: call(rng=rng()),
    textured_building.drive: lambda: call(LIT, rng=rng(), poses=20, radius=0.8, wander=0.05),
    textures.make_atlas: lambda: call([np.full((4, 4), 90.0)]),
    textures.paint: lambda: call("sign", rng=rng()),
    wheels.Slip: lambda: call(0.1, 0.1, 0.1, 0.1),
    wheels.true_increments: lambda: call(POSES),
    wheels.roll: lambda: call(POSES, wheels.SMALL, rng=rng()),
}
