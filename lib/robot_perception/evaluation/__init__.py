"""How good an estimate is: consistency, errors of paths, and intervals of what was measured."""

from importlib import import_module

from robot_perception.doors import door

__getattr__, __dir__, __all__ = door(
    __name__,
    {
        "consistency": ("average_bounds", "coverage", "normalised_squared"),
        "intervals": ("Interval",),
        "progress": (),
        "spatial": ("Similarity",),
        "sweep": (),
        "trajectories": ("PoseError", "RelativeErrors"),
    },
    import_module,
)
