"""What the chapter asks its reader to bet on, and what each answer is told."""

ASIDE = {
    "question": "A landmark was seen from straight ahead. Now the robot sees it from 30° to the "
    "side, and sees a look-alike, a second copy of the same picture, from straight ahead. Whose "
    "descriptor is nearer to the old one?",
    "replies": {
        "the landmark's own": "It has turned by 30°, and its neighbourhood is foreshortened. The "
        "copy differs in light and noise alone.",
        "the look-alike's": "By far. To a descriptor, looking the same counts for more than "
        "being the same.",
        "both are about as near": "Light and noise move a descriptor, too, but by much less than "
        "30° do.",
    },
    "right": "the look-alike's",
}

OWN_FRAMES = {
    "question": "Each class is made of three frames, and its variances are used as they are. "
    "First we assign the very descriptors that made the classes, then descriptors of other "
    "frames from the same viewpoints. How often is the Mahalanobis distance right, compared with "
    "the Euclidean distance to the same means?",
    "replies": {
        "better on both": "Three numbers hardly make a variance. Tested on those three, that "
        "cannot show.",
        "worse on both": "For the descriptors from which they were computed, the variances are "
        "perfect.",
        "better on its own, worse on others": "A class of three knows its own three by heart, "
        "and nothing else.",
    },
    "right": "better on its own, worse on others",
}

REPAIR = {
    "question": ("Which one repair makes the Mahalanobis distance usable with three frames?"),
    "replies": {
        "the log-determinant": "It penalises large variances. The harm done by small ones, such "
        "as a wrong zero, remains.",
        "more frames, thirty": "That helps, but it is not enough: try again from the side.",
        "variances that the landmarks share": "Thousands of frames, of all landmarks, make one "
        "good variance for each entry.",
    },
    "right": "variances that the landmarks share",
}
