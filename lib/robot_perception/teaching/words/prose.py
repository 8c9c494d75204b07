"""Numbers in prose, computed where they stand."""

from collections.abc import Mapping
from string import Formatter

from explorables.media import Shown
from studies.numbers import typeset


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
        text = super().format_field(value, spec)
        return typeset(text) if hasattr(value, "__float__") else text


def tell(text: str, **numbers: object) -> Shown:
    r"""Return Markdown with computed numbers in it.

    Every number of the book's prose is injected this way, so that it cannot differ from what the
    library computes.

    Parameters
    ----------
    text
        Markdown; ``{name}`` or ``{name:.2f}`` takes a number, ``{{`` stands for a brace.
    numbers
        The values by name.

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
