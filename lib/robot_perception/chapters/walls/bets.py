"""The bets of the chapter: question, a reply to each answer, and the right one."""

from typing import Any

TOLERANCE: dict[str, Any] = {
    "question": "How large must the tolerance ε be for each wall of the scan to be found, and "
    "found once?",
    "replies": {
        "ε = σ": "One reading in three lies farther than σ from its wall, and each of these "
        "splits it. Walls end up in pieces too short to count.",
        "ε = 2σ": "One reading in twenty lies farther than 2σ from its wall, and a wall has tens "
        "of readings. One of them is enough for a split: walls come in pieces, or are lost.",
        "ε = 5σ": "The farthest of a hundred readings lies nearly 3σ from the wall, and the "
        "chord, drawn through two noisy readings, adds an error of its own.",
    },
    "right": "ε = 5σ",
}

GATE: dict[str, Any] = {
    "question": "The gate now trusts the covariance alone, and the poses are 2 cm wrong. How does "
    "the number of walls in the map change?",
    "replies": {
        "fewer walls": "A narrower gate never joins more. What fails the gate of every wall "
        "becomes a wall of its own.",
        "about as many": "The covariance knows the scanner's noise only. It has no room for the "
        "error of the poses, which is many times larger.",
        "many more walls": "Seen from a pose 2 cm off, a wall fails its own gate and becomes a "
        "second wall beside itself.",
    },
    "right": "many more walls",
}

HULLS: dict[str, Any] = {
    "question": "Path hulls save nearly all steps on the worst line. How many do they save on the "
    "scan?",
    "replies": {
        "nearly all": "The scan splits into short stretches at once, and there is little left to "
        "save.",
        "about none": "Hulls have to be built before they can be searched, and the stretches of "
        "a scan are too short to pay for that.",
        "they cost more steps": "Building the hulls costs more steps than there are distances to "
        "save.",
    },
    "right": "they cost more steps",
}
