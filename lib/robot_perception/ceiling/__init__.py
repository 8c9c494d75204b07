"""Patterns on a ceiling are found, tracked and put together to a mosaic; a path is remembered."""

from importlib import import_module

from robot_perception.doors import door

__getattr__, __dir__, __all__ = door(
    __name__,
    {
        "contours": ("ContourRules", "find_contours", "find_edges"),
        "correction": ("Correction",),
        "mapping": ("AS_PRINTED", "MapRules", "Mapper", "PatternTrackers"),
        "mosaic": ("Mosaic", "adjust", "paint"),
        "navigator": ("Navigator",),
        "patterns": ("Pattern", "PatternRules", "WindowRules", "interest_windows", "make_pattern"),
        "recognition": ("RecognitionRules", "recognise"),
        "tracker": ("PatternTracker", "TrackerRules"),
        "visual_memory": (
            "Follower",
            "KeyImage",
            "KeyRules",
            "PathGraph",
            "ServoRules",
            "choose_key_images",
            "servo",
        ),
    },
    import_module,
)
