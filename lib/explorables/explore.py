"""Explorers: a drawing with controls, alive in Jupyter, on a built page, and still in print.

In Jupyter an explorer is an ipywidgets widget that holds its default picture; moving a control
calls `draw` in the kernel. While the book is built the whole grid of states is drawn and stored
with the page, which then needs neither a kernel nor a network. Without scripts, on paper, and in a
notebook that was saved or exported the default state remains, with its alternative text.
"""

import inspect
import json
import math
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from hashlib import sha256
from itertools import product
from types import MappingProxyType
from typing import Any

import anywidget
import numpy as np
import traitlets
from IPython.display import display

from explorables.controls import Control, Drag, choice, slider, timeline, toggle
from explorables.figures.output import (
    check_alt,
    check_name,
    figcaption,
    front_end,
    is_lettered,
    on_page,
    opening,
)
from explorables.figures.svg import Marks
from explorables.media import data_element
from explorables.states import WEBP, Frame, pack, render

__all__ = ["Drag", "Explorer", "choice", "explore", "explorers_in", "slider", "timeline", "toggle"]

MOST_STATES = 120
"""Most states of one explorer; each of them is drawn and stored when the book is built."""

Alt = str | Callable[..., str]

STILL_STYLE = (
    "<style>.jp-OutputArea-child:has(#{still}) + .jp-OutputArea-child > .jupyter-widgets"
    " {{ display: none; }}</style>"
)
"""Hides, below a still picture, JupyterLab's word that the view has lost its model."""


def explore(
    draw: Callable[..., Any],
    *,
    alt: Alt,
    caption: str | None = None,
    name: str | None = None,
    presets: Mapping[str, Mapping[str, Any]] | None = None,
    pixelated: bool = False,
    lossless: bool = False,
    drag: Drag | Sequence[str] | None = None,
    **controls: Control,
) -> "Explorer":
    """Let the reader move the parameters of a drawing.

    Parameters
    ----------
    draw
        Called with one value per control; returns a figure or an 8-bit image. Reusing one figure
        makes it twice as fast.
    alt
        Alternative text, or a function of the same parameters that returns it.
    caption, name
        As for `explorables.figures.show`.
    presets
        Settings worth visiting: name of the button, and the values it sets. A control that a preset
        does not name goes to its default.
    pixelated
        Enlarge images without smoothing, for masks and label images.
    lossless
        Keep every value of the images.
    drag
        Names of two controls whose values are a point of the figure's first axes, or a `Drag`: the
        point can be dragged in the picture, and moved by arrow keys, to the nearest state.
    **controls
        The controls by the name of the parameter they set.

    Raises
    ------
    ValueError
        If the controls do not fit the drawing, a preset or `drag` does not fit the controls, the
        grid has too many states, or the alternative text does not serve.
    TypeError
        If a control is no control, `draw` returns something else than a picture, or a figure
        where `pixelated` or `lossless` ask for an image, or an image where `drag` asks for axes.

    Examples
    --------
    >>> from explorables.figures import figure
    >>> fig, ax = figure()
    >>> def draw(gain):
    ...     ax.clear()
    ...     ax.plot([0, 1], [0, gain])
    ...     return fig
    >>> explorer = explore(
    ...     draw, alt="A line whose slope is the gain.", gain=slider("Gain", [0.5, 1, 2], 1)
    ... )
    >>> explorer.gain
    1.0
    """
    presets = {} if presets is None else presets
    return Explorer(draw, alt, caption, name, presets, controls, pixelated, lossless, drag)


class Explorer(anywidget.AnyWidget):
    """A drawing with controls; use `explore` to make one.

    Each control is an observable trait of its own name, so that it can be linked with other
    widgets; `parameters` holds them all. `metadata_of_output` goes with its output.
    """

    _esm = front_end("explorer.js") + "\nexport default { render: explorables.render };\n"
    _css = front_end("figure.css") + front_end("explorer.css")

    spec = traitlets.Dict().tag(sync=True)
    indices = traitlets.Dict().tag(sync=True)
    picture = traitlets.Dict().tag(sync=True)
    still = traitlets.Unicode().tag(sync=True)
    parameters = traitlets.Dict()
    metadata_of_output: Mapping[str, Any] = MappingProxyType({})

    def __init__(
        self,
        draw: Callable[..., Any],
        alt: Alt,
        caption: str | None,
        name: str | None,
        presets: Mapping[str, Mapping[str, Any]],
        controls: Mapping[str, Control],
        pixelated: bool,
        lossless: bool,
        drag: Drag | Sequence[str] | None = None,
    ) -> None:
        _check(draw, controls)
        if not callable(alt):
            check_alt(alt)
        check_name(name, caption)
        super().__init__()
        self._pixelated = pixelated
        self._lossless = lossless
        self._draw = draw
        self._alt = alt
        self._controls = dict(controls)
        self._caption = caption
        self._name = name
        self._drag = _handle(drag, controls)
        self._watched = False
        self._moving = False
        self._presets = {name: self._complete(values, name) for name, values in presets.items()}
        self.add_traits(**{name: _Value(control) for name, control in controls.items()})
        self.parameters = self.defaults
        self.indices = self._indices()
        self.spec = self._specification()
        self.observe(self._control_moved, list(controls))
        self.observe(self._parameters_set, "parameters")
        self.on_msg(self._receive)
        self._markup = self.page() if on_page() else self._still()

    @property
    def controls(self) -> dict[str, Control]:
        """The controls by name."""
        return dict(self._controls)

    @property
    def presets(self) -> dict[str, dict[str, Any]]:
        """The presets by name, each with a value for every control."""
        return {name: dict(values) for name, values in self._presets.items()}

    @property
    def defaults(self) -> dict[str, Any]:
        """The value of every control at the start."""
        return {name: c.values[c.default] for name, c in self._controls.items()}

    def frame(self, *, effort: int = 4, **parameters: Any) -> Frame:
        """Draw a state by some controls, the others at their defaults."""
        values = self._complete(parameters, "frame")
        return self._rendered(*self._drawn(values), marks=self._marks(values), effort=effort)

    def _drawn(self, parameters: Mapping[str, Any]) -> tuple[object, str]:
        """Return what `draw` makes of a state, and its alternative text."""
        alt = self._alt(**parameters) if callable(self._alt) else self._alt
        return self._draw(**parameters), check_alt(alt)

    def _rendered(self, drawing: object, alt: str, **options: Any) -> Frame:
        how = {"lossless": self._lossless, "letters": is_lettered(self._caption)}
        frame = render(drawing, alt, **how, **options)
        if (self._pixelated or self._lossless) and frame.mime != WEBP:
            raise TypeError("pixelated and lossless are for a draw that returns uint8 arrays")
        if self._drag and frame.mime == WEBP:
            raise TypeError("drag is for a draw that returns a figure: an image has no axes")
        return frame

    def _marks(self, values: Mapping[str, Any]) -> Marks | None:
        """Return where the point that can be dragged is for each state of its own controls."""
        if self._drag is None:
            return None
        names = self._drag.controls
        grid = product(*(self._controls[name].values for name in names))
        own = (dict(zip(names, moved, strict=True)) for moved in grid)
        return self._drag.panel, [self._drag.at({**values, **moved}) for moved in own]

    def grid(self) -> Iterator[dict[str, Any]]:
        """Yield the parameters of every state, the last control fastest."""
        for values in product(*(control.values for control in self._controls.values())):
            yield dict(zip(self._controls, values, strict=True))

    def end_points(self) -> Iterator[dict[str, Any]]:
        """Yield the parameters with each control at each of its ends, the others at their defaults.

        A choice has an end at every option. The presets follow.
        """
        for name, control in self._controls.items():
            every = control.kind in ("choice", "toggle")
            for value in control.values if every else (control.values[0], control.values[-1]):
                yield self.defaults | {name: value}
        yield from self.presets.values()

    def _repr_mimebundle_(self, **kwargs: Any) -> dict[str, str]:
        """Return the page, or the default picture."""
        return {"text/html": self._markup, "text/plain": self._default.alt}

    def _ipython_display_(self) -> None:
        """Show the page; or the picture, which outlives the kernel, and the view that replaces it.

        Two outputs: JupyterLab prefers the view to a picture in the same output, also where nothing
        can bring the view to life.
        """
        display(self._repr_mimebundle_(), raw=True, metadata=dict(self.metadata_of_output))
        if not on_page():
            view, _ = super()._repr_mimebundle_()
            display(view | {"text/plain": ""}, raw=True)

    def _complete(self, values: Mapping[str, Any], where: str) -> dict[str, Any]:
        unknown = values.keys() - self._controls.keys()
        if unknown:
            raise ValueError(
                f"presets or parameters: {where!r} sets {', '.join(sorted(unknown))}, which is no"
                " control"
            )
        return self.defaults | {
            name: self._controls[name].values[self._controls[name].index_of(value)]
            for name, value in values.items()
        }

    def _indices(self, values: Mapping[str, Any] | None = None) -> dict[str, int]:
        values = self.parameters if values is None else values
        return {name: c.index_of(values[name]) for name, c in self._controls.items()}

    def _specification(self) -> dict[str, Any]:
        return {
            "controls": [
                {
                    "name": name,
                    "kind": control.kind,
                    "label": control.label,
                    "shown": control.shown,
                    "default": control.default,
                    "fps": control.fps,
                }
                for name, control in self._controls.items()
            ],
            "presets": [
                {"label": name, "indices": self._indices(values)}
                for name, values in self._presets.items()
            ],
            "caption": figcaption(self._caption),
            "spoken": callable(self._alt),
            "figure": "rp-figure rp-pixelated" if self._pixelated else "rp-figure",
            "name": f"fig-{self._name}" if self._name else "",
            "drag": self._drag
            and {"controls": list(self._drag.controls), "label": self._drag.label},
        }

    def _still(self) -> str:
        values = self.defaults
        drawing, alt = self._drawn(values)
        self._default = self._rendered(drawing, alt, marks=self._marks(values))
        self.picture = _described(self._default) | {"data": self._default.data}
        self.still = f"explorer-{self.model_id}"
        picture = self._rendered(drawing, alt, together=True).element(inline=False)
        paper = f'<div style="background-color: white">{picture}</div>'  # its ink is black
        start = opening(self.spec["figure"], self._name)
        figure = f"{start}{paper}{figcaption(self._caption)}</figure>"
        style = STILL_STYLE.format(still=self.still)
        return f'<div class="explorer-still" id="{self.still}">{figure}</div>{style}'

    def page(self) -> str:
        """Return the explorer as a page holds it: all states, and the default one in view."""
        frames = [self.frame(**parameters) for parameters in self.grid()]
        controls = self._controls.values()
        defaults, sizes = [c.default for c in controls], [len(c.values) for c in controls]
        self._default = frames[np.ravel_multi_index(defaults, sizes)]
        spec, states = json.dumps(self.spec, ensure_ascii=False), pack(frames)
        name = sha256((spec + states).encode()).hexdigest()[:12]
        start = opening(self.spec["figure"], self._name)
        return (
            f'<div class="explorer" id="explorer-{name}">{start}'
            f'<div class="rp-canvas">{self._default.element(inline=True)}</div>'
            f"{figcaption(self._caption)}</figure>"
            f"{data_element('rp-spec', spec)}{data_element('rp-states', states)}</div>"
        )

    @contextmanager
    def _together(self) -> Iterator[None]:
        self._moving = True
        try:
            yield
        finally:
            self._moving = False
            self.parameters = {name: getattr(self, name) for name in self._controls}
            self.indices = self._indices()

    def _control_moved(self, _: Any) -> None:
        if self._moving:
            return
        with self._together():
            pass
        if self._watched:
            self._answer(None)

    def _parameters_set(self, change: Any) -> None:
        if self._moving or change["new"] == {name: getattr(self, name) for name in self._controls}:
            return
        with self._together():
            for name, value in self._complete(change["new"], "parameters").items():
                setattr(self, name, value)
        if self._watched:
            self._answer(None)

    def _receive(self, _: Any, content: Mapping[str, Any], __: Any) -> None:
        """Answer a view that asks for the picture of some setting: the controls' indices."""
        if content.get("type") != "draw":
            return
        self._watched = True
        with self._together():
            for name, index in content["indices"].items():
                setattr(self, name, self._controls[name].values[index])
        self._answer(content["request"])

    def _answer(self, request: int | None) -> None:
        about = {"request": request, "indices": self._indices()}
        try:
            frame = self.frame(effort=0, **self.parameters)
        except Exception as error:
            text = "".join(traceback.format_exception_only(error)).strip()
            self.send({"type": "error", "text": text, **about})
            return
        self.send({"type": "frame", **_described(frame), **about}, [frame.data])


class _Value(traitlets.TraitType):
    """A trait that takes only the values of one control."""

    def __init__(self, control: Control) -> None:
        super().__init__(default_value=control.values[control.default])
        self._control = control

    def validate(self, obj: object, value: object) -> object:
        try:
            return self._control.values[self._control.index_of(value)]
        except ValueError as error:
            raise traitlets.TraitError(str(error)) from error


def explorers_in(namespace: Mapping[str, Any]) -> list[Explorer]:
    """Find the explorers among the variables and displayed values of a notebook, each once."""
    displayed = namespace.get("Out", {})
    values = [*namespace.values(), *(displayed.values() if isinstance(displayed, dict) else ())]
    return list({id(value): value for value in values if isinstance(value, Explorer)}.values())


def _check(draw: Callable[..., Any], controls: Mapping[str, Control]) -> None:
    if not callable(draw):
        raise TypeError(f"draw must be a function, got {draw!r}")
    if not controls:
        raise ValueError("controls must not be empty: an explorer needs a control")
    for name, control in controls.items():
        if not isinstance(control, Control):
            raise TypeError(
                f"controls: {name} must be a slider, choice, toggle or timeline, got {control!r}"
            )
        if hasattr(Explorer, name):
            raise ValueError(f"{name!r} is a name that widgets use; rename the parameter")
    labels = [control.label for control in controls.values()]
    if len(set(labels)) < len(labels):
        raise ValueError(f"labels must differ, got {', '.join(labels)}")
    counts = [len(control.values) for control in controls.values()]
    if math.prod(counts) > MOST_STATES:
        raise ValueError(
            f"{' × '.join(map(str, counts))} = {math.prod(counts)} states of"
            f" {', '.join(controls)}; at most {MOST_STATES} can be stored with a page"
        )
    try:
        inspect.signature(draw).bind(**dict.fromkeys(controls))
    except TypeError as error:
        raise ValueError(f"draw does not take {', '.join(controls)}: {error}") from error


def _handle(drag: Drag | Sequence[str] | None, controls: Mapping[str, Control]) -> Drag | None:
    """Return what can be dragged, or raise ``ValueError`` if its controls are not there."""
    if drag is None:
        return None
    handle = drag if isinstance(drag, Drag) else Drag(tuple(drag))
    least = 1 if handle.place else 2
    if not least <= len(handle.controls) <= 2 or not set(handle.controls) <= controls.keys():
        raise ValueError(
            f"drag must name two of the controls {', '.join(controls)}, or one and the place of"
            f" the point, got {', '.join(handle.controls)}"
        )
    return handle


def _described(frame: Frame) -> dict[str, Any]:
    """Return what a view must know of a frame beside its bytes."""
    return {"mime": frame.mime, "alt": frame.alt}
