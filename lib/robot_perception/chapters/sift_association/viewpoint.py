"""Section 4: how the descriptor of one point changes with the viewpoint.

One picture hangs in empty space. The camera goes round its middle, always looking at it, so that
nothing but the viewpoint changes, and noise.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from jaxtyping import Float

from data_synth import stereo
from data_synth.stereo import Rig, Scene, Surface, make_scene
from data_synth.textures import paint
from robot_perception import landmarks
from robot_perception.chapters.sift_association.views import PAPER
from robot_perception.evaluation.intervals import bootstrap_mean, bootstrap_ratio
from robot_perception.evaluation.sweep import sweep
from robot_perception.landmarks import detect
from robot_perception.teaching.claims import Finding, Size, claim
from robot_perception.teaching.results import kept
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted

SAME_PX, SAME_SIZE = 1.5, 1.4
"""A feature is found again within so many pixels of where it must be, its size within a factor."""

BESIDE = 0.02
"""Features nearer to each other than that are not two landmarks, m."""

REMARKABLE = 30.0
"""The paper's "significantly different viewpoints (e.g. 30 degrees apart)", °."""

SLIGHT = 5.0
"""Our reading of its "slightly different viewpoints", °."""


@dataclass(frozen=True, slots=True)
class Config:
    """30° is the paper's; all other values are ours. Distances in m, angles in degrees."""

    kinds: tuple[str, ...] = ("poster", "notices", "door", "books", "writing", "sign")
    distance: float = 2.0
    angles: tuple[float, ...] = field(default=(0, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60))
    across: bool = True


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Distances of descriptors, whose length is 512, by angle.

    ``same`` is the mean distance to the same point's descriptor from straight ahead, ``again`` the
    share of the features that are found again, ``other`` the distance to the nearest other feature
    of the picture. At 0° light and noise alone differ, as they do between two copies of a picture.
    """

    angles: Float[np.ndarray, " k"]
    same: Float[np.ndarray, " k"]
    again: Float[np.ndarray, " k"]
    other: float
    features: int


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Go round pictures of each kind."""
    return record(config, int(rng.integers(2**31)))


@kept
def record(config: Config, seed: int) -> Result:
    """Render the pictures from all angles and find the same features again."""
    own = np.random.default_rng(seed).spawn(len(config.kinds))
    done = [_picture(kind, config, rng) for kind, rng in zip(config.kinds, own, strict=True)]
    many = np.array([one["features"] for one in done])
    found = np.stack([one["found"] for one in done])
    total = np.stack([one["same"] for one in done]).sum(axis=0)
    return Result(
        np.array(config.angles, dtype=float),
        total / np.maximum(found.sum(axis=0), 1),
        found.sum(axis=0) / many.sum(),
        float(sum(one["other"] for one in done) / many.sum()),
        int(many.sum()),
    )


def _picture(kind: str, config: Config, rng: np.random.Generator) -> Mapping[str, np.ndarray]:
    rig, scene = Rig(), hang(paint(kind, rng=rng))
    first, points = seen_ahead(scene, rig, config, rng=rng)
    found, same = [], []
    for angle in config.angles:
        pose = stand(angle, config)
        seen = detect(stereo.render(scene, rig, pose, exposure=0.9, rng=rng).left)
        pairs = found_again(first, stereo.project(rig, pose, points), seen, config.distance)
        gaps = first.descriptors[pairs[:, 0]] - seen.descriptors[pairs[:, 1]]
        found.append(len(pairs))
        same.append(np.linalg.norm(gaps, axis=1).sum())
    between = landmarks.Euclidean(first.descriptors.astype(float)).distances(first.descriptors)
    between[np.linalg.norm(points[:, None] - points, axis=-1) < BESIDE] = np.inf
    return {
        "features": np.array(len(first)),
        "found": np.array(found),
        "same": np.array(same),
        "other": np.array(np.sqrt(between.min(axis=1)).sum()),
    }


def hang(picture: np.ndarray) -> Scene:
    """Return a picture in empty space at the height of the eyes, its middle at the origin."""
    rig, wide = Rig(), 1.6
    high = wide * min(picture.shape[0] / picture.shape[1], 1.0)
    wide = high * picture.shape[1] / picture.shape[0]
    corner = np.array([0.0, wide / 2, rig.height + high / 2])
    edges = np.array([0.0, -wide, 0.0]), np.array([0.0, 0.0, -high])
    return make_scene([Surface(corner, *edges, 0)], [picture])


def seen_ahead(
    scene: Scene, rig: Rig, config: Config, *, rng: np.random.Generator
) -> tuple[landmarks.Features, Float[np.ndarray, "n 3"]]:
    """Return the features of a picture seen from straight ahead, and where they lie, m."""
    pose = stand(0.0, config)
    first = detect(stereo.render(scene, rig, pose, rng=rng).left)
    sight = stereo.surface_points(scene, rig, pose, first.pixels)
    hit = sight.surfaces >= 0
    return first[hit], sight.points[hit]


def stand(angle: float, config: Config) -> Float[np.ndarray, "3"]:
    """Return the pose of a robot that looks at the origin from an angle (°) aside."""
    phi = np.deg2rad(angle)
    return np.array([-config.distance * np.cos(phi), config.distance * np.sin(phi), -phi])


def found_again(
    first: landmarks.Features, at: np.ndarray, seen: landmarks.Features, distance: float
) -> np.ndarray:
    """Return pairs of features that lie where they must, with like size: the nearest of each."""
    if not len(first) or not len(seen):
        return np.empty((0, 2), dtype=int)
    gaps = np.linalg.norm(at[:, None, :2] - seen.pixels, axis=-1)
    ratio = seen.scales * at[:, 2:] / (first.scales[:, None] * distance)
    turn = seen.angles - first.angles[:, None]
    turned = np.abs((turn + np.pi) % (2 * np.pi) - np.pi)
    bad = (gaps > SAME_PX) | (np.abs(np.log(ratio)) > np.log(SAME_SIZE)) | (turned > np.pi / 6)
    gaps[bad] = np.inf
    best = gaps.argmin(axis=1)
    rows = np.flatnonzero(np.isfinite(gaps[np.arange(len(first)), best]))
    return np.stack([rows, best[rows]], axis=1)


@claim(
    "viewpoint",
    paper=PAPER,
    place="§4",
    basis="substitute",
    statement="Seen from viewpoints 30° apart, the descriptors of a point differ remarkably.",
    paper_value="no number",
    method="Pictures of six kinds in empty space, a camera that goes round them: mean distance of "
    f"the descriptors of one point {REMARKABLE:g}° apart, over that of two look-alikes from one "
    "viewpoint, which differ in light and noise.",
    accepted=Accepted(
        1.5,
        np.inf,
        "the paper's consequence is that look-alikes are confused: the landmark itself must be "
        "clearly farther from its own class than a look-alike is from the old viewpoint; the ratio "
        "of 30° to 5° stands beside and meets it, too",
        "our choice",
    ),
    seed=22,
)
def viewpoint(size: Size, rng: np.random.Generator) -> Finding:
    """Compare distances over angles with those between landmarks."""
    config, repeats = (Config(), 10) if size is Size.FULL else (Config(angles=(0, 5, 30)), 3)
    done = sweep(_run, [config] * repeats, rng=rng, desc="viewpoint")
    slight, large = (_at(done, angle) for angle in (SLIGHT, REMARKABLE))
    other, alike = np.array([one.other for one in done]), _at(done, 0.0)
    rows = {
        f"{angle:g}°": (
            bootstrap_mean(np.array([r.same[k] for r in done])),
            bootstrap_mean(np.array([r.again[k] for r in done])),
        )
        for k, angle in enumerate(config.angles)
    }
    columns = {
        "distance": "of the descriptors of one point, of length 512",
        "found": "share of the features that are found again",
    }
    about = f"mean and 95 % bootstrap interval over {repeats} sets of pictures"
    return Finding(
        bootstrap_ratio(large, alike, "30° apart over look-alikes"),
        {
            "distance, 30° over 5°": bootstrap_ratio(large, slight, "30° over 5°"),
            "distance at 5°": bootstrap_mean(slight),
            "distance at 30°": bootstrap_mean(large),
            "distance to the nearest other landmark": bootstrap_mean(other),
            "distance between look-alikes": bootstrap_mean(alike),
        },
        {"distance by angle": Table(rows, columns, about, "viewpoint")},
        note=f"Of length 512, the descriptors of a point differ by {slight.mean():.0f} between "
        f"viewpoints {SLIGHT:g}° apart, by {large.mean():.0f} between viewpoints {REMARKABLE:g}° "
        f"apart, those of two look-alikes from one viewpoint by {alike.mean():.0f}, and those of a "
        f"point and its nearest other in the picture by {other.mean():.0f}.",
    )


def _at(results: list[Result], angle: float) -> np.ndarray:
    k = int(np.abs(results[0].angles - angle).argmin())
    return np.array([one.same[k] for one in results])


def _run(config: Config, *, rng: np.random.Generator) -> Result:
    return run(config, rng=rng)


@viewpoint.sabotage("a camera that stays where it was and looks again")
def unmoved(size: Size, rng: np.random.Generator) -> Finding:
    """Let all viewpoints be the same."""
    done = sweep(_run, [Config(angles=(0.0, 0.0))] * 3, rng=rng)
    again, alike = (np.array([one.same[k] for one in done]) for k in (1, 0))
    return Finding(bootstrap_ratio(again, alike, "30° apart over look-alikes"))
