"""Valid calls of `data_synth.arms`."""

import numpy as np

from data_synth.arms import bodies, gestures
from data_synth.companion import faces
from tests.hostile.sweep import call

WHO = faces.make_identity(np.random.default_rng(0))
GREY = (0.3, 0.3, 0.3)
OUTFIT = bodies.Outfit(GREY, GREY)
PERSON = bodies.Person(bodies.Build(), OUTFIT, WHO)
STAGE = bodies.Stage(40.0, (24, 32))
STILL = np.tile(gestures.REST, 2)


def rng():
    return np.random.default_rng(1)


CALLS = {
    bodies.Build: lambda: call(0.3, 0.25, 0.17, 0.4, 0.25, 0.05),
    bodies.Person.joints: lambda: call(PERSON, STILL, np.array([0.0, 0, 2])),
    bodies.Stage.pixels: lambda: call(STAGE, np.array([[0.1, 0.2, 1.0]])),
    bodies.Stage.face: lambda: call(STAGE, PERSON),
    bodies.Stage.joints: lambda: call(STAGE, PERSON, np.zeros(8)),
    bodies.Stage.paint: lambda: call(
        STAGE, PERSON, STILL, np.zeros((24, 32, 3), dtype=np.float32), 1.0
    ),
    bodies.make_person: lambda: call(rng(), WHO, OUTFIT),
    gestures.ArmScene: lambda: call("pointing", 2, 1, 0.1, 1.0, 0.05, 0.02, 0.1),
    gestures.film_arms: lambda: call(
        rng(), 2, gestures.ArmScene("still"), PERSON, STAGE, np.tile(STILL, (2, 1))
    ),
    gestures.make_motion: lambda: call(rng(), 5, gestures.ArmScene("still"), PERSON),
}
