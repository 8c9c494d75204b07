"""Valid calls of `data_synth.day`; the floor is made when it is first asked for."""

from functools import cache

import numpy as np

from data_synth import stereo
from data_synth.companion import hall
from data_synth.day import acts, building
from data_synth.people.world import World
from tests.hostile.sweep import call

CAMERA = hall.RobotCamera(60.0, (24, 32), 1.3)
RIG = stereo.Rig(size=(16, 12), focal_px=20.0)
POSE = np.array([3.0, 1.2, 0.1])


def rng():
    return np.random.default_rng(1)


@cache
def floor():
    return building.make_building(rng=np.random.default_rng(0))


@cache
def somebody():
    return acts.make_someone(np.random.default_rng(0))


@cache
def act():
    return acts.tutor_comes(floor(), [somebody()] * 3, POSE, rng=rng())


CALLS = {
    building.make_building: lambda: call(rng=rng()),
    building.Building: lambda: call(
        floor().office, floor().scene, floor().colours, floor().above, floor().middle
    ),
    building.Building.pair: lambda: call(floor(), RIG, POSE, rng=rng()),
    building.Building.ahead: lambda: call(floor(), CAMERA, POSE),
    acts.Act.look: lambda: call(act(), CAMERA, act().world.now, rng=rng()),
    acts.Act.heads: lambda: call(act(), act().world.now),
    acts.pointing: lambda: call(
        floor(), somebody(), np.array([6.0, 1.2]), np.array([4.0, 1.2, 0.0]),
        np.array([5.8, 2.4]), CAMERA, rng=rng(), pictures=2,
    ),
    acts.portrait: lambda: call(floor(), somebody(), CAMERA, rng=rng()),
}  # fmt: skip

INNER = {
    acts.clear_the_way,
    acts.guided_tour,
    acts.led_path,
    acts.make_someone,
    acts.tutor_comes,
    building.Building.overhead,
    World,
}
"""What the acts of a day alone call, with what they have made."""
