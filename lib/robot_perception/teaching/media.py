"""Objects that a notebook shows: one plain value with its representations."""

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Shown:
    """Something to show in a notebook, by media type.

    Parameters
    ----------
    bundle
        Representations by media type; ``text/plain`` is what a terminal prints and what a test
        compares.
    """

    bundle: Mapping[str, str]

    def _repr_mimebundle_(self, include: object = None, exclude: object = None) -> dict[str, str]:
        return dict(self.bundle)

    def __repr__(self) -> str:
        return self.bundle.get("text/plain", "")
