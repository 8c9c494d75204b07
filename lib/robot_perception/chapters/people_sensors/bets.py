"""What the chapter asks its reader to bet on, and what each answer is told."""

SONARS = {
    "question": (
        "A robot drives through doors and along corridors. How many of the people that its "
        "sonars report are false?"
    ),
    "replies": {
        "hardly any: people are the only things that move": "A sonar hears no motion. "
        "Whatever answers from less than 2 m is a hypothesis, and a door frame answers.",
        "more than half": "There are more walls than people.",
        "all of them": "Whoever is near is heard as well as a wall is.",
    },
    "right": "more than half",
}
