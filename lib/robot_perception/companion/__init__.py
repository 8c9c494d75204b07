"""A robot's tutor has a face, a raised hand and a way to follow; a table says when to do what."""

from importlib import import_module

from robot_perception.doors import door

__getattr__, __dir__, __all__ = door(
    __name__,
    {
        "boxes": ("crop", "overlap", "overlap_in_pairs"),
        "cues": (),
        "faces": (),
        "following": ("Follower",),
        "hands": (),
        "interaction": ("Event", "Interaction", "StateTable", "Transition", "paper_table"),
        "robot": ("CompanionRobot", "RobotRules"),
        "tutor": ("TutorModel", "TutorRules", "TutorTracker"),
    },
    import_module,
)
