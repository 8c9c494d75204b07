"""What tests of findings share: what every explorer must pass, and the axes of a state.

.. code-block:: python

    class TestExplorers(ExplorerTests):
        explorers = (BUILT, PLAY)
"""

from itertools import product

import numpy as np
import pytest
from matplotlib.axes import Axes

from explorables.explorations import Exploration
from explorables.explore import MOST_STATES
from tests.proof import WHOLE


def presets_that_show_the_default(explorer: Exploration) -> list[str]:
    """Return the names of the presets that lead where an explorer starts."""
    start = explorer.default
    return [name for name, values in explorer.presets.items() if start | dict(values) == start]


def limits(ax: Axes) -> tuple[float, ...]:
    """Return the limits of both axes."""
    return (*ax.get_xlim(), *ax.get_ylim())


def check_presets_and_number_of_states(explorer: Exploration) -> None:
    """Assert that presets lead elsewhere, and that a page can hold all states."""
    assert not presets_that_show_the_default(explorer)
    assert len(list(explorer.parameters())) <= MOST_STATES


def check_ends(explorer: Exploration, whole: bool = WHOLE) -> None:
    """Assert that every end is drawn and said, on axes that stay.

    Of the `whole` all combinations of ends; otherwise all controls at their first value, and all at
    their last one.
    """
    ends = [(c.values[0], c.values[-1]) for c in explorer.controls.values()]
    seen = set()
    for values in product(*ends) if whole else zip(*ends, strict=True):
        setting = dict(zip(explorer.controls, values, strict=True))
        drawn = np.ravel(explorer.drawn(**setting))  # axes, or a figure of them
        axes = np.ravel([one.axes for one in drawn])
        seen.add(tuple(limits(ax) for ax in axes))
        for line in (line for ax in axes for line in ax.lines if len(line.get_ydata())):
            assert np.isfinite(np.asarray(line.get_ydata(), dtype=float)).any(), setting
        assert explorer.described(**setting)
    assert len(seen) == 1


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
        check_presets_and_number_of_states(explorer)

    def test_every_end_is_drawn_and_said_on_axes_that_stay(self, explorer: Exploration):
        check_ends(explorer)
