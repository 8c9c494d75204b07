"""Features followed from frame to frame: what stays visible long enough to be a landmark."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields, replace
from itertools import repeat
from typing import Annotated

import numpy as np
from jaxtyping import Bool, Float, Int, UInt8

from robot_perception import checks
from robot_perception.cameras import Pinhole, StereoRig
from robot_perception.fields import Positive, at_least, checked, from_to
from robot_perception.geometry import se3
from robot_perception.landmarks.classes import DescriptorClasses
from robot_perception.landmarks.features import Features
from robot_perception.landmarks.matching import match_window
from robot_perception.landmarks.stereo import StereoPoints, StereoRules, check_both, observe
from robot_perception.observations import Observations

RULES = StereoRules()


@dataclass(frozen=True, slots=True)
class TrackRules:
    """Rules by which a feature continues one of the frame before. The values are our choice.

    Parameters
    ----------
    window
        Largest distance from where it is expected, in u and in v, px.
    threshold
        Largest Euclidean distance between their descriptors, whose length is 512.

    Raises
    ------
    ValueError
        If a number is not positive.
    """

    window: Positive = 12.0
    threshold: Positive = 200.0
    __post_init__ = checked


@dataclass(frozen=True, eq=False, slots=True)
class Tracks:
    """The track that each feature of the latest frame belongs to.

    A track is a feature seen in consecutive frames; it ends with the first frame that misses it. So
    those that go on are as many as the latest frame has features, in the same order.

    Parameters
    ----------
    ids : (n,)
        Numbers of the tracks, by when they began.
    origins : (n,)
        Row of the same track in the frame before; -1 where the track begins.
    classes
        The descriptors of each track so far, n classes; their number is the track's length.
    begun
        How many tracks have begun so far.
    """

    ids: Int[np.ndarray, " n"]
    origins: Int[np.ndarray, " n"]
    classes: DescriptorClasses
    begun: Annotated[int, from_to(0)]

    def __post_init__(self) -> None:
        checked(self)
        checks.shaped("classes", self.classes.counts, self.ids.shape, beside="ids")

    def __len__(self) -> int:
        return len(self.ids)

    @classmethod
    def start(cls, features: Features) -> "Tracks":
        """Return the tracks that begin with the features of a first frame.

        Parameters
        ----------
        features
            Of the first frame.
        """
        n = len(checks.instance("features", features, Features))
        classes = DescriptorClasses.of(features.descriptors)
        return cls(np.arange(n), np.full(n, -1), classes, n)

    def stable(self, frames: int = 5) -> Bool[np.ndarray, " n"]:
        """Tell which tracks are landmarks: those of more than so many frames.

        Parameters
        ----------
        frames
            The paper's 5.

        Raises
        ------
        ValueError
            If ``frames`` is not a whole number of at least 0.

        References
        ----------
        Gil et al. (2006), §5.
        """
        return self.classes.counts > checks.whole("frames", frames, 0)


@dataclass(frozen=True, eq=False, slots=True)
class FeatureTrack:
    """One track, from its first frame to its last.

    Parameters
    ----------
    number
        Its number, by when it began.
    begin
        Its first frame.
    rows : (p,)
        Which of the features of each frame it is.
    features
        These p features.
    """

    number: int
    begin: int
    rows: Int[np.ndarray, " p"]
    features: Features

    def __len__(self) -> int:
        return len(self.rows)


def predict_pixels(
    points: Float[np.ndarray, "n 3"], T_now_before: Float[np.ndarray, "4 4"], camera: Pinhole
) -> Float[np.ndarray, "n 2"]:
    """Return where points will be seen after a motion.

    Parameters
    ----------
    points : (n, 3)
        In the frame of the camera before the motion, m.
    T_now_before : (4, 4)
        Pose of the camera before the motion in its frame after it.
    camera
        The camera.

    Returns
    -------
    (n, 2)
        u and v, px, within the image or not; infinite for points that are no longer ahead.

    Raises
    ------
    TypeError
        If ``camera`` is none.
    ValueError
        If the shapes are others, a number is not finite or ``T_now_before`` is no rigid motion.
    """
    points = checks.array("points", points, ("n", 3))
    T_now_before = se3.checked("T_now_before", T_now_before)
    checks.shaped("T_now_before", T_now_before, (4, 4))
    moved = se3.act(T_now_before, points)
    ahead = moved[:, 2] > 0
    pixels = np.full((len(points), 2), np.inf)
    pixels[ahead] = checks.instance("camera", camera, Pinhole).project(moved[ahead])
    return pixels


def extend(
    tracks: Tracks,
    before: Features,
    after: Features,
    rules: TrackRules = TrackRules(),
    *,
    predicted: Float[np.ndarray, "n 2"] | None = None,
) -> Tracks:
    """Return the tracks one frame later: those that go on, and those that begin.

    A feature goes on with the one whose descriptor is nearest to its own, both ways, among those
    near the place where it is expected.

    Parameters
    ----------
    tracks
        Tracks of the n features of ``before``.
    before, after
        Features of two consecutive frames.
    rules
        Window and threshold.
    predicted : (n, 2)
        Where the features of ``before`` are expected in the later frame, px, for instance by
        `predict_pixels`; infinite where nowhere. Without it, where they were.

    Returns
    -------
    Tracks
        Tracks of the features of ``after``.

    Raises
    ------
    TypeError
        If an argument is of another type.
    ValueError
        If ``tracks`` are not of ``before``, descriptors have another length or ``predicted``
        another shape, or holds a NaN.
    """
    check_both(before=before, after=after)
    n = len(checks.instance("tracks", tracks, Tracks))
    if n != len(before):
        raise ValueError(f"tracks must be of the {len(before)} features of before, got {n}")
    checks.instance("rules", rules, TrackRules)
    expected = before.pixels
    if predicted is not None:
        expected = _places("predicted", predicted, n)
    side = rules.window
    first, second = match_window(before, expected, after, (-side, side), side, rules.threshold).T
    origins = np.full(len(after), -1)
    origins[second] = first
    new = np.flatnonzero(origins < 0)
    ids = np.empty(len(after), dtype=int)
    ids[second] = tracks.ids[first]
    ids[new] = tracks.begun + np.arange(len(new))
    classes = tracks.classes[first].updated(np.arange(len(first)), after.descriptors[second])
    fresh = DescriptorClasses.of(after.descriptors[new])
    order = np.argsort(np.concatenate([second, new]))
    return Tracks(ids, origins, classes.with_others(fresh)[order], tracks.begun + len(new))


@dataclass(frozen=True, eq=False, slots=True)
class Missed:
    """Tracks that a pair of pictures does not show, and that may go on in a later one.

    Parameters
    ----------
    ids : (k,)
        Their numbers.
    frames : (k,)
        How many pairs in a row missed each so far.
    points : (k, 3)
        Where they should be, in the frame of the left camera now, m.
    features
        How they looked when they were seen last: k features.
    classes
        The descriptors of each track so far.
    """

    ids: Int[np.ndarray, " k"]
    frames: Annotated[Int[np.ndarray, " k"], at_least(0)]
    points: Float[np.ndarray, "k 3"]
    features: Features
    classes: DescriptorClasses

    def __post_init__(self) -> None:
        checked(self)
        for name, count in (("features", len(self.features)), ("classes", len(self.classes))):
            if count != len(self):
                raise ValueError(f"{name} must be of {len(self)} tracks, got {count}")

    def __len__(self) -> int:
        return len(self.ids)


@dataclass(frozen=True, eq=False, slots=True)
class Sighting:
    """Observation of a pair of pictures: points in space, and the track that each belongs to.

    Parameters
    ----------
    points
        n points with covariances, in the frame of the left camera.
    tracks
        Their tracks.
    missed
        Tracks of earlier pairs that may still go on; ``None`` where none is waited for.
    """

    points: StereoPoints
    tracks: Tracks
    missed: Missed | None = None
    __post_init__ = checked

    @property
    def observations(self) -> Observations:
        """The points with their covariances, named by the numbers of their tracks."""
        return self.points.observations.named(self.tracks.ids)

    @property
    def descriptors(self) -> Float[np.ndarray, "n d"]:
        """Descriptor of each, in double precision."""
        return self.points.descriptors


def sight(
    before: Sighting | None,
    left: UInt8[np.ndarray, "height width"],
    right: UInt8[np.ndarray, "height width"],
    rig: StereoRig,
    T_now_before: Float[np.ndarray, "4 4"],
    *,
    rules: StereoRules = RULES,
    track_rules: TrackRules = TrackRules(),
    patience: int = 0,
) -> Sighting:
    """Return what the next pair of a drive shows: `observe`, `predict_pixels` and `extend` in one.

    A track that a pair misses may be waited for. It is looked for where its point should be, and
    goes on with the feature that looks like it, as if it had not been missed.

    Parameters
    ----------
    before
        What the pair before it showed; ``None`` for the first.
    left, right
        Grey pictures of a rectified pair.
    rig
        The cameras.
    T_now_before : (4, 4)
        Pose of the left camera at the pair before in its frame now, for instance by the wheels.
    rules, track_rules
        What counts as a match of left and right, and of now and before.
    patience
        How many pairs in a row may miss a track. Ours, as is waiting: a track of the paper is seen
        in "consecutive frames".

    Raises
    ------
    TypeError
        If an argument is of another type.
    ValueError
        If a picture is not grey or not of the rig's size, ``T_now_before`` no rigid motion, or
        ``patience`` no whole number of at least 0.
    """
    checks.instance("track_rules", track_rules, TrackRules)
    patience = checks.whole("patience", patience, 0)
    points = observe(left, right, rig, rules=rules)
    if before is None:
        return Sighting(points, Tracks.start(points.features))
    old = _remembered(checks.instance("before", before, Sighting))
    predicted = predict_pixels(old.points, T_now_before, rig.camera)
    known = Tracks(old.ids, np.full(len(old), -1), old.classes, before.tracks.begun)
    tracks = extend(known, old.features, points.features, track_rules, predicted=predicted)
    waiting = old.frames < patience
    waiting[tracks.origins[tracks.origins >= 0]] = False
    missed = _waited_for(old, waiting, T_now_before) if waiting.any() else None
    latest = tracks.origins < len(before.tracks)
    return Sighting(points, replace(tracks, origins=np.where(latest, tracks.origins, -1)), missed)


def _remembered(before: Sighting) -> Missed:
    """Return all tracks that may go on: those of the latest pair, and after them the missed."""
    points, tracks = before.points, before.tracks
    none, own = np.zeros(len(tracks), dtype=int), points.points.mean
    latest, missed = Missed(tracks.ids, none, own, points.features, tracks.classes), before.missed
    if missed is None:
        return latest
    return Missed(
        np.concatenate([latest.ids, missed.ids]),
        np.concatenate([latest.frames, missed.frames]),
        np.concatenate([latest.points, missed.points]),
        _joined(latest.features, missed.features),
        latest.classes.with_others(missed.classes),
    )


def _waited_for(
    old: Missed, rows: Bool[np.ndarray, " k"], T_now_before: Float[np.ndarray, "4 4"]
) -> Missed:
    """Return some tracks, missed once more, as they should be seen after a motion."""
    points = se3.act(T_now_before, old.points[rows])
    frames = old.frames[rows] + 1
    return Missed(old.ids[rows], frames, points, old.features[rows], old.classes[rows])


def follow(
    frames: Iterable[Features],
    rules: TrackRules = TrackRules(),
    *,
    predictions: Iterable[Float[np.ndarray, "n 2"] | None] = (),
) -> list[FeatureTrack]:
    """Return all tracks of a sequence, by when they began.

    Parameters
    ----------
    frames
        Features of consecutive frames.
    rules
        Window and threshold.
    predictions
        For each frame but the last, where its features are expected in the next, as of `extend`; of
        frames beyond the last prediction, where they were.

    Raises
    ------
    TypeError
        If ``frames`` holds something else than features.
    ValueError
        If a prediction does not fit its frame.
    """
    checks.instance("rules", rules, TrackRules)
    expected = _endless(checks.iterable("predictions", predictions))
    rows: list[list[int]] = []
    begins: list[int] = []
    seen: list[Features] = []
    for k, features in enumerate(checks.iterable("frames", frames)):
        checks.instance(f"frames[{k}]", features, Features)
        if k == 0:
            tracks = Tracks.start(features)
        else:
            predicted = next(expected)
            if predicted is not None:
                _places(f"predictions[{k - 1}]", predicted, len(seen[-1]))
            tracks = extend(tracks, seen[-1], features, rules, predicted=predicted)
        seen.append(features)
        for row, number in enumerate(tracks.ids.tolist()):
            if number == len(rows):
                rows.append([])
                begins.append(k)
            rows[number].append(row)
    return [
        FeatureTrack(number, begin, np.array(at), _gather(seen[begin : begin + len(at)], at))
        for number, (begin, at) in enumerate(zip(begins, rows, strict=True))
    ]


def _places(name: str, value: np.ndarray, count: int) -> Float[np.ndarray, "n 2"]:
    """Return places of the features of a frame, which may be infinite and not NaN."""
    places = checks.array(name, value, (count, 2), f"{count} features", finite=False)
    if np.isnan(places).any():
        raise ValueError(f"{name} must be numbers, got {np.isnan(places).sum()} NaN")
    return places


def _endless(predictions: Iterable) -> Iterator:
    yield from predictions
    yield from repeat(None)


def _gather(seen: list[Features], rows: list[int]) -> Features:
    """Return one feature of each frame."""
    return _joined(*(frame[[row]] for frame, row in zip(seen, rows, strict=True)))


def _joined(*parts: Features) -> Features:
    """Return features one after the other."""
    names = (field.name for field in fields(Features))
    return Features(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))
