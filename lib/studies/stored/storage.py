"""Dataclasses of arrays in one ``.npz`` file, byte for byte the same for the same numbers.

Arrays and numbers are stored as they are, texts as arrays of text, a nested dataclass or mapping
below its name (``robots/3/error``). A field with ``metadata={"webp": quality}`` holds a picture
(uint8), grey or in colour, and is stored as WebP, lossless at quality 100.
"""

import io
import re
import zipfile
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

import numpy as np
from PIL import Image

from studies.files import reading, written

Result = TypeVar("Result")
_ENDING = re.compile(r"(\.npy|(\.grey)?\.webp)$")
_STAMP = (1980, 1, 1, 0, 0, 0)  # the least that zip can say: files must not differ by their hour


def save(path: Path | str, result: Any, *, finite: bool = True, level: int = 9) -> dict[str, str]:
    """Store a dataclass, whole or not at all; return a summary of each stored part, in words.

    It is packed at a level from 1 (fast) to 9 (small).

    Raises
    ------
    TypeError
        If the result is no dataclass, or a part cannot be stored.
    ValueError
        If a number is not finite where they are to be ``finite``.
    OSError
        If the file cannot be written.
    """
    if not is_dataclass(result) or isinstance(result, type):
        raise TypeError(f"a result is a dataclass, got {type(result).__name__}")
    parts = dict(_flat(result, ""))
    if finite:
        _check_finite(parts)
    with (
        written(path) as beside,
        zipfile.ZipFile(beside, "w", zipfile.ZIP_DEFLATED, compresslevel=level) as archive,
    ):
        for name, (value, webp) in parts.items():
            picture = "grey.webp" if value.ndim == 2 else "webp"  # WebP itself has colours only
            ending = "npy" if webp is None else picture
            info = zipfile.ZipInfo(f"{name}.{ending}", _STAMP)
            info.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(info, _bytes(value, webp))
    return {name: _summary(value) for name, (value, _) in parts.items()}


def load(path: Path | str, kind: type[Result]) -> Result:
    """Return the dataclass that :func:`save` stored.

    Raises
    ------
    DamagedFile
        If it holds no result, a part is missing or there is one that the type does not have.
    OSError
        If the file cannot be read.
    """
    parts = _parts(path)
    with reading(path, f"holds no {kind.__name__}"):
        result = _built(kind, parts, "")
        if parts:
            raise ValueError(f"parts that no field takes: {', '.join(sorted(parts))}")
    return result


def same(one: Path | str, other: Path | str, *, but: Collection[str] = ()) -> bool:
    """Tell whether two files hold the same, numbers to 1e-9 of the largest of their part.

    Of the parts that are named in ``but``, the shape and the kind of number.

    Raises
    ------
    DamagedFile
        If one holds no result.
    OSError
        If one cannot be read.
    """
    ours, theirs = _parts(one), _parts(other)
    if ours.keys() != theirs.keys():
        return False
    return all(_alike(ours[k], theirs[k], numbers=k not in but) for k in ours)


def _alike(ours: np.ndarray, theirs: np.ndarray, *, numbers: bool) -> bool:
    if ours.shape != theirs.shape or ours.dtype != theirs.dtype:
        return False
    if not numbers:
        return True
    if ours.dtype.kind != "f":
        return np.array_equal(ours, theirs)
    return bool((np.abs(ours - theirs) <= 1e-9 * np.abs(theirs).max(initial=0.0)).all())


def _parts(path: Path | str) -> dict[str, np.ndarray]:
    with reading(path, "holds no result"), zipfile.ZipFile(path) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
        return {_ENDING.sub("", name): _array(data, name) for name, data in content.items()}


def _flat(value: Any, name: str, webp: int | None = None) -> Iterator[tuple[str, tuple]]:
    if is_dataclass(value):
        for f in fields(value):
            yield from _flat(getattr(value, f.name), f"{name}/{f.name}", f.metadata.get("webp"))
    elif isinstance(value, Mapping):
        for key, item in value.items():
            if not isinstance(key, str | int) or not re.fullmatch(r"[^/]+", str(key)):
                raise TypeError(f"{name[1:]} has a key that cannot be stored: {key!r}")
            yield from _flat(item, f"{name}/{key}", webp)
    else:
        array = np.asarray(value)
        if array.dtype.kind not in "fiubU":
            raise TypeError(f"{name[1:]} cannot be stored: {type(value).__name__}, {array.dtype}")
        yield name[1:], (array, webp)


def _check_finite(parts: Mapping[str, tuple[np.ndarray, int | None]]) -> None:
    for name, (array, _) in parts.items():
        if array.dtype.kind == "f" and not np.isfinite(array).all():
            bad = np.count_nonzero(~np.isfinite(array))
            raise ValueError(f"{name} must be finite, got {bad} of {array.size} that are not")


def _bytes(array: np.ndarray, webp: int | None) -> bytes:
    buffer = io.BytesIO()
    if webp is None:
        np.lib.format.write_array(buffer, array, allow_pickle=False)
    else:
        picture = Image.fromarray(array)
        picture.save(buffer, "webp", quality=webp, lossless=webp == 100, method=6)
    return buffer.getvalue()


def _array(data: bytes, name: str) -> np.ndarray:
    if name.endswith(".webp"):
        picture = Image.open(io.BytesIO(data), formats=("WEBP",))
        return np.asarray(picture.convert("L") if name.endswith(".grey.webp") else picture)
    return np.lib.format.read_array(io.BytesIO(data), allow_pickle=False)


def _built(kind: Any, parts: dict[str, np.ndarray], name: str) -> Any:
    """Return a value of a type from the parts below a name, and take these parts away."""
    origin, inner = get_origin(kind) or kind, get_args(kind)
    if is_dataclass(origin):
        hints = get_type_hints(origin)
        return origin(
            **{f.name: _built(hints[f.name], parts, f"{name}/{f.name}") for f in fields(origin)}
        )
    if isinstance(origin, type) and issubclass(origin, Mapping):
        start = f"{name[1:]}/"
        keys = dict.fromkeys(p[len(start) :].split("/")[0] for p in parts if p.startswith(start))
        of_key, of_value = inner
        return {of_key(key): _built(of_value, parts, f"{name}/{key}") for key in keys}
    if name[1:] not in parts:
        raise ValueError(f"{name[1:]} is missing")
    array = parts.pop(name[1:])
    if isinstance(origin, type) and issubclass(origin, float | int | bool | str):
        return origin(array.item())
    if isinstance(origin, type) and issubclass(origin, Sequence):
        return origin(array.tolist()) if origin in (tuple, list) else tuple(array.tolist())
    return array


def _summary(array: np.ndarray) -> str:
    """Return a part in words: a number as it is, an array by shape, range and mean."""
    if array.ndim == 0:
        return f"{array.item():.10g}" if array.dtype.kind == "f" else str(array.item())
    shape = " × ".join(map(str, array.shape))
    if array.dtype.kind == "U":
        return f"{shape}: {', '.join(array.ravel()[:8])}{' …' if array.size > 8 else ''}"
    if not array.size:
        return f"{shape} {array.dtype}"
    ends = (array.min(), array.max(), array.mean())
    return f"{shape} {array.dtype}, " + "{:.10g} to {:.10g}, mean {:.10g}".format(*map(float, ends))
