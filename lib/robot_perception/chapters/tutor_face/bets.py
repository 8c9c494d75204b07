"""The bets of the chapter: question, a reply to each answer, and the right one."""

from typing import Any

STRANGER: dict[str, Any] = {
    "question": "The gallery holds three tutors. A limit on the distance is set so that nearly all "
    "of their new pictures pass. Strangers come. What happens?",
    "replies": {
        "strangers are turned away": "They would be, if faces of one person lay close together and "
        "those of others far off. Light and expression move a face as far as another face is.",
        "some four in ten pass": "A limit that lets a tutor pass in any light lets many others "
        "pass, too.",
        "all of them pass": "Not all: some faces are far from everybody in the gallery.",
    },
    "right": "some four in ten pass",
}

LAST: dict[str, Any] = {
    "question": "The detector misses a face for a few pictures. One robot predicts by a filter of "
    "constant velocity, another keeps the last detection. Which holds the face more often?",
    "replies": {
        "the filter": "It would if people went on as they move. They sway, and turn back within a "
        "gap: the velocity leads away then.",
        "the last detection": "It would for a person at rest. This one moves on by a good part of "
        "a face before it turns back.",
        "there is no difference": "What the filter gains on the way out it loses on the way back.",
    },
    "right": "there is no difference",
}
