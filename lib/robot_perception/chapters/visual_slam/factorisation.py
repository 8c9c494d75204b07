"""Eq. (2): given the path, the landmarks are independent, and each map is the exact one."""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float, Int

from robot_perception.chapters.visual_slam import drives, frontend
from robot_perception.chapters.visual_slam.drives import Drive, Options
from robot_perception.chapters.visual_slam.maps import PAPER
from robot_perception.evaluation.intervals import exact
from robot_perception.geometry import se3
from robot_perception.teaching.claims import Finding, Size, claim
from robot_perception.teaching.verdicts import Accepted


@dataclass(frozen=True, slots=True)
class Config:
    """The beginning of the drive, with resampling; all is ours."""

    film: frontend.Config = frontend.PAPER
    options: Options = drives.TEN


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Deviation of each landmark of each particle from the exact map given its path.

    Parameters
    ----------
    means : (M, n)
        Of the place, in standard deviations.
    variances : (M, n)
        Of the variances, relative, the largest of three.
    drawn
        How often particles were drawn anew.
    """

    means: Float[np.ndarray, "M n"]
    variances: Float[np.ndarray, "M n"]
    drawn: int


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Run the filter, and work out each particle's map again from its path."""
    drive = _driven(config, rng)
    lineages = drive.lineage
    return _deviations(drive, lineages)


def _driven(config: Config, rng: np.random.Generator) -> Drive:
    wheel, own = rng.spawn(2)
    seen = frontend.seen(config.film)
    return drives.run(seen, config.options, drives.roll(seen.poses, rng=wheel), rng=own)


def _deviations(drive: Drive, lineages: Int[np.ndarray, "frames M"]) -> Result:
    """Compare the maps with those given the paths of some lineages."""
    means, covs = drive.maps.means, drive.maps.covs
    apart, wider = np.empty(means.shape[:2]), np.empty(means.shape[:2])
    for m, lineage in enumerate(lineages.T):
        path = drive.poses[np.arange(len(drive.poses)), lineage]
        place, cov = exact_map(drive, path)
        sigma = np.sqrt(np.diagonal(cov, axis1=1, axis2=2))
        apart[m] = (np.abs(means[m] - place) / sigma).max(axis=1)
        own = np.diagonal(covs[m], axis1=1, axis2=2)
        wider[m] = np.abs(own / sigma**2 - 1).max(axis=1)
    return Result(apart, wider, int(drive.drawn.sum()))


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


@claim(
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
    seed=43,
)
def factorisation(size: Size, rng: np.random.Generator) -> Finding:
    """Compare every landmark of every particle with the exact one."""
    result = run(Config(), rng=rng)
    return Finding(
        exact(_worst(result.means), "σ", "largest over all landmarks of all particles"),
        {
            "largest relative difference of a variance": exact(_worst(result.variances)),
            "landmarks compared": exact(float(result.means.size)),
            "times that particles were drawn anew": exact(float(result.drawn)),
        },
        note=f"{result.means.size} landmarks of {len(result.means)} particles.",
    )


def _worst(differences: np.ndarray) -> float:
    """Return the largest to eight decimals: what is below is the rounding of a processor."""
    return round(float(differences.max()), 8)


@factorisation.sabotage("the path of another particle, none drawn anew")
def another_path(size: Size, rng: np.random.Generator) -> Finding:
    """Give each particle the path of its neighbour; drawn anew, all would share one path."""
    drive = _driven(Config(options=replace(drives.TEN, share=0.0)), rng)
    result = _deviations(drive, np.roll(drive.lineage, 1, axis=1))
    return Finding(exact(float(result.means.max()), "σ"))
