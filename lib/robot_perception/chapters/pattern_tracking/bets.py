"""The bets of the chapter: question, a reply to each answer, and the right one."""

from typing import Any

THREE: dict[str, Any] = {
    "question": "The pattern moves by three σ of the random walk between two pictures, along one "
    "coordinate. Two hundred particles are drawn. How far off is the estimate, typically?",
    "replies": {
        "hardly at all": "That is how it is with a few thousand particles. Of two hundred draws in "
        "four coordinates hardly one falls near a place three σ away.",
        "more than one σ": "The estimate is a mean of particles, and hardly one of two hundred is "
        "drawn near the place.",
        "three σ: it stays behind": "Some particles do fall on the near side of the pattern, and "
        "their vectors already fit better. The estimate goes part of the way.",
    },
    "right": "more than one σ",
}

COVERED: dict[str, Any] = {
    "question": "Bad vectors are left out of the product, up to 30 % of them. What does this cost "
    "while nothing covers the pattern?",
    "replies": {
        "nothing": "It would, if vectors were bad only when they are covered. But a particle "
        "beside the pattern has bad vectors, too, and may leave them out as well.",
        "the error grows": "A particle beside the pattern may leave out the vectors that would "
        "have told against it.",
        "the error shrinks": "It would, if a vector were bad because of noise. Here the noise is "
        "far below the threshold.",
    },
    "right": "the error grows",
}

SMOOTH: dict[str, Any] = {
    "question": "The pattern grows to twice its size. The picture is smoothed by σ = 2 px before "
    "vectors are taken, as the paper has it. Are they more like the stored ones than without "
    "smoothing?",
    "replies": {
        "yes": "The detail that smoothing removes was not in the model, that is right. But the "
        "model has its own sharp edges, and smoothing takes these away, too.",
        "no": "The stored vectors come from a picture that was not smoothed.",
        "there is no difference": "There is: a factor of more than two.",
    },
    "right": "no",
}
