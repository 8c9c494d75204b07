"""The bets of the chapter: question, a reply to each answer, and the right one."""

from typing import Any

HIDES: dict[str, Any] = {
    "question": "The cost of a pose is summed over the points of its outline that are visible. "
    "A search is free to choose any pose. What will it do, if it can?",
    "replies": {
        "put the outline on the edges": "It does, where nothing is cheaper. But a point that is "
        "not visible costs nothing at all.",
        "hide the arm": "A point that is not visible is not summed: nothing is cheaper than an arm "
        "of which nothing is seen.",
        "stretch the arm": "A stretched arm has all its points in view, and each of them costs.",
    },
    "right": "hide the arm",
}

TRUST: dict[str, Any] = {
    "question": "The paper gives more weight to a patch of many colours. Each patch alone puts the "
    "arm somewhere. Do the patches with more weight put it nearer to the truth?",
    "replies": {
        "yes, they err less": "So says the paper: many colours, much to tell. But a checked sleeve "
        "looks the same all along the arm.",
        "no, they err a little more": "What counts is whether the neighbourhood looks different, "
        "and skin, of one colour, is unlike most walls.",
        "only those on hands": "Of the hands alone it is the same: those with more weight err a "
        "little more.",
    },
    "right": "no, they err a little more",
}
