"""What the chapter asks its reader to bet on, and what each answer is told."""

WRONG = {
    "question": (
        "The paper of this chapter says that one anchor is enough, and a computer algebra system "
        "agreed. Who is wrong?"
    ),
    "replies": {
        "the picture": "The measurements were taken again in the turned world, and they agree to "
        "rounding. No filter can tell the two worlds apart.",
        "the algebra": "It computed the rank of the matrix that it was given, and computed it "
        "right. Ask which robot that matrix belongs to.",
        "the paper's conclusion": "The algebra is right about its matrix and the picture is "
        "right about the robot. Three ways to ask the same question, below, will show where the "
        "two part.",
    },
    "right": "the paper's conclusion",
}

LEFT = {
    "question": (
        "Without a reference, four fifths of the first error stay for ever. How much of the "
        "landmark's first error (root mean square) is left after a hundred measurements, once "
        "there is an anchor?"
    ),
    "replies": {
        "half": "Each measurement of the anchor ties the robot to the floor once more, and they "
        "average. A hundred of them do better.",
        "between a twentieth and a tenth": "The error is an average of a hundred fresh "
        "measurements now, and averages shrink like $1/\\sqrt{k}$.",
        "nothing at all": "It comes closer and closer to nothing, like $1/\\sqrt{k}$, and never "
        "gets there.",
    },
    "right": "between a twentieth and a tenth",
}

HEADING = {
    "question": "What will a plain filter claim to know of its heading after 150 steps?",
    "replies": {
        "about ±10°, as at the start": "An honest filter would: no measurement says anything about "
        "the turn. This one takes its Jacobians from a mixture of points.",
        "more than ±10°, for the wheels slip": "The landmarks hold the heading against slip. The "
        "start heading itself is what nothing measures.",
        "less than ±5°": "It claims to have learnt what nothing told it.",
    },
    "right": "less than ±5°",
}
