"""What tests of findings share: all states of an explorer, its presets, and the axes of a state."""

from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any

from matplotlib.axes import Axes

from robot_perception.teaching.controls import Control

Controls = Mapping[str, Control]


def states(controls: Controls) -> Iterator[dict[str, Any]]:
    """Yield every state of an explorer."""
    for values in product(*(control.values for control in controls.values())):
        yield dict(zip(controls, values, strict=True))


def default(controls: Controls) -> dict[str, Any]:
    """Return the state that an explorer starts in."""
    return {name: control.values[control.default] for name, control in controls.items()}


def presets_that_show_the_default(
    presets: Mapping[str, Mapping[str, Any]], controls: Controls
) -> list[str]:
    """Return the names of the presets that lead where the explorer starts."""
    start = default(controls)
    return [name for name, values in presets.items() if start | dict(values) == start]


def limits(ax: Axes) -> tuple[float, ...]:
    """Return the limits of both axes."""
    return (*ax.get_xlim(), *ax.get_ylim())
