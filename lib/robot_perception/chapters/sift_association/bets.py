"""What the chapter asks its reader to bet on, and what each answer is told."""

ASIDE = {
    "question": "A landmark was seen from straight ahead. Now the robot sees it from 30° aside, "
    "and a look-alike, a second copy of the same picture, from straight ahead. Whose descriptor is "
    "nearer to the old one?",
    "replies": {
        "the landmark's own": "It has turned by 30°, and its neighbourhood is foreshortened. The "
        "copy differs in light and noise alone.",
        "the look-alike's": "Yes, by far. For a descriptor, the same look is worth more than the "
        "same place.",
        "both are about as near": "Light and noise move a descriptor, too, but by much less than "
        "30° do.",
    },
    "right": "the look-alike's",
}

OWN_FRAMES = {
    "question": "Classes of three frames, variances as they are. First we assign the very "
    "descriptors that made the classes, then descriptors of other frames from the same viewpoints. "
    "How do the shares of right assignments compare with the Euclidean distance to the same means?",
    "replies": {
        "better on both": "Three numbers hardly make a variance. On their own it cannot show.",
        "worse on both": "On the descriptors that made them the variances are perfect: they were "
        "made of them.",
        "better on its own, worse on others": "Yes. A class of three knows its own three by heart "
        "and nothing else.",
    },
    "right": "better on its own, worse on others",
}

REPAIR = {
    "question": ("Which one repair makes the Mahalanobis distance usable with three frames?"),
    "replies": {
        "the log-determinant": "It charges for large variances. The harm of small ones, a wrong "
        "zero, it leaves.",
        "more frames, thirty": "That helps, and is not enough: ask again from aside.",
        "variances that the landmarks share": "Yes. Thousands of frames of all landmarks make one "
        "good variance for each entry.",
    },
    "right": "variances that the landmarks share",
}
