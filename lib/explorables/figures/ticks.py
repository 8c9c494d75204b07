"""Axes whose ticks are made once and drawn once, since the pictures of an explorer repeat them.

matplotlib makes ticks anew whenever axes are cleared, five artists each, and measures and draws all
of them for every picture: half the time of a picture. Here ticks outlive clearing while nothing
that they are made from changes, and what was written of them is written again where it is the same.
Ticks that somebody has asked for, and may have changed, are drawn as matplotlib draws them.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import chain
from typing import Any

import matplotlib as mpl
from matplotlib.axis import Axis, Tick, XAxis, YAxis
from matplotlib.ticker import NullLocator
from matplotlib.transforms import Bbox

MOST_KEPT = 40
"""Drawings of its ticks that an axis keeps."""

_LISTS = ("majorTicks", "minorTicks")
_ASKED = ("axes.", "font.", "grid.", "lines.", "markers.", "mathtext.", "text.", "xtick.", "ytick.")
_RULES = tuple(name for name in mpl.rcParams if name.startswith(_ASKED))


def checked(values: dict[str, Any]) -> dict[str, Any]:
    """Return settings of matplotlib as their checks return them, ready for `settings`."""
    return dict(mpl.RcParams(values).items())


@contextmanager
def settings(values: dict[str, Any]) -> Iterator[None]:
    """Put checked settings of matplotlib in place.

    `matplotlib.rc_context` copies all there are and checks the new ones, a millisecond each time.
    """
    current = mpl.rcParams
    before = [(name, current._get(name)) for name in values]
    try:
        for name, value in values.items():
            current._set(name, value)
        yield
    finally:
        for name, value in before:
            current._set(name, value)


@dataclass(frozen=True, slots=True)
class _Drawn:
    """Ticks that an axis has drawn.

    Parameters
    ----------
    passage
        What was written, as the renderer keeps it.
    boxes
        Of the labels on either side, in points.
    away
        Place of the axis label in the direction away from the axis.
    """

    passage: Any
    boxes: tuple[list[Bbox], list[Bbox]]
    away: float


class _Lasting(Axis):
    """An axis that keeps its ticks, and what it drew of them.

    What stands in `majorTicks` and `minorTicks` was asked for by somebody; the axis's own ticks
    stand there only while they are needed.
    """

    def __init__(self, *args: Any, style: dict[str, Any], **kwargs: Any) -> None:
        self._style = style
        self._own: dict[str, list[Tick]] = {}
        self._own_from: tuple = ()
        self._drawn: dict[tuple, list[_Drawn]] = {}
        self._drawn_by: list[Any] = []
        super().__init__(*args, **kwargs)

    # ---- what clearing calls: ticks that are not there need not be changed

    def set_tick_params(self, *args: Any, **kwargs: Any) -> None:
        """Set how ticks look; those that are made later will look so."""
        with self._none_made():
            super().set_tick_params(*args, **kwargs)

    def set_clip_path(self, *args: Any, **kwargs: Any) -> None:
        """Set what the grid is cut by."""
        with self._none_made():
            super().set_clip_path(*args, **kwargs)

    @contextmanager
    def _none_made(self) -> Iterator[None]:
        absent = [name for name in _LISTS if name not in vars(self)]
        vars(self).update((name, []) for name in absent)
        try:
            yield
        finally:
            for name in absent:
                vars(self).pop(name, None)

    # ---- its own ticks

    @contextmanager
    def _lent(self) -> Iterator[None]:
        """Put the axis's own ticks in place, unless there are others."""
        if not self._untouched():
            yield
            return
        with settings(self._style):
            source = self._made_from(), _rules()
            own = self._own if self._own_from == source else {}
            for tick in chain(*own.values()):
                tick.gridline.set_clip_box(self.get_clip_box())
            vars(self).update(own)
            try:
                yield
            finally:
                there = vars(self)
                self._own = {name: there.pop(name) for name in _LISTS if name in there}
                self._own_from = source

    def _untouched(self) -> bool:
        return not any(name in vars(self) for name in _LISTS)

    def _made_from(self) -> tuple:
        kinds = self._major_tick_kw, self._minor_tick_kw
        spines = (spine.get_position() for spine in self.axes.spines.values())
        return *(tuple(sorted(kind.items())) for kind in kinds), *spines

    def _get_tick(self, major: bool) -> Tick:
        tick = super()._get_tick(major)
        tick.gridline.set_clip_box(self.get_clip_box())
        return tick

    def set_ticks(
        self, ticks: Any, labels: Any = None, *, minor: bool = False, **kwargs: Any
    ) -> list[Tick]:
        """Set where ticks are and how they are labelled; return those that somebody asked for."""
        if kwargs:  # of the labels that are there now
            return super().set_ticks(ticks, labels, minor=minor, **kwargs)
        with self._lent():
            made = super().set_ticks(ticks, labels, minor=minor)
        return [] if self._untouched() else made

    def _get_ticks_position(self) -> Any:
        with self._lent():
            return super()._get_ticks_position()

    def get_tightbbox(self, renderer: Any = None, *, for_layout_only: bool = False) -> Bbox | None:
        """Return the box around labels and words; a title asks for it, to keep clear of them."""
        drawn = None if for_layout_only else self._recalled(renderer, self._shown(renderer))
        if drawn is None or not self.get_visible():
            with self._lent():
                return super().get_tightbbox(renderer, for_layout_only=for_layout_only)
        self._place(drawn)
        words = (word for word in (self.offsetText, self.label) if word.get_visible())
        boxes = [*chain(*drawn.boxes), *(word.get_window_extent(renderer) for word in words)]
        finite = [box for box in boxes if box._is_finite()]
        return Bbox.union(finite) if finite else None

    # ---- what it drew of them

    def draw(self, renderer: Any) -> None:
        """Draw the axis, its ticks only where they are not as they were before."""
        key = self._shown(renderer)
        if key is None or not self.get_visible():
            with self._lent():
                super().draw(renderer)
            return
        renderer.open_group("matplotlib.axis", gid=self.get_gid())
        drawn = self._recalled(renderer, key)
        if drawn is None:
            drawn = self._draw_ticks(renderer, key)
        else:
            renderer.repeat(drawn.passage)
        self._place(drawn)
        self.label.draw(renderer)
        self.offsetText.draw(renderer)
        renderer.close_group("matplotlib.axis")
        self.stale = False

    def _draw_ticks(self, renderer: Any, key: tuple) -> _Drawn:
        with self._lent():
            ticks = self._update_ticks()
            boxes = self._get_ticklabel_bboxes(ticks, renderer)
            with renderer.kept() as passage:
                for tick in ticks:
                    tick.draw(renderer)
            self._update_label_position(renderer)
        drawn = _Drawn(passage, boxes, self.label.get_position()[self._across])
        if len(self._drawn) >= MOST_KEPT:
            self._drawn.clear()
        self._drawn.setdefault(key, []).append(drawn)
        return drawn

    def _recalled(self, renderer: Any, key: tuple | None) -> _Drawn | None:
        """Return what was drawn of the same ticks, if it can be written where the renderer is."""
        fitting = (each for each in self._drawn.get(key, ()) if renderer.has_for(each.passage))
        return next(fitting, None)

    def _place(self, drawn: _Drawn) -> None:
        """Put the words beside the ticks' labels."""
        if self._autolabelpos:
            place = list(self.label.get_position())
            place[self._across] = drawn.away
            self.label.set_position(place)
        self._update_offset_text_position(*drawn.boxes)
        self.offsetText.set_text(self.major.formatter.get_offset())

    @property
    def _across(self) -> int:
        return 1 if self.axis_name == "x" else 0

    def _shown(self, renderer: Any) -> tuple | None:
        """Return all that the ticks' drawing depends on, or None if it is not to be kept."""
        axes, fig = self.axes, self.get_figure(root=False)
        if not getattr(renderer, "keeps", False) or not self._untouched() or self.get_rasterized():
            return None
        if len(fig._align_label_groups[self.axis_name].get_siblings(axes)) > 1:
            return None
        rules = _rules()
        if rules != self._drawn_by:
            self._drawn.clear()
            self._drawn_by = rules
        ticks = []
        for kind, places in (
            (self.major, self.get_majorticklocs),
            (self.minor, self.get_minorticklocs),
        ):
            if not isinstance(kind.locator, NullLocator):
                found = places()
                ticks += [*kind.formatter.format_ticks(found), *found]
                ticks += [*self.get_transform().transform(found), len(found)]
        clip = self.get_clip_box()
        return (
            self._made_from(),
            *ticks,
            *self.get_view_interval(),
            *axes.bbox.bounds,
            *(clip.bounds if clip else ()),
            self.get_clip_on(),
            fig.bbox.height,
            self.labelpad,
            self.label_position,
        )


def _rules() -> list[Any]:
    """Return the settings that ticks are made and drawn by, now."""
    return [mpl.rcParams._get(name) for name in _RULES]


class LastingXAxis(_Lasting, XAxis):
    """An abscissa that keeps its ticks."""


class LastingYAxis(_Lasting, YAxis):
    """An ordinate that keeps its ticks."""
