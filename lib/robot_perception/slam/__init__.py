"""A robot finds where it is and what stands around it: on a rail, in the plane, by what it sees."""

from importlib import import_module

from robot_perception.doors import door

__getattr__, __dir__, __all__ = door(
    __name__,
    {
        "localisation": (),
        "monobot": (),
        "observability": (),
        "planar": (),
        "rao_blackwellised": (),
        "visual": (),
    },
    import_module,
)
