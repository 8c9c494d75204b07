"""The bets of the chapter: question, a reply to each answer, and the right one."""

from typing import Any

CLUTTERED: dict[str, Any] = {
    "question": "Forty things hang on the wall and two people walk behind. One of four is taken "
    "from the tracker. Without which of them does it lose most arms?",
    "replies": {
        "contours": "One would think so. But patches say where an arm is nearly as well without "
        "them, and edges that are not the arm's pull as hard as those that are.",
        "patches of colour and texture": "Edges of the wall look like edges of arms. Colours of "
        "the wall do not look like sleeves.",
        "motion": "It helps a little: people behind move, too.",
        "the pull to rest": "It is a hundred times weaker than what the picture says.",
    },
    "right": "patches of colour and texture",
}

FILTERED: dict[str, Any] = {
    "question": "The auxiliary filter looks ahead: it draws the particles that the patches like "
    "before they move. Plain condensation moves first and looks afterwards. With 400 particles "
    "each, how much better is the auxiliary filter?",
    "replies": {
        "much: half of the error": "It would be if the look ahead told where the arms will be. It "
        "tells where they have been.",
        "hardly": "The motion is a random walk, so that the expected next state is the present "
        "one, and moving scatters what was chosen.",
        "it is much worse": "It asks twice, and answers about as well.",
    },
    "right": "hardly",
}
