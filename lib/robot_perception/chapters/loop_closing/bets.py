"""What the chapter asks its reader to bet on, and what each answer is told."""

GIVEN = {
    "question": (
        "The same drive again, the same scans, the same poor wheels. You may give the filter "
        "one thing more. Which of these closes the loop?"
    ),
    "replies": {
        "the place of the first landmark, as an anchor": "The anchor stays behind, out of sight "
        "for most of the drive. When the robot comes back it does not know that this is the "
        "anchor.",
        "a joint test of all matches in a scan": "It rejects matches that are unlikely together. "
        "With an error of metres the right ones are unlikely, too.",
        "the name of every landmark that it sees": "The loop closes when the robot recognises "
        "one thing that it has seen before.",
    },
    "right": "the name of every landmark that it sees",
}

PLACE = {
    "question": (
        "Where should the one surveyed post stand, so that the error over the whole drive is "
        "smallest?"
    ),
    "replies": {
        "at the start": "There the robot knows its position anyway, and it meets the post again "
        "only when the loop closes.",
        "a third of the way round": "There the robot has had time to err; what it learns "
        "corrects the path behind it and lets the path ahead start afresh.",
        "just before the end": "There the loop is about to close, and closing it corrects the same "
        "errors once more.",
    },
    "right": "a third of the way round",
}

REMOVED = {
    "question": (
        "Landmarks leave the state after fifty revisions, on a drive round the posts. What "
        "happens to the error of the path, and to what the filter says of it?"
    ),
    "replies": {
        "the error explodes": "It grows, but not by much: after fifty revisions most landmarks "
        "stand about where they should, relative to the robot.",
        "the error hardly grows, the filter is far too sure": "A frozen landmark keeps its error "
        "and loses its uncertainty.",
        "nothing: fifty measurements are enough": "Fifty measurements make a landmark sharp "
        "relative to the robot. They all share the error of the robot's pose, and no number of "
        "them averages it away.",
    },
    "right": "the error hardly grows, the filter is far too sure",
}
