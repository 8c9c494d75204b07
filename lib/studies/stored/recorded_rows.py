"""Recorded rows: a study and its variants in one ``.npz``, with a summary that a diff shows.

The summary has, for each variant, the hash of the code, of what was run, and of the numbers, and
beside the variants the seconds that their trials take. Rows whose numbers are not those of the hash
are damaged, and nobody takes them for computed. Where one of the two files is missing nothing is
recorded: whoever was interrupted between them records the rows again.
"""

import hashlib
import json
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import date
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from threadpoolctl import threadpool_info

from studies.files import DamagedFile, reading, written
from studies.keys.versions import here
from studies.project import project
from studies.records import records
from studies.stored import storage
from studies.stored.locks import changing

RTOL = 1e-6
"""Numbers are the same that differ by this share of the largest of their column and combination."""
NOUGHT = 1e-9
"""A number is zero below this share of what it is compared with."""
COMPARED = 1e-3
"""Scale of comparisons where a study gives none: a millimetre, a milliradian."""
MARK = "\x10"
"""Data link escape: what follows in a column of text is JSON of what is no text."""
FEATURES = ("AVX512_SKX", "AVX2", "SSE42")
"""Instructions that make a kind of processor, from the most to the least."""
KERNELS = {"Zen": "Haswell"}
"""Names under which OpenBLAS runs the kernels of another one."""
UNNAMED = "Haswell"
"""Kernels of rows that were recorded before their name was: they give these rows bit for bit."""


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
    """Contents of a file: columns by variant."""

    variants: Mapping[str, Mapping[str, np.ndarray]]


def folder() -> Path:
    """Return where rows are recorded."""
    return records() / "rows"


def file_of(stem: str, study: str) -> Path:
    """Return the file of a study's rows."""
    return folder() / f"{stem}.{study}.npz"


def read(stem: str, study: str, variant: str) -> Recorded | None:
    """Return the recorded rows of a variant, ``None`` if there are none, or half of them.

    Raises
    ------
    DamagedFile
        If a file is not what was recorded: its numbers have another hash.
    """
    file = file_of(stem, study)
    if not _is_whole(file):
        return None
    try:
        parts, summary, _ = _read(file, *_changed(file))
        if variant not in summary:
            return None
        said = summary[variant]
        with reading(file, f"holds no rows of {variant!r}"):
            columns = parts.variants[variant]
            if content(columns) != said["content"]:
                raise ValueError("its numbers are not those that were recorded")
            table = pd.DataFrame({name: _levels(columns[name]) for name in said["columns"]})
            kind = _kind(said["processor"])
            keys = (said[name] for name in ("code", "declared", "date"))
            return Recorded(table, *keys, kind, said.get("versions", ""))
    except DamagedFile as error:
        how = project().storing("--only", f"{stem}.{study}")
        raise DamagedFile(f"{error}; {how} records the rows anew") from error


def _is_whole(file: Path) -> bool:
    """Tell whether rows and their summary are there."""
    return file.exists() and file.with_suffix(".json").exists()


def _changed(file: Path) -> tuple[int, int]:
    """Return when rows and their summary were changed."""
    return file.stat().st_mtime_ns, file.with_suffix(".json").stat().st_mtime_ns


@lru_cache(maxsize=64)
def _read(
    file: Path, rows_changed: int, summary_changed: int
) -> tuple[_Stored, dict[str, Any], dict[str, list[float]]]:
    """Return what is stored, the summary of each variant, and the seconds of its trials."""
    summary = file.with_suffix(".json")
    with reading(summary, "no summary of rows"):
        said = json.loads(summary.read_text("utf-8"))
        variants, seconds = dict(said["variants"]), dict(said.get("seconds", {}))
    return storage.load(file, _Stored), variants, seconds


def _intact(file: Path) -> tuple[dict[str, Any], dict[str, Any], dict[str, list[float]]]:
    """Return what is stored of the variants whose numbers fit the summary; none if damaged."""
    with suppress(DamagedFile), reading(file, "no rows"):
        if _is_whole(file):
            stored, summary, seconds = _read(file, *_changed(file))
            kept = {
                name: columns
                for name, columns in stored.variants.items()
                if name in summary and content(columns) == summary[name]["content"]
            }
            return kept, {k: v for k, v in summary.items() if k in kept}, dict(seconds)
    return {}, {}, {}


def write(
    stem: str,
    study: str,
    variant: str,
    table: pd.DataFrame,
    code: str | None,
    declared: str,
    seconds: tuple[float, float] | None = None,
) -> Path:
    """Record the rows of a variant; those of others stay unless they are damaged.

    Parameters
    ----------
    stem, study, variant
        Whose rows they are.
    table
        The rows.
    code, declared
        Hashes of the code, and of replicates, levels and keywords.
    seconds
        What a trial of the first combination of factors takes at most, and one of any combination.

    Returns
    -------
    Path
        The file of the rows.
    """
    file = file_of(stem, study)
    file.parent.mkdir(parents=True, exist_ok=True)
    columns = {name: _plain(table[name]) for name in table}
    start = f"variants/{variant}/"
    with changing(file):
        variants, summary, took = _intact(file)
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
        took = took | {variant: [*seconds]} if seconds else took
        _describe(file, summary, took)
    return file


def renew(stem: str, study: str, variant: str, code: str | None, declared: str) -> None:
    """Record that other code gives the rows of a variant; the rows stay."""
    file = file_of(stem, study)
    with changing(file):
        _, summary, seconds = _read(file, *_changed(file))
        keys = {"code": code, "declared": declared, "versions": here()}
        _describe(file, summary | {variant: summary[variant] | keys}, seconds)


def drop(stem: str, study: str, variants: set[str]) -> None:
    """Forget variants of a study, and what is damaged; where nothing is left, the files too."""
    file = file_of(stem, study)
    with changing(file):
        stored, summary, seconds = _intact(file)
        kept = {name: columns for name, columns in stored.items() if name not in variants}
        if kept:
            storage.save(file, _Stored(kept))
            _describe(file, {name: summary[name] for name in summary if name in kept}, seconds)
        else:
            file.unlink(missing_ok=True)
            file.with_suffix(".json").unlink(missing_ok=True)


def variants(stem: str, study: str) -> tuple[str, ...]:
    """Return the variants of a study of which rows are recorded."""
    file = file_of(stem, study)
    return tuple(_read(file, *_changed(file))[1]) if _is_whole(file) else ()


def seconds(stem: str, study: str) -> dict[str, tuple[float, float]]:
    """Return what trials take by variant, where it was measured and the summary is not damaged.

    It is the most that a trial of the first combination of factors has taken, and one of any; of
    what was recorded before times were, 3.3 s stand for a trial that was stopped after so long.
    """
    summary = file_of(stem, study).with_suffix(".json")
    with suppress(FileNotFoundError, DamagedFile), reading(summary, "no summary of rows"):
        said = json.loads(summary.read_text("utf-8")).get("seconds", {})
        return {variant: (first, longest) for variant, (first, longest) in said.items()}
    return {}


def content(columns: Mapping[str, np.ndarray]) -> str:
    """Hash the numbers of rows, with the names and types of their columns."""
    digest = hashlib.sha256()
    for name in sorted(columns):
        values = np.ascontiguousarray(columns[name])
        digest.update(f"{name} {values.dtype.str} {values.shape}\n".encode())
        digest.update(values.tobytes())
    return digest.hexdigest()[:16]


def alike(
    again: pd.Series,
    before: pd.Series,
    others: pd.Series,
    scale: float = COMPARED,
    *,
    elsewhere: bool = False,
) -> bool:
    """Tell whether a column of rows is the recorded one.

    Numbers are the same to 1e-6 of the largest of their combination of factors, or to 1e-9 of what
    they are compared with. Where another kind of processor has recorded them, they lie where those
    of their combination lie, or as far outside as these reach.

    Parameters
    ----------
    again, before
        As computed now, and as recorded.
    others
        As recorded of all replicates of this combination, which say how large a number is.
    scale
        What the numbers are compared with.
    elsewhere
        Whether another kind of processor has recorded them.
    """
    if not pd.api.types.is_numeric_dtype(before):
        return set(again) <= set(others) if elsewhere else again.tolist() == before.tolist()
    ours, theirs, all_ = (part.to_numpy(dtype=float) for part in (again, before, others))
    rounded = max(RTOL * np.abs(all_).max(initial=0.0), NOUGHT * scale)
    if elsewhere:
        reach = np.ptp(all_) + rounded
        return bool((all_.min() - reach <= ours).all() and (ours <= all_.max() + reach).all())
    return bool((np.abs(ours - theirs) <= rounded).all())


@cache
def processor() -> str:
    """Return the kind of this processor: its instructions, and the kernels of linear algebra.

    By the first films and elementary functions round alike, by the second sums of products.
    OpenBLAS may take kernels of fewer instructions than the processor has.
    """
    linear = [one for one in threadpool_info() if one["user_api"] == "blas"]
    kernels = linear[0].get("architecture", linear[0]["internal_api"]) if linear else "unknown"
    return f"{_instructions()} {KERNELS.get(kernels, kernels)}"


def _instructions() -> str:
    try:
        import cv2

        line = cv2.getCPUFeaturesLine()
        used = {"AVX512_SKX": "*AVX512-SKX", "AVX2": "*AVX2"}
        return next((name for name, word in used.items() if word in line.split()), FEATURES[-1])
    except ModuleNotFoundError:
        from numpy._core._multiarray_umath import __cpu_features__

        return next((name for name in FEATURES if __cpu_features__.get(name)), FEATURES[-1])


def _kind(recorded: str) -> str:
    """Return the kind of processor of a summary, some of which do not name the kernels."""
    return recorded if " " in recorded else f"{recorded} {UNNAMED}"


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


def _describe(file: Path, summary: Mapping[str, Any], seconds: Mapping[str, Any]) -> None:
    said = {"variants": dict(summary)}
    if took := {name: seconds[name] for name in summary if name in seconds}:
        said["seconds"] = took
    text = json.dumps(said, indent=1, ensure_ascii=False)
    with written(file.with_suffix(".json")) as beside:
        beside.write_text(f"{text}\n", encoding="utf-8")
    _read.cache_clear()
