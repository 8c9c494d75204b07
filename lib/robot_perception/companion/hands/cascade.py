"""A cascade of boosted stages: most windows are rejected by the first few features."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Annotated, Any, final, no_type_check

import numpy as np
from jaxtyping import Float, Int, UInt8

from robot_perception import checks
from robot_perception.companion.boxes import grey_picture, known_sides, within
from robot_perception.companion.hands.boosting import Boosted, boost
from robot_perception.companion.hands.features import (
    FLAT,
    HEAVIEST,
    SIZE,
    check_features,
    check_windows,
    deviations,
    feature_values,
    in_window,
    integral,
)
from robot_perception.extras import needing
from robot_perception.fields import Share, above, checked, from_to
from robot_perception.kernels import kernel

with needing():
    import cv2

__all__ = ["Cascade", "Goals", "HandDetector", "Stage", "StageReport", "train"]

FORMAT = "boosted cascade of Haar-like features"
VERSION = 1
MOST_FEATURES, MOST_STAGES, MOST_STUMPS = 20_000, 100, 10_000
"""Largest numbers of features and stages of a cascade."""


@final
@dataclass(frozen=True, eq=False, slots=True)
class Stage:
    """One stage.

    Parameters
    ----------
    stumps
        Of features of the cascade.
    threshold
        A window whose votes are fewer is rejected.
    """

    stumps: Boosted
    threshold: float
    __post_init__ = checked


@final
@dataclass(frozen=True, eq=False, slots=True)
class Cascade:
    """Features and stages.

    Parameters
    ----------
    features : (n, 3, 5)
        That the stumps ask.
    stages
        In the order in which a window passes them.

    Raises
    ------
    ValueError
        If there is no stage or more than 100, or a stump asks for a feature that is not there.
    """

    features: Annotated[Int[np.ndarray, "n 3 5"], in_window]
    stages: tuple[Stage, ...]
    _tables: tuple = field(init=False, repr=False)

    def __post_init__(self) -> None:
        checked(self)
        features, stages = self.features, self.stages
        if not 0 < len(stages) <= MOST_STAGES:
            raise ValueError(f"stages must be from 1 to {MOST_STAGES}, got {len(stages)}")
        for stage in stages:
            if (highest := stage.stumps.features.max()) >= len(features):
                raise ValueError(f"stages must ask {len(features)} features, got {highest}")
        parts = [stage.stumps for stage in stages]
        ends = np.cumsum([len(part.features) for part in parts])
        asked = np.concatenate([part.features for part in parts])
        names = ("thresholds", "polarities", "votes")
        columns = (np.concatenate([getattr(part, name) for part in parts]) for name in names)
        limits = np.array([stage.threshold for stage in stages])
        tables = (np.ascontiguousarray(features[asked]), *columns, ends, limits)
        object.__setattr__(self, "_tables", tables)

    def passed(self, windows: UInt8[np.ndarray, "m 24 24"]) -> Int[np.ndarray, " m"]:
        """Return how many stages each window passes, before one rejects it.

        Raises
        ------
        TypeError, ValueError
            As `feature_values`.
        """
        windows = check_windows(windows)
        values = feature_values(windows, self.features)
        through = np.ones(len(windows), dtype=bool)
        through &= deviations(windows) >= FLAT
        found = np.zeros(len(windows), dtype=np.int64)
        for stage in self.stages:
            through &= stage.stumps.scores(values) >= stage.threshold
            found += through
        return found

    def to_plain(self) -> dict[str, Any]:
        """Return the cascade in plain types that JSON can hold."""
        stages = [
            {
                "threshold": round(float(stage.threshold), 6),
                "stumps": [
                    [int(f), round(float(t), 6), int(p), round(float(v), 6)]
                    for f, t, p, v in zip(
                        stage.stumps.features,
                        stage.stumps.thresholds,
                        stage.stumps.polarities,
                        stage.stumps.votes,
                        strict=True,
                    )
                ],
            }
            for stage in self.stages
        ]
        features = [[r.tolist() for r in f if r[2] > 0] for f in self.features]
        return {
            "format": FORMAT,
            "version": VERSION,
            "size": SIZE,
            "features": features,
            "stages": stages,
        }

    @classmethod
    def from_plain(cls, plain: Any) -> "Cascade":
        """Return the cascade of :meth:`to_plain`.

        Raises
        ------
        ValueError
            If it is of another format or version, something is missing, or a value is not as it
            should be; the message says which.
        """
        if not isinstance(plain, dict) or plain.get("format") != FORMAT:
            raise ValueError(f"plain must be a {FORMAT}, got {checks.shown(plain)}")
        if not _is("version", plain, VERSION):
            raise ValueError(
                f"plain must be of version {VERSION}, got version {plain.get('version')!r}:"
                " train the model anew"
            )
        if not _is("size", plain, SIZE):
            raise ValueError(f"plain must be of windows of {SIZE} px, got {plain.get('size')!r}")
        try:
            rows = _rows("features", plain["features"], MOST_FEATURES)
            features = np.zeros((len(rows), 3, 5), dtype=np.int64)
            for k, rectangles in enumerate(rows):
                for r, rectangle in enumerate(_rows(f"features[{k}]", rectangles, 3)):
                    features[k, r] = _rectangle(f"features[{k}][{r}]", rectangle)
            rows = enumerate(_rows("stages", plain["stages"], MOST_STAGES))
            return cls(features, tuple(_stage(f"stages[{k}]", stage) for k, stage in rows))
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"plain is no whole model: {error!r:.120}") from error


def _is(name: str, plain: dict, wanted: int) -> bool:
    """Tell whether a file says a whole number; 1.0 and true are none."""
    return type(plain.get(name)) is int and plain[name] == wanted


def _rows(name: str, plain: Any, most: int) -> list:
    """Return a list of a file, if it is none that takes for ever."""
    if len(checks.instance(name, plain, list)) > most:
        raise ValueError(f"{name} must be at most {most}, got {len(plain)}")
    return plain


def _rectangle(name: str, plain: Any) -> list[int]:
    """Return column, row, width, height and weight."""
    ends = ((0, SIZE), (0, SIZE), (1, SIZE), (1, SIZE), (-HEAVIEST, HEAVIEST))
    return [
        checks.whole(name, value, *end)
        for value, end in zip(_rows(name, plain, 5), ends, strict=True)
    ]


def _stage(name: str, plain: Any) -> Stage:
    """Return a stage of a file."""
    stumps = [
        (
            checks.whole(f"{name} feature", feature, 0, MOST_FEATURES),
            checks.number(f"{name} threshold of a stump", threshold),
            checks.whole(f"{name} polarity", polarity, -1, 1),
            checks.number(f"{name} vote", vote),
        )
        for feature, threshold, polarity, vote in _rows(name, plain["stumps"], MOST_STUMPS)
    ]
    return Stage(Boosted(*map(np.array, zip(*stumps, strict=True))), plain["threshold"])


@final
@dataclass(frozen=True, slots=True)
class Goals:
    """Goals of the training of each stage.

    Parameters
    ----------
    detection
        Least share of the hands that pass.
    false_alarms
        Largest share of the others that pass.
    stages
        How many there are at most.
    most
        Features of a stage at most.

    References
    ----------
    Viola and Jones train by such goals; the numbers are ours, the paper names none.
    """

    detection: Share = 0.995
    false_alarms: Share = 0.5
    stages: Annotated[int, from_to(1, MOST_STAGES)] = 14
    most: Annotated[int, from_to(1, MOST_STUMPS)] = 60
    __post_init__ = checked


@final
@dataclass(frozen=True, slots=True)
class StageReport:
    """Rates that a stage reached on the samples that it was trained on.

    Parameters
    ----------
    features
        How many it asks.
    hands, others
        Samples of either kind.
    detection, false_alarms
        Shares of these that pass.
    """

    features: int
    hands: int
    others: int
    detection: float
    false_alarms: float


def train(
    hands: UInt8[np.ndarray, "m 24 24"],
    others: Callable[[Cascade | None, int], UInt8[np.ndarray, "k 24 24"]],
    features: Int[np.ndarray, "n 3 5"],
    *,
    count: int = 6000,
    goals: Goals | None = None,
    told: Callable[[StageReport], None] = lambda report: None,
) -> tuple[Cascade, tuple[StageReport, ...]]:
    """Return a cascade, trained stage by stage on what the stages before let pass.

    Parameters
    ----------
    hands : (m, 24, 24)
        Windows with hands.
    others
        Function of the cascade so far (``None`` before the first stage) and a number that returns
        so many windows without a hand that pass it, or fewer if it finds no more: the hard ones.
    features : (n, 3, 5)
        From which to choose.
    count
        Others for each stage; 6000 in the paper, beside 2000 hands.
    goals
        Of the stages.
    told
        Called with the report of each stage.

    Returns
    -------
    Cascade
        With those features only that it asks.
    tuple of StageReport

    Raises
    ------
    ValueError
        If there are no hands, or no others for the first stage.
    """
    hands, features = check_windows(hands, "hands"), check_features(features)
    for name, function in (("others", others), ("told", told)):
        checks.instance(name, function, Callable)
    count = checks.whole("count", count, 1, 10**6)
    goals = Goals() if goals is None else checks.instance("goals", goals, Goals)
    if not len(hands):
        raise ValueError("hands must not be empty")
    of_hands = feature_values(hands, features)
    passes = np.ones(len(hands), dtype=bool)
    stages: list[Stage] = []
    reports: list[StageReport] = []
    for k in range(goals.stages):
        so_far = _compact(features, stages) if stages else None
        windows = check_windows(others(so_far, count), "others(cascade, count)")
        if len(windows) < max(count // 20, 10):
            if not k:
                raise ValueError(
                    f"others must find windows for the first stage, got {len(windows)}"
                )
            break
        values = np.hstack([of_hands[:, passes], feature_values(windows, features)])
        labels = np.arange(values.shape[1]) < passes.sum()

        def judged(stumps: Boosted, values=values, labels=labels) -> tuple[float, np.ndarray]:
            """Return the threshold that lets enough hands pass, and what passes it."""
            scores = stumps.scores(values)
            lowest = np.quantile(scores[labels], 1 - goals.detection, method="lower")
            return float(lowest) - 1e-9, scores >= lowest - 1e-9

        def enough(stumps: Boosted, labels=labels, judged=judged) -> bool:
            return bool(judged(stumps)[1][~labels].mean() <= goals.false_alarms)

        stumps = boost(values, labels, enough, most=goals.most)
        limit, through = judged(stumps)
        stages.append(Stage(stumps, limit))
        stay, alarms = through[labels], float(through[~labels].mean())
        report = StageReport(
            len(stumps.features), int(passes.sum()), len(windows), float(stay.mean()), alarms
        )
        passes[passes] = stay
        reports.append(report)
        told(report)
    return _compact(features, stages), tuple(reports)


def _compact(features: np.ndarray, stages: list[Stage]) -> Cascade:
    """Return a cascade of the features that its stages ask."""
    asked = np.unique(np.concatenate([stage.stumps.features for stage in stages]))
    renamed = tuple(
        Stage(
            Boosted(
                np.searchsorted(asked, stage.stumps.features),
                stage.stumps.thresholds,
                stage.stumps.polarities,
                stage.stumps.votes,
            ),
            stage.threshold,
        )
        for stage in stages
    )
    return Cascade(features[asked], renamed)


@final
@dataclass(frozen=True, eq=False, slots=True)
class HandDetector:
    """Finds hands of all sizes in a picture.

    Parameters
    ----------
    cascade
        A trained one.
    scale
        From each size to the next.
    step
        From each window to the next, px of the smallest window.
    neighbours
        How many windows must agree on a hand; with 0 every window is returned as it is.
    least
        Side of the smallest hand, px.
    """

    cascade: Cascade
    scale: Annotated[float, above(1.01, 10)] = 1.15
    step: Annotated[int, from_to(1, SIZE)] = 2
    neighbours: Annotated[int, from_to(0, 1000)] = 3
    least: Annotated[int, from_to(SIZE, 10**6)] = SIZE
    __post_init__ = checked

    def find(
        self,
        image: UInt8[np.ndarray, "height width"],
        window: Float[np.ndarray, " 4"] | None = None,
        sides: tuple[float, float] | None = None,
    ) -> Float[np.ndarray, "n 4"]:
        """Return the boxes of the hands, those first on which most windows agree.

        Parameters
        ----------
        image : (height, width)
            Grey values.
        window : (4,), optional
            The part of the picture to look into: left, top, width and height, px.
        sides
            Smallest and largest side of a hand, px, where they are known.

        Raises
        ------
        TypeError
            If the image does not hold bytes.
        ValueError
            If it is in colour or empty, the window has no area, or the sides do not rise.
        """
        least, most = known_sides(sides, self.least, 10**6)
        image, corner = within(grey_picture("image", image), window)
        if min(image.shape) < least:
            return np.zeros((0, 4))
        boxes = self.windows(image, (least, most))[0]
        if not len(boxes):
            return np.zeros((0, 4))
        if not self.neighbours:
            return boxes + np.array([*corner, 0, 0])
        # a threshold of 0 would group nothing: each box goes in twice, so that one can be enough
        twice = np.rint(boxes).astype(int).repeat(2, axis=0).tolist()
        grouped, weights = cv2.groupRectangles(twice, 2 * self.neighbours - 1, 0.25)
        grouped = np.asarray(grouped, dtype=float).reshape(-1, 4)
        first = np.argsort(-np.asarray(weights).ravel(), kind="stable")
        return grouped[first] + np.array([*corner, 0, 0])

    def windows(
        self,
        image: UInt8[np.ndarray, "height width"],
        sides: tuple[float, float] | None = None,
    ) -> tuple[Float[np.ndarray, "n 4"], int]:
        """Return every window that passes all stages, and how many were looked at.

        Parameters
        ----------
        image, sides
            As of :meth:`find`.

        Raises
        ------
        TypeError, ValueError
            As :meth:`find`.
        """
        grey_picture("image", image)
        found: list[np.ndarray] = []
        looked = 0
        for factor, small in self._sizes(image, *known_sides(sides, self.least, 10**6)):
            total, squares = integral(small)
            passed = np.zeros([(n - SIZE) // self.step + 1 for n in small.shape], dtype=np.int32)
            _scan(total, squares, self.step, *self.cascade._tables, passed)
            looked += passed.size
            rows, columns = np.nonzero(passed == len(self.cascade.stages))
            if len(rows):
                places = np.stack([columns, rows], axis=1) * self.step * factor
                found.append(np.hstack([places, np.full((len(rows), 2), SIZE * factor)]))
        return (np.concatenate(found) if found else np.zeros((0, 4))), looked

    def stages_passed(
        self, image: UInt8[np.ndarray, "height width"], box: Float[np.ndarray, " 4"]
    ) -> int:
        """Return how many stages a square of a picture passes.

        Raises
        ------
        TypeError, ValueError
            As :meth:`find`; also if the box does not lie in the picture.
        """
        grey_picture("image", image)
        left, top, side, _ = checks.vector("box", box, 4)
        x, y, n = round(left), round(top), round(side)
        if n < 1 or x < 0 or y < 0 or x + n > image.shape[1] or y + n > image.shape[0]:
            raise ValueError(f"box must lie in the picture of {image.shape[::-1]} px, got {box}")
        inside = np.ascontiguousarray(image[y : y + n, x : x + n])
        small = cv2.resize(inside, (SIZE, SIZE), interpolation=cv2.INTER_AREA)
        return int(self.cascade.passed(small[None])[0])

    def _sizes(
        self, image: np.ndarray, least: int, most: int
    ) -> Iterator[tuple[float, np.ndarray]]:
        """Yield the picture ever smaller, with the factor by which it is."""
        factor = least / SIZE
        while min(image.shape) >= SIZE * factor and SIZE * factor <= most:
            size = round(image.shape[1] / factor), round(image.shape[0] / factor)
            if min(size) >= SIZE:
                small = image
                if factor > 1:
                    small = cv2.resize(image, size, interpolation=cv2.INTER_AREA)
                yield factor, small
            factor *= self.scale


@no_type_check
@kernel()
def _scan(total, squares, step, features, thresholds, polarities, votes, ends, limits, passed):
    """Count the stages that each window passes."""  # pragma: no cover - compiled
    count = SIZE * SIZE
    for row in range(passed.shape[0]):
        y0 = row * step
        for column in range(passed.shape[1]):
            x0 = column * step
            y1, x1 = y0 + SIZE, x0 + SIZE
            mean = (total[y1, x1] - total[y0, x1] - total[y1, x0] + total[y0, x0]) / count
            square = (squares[y1, x1] - squares[y0, x1] - squares[y1, x0] + squares[y0, x0]) / count
            spread = square - mean * mean
            if spread < FLAT * FLAT:
                continue
            scale = 1 / (np.sqrt(spread) * count)
            k = 0
            for stage in range(len(ends)):
                score = 0.0
                while k < ends[stage]:
                    value = 0
                    for r in range(3):
                        w = features[k, r, 2]
                        if w > 0:
                            a, b = x0 + features[k, r, 0], y0 + features[k, r, 1]
                            h = features[k, r, 3]
                            value += features[k, r, 4] * (
                                total[b + h, a + w]
                                - total[b, a + w]
                                - total[b + h, a]
                                + total[b, a]
                            )
                    if polarities[k] * value * scale < polarities[k] * thresholds[k]:
                        score += votes[k]
                    k += 1
                if score < limits[stage]:
                    break
                passed[row, column] += 1
