"""Explorations: an explorer as one object, with all that a page and a test need of it.

.. code-block:: python

    rumour = Exploration(
        figures.rumours, heard, describe_rumour,
        caption="True over stated variance …", name="ci-rumour",
        controls={"share": slider("Repeated", (0, 0.5, 1), 0.5)}, presets={"all": {"share": 1}},
        axes=partial(figure, height=3.8), finding=lambda state: state.ratio[-1],
    )

The cell of a notebook ends with ``rumour``, or with ``rumour.show()``; the test of a finding goes
through ``rumour.found()``, or stands in ``finds``. What all states say, ``rumour.said()``, is
recorded.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from typing import Any, Generic, TypeVar

from explorables.controls import Control, Drag
from explorables.explore import Explorer, explore
from explorables.figures import figure
from explorables.figures.output import on_page
from explorables.snapshots import STATES, snapshot

State = TypeVar("State")


@dataclass(frozen=True, eq=False)
class Exploration(Generic[State]):
    """A drawing of a state, the controls that choose the state, and the words for both.

    Parameters
    ----------
    draw
        ``draw(axes, state)`` draws on cleared or kept axes; where ``axes`` is ``None`` it is
        ``draw(state)``, which returns an 8-bit image.
    state
        ``state(**parameters)``: what the controls choose, with a parameter for each control.
    alt
        Alternative text, or a function of the state that returns it.
    controls
        By the name of the parameter they set.
    caption, name
        As for `figures.show`.
    presets
        Settings worth visiting: name of the button, and the values it sets.
    axes
        Makes figure and axes.
    finding
        The quantity that our finding speaks of, as a function of the state: some numbers and texts.
    finds
        Whether our finding holds, as a function of all quantities, in the order of the states; it
        must while the page is built.
    pixelated, lossless, drag
        As for `explore`.
    """

    draw: Callable[..., Any]
    state: Callable[..., State]
    alt: str | Callable[[State], str]
    controls: Mapping[str, Control]
    caption: str | None = None
    name: str | None = None
    presets: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    axes: Callable[[], tuple[Any, Any]] | None = figure
    finding: Callable[[State], Any] | None = None
    finds: Callable[[list[Any]], bool] | None = None
    pixelated: bool = False
    lossless: bool = False
    drag: Drag | Sequence[str] | None = None

    def show(self) -> Explorer:
        """Return the explorer; on the built page it holds all states, and what they say.

        Raises
        ------
        AssertionError
            On the built page, if what we say that a reader finds is not there.
        """
        if not on_page() or self.finding is None:
            return self._explorer(self._draw)
        said = []

        def draw(**parameters: Any) -> Any:
            said.append(self._said(parameters))  # here, where its state is computed anyway
            return self._draw(**parameters)

        explorer = self._explorer(draw)
        if self.finds is not None and not self.finds([finding for finding, _ in said]):
            raise AssertionError(f"{self.name}: our finding does not hold in all states")
        explorer.metadata_of_output = {STATES: json.dumps(snapshot(self.name, said))}
        return explorer

    def _explorer(self, draw: Callable[..., Any]) -> Explorer:
        return explore(
            draw,
            alt=self.alt if isinstance(self.alt, str) else self._describe,
            caption=self.caption,
            name=self.name,
            presets=self.presets,
            pixelated=self.pixelated,
            lossless=self.lossless,
            drag=self.drag,
            **self.controls,
        )

    def _ipython_display_(self) -> None:
        self.show()._ipython_display_()

    @property
    def default(self) -> dict[str, Any]:
        """The parameters at the start."""
        return {name: c.values[c.default] for name, c in self.controls.items()}

    def parameters(self, **fixed: Any) -> Iterator[dict[str, Any]]:
        """Yield the parameters of every state, or of those in which some controls are set."""
        for values in product(*(c.values for c in self.controls.values())):
            setting = dict(zip(self.controls, values, strict=True))
            if fixed.items() <= setting.items():
                yield setting

    def found(self, **fixed: Any) -> list[Any]:
        """Return what the finding speaks of, in every state or where some controls are set."""
        return [self.finding(self.state(**setting)) for setting in self.parameters(**fixed)]

    def said(self) -> list[tuple[Any, str]]:
        """Return what the finding speaks of and the words, of every state."""
        return [self._said(setting) for setting in self.parameters()]

    def drawn(self, **parameters: Any) -> Any:
        """Draw a state, the other controls at the start, and return the axes or the image."""
        drawing = self._draw(**self.default | parameters)
        return drawing if self.axes is None else self._made[1]

    def described(self, **parameters: Any) -> str:
        """Return the alternative text of a state, the other controls at the start."""
        return self._describe(**self.default | parameters)

    @cached_property
    def _made(self) -> tuple[Any, Any]:
        return self.axes()

    @cached_property
    def _last(self) -> dict[str, Any]:
        return {}

    def _state(self, parameters: Mapping[str, Any]) -> State:
        """Return a state; drawing and alternative text ask for the same one after the other."""
        if self._last.get("parameters") != parameters:
            self._last.update(state=self.state(**parameters), parameters=dict(parameters))
        return self._last["state"]

    def _said(self, parameters: Mapping[str, Any]) -> tuple[Any, str]:
        return self.finding(self._state(parameters)), self._describe(**parameters)

    def _draw(self, **parameters: Any) -> Any:
        state = self._state(parameters)
        if self.axes is None:
            return self.draw(state)
        fig, axes = self._made
        self.draw(axes, state)
        return fig

    def _describe(self, **parameters: Any) -> str:
        return self.alt if isinstance(self.alt, str) else self.alt(self._state(parameters))
