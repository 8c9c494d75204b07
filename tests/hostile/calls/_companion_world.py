"""Valid calls of `data_synth.companion`."""

import numpy as np

from data_synth.companion import face_films, faces, hall, hands, visits, walking, walks
from tests.hostile.sweep import call

CAMERA = hall.RobotCamera(60.0, (24, 32), 1.3)
HALL = hall.make_hall(np.random.default_rng(0), length=5.0, width=5.0, clutter=2)
PERSON = faces.make_identity(np.random.default_rng(0))
CLOTHES = walking.make_clothes(np.random.default_rng(0))
GREY = (0.3, 0.3, 0.3)
PLASTER = np.full((2, 3, 3), 0.3, dtype=np.float32)
VISITOR = visits.make_visitor(np.random.default_rng(0))
VISIT = visits.make_visit(np.random.default_rng(0), brief=True)


def rng():
    return np.random.default_rng(1)


CALLS = {
    hall.RobotCamera: lambda: call(60.0, (24, 32), 1.3),
    hall.RobotCamera.project: lambda: call(CAMERA, 2.0, 0.1, 1.0),
    hall.Hall.view: lambda: call(HALL, np.array([2.0, 2.0, 0.3]), CAMERA),
    hall.make_hall: lambda: call(rng(), length=5.0, width=4.5, clutter=2),
    faces.FaceIdentity.part: lambda: call(PERSON, "jaw"),
    faces.FaceView: lambda: call(0.1, 0.0, 0.0, 0.2, 0.0, 0.0, 0.3, 0.5, 0.5, 1.0),
    faces.make_identity: lambda: call(rng(), tone=2),
    faces.face_sprite: lambda: call(PERSON, faces.FaceView(), 30),
    face_films.FaceScene: lambda: call(1, 0.5, 1.0, 2.0, 8, "steady", 0.0, False, (90.0, 120.0)),
    face_films.film_faces: lambda: call(rng(), 1, face_films.FaceScene(), (PERSON,)),
    face_films.portraits: lambda: call(rng(), PERSON, 1, size=(28, 23)),
    hands.make_hand: lambda: call(rng(), "fist", tone=1),
    hands.hand_window: lambda: call(rng(), hands.HandPose(), tilt=0.1, size=12, jitter=0.02),
    hands.clutter_picture: lambda: call(rng(), (40, 50), people=0.5),
    walking.Arm: lambda: call(1, 0.3, 1.7),
    walks.WalkScene: lambda: call("short, whole", "steady", False, 1, 1.0),
    walks.film_walk: lambda: call(rng(), 40, walks.WalkScene(others=0)),
    visits.Stance: lambda: call(2.0, 3.0, 0.3, True, 0.5, False, 0.1),
    visits.make_visitor: lambda: call(rng()),
    visits.make_visit: lambda: call(rng(), brief=True),
    visits.Visit.at: lambda: call(VISIT, 3),
    visits.Visit.order: lambda: call(VISIT, "tutor"),
    visits.see: lambda: call(
        HALL, CAMERA, np.array([1.0, 2.0, 0.0]), [(VISITOR, visits.Stance(3.0, 2.0, raised=1.0))],
        rng=rng(), phase=0.3, light=1.0,
    ),
}  # fmt: skip
