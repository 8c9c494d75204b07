"""The exercises of the chapter "People, by committee"."""

from collections.abc import Callable

import numpy as np

from robot_perception.teaching.exercises import Exercise, Sheet

_ALPHA, _THETA, _MATCHES = 0.1, 0.3, 10
_WEIGHT, _PATIENCE = 0.9, 3.0
_CASES = [
    (weight, matched, elapsed)
    for weight in (0.3, 0.31, 0.5, 0.9, 1.0)
    for matched in (True, False)
    for elapsed in (0.02, 0.1, 1.0)
]

Update = Callable[[float, bool, float, float, float, float], float]


def _weight(
    weight: float, matched: bool, elapsed: float, alpha: float, patience: float, theta: float
) -> float:
    """Return a weight after a reading by eqs (5) and (6); 0 if its hypothesis is deleted."""
    after = weight + alpha * (1 - weight)
    if not matched:
        after = weight - (1 - theta) * elapsed / patience
    return after if after >= theta else 0.0


def _agrees(right: Update) -> Callable[[object], bool]:
    """Return whether a function answers all cases as another one."""

    def judge(given: object) -> bool:
        return callable(given) and all(
            np.isclose(given(*case, *rules), right(*case, *rules), atol=1e-9)
            for case in _CASES
            for rules in ((0.1, 3.0, 0.3), (0.4, 5.0, 0.2))
        )

    return judge


def _never_deletes(*case: float) -> float:
    weight, matched, elapsed, alpha, patience, theta = case
    return weight + alpha * (1 - weight) if matched else weight - (1 - theta) * elapsed / patience


def _adds_alpha(*case: float) -> float:
    weight, matched, *_, alpha, _, theta = case
    return _weight(*case) if not matched else weight + alpha * (weight >= theta)


def _falls_from_one_to_nothing(*case: float) -> float:
    weight, matched, elapsed, _, patience, theta = case
    after = weight - elapsed / patience
    return _weight(*case) if matched else after * (after >= theta)


_RAISED = {
    _THETA + _MATCHES * _ALPHA * (1 - _THETA): "each match adds a share of what is missing now, "
    "not of what was missing at first.",
    1 - (1 - _ALPHA) ** _MATCHES: "the weight starts at θ, not at 0.",
    1 - (1 - _THETA) * (1 - _ALPHA) ** (_MATCHES - 1): "that is after nine.",
}
_FORGOTTEN = {
    _PATIENCE: "so long takes a weight of 1.",
    _PATIENCE * _WEIGHT / (1 - _THETA): "it is deleted at θ, not at 0.",
    _PATIENCE * (_WEIGHT - _THETA): "in t_v the weight falls by 1 − θ, not by 1.",
}
_UPDATE = {
    _agrees(_never_deletes): "who falls below θ is deleted: return 0 then.",
    _agrees(_adds_alpha): "eq. 5 adds a share α of what is missing to 1, not α itself.",
    _agrees(_falls_from_one_to_nothing): "in t_v the weight falls by 1 − θ, not by 1.",
}
EXERCISES = Sheet(
    {
        "people-raised": Exercise(
            1 - (1 - _THETA) * (1 - _ALPHA) ** _MATCHES,
            mistakes=tuple(_RAISED.items()),
            hint="What is missing to 1 is multiplied by 1 − α at each match.",
            rtol=5e-3,
        ),
        "people-forgotten": Exercise(
            _PATIENCE * (_WEIGHT - _THETA) / (1 - _THETA),
            mistakes=tuple(_FORGOTTEN.items()),
            hint="The weight falls evenly: by 1 − θ in the time t_v.",
            rtol=5e-3,
        ),
        "people-update": Exercise(
            _agrees(_weight),
            mistakes=tuple(_UPDATE.items()),
            hint="With a match eq. 5, without one eq. 6 and then the comparison with θ.",
        ),
    }
)
check = EXERCISES.check
