"""The door of a room: what a stranger finds in it by name, imported when it is asked for."""

from collections.abc import Callable, Collection, Mapping
from types import ModuleType


def door(
    room: str, offered: Mapping[str, Collection[str]], by: Callable[[str], ModuleType]
) -> tuple[Callable[[str], object], Callable[[], list[str]], list[str]]:
    """Return ``__getattr__``, ``__dir__`` and ``__all__`` of a package that imports when asked.

    Who enters one module of a room waits for no other, and needs no package that another needs.

    Parameters
    ----------
    room
        Name of the package.
    offered
        The modules that it offers, and of each what stands in the package, too.
    by
        ``importlib.import_module``. The package imports it itself, so that the import graph shows
        who may import by name.
    """
    homes = {name: module for module, names in offered.items() for name in names}
    everything = sorted({*offered, *homes})

    def find(name: str) -> object:
        module = homes.get(name, name)
        if module not in offered:
            raise AttributeError(f"module {room!r} has no attribute {name!r}")
        found = by(f"{room}.{module}")
        return found if name == module else getattr(found, name)

    return find, lambda: everything, everything
