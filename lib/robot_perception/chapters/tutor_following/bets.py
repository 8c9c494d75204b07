"""The bets of the chapter: question, a reply to each answer, and the right one."""

from typing import Any

FIXED: dict[str, Any] = {
    "question": "Somebody stops before the person for 2.5 s and hides him. One robot keeps the "
    "colours that it has seen at first, another one learns what it sees. Which is still with the "
    "person afterwards?",
    "replies": {
        "the one that learns": "It learns the colours of the one who stands in front, and stays "
        "with him.",
        "the one that keeps the colours": "Nothing that it sees fits, so its particles spread, and "
        "many find the person when he is seen again.",
        "neither, most often": "That would be so if nothing were left to find the person again. "
        "What it remembers is.",
    },
    "right": "the one that keeps the colours",
}

STARTS: dict[str, Any] = {
    "question": "The paper says: an open hand starts the following, and the following runs until "
    "an open hand is seen. A robot is built like that, to the letter. What does it do when its "
    "tutor raises a hand?",
    "replies": {
        "it follows until the next hand": "It would if it knew which hand is the next one.",
        "it follows for a moment and stops": "The hand that began it is still up in the next "
        "pictures, and an open hand ends the following.",
        "nothing": "The first pictures do start it.",
    },
    "right": "it follows for a moment and stops",
}
