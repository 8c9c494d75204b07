"""Snapshots of explorers: what each state says, findings and words, as plain data.

While the book is built the snapshot of an explorer becomes metadata of its output, as a text of
JSON: messages of kernels hold no infinity. No page shows it; it stays in the executed notebook that
the build keeps, where a test finds what was computed.
"""

from collections.abc import Mapping, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np

STATES = "explorables_states"
"""The name of a snapshot in the metadata of an output."""
DIGITS = 9
"""Significant digits of a stored number."""
ARRAY, FIELDS, ENTRIES = "array", "fields", "entries"
"""Marks that tell arrays, namespaces and dictionaries from sequences."""


def snapshot(name: str | None, said: Sequence[tuple[Any, str]]) -> dict[str, Any]:
    """Return what the states of an explorer say, as JSON can hold it.

    Parameters
    ----------
    name
        The explorer.
    said
        Finding and words of each state.
    """
    findings, words = zip(*said, strict=True)
    return {"name": name, "findings": [plain(one) for one in findings], "words": list(words)}


def plain(finding: Any) -> Any:
    """Return a finding as JSON can hold it, its numbers rounded to `DIGITS`.

    Raises
    ------
    TypeError
        If it is not made of numbers, texts, arrays, sequences, dictionaries and namespaces.
    """
    if isinstance(finding, np.generic):
        finding = finding.item()
    if finding is None or isinstance(finding, str | bool | int):
        return finding
    if isinstance(finding, float):
        return float(f"{finding:.{DIGITS}g}")
    if isinstance(finding, np.ndarray):
        return {ARRAY: plain(finding.tolist())}
    if isinstance(finding, tuple | list):
        return [*map(plain, finding)]
    if isinstance(finding, SimpleNamespace):
        return {FIELDS: {name: plain(value) for name, value in vars(finding).items()}}
    if isinstance(finding, Mapping):
        return {ENTRIES: [[plain(key), plain(value)] for key, value in finding.items()]}
    raise TypeError(
        f"finding must be made of numbers, texts and arrays, got {type(finding).__name__}"
    )


def finding_of(stored: Any) -> Any:
    """Return the finding that `plain` has stored; its sequences are tuples."""
    if isinstance(stored, list):
        return tuple(map(finding_of, stored))
    if not isinstance(stored, dict):
        return stored
    ((kind, value),) = stored.items()
    if kind == ARRAY:
        return np.array(value)
    if kind == FIELDS:
        return SimpleNamespace(**{name: finding_of(part) for name, part in value.items()})
    return {finding_of(key): finding_of(part) for key, part in value}
