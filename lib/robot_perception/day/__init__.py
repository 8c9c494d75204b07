"""One robot in which the systems of the five papers hand over to each other, for a day."""

from importlib import import_module

from robot_perception.doors import door

__getattr__, __dir__, __all__ = door(
    __name__,
    {
        "memory": ("Lesson", "Memory", "remember"),
        "robot": ("SYSTEMS", "TASKS", "DayRobot", "Reading", "clear_of", "pointed_at"),
    },
    import_module,
)
