"""What the chapter asks its reader to bet on, and what each answer is told."""

COMMITTEE = {
    "question": (
        "All three sensors, each also alone, with the same rules and the same memory. We count the "
        "people found and the hypotheses that are nobody. Which is best?"
    ),
    "replies": {
        "the committee, in both": "It finds the most people. But whatever one member makes up, "
        "the committee believes for a while, too.",
        "the committee finds the most, and is wrong more often than a single member": "Yes. It "
        "collects people and mistakes alike.",
        "the laser, which measures best": "Ahead it does. Half of the people are behind it.",
    },
    "right": "the committee finds the most, and is wrong more often than a single member",
}
