"""Belief of the filter: weighted poses, and for each pose a map of its own."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception import checks
from robot_perception.beliefs import Gaussian, ParticleSet
from robot_perception.slam.rao_blackwellised import kernels

UPPER = np.triu_indices(3)
FULL = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])  # where an entry stands in the upper triangle


class ParticleMaps:
    r"""M particles, each a pose and N landmarks that are independent given its path.

    .. math:: S^{[m]} = \{s^{[m]}, \mu_1^{[m]}, \Sigma_1^{[m]}, …, \mu_N^{[m]}, \Sigma_N^{[m]}\}

    A belief is never changed: each step returns a new one, which shares with the old one what is
    the same in both. A landmark has a block with a row (mean and covariance) for each version of it
    that a particle holds, and the table says which row that is. Resampling copies numbers of rows
    and no map; an update writes new rows for the landmarks that were seen.

    Parameters
    ----------
    particles
        Poses (M, 3), m, m, rad, and their weights.
    ids : (N,)
        Identifiers of the landmarks, each at least 0.
    means : (M, N, 3)
        Landmarks of each particle in the world, m.
    covs : (M, N, 3, 3)
        Their covariances given the path of the particle, m².

    Attributes
    ----------
    particles
        Poses and weights.
    ids : (N,)
        Identifiers in the order of the map.

    Raises
    ------
    ValueError
        If the shapes disagree, a number is not finite, an identifier is no integer, negative or
        there twice, or a covariance is none.

    References
    ----------
    Gil, Payá, Reinoso, Fernández and Puerto, "Simultaneous localization and mapping in indoor
    environments using SIFT features", VIIP 2006, eqs (2) and (3).
    """

    __slots__ = ("blocks", "ids", "particles", "sizes", "slots", "table")

    def __init__(
        self,
        particles: ParticleSet,
        ids: Int[np.ndarray, "N"],
        means: Float[np.ndarray, "M N 3"],
        covs: Float[np.ndarray, "M N 3 3"],
    ) -> None:
        poses = checks.instance("particles", particles, ParticleSet).states
        checks.shaped("particles", poses, ("M", 3))
        ids = checks.integers("ids", ids, ("N",), 0)
        if len(set(ids.tolist())) < ids.size:
            raise ValueError(f"ids must differ, got {ids.tolist()}")
        size, beside = (len(poses), ids.size, 3), f"{len(poses)} particles and {ids.size} ids"
        means = checks.array("means", means, size, beside)
        covs = checks.covariance("covs", covs, (*size, 3), beside)
        rows = np.concatenate([means, covs[:, :, *UPPER]], axis=-1)
        _fill(
            self,
            particles,
            ids,
            {name: slot for slot, name in enumerate(ids.tolist())},
            np.tile(numbers(len(poses)), (ids.size, 1)),
            tuple(rows[:, n].copy() for n in range(ids.size)),
            np.full(ids.size, len(poses)),
        )

    @classmethod
    def start(cls, pose: Float[np.ndarray, "3"], count: int) -> "ParticleMaps":
        """Return so many particles at one pose (m, m, rad), with empty maps and equal weights."""
        pose, count = checks.vector("pose", pose, 3), checks.whole("count", count, 1)
        try:
            poses = np.tile(pose, (count, 1))
        except (MemoryError, ValueError):
            raise ValueError(
                f"count must be of particles that fit in memory, got {count}"
            ) from None
        ids, table = np.empty(0, dtype=np.int64), np.empty((0, count), dtype=numbers(count).dtype)
        return _made(ParticleSet.uniform(poses), ids, {}, table, (), ids)

    def __len__(self) -> int:
        """Return the number of particles."""
        return len(self.particles.states)

    @property
    def poses(self) -> Float[np.ndarray, "M 3"]:
        """Poses of the particles: m, m, rad."""
        return self.particles.states

    @property
    def pose(self) -> Float[np.ndarray, "3"]:
        """Weighted mean of the poses, that of the headings on the circle."""
        weights, headings = self.particles.weights, self.poses[:, 2]
        x, y = weights @ self.poses[:, :2]
        return np.array([x, y, np.arctan2(weights @ np.sin(headings), weights @ np.cos(headings))])

    @property
    def best(self) -> int:
        """Particle with the largest weight, the first of equals."""
        return int(np.argmax(self.particles.log_weights))

    @property
    def known(self) -> Bool[np.ndarray, "M N"]:
        """Mask of the landmarks that a particle has in its map: all do where names are shared."""
        return self.table.T >= 0

    @property
    def means(self) -> Float[np.ndarray, "M N 3"]:
        """Landmarks of each particle, m; NaN where it does not have one."""
        return self._rows()[..., :3]

    @property
    def covs(self) -> Float[np.ndarray, "M N 3 3"]:
        """Covariances of the landmarks given the path of each particle, m²; NaN likewise."""
        return self._rows()[..., 3:][..., FULL]

    @property
    def nbytes(self) -> int:
        """Memory of all maps: rows that some particle holds, and the table."""
        return self.table.nbytes + sum(block.nbytes for block in self.blocks)

    def landmarks(self, particle: int | np.integer) -> tuple[Int[np.ndarray, "n"], Gaussian]:
        """Return the map of one particle: identifiers (n,) and beliefs in their places, m.

        Raises
        ------
        ValueError
            If there is no such particle.
        """
        particle = checks.whole("particle", particle, 0, len(self) - 1)
        mine = np.flatnonzero(self.table[:, particle] >= 0)
        rows = np.empty((mine.size, kernels.ROW))
        for i, slot in enumerate(mine):
            rows[i] = self.blocks[slot][self.table[slot, particle]]
        return self.ids[mine], Gaussian(rows[:, :3], rows[:, 3:][:, FULL])

    def _rows(self) -> np.ndarray:
        rows = gathered(self, range(self.ids.size)).swapaxes(0, 1)
        return np.where(self.known[..., None], rows, np.nan)


def numbers(count: int) -> np.ndarray:
    """Return the numbers of so many rows, in as few bytes as can be."""
    return np.arange(count, dtype=np.int16 if count <= 2**15 else np.int32)


def gathered(maps: ParticleMaps, slots: Sequence[int]) -> np.ndarray:
    """Return copies of landmarks of all particles, (k, M, 9); zeros where one is not known."""
    rows = np.empty((len(slots), len(maps), kernels.ROW))
    for i, slot in enumerate(slots):
        kernels.fetch(maps.blocks[slot], maps.table[slot], rows[i])
    return rows


def with_particles(maps: ParticleMaps, poses: np.ndarray, log_weights: np.ndarray) -> ParticleMaps:
    """Return the same maps for other poses or weights."""
    return _made(
        trusted(poses, log_weights), maps.ids, maps.slots, maps.table, maps.blocks, maps.sizes
    )


def rewritten(
    maps: ParticleMaps, slots: list[int], rows: np.ndarray, log_weights: np.ndarray
) -> ParticleMaps:
    """Return the maps with landmarks of all particles, (k, M, 9), in place of old ones."""
    table, blocks, sizes = maps.table.copy(), list(maps.blocks), maps.sizes.copy()
    kernels.renumber(table, sizes, np.array(slots, dtype=np.int64))
    for slot, block in zip(slots, rows, strict=True):
        blocks[slot] = block.copy()  # by itself: a view would keep its neighbours alive
    particles = trusted(maps.poses, log_weights)
    return _made(particles, maps.ids, maps.slots, table, tuple(blocks), sizes)


def extended(
    maps: ParticleMaps, ids: Sequence[int], rows: np.ndarray, where: np.ndarray
) -> ParticleMaps:
    """Return the maps with new landmarks (k, M, 9), for the particles ``where`` (k, M)."""
    return _made(
        maps.particles,
        np.concatenate([maps.ids, np.asarray(ids, dtype=np.int64)]),
        {**maps.slots, **{name: maps.ids.size + i for i, name in enumerate(ids)}},
        np.concatenate(
            [maps.table, np.where(where, numbers(len(maps)), maps.table.dtype.type(-1))]
        ),
        maps.blocks + tuple(block.copy() for block in rows),
        np.concatenate([maps.sizes, np.full(len(ids), len(maps))]),
    )


def descended(maps: ParticleMaps, ancestors: np.ndarray) -> ParticleMaps:
    """Return the maps of particles drawn anew, of equal weights: each has the rows of its ancestor.

    A block is shortened when less than a quarter of its rows have a holder left.
    """
    table, blocks, sizes = np.empty_like(maps.table), list(maps.blocks), maps.sizes.copy()
    slots, counts, kept = kernels.inherited(maps.table, ancestors, sizes, table)
    sizes[slots] = counts
    begin = 0
    for slot, count in zip(slots.tolist(), counts.tolist(), strict=True):
        blocks[slot] = blocks[slot].take(kept[begin : begin + count], axis=0)
        begin += count
    particles = trusted(maps.poses[ancestors], np.full(len(maps), -np.log(len(maps))))
    return _made(particles, maps.ids, maps.slots, table, tuple(blocks), sizes)


def trusted(poses: np.ndarray, log_weights: np.ndarray) -> ParticleSet:
    """Return particles made by the filter itself, without the checks of the constructor."""
    particles = object.__new__(ParticleSet)
    object.__setattr__(particles, "states", poses)
    object.__setattr__(particles, "log_weights", log_weights)
    return particles


def _made(*parts: object) -> ParticleMaps:
    """Return a belief made by the filter itself, without the checks of the constructor."""
    return _fill(object.__new__(ParticleMaps), *parts)


def _fill(
    maps: ParticleMaps,
    particles: ParticleSet,
    ids: np.ndarray,
    slots: dict[int, int],
    table: np.ndarray,
    blocks: tuple[np.ndarray, ...],
    sizes: np.ndarray,
) -> ParticleMaps:
    maps.particles, maps.ids, maps.slots = particles, ids, slots
    maps.table, maps.blocks, maps.sizes = table, blocks, sizes
    return maps
