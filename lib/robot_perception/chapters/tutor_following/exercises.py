"""The exercises of the chapter "Follow me"."""

from robot_perception.teaching.exercises import Exercise, Sheet

EXERCISES = Sheet(
    {
        "following-integral": Exercise(
            21.0,
            mistakes=(
                (15.0, "the upper left part was not added back, but taken away once more."),
                (18.0, "what lies above and to the left was taken away twice: add it back."),
            ),
            hint="What is above and what is to the left overlap: they share the upper left part.",
            rtol=1e-6,
        ),
        "following-cascade": Exercise(
            30_000 * 0.5**13,
            mistakes=(
                (30_000 * 0.5 / 13, "each stage halves what is left: multiply."),
                (30_000 * (1 - 0.995**13), "that is from the share of hands that are lost."),
                (30_000 * 0.5**12, "there are thirteen stages."),
            ),
            hint="Each stage lets half of what it gets pass.",
            rtol=0.01,
        ),
        "following-drift": Exercise(
            1 - 0.95**25,
            mistakes=(
                (25 * 0.05, "more than all: what was learnt first is forgotten, too."),
                (0.95**25, "that is the share of the person that is left."),
            ),
            hint="In each picture 95 % of the model stay. After 25 pictures?",
            rtol=0.01,
        ),
    }
)
check = EXERCISES.check
