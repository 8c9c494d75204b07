"""The bets of the chapter: question, a reply to each answer, and the right one."""

from typing import Any

TENTH: dict[str, Any] = {
    "question": "Now only a tenth of each reading's variance is repeated, and nine tenths are new. "
    "Twenty readings are fused as if independent. How many times too small is the stated variance?",
    "replies": {
        "1.1 times": "That would be right for a single fusion. The new parts average out as more "
        "readings come; the repeated part does not.",
        "about 3 times": "The new nine tenths fall to a twentieth of their size, and the "
        "repeated tenth stays. The robot believes that all of it falls.",
        "20 times": "That would be so if the whole error were repeated.",
    },
    "right": "about 3 times",
}

TWICE: dict[str, Any] = {
    "question": "Two beliefs are fused as if independent, and the correlation is the worst "
    "possible. How many times too small can a stated variance be?",
    "replies": {
        "without limit": "Two beliefs can count the same information twice, not more often. For a "
        "larger factor it takes more beliefs.",
        "twice": "And never more: at worst the two errors are one, and its information was "
        "counted twice.",
        "four times": "Try two beliefs of variance 1. The filter takes their average and states "
        "1/2. If both errors are one, the average errs by a variance of 1, no more than each "
        "belief.",
    },
    "right": "twice",
}

LEAST: dict[str, Any] = {
    "question": "Draw two beliefs at random. Is eq. 4 the weight of the least determinant?",
    "replies": {
        "yes, as the paper says": "Eq. 4 compares the sizes of the two ellipses. Where "
        "the result is smallest depends on their directions, too.",
        "hardly ever": "The determinants have to be equal, or the pair has to satisfy one other "
        "equation. For a pair drawn at random neither is the case.",
        "for most pairs": "It is close for most pairs. It is exact for next to none.",
    },
    "right": "hardly ever",
}
