"""Raised hands are found by Haar-like features, boosted to a cascade that is trained here."""

from importlib import import_module

from robot_perception.doors import door

__getattr__, __dir__, __all__ = door(
    __name__,
    {
        "boosting": ("Boosted", "boost"),
        "cascade": ("Cascade", "Goals", "HandDetector", "train"),
        "features": ("feature_pool", "feature_values"),
        "windows": ("hard_windows", "random_window", "window_at"),
    },
    import_module,
)
