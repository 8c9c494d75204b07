"""Evaluation of estimates: consistency, and errors of paths."""

from importlib import import_module

from robot_perception.doors import door

__getattr__, __dir__, __all__ = door(
    __name__,
    {
        "consistency": ("average_bounds", "coverage", "normalised_squared"),
        "spatial": ("Similarity",),
        "trajectories": ("PoseError", "RelativeErrors"),
    },
    import_module,
)
