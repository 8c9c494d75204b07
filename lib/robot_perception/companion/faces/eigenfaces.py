r"""Eigenfaces: faces as points of a space of few dimensions, and who is near.

A face is a vector :math:`\Gamma` of pixels. From the mean :math:`\Psi` of the gallery it differs
by :math:`\Phi = \Gamma - \Psi`; the eigenimages :math:`u_k` are the directions in which the gallery
varies most, and :math:`\omega_k = u_k^\top \Phi` describes the face:

.. math::
    \hat\Phi = \sum_k \omega_k u_k, \qquad
    \epsilon = \lVert \Phi - \hat\Phi \rVert, \qquad
    \epsilon_i = \lVert \omega - \omega^{(i)} \rVert

:math:`\epsilon` is the distance from face space, :math:`\epsilon_i` that to a picture of the
gallery in it. Who is far from face space is no face, who is far from everybody in it is unknown.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Annotated, Any, final

import numpy as np
from jaxtyping import Float

from robot_perception import checks
from robot_perception.fields import above_zero, checked, not_empty

__all__ = ["Eigenfaces", "Recognition", "enrol"]

SMALLEST = 1e-9
"""Share of the largest variation of a gallery below which a direction is left out."""
ROUNDING = 1e-14
"""Share of a picture's values and length that is not to be trusted; of a square, of the square."""

Faces = Float[np.ndarray, "n rows columns"]
Face = Float[np.ndarray, "rows columns"]


@final
@dataclass(frozen=True, eq=False, slots=True)
class Recognition:
    """Result of recognising a face.

    Parameters
    ----------
    name
        The person, ``None`` if it is unknown or no face.
    nearest
        The nearest person, known or not.
    distance
        To the nearest picture in face space, in the measure of `Eigenfaces`.
    from_space
        Distance from face space, root mean square of a pixel.
    descriptor : (k,)
        Of the face.
    """

    name: str | None
    nearest: str
    distance: float
    from_space: float
    descriptor: Float[np.ndarray, " k"]


def _threshold(name: str, value: Any) -> float:
    """Return a number of at least 0, which may be infinite."""
    found = checks.number(name, value, finite=False)
    if not found >= 0:
        raise ValueError(f"{name} must not be negative, got {checks.shown(value)}")
    return found


@final
@dataclass(frozen=True, eq=False, slots=True)
class Eigenfaces:
    """A gallery in its face space.

    Parameters
    ----------
    mean : (rows, columns)
        The mean face.
    images : (k, rows, columns)
        The eigenimages, orthonormal, by falling variance.
    deviations : (k,)
        Standard deviation of the gallery along each.
    names
        The person of each picture of the gallery.
    descriptors : (n, k)
        Of each picture of the gallery.
    whiten
        Whether distances in face space are measured in the deviations of each direction, so that
        light, which varies most, counts no more than the rest. Turk and Pentland measure without.
    most_distance, most_from_space
        Beyond which a face is unknown, and no face; infinite unless learnt, see `enrol`.

    Raises
    ------
    ValueError
        If there are not as many names as descriptors, or none.

    References
    ----------
    Turk and Pentland, "Face recognition using eigenfaces", CVPR 1991; section III of the paper,
    which asks for 20 eigenimages.
    """

    mean: Annotated[Face, not_empty]
    images: Float[np.ndarray, "k rows columns"]
    deviations: Annotated[Float[np.ndarray, " k"], above_zero]
    names: tuple[str, ...]
    descriptors: Float[np.ndarray, "n k"]
    whiten: bool = False
    most_distance: Annotated[float, _threshold] = np.inf
    most_from_space: Annotated[float, _threshold] = np.inf
    _flat: np.ndarray = field(init=False, repr=False)

    def __post_init__(self) -> None:
        checked(self)
        names, count = len(self.names), len(self.descriptors)
        if not names or names != count:
            raise ValueError(f"names must be {count}, as the descriptors, got {names}")
        object.__setattr__(self, "_flat", self.images.reshape(len(self.images), -1))

    @classmethod
    def learn(
        cls, faces: Faces, names: Sequence[str], count: int = 20, *, whiten: bool = False
    ) -> "Eigenfaces":
        """Return the face space of a gallery, by singular value decomposition.

        Parameters
        ----------
        faces : (n, rows, columns)
            Pictures of one size.
        names
            Whose each is.
        count
            How many eigenimages, less than n; those without variance are left out.
        whiten
            See `Eigenfaces`.

        Raises
        ------
        ValueError
            If there are fewer than two pictures, all are the same, the names are not as many, or
            there are not so many eigenimages.
        """
        faces = checks.array("faces", faces, ("n", "rows", "columns"))
        checks.moderate("faces", faces, 1e9)
        names = checks.instances("names", tuple(checks.iterable("names", names)), str)
        if len(faces) < 2:
            raise ValueError(f"faces must be two at least, got {len(faces)}")
        if len(names) != len(faces):
            raise ValueError(f"names must be {len(faces)}, as the faces, got {len(names)}")
        count = checks.whole("count", count, 1, len(faces) - 1)
        if _are_alike(faces):
            raise ValueError("faces must differ, got the same picture throughout")
        mean = faces.mean(axis=0)
        centred = (faces - mean).reshape(len(faces), -1)
        _, singular, directions = np.linalg.svd(centred, full_matrices=False)
        deviations = singular / np.sqrt(len(faces) - 1)
        kept = min(count, int((singular > SMALLEST * singular[0]).sum()))
        flat = directions[:kept]
        flat = flat * np.where(flat.sum(axis=1) < 0, -1.0, 1.0)[:, None]  # one of two signs
        return cls(
            mean,
            flat.reshape(kept, *mean.shape),
            deviations[:kept],
            names,
            centred @ flat.T,
            whiten,
        )

    @property
    def people(self) -> tuple[str, ...]:
        """Everybody in the gallery."""
        return tuple(dict.fromkeys(self.names))

    def describe(self, face: Face) -> Float[np.ndarray, " k"]:
        """Return the descriptor of a face.

        Raises
        ------
        ValueError
            If the face is of another size, or not finite.
        """
        return self._flat @ self._centred(face)

    def rebuild(self, face: Face, count: int | None = None) -> Face:
        """Return what the first eigenimages make of a face.

        Parameters
        ----------
        face : (rows, columns)
            Of the gallery's size.
        count
            How many are taken, from 0, which gives the mean face, on; all if not given.

        Raises
        ------
        ValueError
            If the face is of another size, or there are not so many eigenimages.
        """
        count = len(self.images) if count is None else count
        count = checks.whole("count", count, 0, len(self.images))
        flat = self._flat[:count]
        return self.mean + (self.describe(face)[:count] @ flat).reshape(self.mean.shape)

    def recognise(self, face: Face) -> Recognition:
        """Return who a face is.

        Raises
        ------
        ValueError
            If the face is of another size, or not finite.
        """
        centred = self._centred(face)
        descriptor = self._flat @ centred
        left = centred @ centred - descriptor @ descriptor
        from_space = float(np.sqrt(max(left, 0.0) / centred.size))
        distances = self.distances(descriptor)
        nearest = int(distances.argmin())
        distance, name = float(distances[nearest]), self.names[nearest]
        known = distance <= self.most_distance and from_space <= self.most_from_space
        return Recognition(name if known else None, name, distance, from_space, descriptor)

    def distances(self, descriptor: Float[np.ndarray, " k"]) -> Float[np.ndarray, " n"]:
        """Return the distance of a descriptor to each picture of the gallery.

        Raises
        ------
        ValueError
            If it has another length, or is not finite.
        """
        descriptor = checks.vector("descriptor", descriptor, len(self.images))
        unit = self.deviations if self.whiten else 1.0
        apart = (self.descriptors - descriptor) / unit
        return np.sqrt((apart**2).mean(axis=1))

    def _centred(self, face: Face) -> np.ndarray:
        return (checks.array("face", face, self.mean.shape) - self.mean).ravel()


def enrol(
    faces: Faces,
    names: Sequence[str],
    count: int = 20,
    *,
    accepted: float = 0.95,
    folds: int = 5,
    whiten: bool = False,
) -> Eigenfaces:
    """Return a gallery that knows beyond which distances it knows nobody.

    The pictures are left out in turn, each fold of them by a face space of the others. How far they
    then lie from the nearest picture of the same person, and from face space, is how far a new
    picture of a known person lies; both thresholds accept the same share of these. Of one person
    with two pictures the other one alone is no space: both thresholds then are how far the two are
    apart.

    Parameters
    ----------
    faces, names, count, whiten
        As of `Eigenfaces.learn`; two pictures a person at least.
    accepted
        Share of the pictures left out that either threshold accepts.
    folds
        Into how many parts each person's pictures are cut, in their order: pictures of a film that
        follow each other are alike, and in parts that are dealt each would have its twin.

    Returns
    -------
    Eigenfaces
        Of all pictures.

    Raises
    ------
    ValueError
        As `Eigenfaces.learn`; also if a person has one picture only, by name, or a share or a
        number of folds is out of range.

    References
    ----------
    Turk and Pentland name two thresholds and no rule for them; this one is ours.
    """
    accepted, folds = checks.share("accepted", accepted), checks.whole("folds", folds, 2, 1000)
    model = Eigenfaces.learn(faces, names, count, whiten=whiten)
    faces, whose = np.asarray(faces, dtype=float), np.array(model.names)
    alone = [name for name in model.people if (whose == name).sum() < 2]
    if alone:
        raise ValueError(f"names must have two pictures a person at least, one only of {alone}")
    turn = np.empty(len(whose), dtype=int)
    for name in model.people:
        mine = np.flatnonzero(whose == name)
        turn[mine] = np.arange(len(mine)) * min(folds, len(mine)) // len(mine)
    distances, from_space = [], []
    for fold in range(turn.max() + 1):
        others = turn != fold
        part = min(count, int(others.sum()) - 1)
        if _are_alike(faces[others]):
            for k in np.flatnonzero(~others):
                distances.append(model.distances(model.descriptors[k])[others].min())
                from_space.append(np.sqrt(np.mean((faces[k] - faces[others][0]) ** 2)))
            continue
        space = Eigenfaces.learn(faces[others], list(whose[others]), part, whiten=whiten)
        for k in np.flatnonzero(~others):
            found = space.recognise(faces[k])
            same = np.array(space.names) == whose[k]
            distances.append(space.distances(found.descriptor)[same].min())
            from_space.append(found.from_space)
    length, pixels = np.linalg.norm(faces, axis=(1, 2)).max(), faces[0].size
    return replace(  # at least what rounding makes of a picture that is in the gallery
        model,
        most_distance=float(max(np.quantile(distances, accepted), ROUNDING * length)),
        most_from_space=float(
            max(np.quantile(from_space, accepted), np.sqrt(ROUNDING / pixels) * length)
        ),
    )


def _are_alike(faces: Faces) -> bool:
    """Return whether pictures are the same but for rounding."""
    return bool(np.abs(faces - faces[0]).max() <= ROUNDING * np.abs(faces).max())
