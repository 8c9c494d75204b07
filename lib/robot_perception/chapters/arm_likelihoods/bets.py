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
    "question": "Patches on sleeves and hands are compared with how they looked at first. One "
    "sleeve is checked, the hands are of one colour. Which is the better patch to hold on to?",
    "replies": {
        "the checked sleeve": "So says the paper: many colours, much to tell. But a checked sleeve "
        "looks the same all along the arm.",
        "the hand of one colour": "What counts is whether the neighbourhood looks different, and "
        "skin is unlike most walls.",
        "they are equally good": "They would be if their neighbourhoods looked equally different.",
    },
    "right": "the hand of one colour",
}
