"""Numbers in prose, computed where they stand."""

from robot_perception.checks import instance
from robot_perception.teaching.media import Shown


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
    instance("text", text, str)
    unused = dict(numbers)

    class Numbers(dict):
        def __missing__(self, name: str) -> object:
            raise ValueError(f"the text uses {{{name}}}, which is not given")

        def __getitem__(self, name: str) -> object:
            unused.pop(name, None)
            return super().__getitem__(name)

    written = text.format_map(Numbers(numbers))
    if unused:
        raise ValueError(f"given but not used in the text: {', '.join(unused)}")
    return Shown({"text/markdown": written, "text/plain": written})
