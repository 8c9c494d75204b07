"""What tests of findings share: what every explorer must pass, and the axes of a state.

.. code-block:: python

    class TestExplorers(ExplorerTests):
        explorers = (BUILT, PLAY)
"""

from itertools import product

import numpy as np
import pytest
from matplotlib.axes import Axes

from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.explore import MOST_STATES


def presets_that_show_the_default(explorer: Exploration) -> list[str]:
    """Return the names of the presets that lead where an explorer starts."""
    start = explorer.default
    return [name for name, values in explorer.presets.items() if start | dict(values) == start]


def limits(ax: Axes) -> tuple[float, ...]:
    """Return the limits of both axes."""
    return (*ax.get_xlim(), *ax.get_ylim())


class ExplorerTests:
    """Presets lead elsewhere, a page can hold all states, and axes stay while controls move."""

    explorers: tuple[Exploration, ...]

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """Make one test an explorer."""
        if "explorer" in metafunc.fixturenames:
            ids = [explorer.name for explorer in self.explorers]
            metafunc.parametrize("explorer", self.explorers, ids=ids)

    def test_no_preset_shows_the_default_and_there_are_not_too_many_states(
        self, explorer: Exploration
    ):
        assert not presets_that_show_the_default(explorer)
        assert len(list(explorer.parameters())) <= MOST_STATES

    def test_every_end_is_drawn_and_said_on_axes_that_stay(self, explorer: Exploration):
        ends = {name: (c.values[0], c.values[-1]) for name, c in explorer.controls.items()}
        seen = set()
        for values in product(*ends.values()):
            setting = dict(zip(ends, values, strict=True))
            drawn = np.ravel(explorer.drawn(**setting))  # axes, or a figure of them
            axes = np.ravel([one.axes for one in drawn])
            seen.add(tuple(limits(ax) for ax in axes))
            for line in (line for ax in axes for line in ax.lines if len(line.get_ydata())):
                assert np.isfinite(np.asarray(line.get_ydata(), dtype=float)).any(), setting
            assert explorer.described(**setting)
        assert len(seen) == 1
