"""The bets of the chapter: question, a reply to each answer, and the right one.

The tests compute each right answer.
"""

from typing import Any

CURES: dict[str, Any] = {
    "question": "Which of the three makes the error fall for good?",
    "replies": {
        "Stopping the robot": "Not alone. Where the robot stands was uncertain at the start, and "
        "stays as uncertain.",
        "An exactly known start": "Not alone. Each move adds new uncertainty about where the robot "
        "is, and the landmark takes its share of it.",
        "Ten landmarks": "All ten inherit the one error of the robot that saw them first.",
        "None of them alone": "Two of them together do it; the controls below show which.",
    },
    "right": "None of them alone",
}

FIFTY: dict[str, Any] = {
    "question": "Which slope do fifty landmarks give, compared with that of one?",
    "replies": {
        "Fifty times as much": "Fifty independent measurements would give that, but how far the "
        "robot moved in the last step is unknown to all fifty alike.",
        r"About seven times ($\sqrt{50}$)": "The root holds for the error of a mean of "
        "independent measurements. Their information would grow fifty times, and these are not "
        "independent.",
        "Less than three times": "One unknown move is common to all fifty.",
    },
    "right": "Less than three times",
}

SAME: dict[str, Any] = {
    "question": "Which of the four gives the same estimates, to the last digit, as the right "
    "filter?",
    "replies": {
        r"State a $P_0$ that is a hundredth of the truth": r"The gains do not contain $P_0$. "
        r"Only what the filter says about its errors changes, and is no longer true.",
        "Use each measurement before the move that led to it": "Each measurement is compared "
        "with a place that the robot has left.",
        "Forget the cross-covariance when a landmark enters the map": "The filter takes one "
        "error for two independent ones, and that changes the gains.",
        "Give one landmark a known place": "It changes them, and that is its merit: the "
        "estimates get better.",
    },
    "right": r"State a $P_0$ that is a hundredth of the truth",
}
