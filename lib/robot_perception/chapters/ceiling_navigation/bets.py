"""The bets of the chapter: question, a reply to each answer, and the right one."""

from typing import Any

HIGHER: dict[str, Any] = {
    "question": "A robot believes that the ceiling is one and a half times as high as it is. It "
    "drives to the next key image by its pictures. Where does it end?",
    "replies": {
        "half as far again": "That is where a robot would end that plans its way in metres and "
        "drives it blind. This one looks all the time.",
        "at the key image": "It believes itself too far away and drives too fast. But it stops "
        "where the ceiling looks as it did, and there every scale says zero.",
        "nowhere: it circles": "Directions do not depend on the scale, so it heads the right way. "
        "Only a scale that is too large by far makes it swing.",
    },
    "right": "at the key image",
}

LOOP: dict[str, Any] = {
    "question": "A path is a straight piece, a whole circle, and a straight piece. Key images "
    "share patterns, but may be turned against each other as they like. What does the robot do?",
    "replies": {
        "it drives the circle": "Which key image would tell it to? Before and after the circle the "
        "ceiling looks the same.",
        "it leaves the circle out": "Two images that look alike are near to each other, whatever "
        "lies between them in time.",
        "it stands still": "It would if it saw no pattern of the next key image, but it does.",
    },
    "right": "it leaves the circle out",
}

DRIFT: dict[str, Any] = {
    "question": "A mosaic is chained along a loop of 28 metres. Which errors bend it most?",
    "replies": {
        "those of positions": "They add up like a random walk, some millimetres at a time, and "
        "nothing multiplies them.",
        "those of headings": "A heading that is wrong by a degree turns all that comes after it: "
        "17 cm for every 10 m.",
        "that of the scale": "It makes the whole mosaic larger or smaller, but does not bend it.",
    },
    "right": "those of headings",
}
