"""What explorers say in all states: as recorded in ``states/<stem>.json``, and as computed now.

A file holds the kind of processor that computed it and, by the name of each explorer, the values of
its controls, of which disturbed findings (`tests.book.predicates`) ``finds`` is true and false, the
texts without their numbers, and a line for each state, the last control fastest: its finding, which
text it has, and the numbers in it.
``python -m tests.tools.snapshot`` writes it.
"""

import json
import math
import os
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from explorables.explorations import Exploration
from explorables.snapshots import (
    ARRAY,
    ENTRIES,
    FIELDS,
    STATES,
    finding_of,
    snapshot,
)
from studies.keys.dependencies import Dependencies
from studies.stored.recorded_rows import COMPARED, NOUGHT, RTOL, processor
from tests.book import pages
from tests.book.computing import module
from tests.proof import WHOLE

FOLDER = Path(__file__).with_name("states")
SITE = "ROBOT_PERCEPTION_SITE"
"""Environment variable: the built site."""
GAP = "#"
"""Stands for a number of a text."""
NUMBER = re.compile(r"[-−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")

Path_ = tuple[str, ...]


def explorers(stem: str) -> dict[str, Exploration]:
    """Return the explorers of a chapter by name."""
    values = vars(module(stem)).values()
    return {one.name: one for one in values if isinstance(one, Exploration)}


def recorded(stem: str) -> dict[str, Any]:
    """Return what is recorded of a chapter; no explorers if nothing is."""
    file = FOLDER / f"{stem}.json"
    if not file.exists():
        return {"processor": processor(), "explorers": {}}
    return json.loads(file.read_text("utf-8"))


def findings(stem: str, name: str) -> list[Any]:
    """Return the recorded findings of an explorer, in the order of the states."""
    return [finding_of(state[0]) for state in recorded(stem)["explorers"][name]["states"]]


def computed(stem: str, name: str) -> dict[str, Any]:
    """Return the snapshot of an explorer: of the build if there is one, otherwise computed."""
    explorer = explorers(stem)[name]
    return built(stem).get(name) or snapshot(name, explorer.said())


@cache
def built(stem: str) -> dict[str, dict[str, Any]]:
    """Return the snapshots by name that this code's site was built with; none without a site.

    The build keeps them among the results of a page, in a folder named by all that they depend on.
    """
    site = os.environ.get(SITE)
    if not site or WHOLE:
        return {}
    key = _dependencies().key(pages.BOOK / f"{stem}.ipynb")
    cache_ = (pages.ROOT / site).resolve().parent / ".jupyter_cache" / f"{stem}-{key}"
    notebooks = (json.loads(file.read_text("utf-8")) for file in cache_.glob("executed/*/*.ipynb"))
    noted = (
        output.get("metadata", {})
        for notebook in notebooks
        for cell in notebook["cells"]
        for output in cell.get("outputs", ())
    )
    found = (json.loads(one[STATES]) for one in noted if STATES in one)
    return {one["name"]: one for one in found}


@cache
def _dependencies() -> Dependencies:
    return Dependencies(pages.ROOT)


def described(explorer: Exploration, said: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is recorded of an explorer, from its snapshot."""
    texts: dict[str, int] = {}
    states = []
    for finding, words in zip(said["findings"], said["words"], strict=True):
        assert GAP not in words, words
        text = texts.setdefault(NUMBER.sub(GAP, words), len(texts))
        states.append([finding, text, " ".join(NUMBER.findall(words))])
    controls = {name: [*map(str, control.values)] for name, control in explorer.controls.items()}
    return {"controls": controls, "texts": list(texts), "states": states}


def written(kind: str, explorers_: Mapping[str, Mapping[str, Any]]) -> str:
    """Return the text of a file: a line for each state, so that a diff shows what changes."""
    blocks = []
    for name, said in explorers_.items():
        states = ",\n".join(f"    {_line(state)}" for state in said["states"])
        texts = ",\n".join(f"    {_line(text)}" for text in said["texts"])
        blocks.append(
            f'  {_line(name)}: {{\n   "controls": {_line(said["controls"])},\n'
            f'   "finds": {_line(said["finds"])},\n'
            f'   "texts": [\n{texts}\n   ],\n   "states": [\n{states}\n   ]\n  }}'
        )
    return (
        f'{{\n "processor": {_line(kind)},\n "explorers": {{\n' + ",\n".join(blocks) + "\n }\n}\n"
    )


def _line(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)


def leaves(finding: Any, path: Path_ = ()) -> Iterator[tuple[Path_, Any]]:
    """Yield the numbers and texts of a stored finding, each with the name of its column.

    All numbers of an array are in one column.
    """
    if isinstance(finding, list):
        for k, part in enumerate(finding):
            yield from leaves(part, (*path, str(k)))
    elif isinstance(finding, dict):
        ((kind, value),) = finding.items()
        if kind == ARRAY:
            yield from ((path, one) for one in _flat(value))
        parts = value.items() if kind == FIELDS else value if kind == ENTRIES else ()
        for key, part in parts:
            yield from leaves(part, (*path, str(key)))
    else:
        yield path, finding


def _flat(values: Any) -> Iterator[Any]:
    if isinstance(values, list):
        for part in values:
            yield from _flat(part)
    else:
        yield values


def differences(before: Mapping[str, Any], now: Mapping[str, Any], elsewhere: bool) -> list[str]:
    """Say where an explorer says something else than what is recorded.

    Parameters
    ----------
    before, now
        What is recorded, and what is to be compared (`described`).
    elsewhere
        Whether another kind of processor has recorded it, on which films and filters round
        differently: then a finding must lie where those of the explorer lie or as far outside as
        these reach, and words must be one of its texts, whatever their numbers.
    """
    if before["controls"] != now["controls"]:
        return [f"controls {now['controls']}, recorded {before['controls']}"]
    columns: dict[Path_, list[Any]] = defaultdict(list)
    for finding, *_ in before["states"]:
        for path, value in leaves(finding):
            columns[path].append(value)
    lines = []
    for k, (old, new) in enumerate(zip(before["states"], now["states"], strict=True)):
        where = f"state {k}"
        was, is_ = list(leaves(old[0])), list(leaves(new[0]))
        if elsewhere:
            lines += [
                f"{where}, finding {'.'.join(path)}: {value}, beyond all that is recorded"
                for path, value in is_
                if not _lies_among(value, columns.get(path, []))
            ]
            if now["texts"][new[1]] not in before["texts"]:
                lines.append(f"{where}: {now['texts'][new[1]]!r} is none of its texts")
            continue
        if [path for path, _ in was] != [path for path, _ in is_]:
            lines.append(f"{where}: finding {new[0]}, recorded {old[0]}")
            continue
        lines += [
            f"{where}, finding {'.'.join(path)}: {value}, recorded {one}"
            for (path, one), (_, value) in zip(was, is_, strict=True)
            if not _alike(value, one, columns[path])
        ]
        said, says = _words(before["texts"], old), _words(now["texts"], new)
        if said != says:
            lines.append(f"{where}: {says!r}, recorded {said!r}")
    return lines


def _words(texts: Sequence[str], state: Sequence[Any]) -> str:
    numbers = iter(state[2].split())
    return re.sub(GAP, lambda _: next(numbers), texts[state[1]])


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _finite(values: Sequence[Any]) -> list[float]:
    return [value for value in values if _is_number(value) and math.isfinite(value)]


def _rounded(column: Sequence[Any]) -> float:
    """Return what rounding leaves of the numbers of a column."""
    return max(RTOL * max(map(abs, _finite(column)), default=0.0), NOUGHT * COMPARED)


def _alike(value: Any, recorded_: Any, column: Sequence[Any]) -> bool:
    if _finite([value, recorded_]) != [value, recorded_]:
        return repr(value) == repr(recorded_)  # NaN is NaN
    return abs(value - recorded_) <= _rounded(column)


def _lies_among(value: Any, column: Sequence[Any]) -> bool:
    finite = _finite(column)
    if not finite or not _finite([value]):
        return repr(value) in map(repr, column)
    reach = max(finite) - min(finite) + _rounded(column)
    return min(finite) - reach <= value <= max(finite) + reach
