"""Eq. (2): given the path, the landmarks are independent, and each map is the exact one."""

import numpy as np
from jaxtyping import Float

from robot_perception.chapters.visual_slam import drives, frontend
from robot_perception.chapters.visual_slam.drives import Drive, Options
from robot_perception.chapters.visual_slam.maps import PAPER
from robot_perception.evaluation.intervals import exact
from robot_perception.geometry import se3
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted

Deviations = tuple[Float[np.ndarray, "M n"], Float[np.ndarray, "M n"], int]
"""How far each landmark of each particle is from the exact map given the path: its place, in
standard deviations, its variances, relative; and how often particles were drawn anew."""


def run(options: Options, *, rng: np.random.Generator) -> Deviations:
    """Run the filter, and work out each particle's map again from its path."""
    drive = _driven(options, rng)
    return _deviations(drive, drive.paths())


def on_another_path(options: Options, *, rng: np.random.Generator) -> Deviations:
    """Give each particle the path of its neighbour; drawn anew, all would share one path."""
    drive = _driven(options, rng)
    return _deviations(drive, np.roll(drive.paths(), 1, axis=1))


def _driven(options: Options, rng: np.random.Generator) -> Drive:
    wheel, own = rng.spawn(2)
    seen = frontend.seen()
    return drives.run(seen, options, drives.roll(seen.poses, rng=wheel), rng=own)


def _deviations(drive: Drive, paths: Float[np.ndarray, "frames M 3"]) -> Deviations:
    """Compare the maps with those given some paths."""
    places, covs = map(
        np.array, zip(*(exact_map(drive, path) for path in paths.swapaxes(0, 1)), strict=True)
    )
    variances, own = (np.diagonal(c, axis1=-2, axis2=-1) for c in (covs, drive.maps.covs))
    return (
        (np.abs(drive.maps.means - places) / np.sqrt(variances)).max(axis=-1),
        np.abs(own / variances - 1).max(axis=-1),
        int(drive.drawn.sum()),
    )


def exact_map(
    drive: Drive, path: Float[np.ndarray, "frames 3"]
) -> tuple[Float[np.ndarray, "n 3"], Float[np.ndarray, "n 3 3"]]:
    r"""Return the map given a path, from all observations of each landmark at once.

    .. math:: \Sigma^{-1} = \sum_i S_i^{-1}, \qquad \Sigma^{-1} \mu = \sum_i S_i^{-1} p_i

    with :math:`p_i = R v_i + t` the observed points in the world and :math:`S_i = R Q_i R^\top`.
    """
    seen, rows = drive.seen, drive.rows
    T = se3.compose(se3.from_se2(path), frontend.RIG.T_robot_camera)[seen.frames[rows]]
    points = (T[:, :3, :3] @ seen.points[rows][..., None])[..., 0] + T[:, :3, 3]
    weights = np.linalg.inv(
        T[:, :3, :3] @ (drive.options.noise**2 * seen.covs[rows]) @ T[:, :3, :3].mT
    )
    information = np.zeros((len(drive.places), 3, 3))
    vector = np.zeros((len(drive.places), 3))
    np.add.at(information, drive.names, weights)
    np.add.at(vector, drive.names, (weights @ points[..., None])[..., 0])
    cov = np.linalg.inv(information)
    return (cov @ vector[..., None])[..., 0], cov


EXACT = Study(run, full=Options(), quick=Options(), seed=43)


@EXACT.claim(
    "factorisation",
    paper=PAPER,
    place="§3.2, eq. 2",
    basis="mathematics",
    statement="The posterior is that of the path times one of each landmark given the path, "
    "so that the map of a particle is the exact map given the path of the particle.",
    method="The drive with ten particles, resampled as in the paper: for each particle the "
    "landmarks are worked out again, all observations at once, from the path that its lineage "
    "gives. Largest difference of a coordinate, in standard deviations, to eight decimals.",
    accepted=Accepted(0.0, 1e-6, "equal but for rounding"),
    sabotage=Change("the path of another particle, none drawn anew", on_another_path, share=0.0),
)
def factorisation(deviations: Deviations) -> Finding:
    """Compare every landmark of every particle with the exact one."""
    means, variances, drawn = deviations
    return Finding(
        exact(_worst(means), "σ", "largest over all landmarks of all particles"),
        {
            "largest relative difference of a variance": exact(_worst(variances)),
            "landmarks compared": exact(float(means.size)),
            "times that particles were drawn anew": exact(float(drawn)),
        },
        note=f"{means.size} landmarks of {len(means)} particles.",
    )


def _worst(differences: np.ndarray) -> float:
    """Return the largest to eight decimals: what is below is the rounding of a processor."""
    return round(float(differences.max()), 8)
