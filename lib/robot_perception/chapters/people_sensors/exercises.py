"""The exercises of the chapter "Three witnesses"."""

from collections.abc import Callable

import numpy as np

from robot_perception.teaching.exercises import Exercise, Sheet

_GAP, _DISTANCE, _LEG = np.deg2rad(1.0), 3.0, 0.12
_CONE, _AWAY = np.deg2rad(15.0), 1.5
_EARS, _SPEED, _FROM = 0.2, 343.0, np.deg2rad(30.0)
_NEAR, _FAR = 0.1, 0.5
_LEGS = [
    np.random.default_rng(count).uniform(0, 0.8, (count, 2)) for count in (0, 1, 2, 3, 5, 8, 8)
]

Count = Callable[[np.ndarray, float, float], int]


def _apart(middles: np.ndarray) -> np.ndarray:
    return np.hypot(*(middles[:, None] - middles).transpose(2, 0, 1))


def _pairs(middles: np.ndarray, near: float, far: float) -> int:
    """Count the pairs that are from near to far apart."""
    apart = _apart(middles)[np.triu_indices(len(middles), 1)]
    return int(((apart >= near) & (apart <= far)).sum())


def _twice(middles: np.ndarray, near: float, far: float) -> int:
    return 2 * _pairs(middles, near, far)


def _touching(middles: np.ndarray, near: float, far: float) -> int:
    return _pairs(middles, 0.0, far)


def _neighbours(middles: np.ndarray, near: float, far: float) -> int:
    return sum(_pairs(middles[k : k + 2], near, far) for k in range(len(middles)))


def _counts(right: Count) -> Callable[[object], bool]:
    """Return whether a function counts the pairs of all cases as another one."""

    def judge(given: object) -> bool:
        return callable(given) and all(
            given(middles, _NEAR, _FAR) == right(middles, _NEAR, _FAR) for middles in _LEGS
        )

    return judge


_BEAMS = {
    _LEG / _GAP: "so far away one beam is certain, and a second one is luck.",
    _DISTANCE * _GAP: "that is the gap at 3 m; where is the leg as wide as two gaps?",
    _LEG / 2: "use the gap in radians.",
}
_WIDTHS = {_AWAY * np.tan(_CONE / 2): "that is from the axis to the rim; both sides count."}
_LATE = 1e3 * _EARS / _SPEED
_DELAYS = {
    _LATE: "so late is a voice straight from the left.",
    _LATE * np.cos(_FROM): "a voice from ahead reaches both at once: which function is 0 there?",
    _LATE * np.sin(_FROM) / 1e3: "that is in seconds.",
}
_COUNTS = {
    _counts(_twice): "each pair once: i and j is j and i.",
    _counts(_touching): "two that are nearer than a step are one leg in pieces.",
    _counts(_neighbours): "the second leg need not be the next one in the scan.",
}
EXERCISES = Sheet(
    {
        "people-beams": Exercise(
            _LEG / (2 * _GAP),
            mistakes=tuple(_BEAMS.items()),
            hint="Beams that are g apart meet a leg at least twice, wherever they fall, if it is "
            "2 g wide. What is g at the distance r?",
            rtol=5e-3,
        ),
        "people-cone": Exercise(
            2 * _AWAY * np.tan(_CONE / 2),
            mistakes=tuple(_WIDTHS.items()),
            hint="Half of the cone is a right triangle with an angle of 7.5°.",
            rtol=2e-2,
        ),
        "people-delay": Exercise(
            _LATE * np.sin(_FROM),
            mistakes=tuple(_DELAYS.items()),
            hint="How much longer is the way to the right one? A far wave is a straight front.",
            rtol=5e-3,
        ),
        "people-pairs": Exercise(
            _counts(_pairs),
            mistakes=tuple(_COUNTS.items()),
            hint="Compare each leg with all that come after it.",
        ),
    }
)
check = EXERCISES.check
