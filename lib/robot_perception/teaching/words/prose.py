"""Numbers in prose, computed where they stand."""

from collections.abc import Mapping
from string import Formatter

from explorables.media import Shown
from studies.intervals import Interval
from studies.numbers import typeset

POINTS = "p"
"""Ends the format of a difference of shares: per cent, without the sign."""


class _Typeset(Formatter):
    """Writes numbers as print does: −2, 2 × 10⁻¹⁵, 5 %, 10 000, and no negative zero."""

    def get_value(self, key: int | str, args: object, kwargs: Mapping[str, object]) -> object:
        if key not in kwargs:
            raise ValueError(f"the text uses {{{key}}}, which is not given")
        return kwargs[key]

    def check_unused_args(self, used_args: set, args: object, kwargs: Mapping) -> None:
        unused = [name for name in kwargs if name not in used_args]
        if unused:
            raise ValueError(f"given but not used in the text: {', '.join(unused)}")

    def format_field(self, value: object, spec: str) -> str:
        value = value() if callable(value) else value
        number = value.estimate if isinstance(value, Interval) and spec else value
        points = spec.endswith(POINTS)
        text = super().format_field(number, f"{spec[:-1]}%" if points else spec)
        text = text.removesuffix("%") if points else text
        return typeset(text) if hasattr(number, "__float__") else text


def tell(text: str, **numbers: object) -> Shown:
    r"""Return Markdown with computed numbers in it.

    Every number of the book's prose is injected this way, so that it cannot differ from what the
    library computes.

    Parameters
    ----------
    text
        Markdown; ``{name}`` or ``{name:.2f}`` takes a number, ``{{`` stands for a brace. Of shares
        ``{name:.0%}`` is written in per cent, of their differences ``{name:.0p}`` in points.
    numbers
        The values by name. Of an interval the estimate is told, its ends are ``{name.low:.2f}``
        and ``{name.high:.2f}``; of a measure, what it gives.

    Raises
    ------
    ValueError
        If the text uses a name that is not given, or a name is given that it does not use.

    Examples
    --------
    >>> tell("The gain is {gain:.2f}.", gain=0.25)
    The gain is 0.25.
    """
    written = _Typeset().format(text, **numbers)
    return Shown({"text/markdown": written, "text/plain": written})
