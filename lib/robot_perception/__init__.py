"""Five classic papers on how mobile robots perceive, rebuilt from running code."""

from importlib.metadata import version

__version__ = version("robot-perception")
