"""What the chapter asks its reader to bet on, and what each answer is told."""

SNAKE = {
    "question": (
        "A snail has a shell and, in the same colours, a neck. The piece cut out by colour holds "
        "both. Which snake stays on the shell?"
    ),
    "replies": {
        "only the affine one": "Or nearly so: its six numbers cannot follow the neck, but a "
        "stiff free snake comes close if it starts close.",
        "both, if they are stiff": "Stiffness helps, but where the snakes look for edges far "
        "away, the stiff free one still takes in nearly three times as much of the neck.",
        "neither": "The neck's edge pulls, but six numbers cannot follow it.",
    },
    "right": "only the affine one",
}

BEETLE = {
    "question": (
        "A beetle crawls over sand, in and out of the shadow of leaves. Which tracker loses it in "
        "every film?"
    ),
    "replies": {
        "edges alone": "They lose some. The beetle's edge is strong, and it moves slowly.",
        "colours of the first frame": "They fade in the shadow, but a part of the beetle keeps "
        "its colours, and the outline waits there.",
        "colours adapted without a check": "Once a piece of ground is inside the outline, its "
        "colours are the model; soon the outline runs round the whole frame.",
    },
    "right": "colours adapted without a check",
}
