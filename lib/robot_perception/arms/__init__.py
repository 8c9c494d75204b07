"""Two arms are followed by one camera: a model of the body, likelihoods cue by cue, a tracker."""

from importlib import import_module

from robot_perception.doors import door

__getattr__, __dir__, __all__ = door(
    __name__,
    {
        "body_model": ("BodyModel", "Measures"),
        "likelihoods": (
            "CollisionCue",
            "EdgeCue",
            "EdgeRules",
            "LimitCue",
            "PatchCue",
            "StabiliserCue",
        ),
        "printed": ("SumCue",),
        "tracker": ("BOUNDS", "CUES", "FILTERS", "ArmRules", "ArmTracker", "find_face"),
        "watching": ("ArmWatch",),
    },
    import_module,
)
