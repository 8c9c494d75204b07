"""What the chapter asks its reader to bet on, and what each answer is told."""

GUESSES = {
    "question": (
        "One guess makes a map. Now take ten guesses in place of one, with the same frames and "
        "the same wheels. What happens to the error of the path?"
    ),
    "replies": {
        "it falls by a tenth or so": "The errors of guesses do not average out like noise. The "
        "guesses are not averaged at all: those that fit are kept.",
        "it falls to a third or less": "Ten guesses are enough: in each frame one fits better "
        "than the others, and the better one goes on.",
        "it stays the same: ten guesses err like one": "They would if nothing chose among them. "
        "The frames do: a guess that has gone astray expects its landmarks elsewhere.",
    },
    "right": "it falls to a third or less",
}

ANCESTORS = {
    "question": (
        "Take the fifty particles in the middle of the drive. Twenty frames ago, three metres "
        "back, there were fifty as well. From how many of those do all the present ones descend?"
    ),
    "replies": {
        "from about half of them": "That would be so if each frame favoured some particles a "
        "little. A dozen points, each good to centimetres, favour one by far.",
        "from a handful": "Nearly. After a frame the weights are those of about two particles of "
        "the fifty, and twenty such frames leave one.",
        "from one": "The others have no descendants, and whatever they knew of the path is gone.",
    },
    "right": "from one",
}
