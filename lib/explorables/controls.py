"""The controls of an explorer: finite lists of values with a label and a default."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

Kind = Literal["slider", "choice", "toggle", "timeline"]


@dataclass(frozen=True, slots=True)
class Control:
    """One control: its values, how they are shown, and where it starts.

    Parameters
    ----------
    kind
        What the reader sees: a range input, a selection, a check box, a range with play and pause.
    label
        Name shown beside the control, with the quantity it sets.
    values
        What `draw` receives.
    shown
        The same values as text.
    default
        Index of the value at the start.
    fps
        Frames per second of a timeline at play.
    """

    kind: Kind
    label: str
    values: tuple[Any, ...]
    shown: tuple[str, ...]
    default: int
    fps: float | None = None

    def __post_init__(self) -> None:
        """Refuse a control that cannot work."""
        if not self.label.strip():
            raise ValueError("label must not be empty: a control needs a label")
        if self.fps is not None and not self.fps > 0:
            raise ValueError(f"fps of {self.label!r} must be positive, got {self.fps}")
        if len(self.values) < 2:
            raise ValueError(f"{self.label!r} needs two values or more, got {self.values}")
        if len(set(self.shown)) < len(self.shown):
            raise ValueError(f"values of {self.label!r} look alike: {', '.join(self.shown)}")

    def index_of(self, value: object) -> int:
        """Return the index of a value; a number may differ by rounding.

        Raises
        ------
        ValueError
            If the control has no such value.
        """
        for alike in (_same, _close):  # of values that are close, the very one first
            for index, known in enumerate(self.values):
                if alike(known, value):
                    return index
        raise ValueError(
            f"{self.label!r} has no value {value!r}; it has {', '.join(self.shown)}"
            " (the default is one of the options)"
        )


Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Drag:
    """A point of a drawing that one or two controls move: by mouse, finger or arrow keys.

    Parameters
    ----------
    controls
        Names of one control or two.
    label
        What is moved.
    place
        ``place(**parameters)``: where the point stands in the coordinates of the axes; ``None``
        where there is none. By default the values of the two controls are the coordinates.
    panel
        The axes, by their number in the figure.
    """

    controls: tuple[str, ...]
    label: str = "the point"
    place: Callable[..., Point | None] | None = None
    panel: int = 0

    def at(self, parameters: Mapping[str, Any]) -> Point | None:
        """Return where the point stands in a state of the explorer."""
        if self.place is not None:
            return self.place(**parameters)
        x, y = (parameters[name] for name in self.controls)
        return x, y


def slider(label: str, values: Iterable[float], default: float, unit: str = "") -> Control:
    """Make a slider over a list of numbers.

    Parameters
    ----------
    label
        Name shown beside it.
    values
        The numbers in order, not necessarily equally spaced.
    default
        The number to start at; one of the values.
    unit
        Unit shown after the number.

    Raises
    ------
    ValueError
        If there are fewer than two values, two look alike, or the default is none of them.
    """
    return _ordered("slider", label, values, default, unit)


def timeline(
    label: str,
    values: Iterable[float],
    default: float,
    unit: str = "",
    *,
    fps: float = 5.0,
) -> Control:
    """Make a slider over time that can be played; it never starts by itself.

    Parameters
    ----------
    label, values, default, unit
        As for `slider`.
    fps
        Frames per second at play.

    Raises
    ------
    ValueError
        As for `slider`, or if `fps` is not positive.
    """
    return _ordered("timeline", label, values, default, unit, float(fps))


def choice(label: str, options: Sequence[Any] | Mapping[str, Any], default: Any) -> Control:
    """Make a choice among a few options.

    Parameters
    ----------
    label
        Name shown beside it.
    options
        The values, or a mapping from shown text to value.
    default
        The value to start with.

    Raises
    ------
    ValueError
        If there are fewer than two options, two look alike, or the default is none of them.
    """
    values = options.values() if isinstance(options, Mapping) else options
    return _with_default("choice", label, tuple(values), tuple(map(str, options)), default)


def toggle(label: str, default: bool = False) -> Control:
    """Make a check box; `draw` receives False or True.

    Parameters
    ----------
    label
        What is so when the box is checked.
    default
        Whether it is checked at the start.
    """
    return _with_default("toggle", label, (False, True), ("off", "on"), default)


def _ordered(
    kind: Kind,
    label: str,
    values: Iterable[float],
    default: float,
    unit: str,
    fps: float | None = None,
) -> Control:
    listed = np.asarray([*values]).tolist()
    numbers = tuple(n if isinstance(n, int) else float(f"{n:.12g}") for n in listed)
    space = "" if unit in ("", "°", "%") else "\N{NO-BREAK SPACE}"
    shown = tuple(f"{format(n, '.4g').replace('-', '−')}{space}{unit}" for n in numbers)
    return _with_default(kind, label, numbers, shown, default, fps)


def _with_default(
    kind: Kind,
    label: str,
    values: tuple[Any, ...],
    shown: tuple[str, ...],
    default: object,
    fps: float | None = None,
) -> Control:
    control = Control(kind, label, values, shown, 0, fps)
    return replace(control, default=control.index_of(default))


def _same(known: object, value: object) -> bool:
    if isinstance(known, np.ndarray) or isinstance(value, np.ndarray):
        return known is value
    return bool(known == value)


def _close(known: object, value: object) -> bool:
    """Return whether two numbers differ by rounding only."""
    return _numeric(known, value) and bool(np.isclose(known, value, rtol=1e-9))


def _numeric(*values: object) -> bool:
    return all(isinstance(v, int | float | np.number) and not isinstance(v, bool) for v in values)
