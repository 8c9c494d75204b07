"""What the chapter asks its reader to bet on, and what each answer is told."""

COMMITTEE = {
    "question": (
        "All three sensors work together, and then each works alone, with the same rules and the "
        "same memory. We count the people found and the false hypotheses. Which is best?"
    ),
    "replies": {
        "the committee, on both counts": "It finds the most people. But whatever one member makes "
        "up, the committee believes for a while, too.",
        "the committee finds the most, and is wrong more often than a single member": "It "
        "collects people and mistakes alike.",
        "the laser, which measures best": "Ahead it does. Half of the people are behind it.",
    },
    "right": "the committee finds the most, and is wrong more often than a single member",
}
