r"""The picture of a tilted camera as the robot would see it: eq. (1).

.. math:: {}^C H_R = K \left( R - \frac{t\, n^\top}{d} \right) K^{-1}

What the corrected picture shows where is compared with a camera that stands in the robot's frame.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, UInt8

from data_synth.ceiling import CeilingCamera, Mount, make_ceiling
from robot_perception.ceiling.correction import Correction, correction
from robot_perception.chapters.ceiling_navigation.world import HALF, MOUNT, PAPER, looking
from robot_perception.evaluation.intervals import exact, spread
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.results import kept
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted, Condition

TO_ROBOT, UPWARDS = (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)
"""The two unit normals of a level ceiling, in the robot's frame."""
ROUNDING = 1e-6
"""What rounding leaves of a pixel."""


@dataclass(frozen=True, slots=True)
class Config:
    """Cameras mounted at random, and points in view; the paper gives no numbers, all are ours.

    ``tilt`` bounds roll and pitch, rad; ``aside`` the place of the camera on the robot, m. The
    camera may have been tilted by ``since`` after its mounting was measured, rad, and the points
    may hang ``below`` the ceiling, m.
    """

    mounts: int = 500
    points: int = 20
    tilt: float = np.deg2rad(10.0)
    aside: float = 0.3
    since: float = 0.0
    below: float = 0.0


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Largest distance of a corrected point from where it should be, px, camera by camera."""

    towards: Float[np.ndarray, " mounts"]
    upwards: Float[np.ndarray, " mounts"]
    raw: Float[np.ndarray, " mounts"]


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Correct what cameras mounted at random see, with either normal, and not at all."""
    rows = []
    for _ in range(config.mounts):
        roll, pitch = rng.uniform(-config.tilt, config.tilt, 2).tolist()
        x, y = rng.uniform(-config.aside, config.aside, 2).tolist()
        mount = Mount(roll=roll, pitch=pitch, yaw=float(rng.uniform(-0.5, 0.5)), x=x, y=y)
        pose = rng.uniform(-1, 1, 3) * [5, 5, np.pi]
        ahead, left = (rng.uniform(-1, 1, (config.points, 2)) * HALF).T
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        points = pose[:2] + np.stack([cos * ahead - sin * left, sin * ahead + cos * left], axis=-1)
        height = MOUNT.height - config.below
        turned = (roll, pitch + config.since, mount.yaw, x, y, height)
        image = looking.__wrapped__(*turned).points_seen(pose, points)
        ideal = looking(height=height).points_seen(pose, points)
        off = [np.abs(image - ideal)]
        for normal in (TO_ROBOT, UPWARDS):
            off.append(np.abs(corrected(image, mount, normal) - ideal))
        rows.append([np.hypot(*one.T).max() for one in off])
    raw, towards, upwards = np.array(rows).T
    return Result(towards, upwards, raw)


def corrected(
    image: Float[np.ndarray, "n 2"], mount: Mount, normal: tuple[float, float, float]
) -> Float[np.ndarray, "n 2"]:
    """Return where pixels of a camera are in the ideal picture, by eq. (1) and a normal."""
    H = correction(
        mount.K, mount.rotation, mount.translation, np.array(normal), mount.height, MOUNT.K
    )
    rays = np.linalg.solve(H, np.column_stack([image, np.ones(len(image))]).T)
    return (rays[:2] / rays[2]).T


TILTED = replace(MOUNT, roll=np.deg2rad(6), pitch=np.deg2rad(-8), x=0.15, y=-0.1)
"""A camera mounted without care, for the page."""


@dataclass(frozen=True, eq=False, slots=True)
class Pictures:
    """What the tilted camera sees, what eq. (1) makes of it, and what it should be."""

    raw: UInt8[np.ndarray, "240 320"]
    corrected: UInt8[np.ndarray, "240 320"]
    ideal: UInt8[np.ndarray, "240 320"]
    seen: np.ndarray

    def off(self, image: np.ndarray) -> float:
        """Return the root mean squared difference of grey values from the ideal picture."""
        both = image[self.seen].astype(float) - self.ideal[self.seen]
        return float(np.sqrt(np.mean(both**2)))


@kept
def pictures(seed: int = 100) -> Pictures:
    """Return pictures of one ceiling by the tilted camera and by the ideal one."""
    ceiling = make_ceiling("varied", rng=np.random.default_rng(seed), side=8.0)
    pose = np.array([0.3, 0.2, 0.4])
    raw, ideal = (CeilingCamera(ceiling, mount).image(pose) for mount in (TILTED, MOUNT))
    fix = Correction(
        TILTED.K, TILTED.rotation, TILTED.translation, np.array(TO_ROBOT), TILTED.height,
        TILTED.size,
    )  # fmt: skip
    return Pictures(raw, fix.apply(raw), ideal, fix.seen)


correcting = Study(run, full=Config(), quick=Config(mounts=50), seed=71)


@correcting.claim(
    "camera-correction",
    paper=PAPER,
    place="§2.1, eq. 1",
    basis="mathematics",
    statement="Corrected by the homography of eq. 1, what a camera mounted anyhow sees of the "
    "ceiling is what a camera in the robot's frame would see.",
    paper_value="in words",
    method="Cameras tilted by up to 10°, turned and displaced at random: largest distance of a "
    "corrected point of the ceiling from where a camera in the robot's frame sees it, with the "
    "normal that points from the ceiling to the robot.",
    accepted=Accepted(0.0, ROUNDING, "an identity leaves nothing but rounding"),
    sabotage=[
        Change("a camera tilted by 1° after it was calibrated", since=np.deg2rad(1.0)),
        Change("points that hang 30 cm below the ceiling", below=0.3),
    ],
)
def corrects(found: Result) -> Finding:
    """Compare corrected points with those of the ideal camera."""
    upwards = exact(float(np.median(found.upwards)), "px", "median over cameras")
    shown = pictures()
    return Finding(
        exact(float(found.towards.max()), "px", "largest over cameras and points"),
        {
            "the same with the upward normal": spread(found.upwards, "px"),
            "not corrected": spread(found.raw, "px"),
            "grey values of a picture, off by": exact(shown.off(shown.corrected)),
            "the same, not corrected": exact(shown.off(shown.raw)),
        },
        conditions=(
            Condition(
                "n points from the ceiling to the robot, which the paper does not say",
                bool(upwards.low > ROUNDING),
            ),
        ),
        note="With the sign as printed, eq. 1 needs the normal that points down. With the upward "
        "one it corrects for −t: a camera beside the robot's middle is moved to the wrong side.",
    )
