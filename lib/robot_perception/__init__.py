"""Five classic papers on how mobile robots perceive, rebuilt from running code."""

from importlib.metadata import version

from robot_perception import project  # noqa: F401 - tells `studies` where the book is

__version__ = version("robot-perception")
