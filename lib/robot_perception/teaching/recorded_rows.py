"""Recorded rows: a study and its variants in one ``.npz``, with a summary that a diff shows.

The summary has, for each variant, the hash of the code, of what was run, and of the numbers. Rows
whose numbers are not those of the hash are damaged, and nobody takes them for computed.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from robot_perception.files import reading, written
from robot_perception.teaching import storage
from robot_perception.teaching.locks import changing
from robot_perception.teaching.records import records
from robot_perception.teaching.versions import here

RTOL = 1e-6
ROUNDED = 1e-12
"""What rounding leaves of metres and radians that cancel; each processor leaves something else."""
MARK = "\x10"
"""Data link escape: what follows in a column of text is JSON of what is no text."""
FEATURES = ("AVX512_SKX", "AVX2", "SSE42")
"""What makes a kind of processor, from the most to the least."""


@dataclass(frozen=True, eq=False, slots=True)
class Recorded:
    """Rows as they were recorded.

    Parameters
    ----------
    table
        The rows.
    code, declared
        Hashes of the code, and of replicates, levels and keywords.
    date, processor, versions
        When they were computed, by which kind of processor, and with which packages.
    """

    table: pd.DataFrame
    code: str | None
    declared: str
    date: str
    processor: str
    versions: str = ""

    def fits(self, code: str | None, declared: str) -> bool:
        """Tell whether code and what it is run with are those that gave the rows."""
        return code is not None and (self.code, self.declared) == (code, declared)


@dataclass(frozen=True, eq=False, slots=True)
class _Stored:
    """What a file holds: columns by variant."""

    variants: Mapping[str, Mapping[str, np.ndarray]]


def folder() -> Path:
    """Return where rows are recorded."""
    return records() / "rows"


def file_of(stem: str, study: str) -> Path:
    """Return the file of a study's rows."""
    return folder() / f"{stem}.{study}.npz"


def read(stem: str, study: str, variant: str) -> Recorded | None:
    """Return the recorded rows of a variant, ``None`` if there are none.

    Raises
    ------
    DamagedFile
        If a file is not what was recorded: its numbers have another hash.
    """
    file = file_of(stem, study)
    if not file.exists():
        return None
    parts, summary = _read(file, file.stat().st_mtime_ns)
    if variant not in summary:
        return None
    said = summary[variant]
    with reading(file, f"holds no rows of {variant!r}"):
        columns = parts.variants[variant]
        if content(columns) != said["content"]:
            raise ValueError("its numbers are not those that were recorded")
        table = pd.DataFrame({name: _levels(columns[name]) for name in said["columns"]})
        keys = (said[name] for name in ("code", "declared", "date", "processor"))
        return Recorded(table, *keys, said.get("versions", ""))


@lru_cache(maxsize=64)
def _read(file: Path, changed: int) -> tuple[_Stored, dict[str, Any]]:
    summary = file.with_suffix(".json")
    with reading(summary, "no summary of rows"):
        said = json.loads(summary.read_text("utf-8"))["variants"]
    return storage.load(file, _Stored), said


def write(
    stem: str, study: str, variant: str, table: pd.DataFrame, code: str | None, declared: str
) -> Path:
    """Record the rows of a variant; those of others stay. Return the file."""
    file = file_of(stem, study)
    file.parent.mkdir(exist_ok=True)
    columns = {name: _plain(table[name]) for name in table}
    start = f"variants/{variant}/"
    with changing(file):
        variants, summary = {}, {}
        if file.exists():
            stored, summary = _read(file, file.stat().st_mtime_ns)
            variants, summary = dict(stored.variants), dict(summary)
        variants[variant] = columns
        words = storage.save(file, _Stored(variants))
        summary[variant] = {
            "code": code,
            "declared": declared,
            "content": content(columns),
            "date": date.today().isoformat(),
            "processor": processor(),
            "columns": {name: words[f"{start}{name}"] for name in columns},
            "versions": here(),
        }
        _describe(file, summary)
    return file


def renew(stem: str, study: str, variant: str, code: str | None, declared: str) -> None:
    """Record that other code gives the rows of a variant; the rows stay."""
    file = file_of(stem, study)
    with changing(file):
        _, summary = _read(file, file.stat().st_mtime_ns)
        keys = {"code": code, "declared": declared, "versions": here()}
        _describe(file, summary | {variant: summary[variant] | keys})


def drop(stem: str, study: str, variants: set[str]) -> None:
    """Forget the variants of a study that nobody declares."""
    file = file_of(stem, study)
    with changing(file):
        stored, summary = _read(file, file.stat().st_mtime_ns)
        kept = {name: columns for name, columns in stored.variants.items() if name not in variants}
        storage.save(file, _Stored(kept))
        _describe(file, {name: said for name, said in summary.items() if name not in variants})


def variants(stem: str, study: str) -> tuple[str, ...]:
    """Return the variants of a study of which rows are recorded."""
    file = file_of(stem, study)
    return tuple(_read(file, file.stat().st_mtime_ns)[1]) if file.exists() else ()


def content(columns: Mapping[str, np.ndarray]) -> str:
    """Hash the numbers of rows, with the names and types of their columns."""
    digest = hashlib.sha256()
    for name in sorted(columns):
        values = np.ascontiguousarray(columns[name])
        digest.update(f"{name} {values.dtype.str} {values.shape}\n".encode())
        digest.update(values.tobytes())
    return digest.hexdigest()[:16]


def alike(again: pd.Series, before: pd.Series, others: pd.Series, elsewhere: bool) -> bool:
    """Tell whether a column of a trial is the recorded one.

    Parameters
    ----------
    again, before
        As computed now, and as recorded.
    others
        As recorded of all replicates of this combination, which say how large a number is.
    elsewhere
        Whether it is enough to lie where the others lie, or as far outside as these reach.
    """
    if not pd.api.types.is_numeric_dtype(before):
        return again.tolist() == before.tolist()
    ours, theirs, all_ = (part.to_numpy(dtype=float) for part in (again, before, others))
    rounded = max(RTOL * np.abs(all_).max(initial=0.0), ROUNDED)
    if elsewhere:
        reach = np.ptp(all_) + rounded
        return bool((all_.min() - reach <= ours).all() and (ours <= all_.max() + reach).all())
    return bool((np.abs(ours - theirs) <= rounded).all())


def processor() -> str:
    """Return the kind of this processor, by which films and filters round alike."""
    try:
        import cv2

        line = cv2.getCPUFeaturesLine()
        used = {"AVX512_SKX": "*AVX512-SKX", "AVX2": "*AVX2"}
        return next((name for name, word in used.items() if word in line.split()), FEATURES[-1])
    except ModuleNotFoundError:
        from numpy._core._multiarray_umath import __cpu_features__

        return next((name for name in FEATURES if __cpu_features__.get(name)), FEATURES[-1])


def _plain(column: pd.Series) -> np.ndarray:
    """Return a column as it is stored: text that is none begins with `MARK`, and is JSON."""
    values = column.to_numpy()
    return values if values.dtype.kind in "fiub" else np.array([*map(_text, values)], dtype=str)


def _text(value: Any) -> str:
    if isinstance(value, str) and not value.startswith(MARK):
        return value
    return MARK + json.dumps(value.item() if isinstance(value, np.generic) else value)


def _levels(values: np.ndarray) -> np.ndarray | pd.Series:
    """Return a column as it was before it was stored."""
    if values.dtype.kind != "U" or not np.char.startswith(values, MARK).any():
        return values
    said = [
        json.loads(text[len(MARK) :]) if text.startswith(MARK) else text for text in values.tolist()
    ]
    return pd.Series(said, dtype=object)  # a guess would make NaN of None


def _describe(file: Path, summary: Mapping[str, Any]) -> None:
    text = json.dumps({"variants": dict(summary)}, indent=1, ensure_ascii=False)
    with written(file.with_suffix(".json")) as beside:
        beside.write_text(f"{text}\n", encoding="utf-8")
    _read.cache_clear()
