"""Values of any make as one text and a few arrays: what is recorded, and what is kept.

The text, in JSON, says how a value is made of tuples, lists, mappings, dataclasses, named tuples
and enumerations of the project's packages or of a notebook, and where its numbers lie in one array
for each type. Pictures may be WebP without loss. Reading makes the same value again, of the same
types, and runs nothing but the types' own checks.
"""

import io
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from enum import Enum
from importlib import import_module
from typing import Any

import numpy as np
from PIL import Image

from studies.keys.cells import LIVE
from studies.keys.dependencies import known_packages


@dataclass(frozen=True, eq=False, slots=True)
class Packed:
    """A value as a text and arrays.

    Parameters
    ----------
    structure
        JSON: how the value is made, and where its numbers lie.
    arrays : type -> (n,)
        All numbers of a type, one after the other.
    """

    structure: str
    arrays: Mapping[str, np.ndarray] = field(repr=False)

    def alike(self, other: "Packed") -> bool:
        """Tell whether two values are the same, numbers to 1e-9."""
        if self.structure != other.structure or self.arrays.keys() != other.arrays.keys():
            return False
        pairs = ((self.arrays[kind], other.arrays[kind]) for kind in self.arrays)
        return all(
            np.allclose(ours, theirs, rtol=1e-9, atol=1e-12, equal_nan=True)
            for ours, theirs in pairs
        )


def packed(value: Any, *, pictures: bool = True) -> Packed:
    """Take a value apart.

    Parameters
    ----------
    value
        What is to be stored.
    pictures
        Whether pictures become WebP, which takes long and little room.

    Raises
    ------
    TypeError
        If there is something in it of a type that cannot be stored.
    """
    packer = _Packer(pictures)
    structure = json.dumps(packer.plan(value), ensure_ascii=False, separators=(",", ":"))
    arrays = {kind: np.concatenate(parts) for kind, parts in packer.parts.items()}
    return Packed(structure, arrays)


def unpacked(parts: Packed) -> Any:
    """Make the value again."""
    return _made(json.loads(parts.structure), parts.arrays, {})


class _Packer:
    """Lays the numbers of a value one after the other; what stands in it twice is laid once."""

    def __init__(self, pictures: bool) -> None:
        self._pictures = pictures
        self.parts: dict[str, list[np.ndarray]] = {}
        self._ends: dict[str, int] = {}
        self._laid: dict[int, tuple[np.ndarray, list[Any]]] = {}

    def plan(self, value: Any) -> list[Any]:
        """Return how a value is made."""
        if isinstance(value, Enum):
            return ["member", *_named(type(value)), value.name]
        if value is None or isinstance(value, bool | int | str):
            return ["as it is", value]
        if isinstance(value, float) and type(value) is float:
            return ["float", self._lay(np.array([value]))]
        if isinstance(value, np.ndarray | np.generic):
            return self._array(value)
        if isinstance(value, Mapping):
            return ["mapping", [[self.plan(key), self.plan(value[key])] for key in value]]
        if is_dataclass(value) and not isinstance(value, type):
            return self._object(value, [f.name for f in fields(value)])
        if isinstance(value, tuple) and hasattr(value, "_fields"):
            return self._object(value, value._fields)
        if type(value) in (list, tuple):
            return [type(value).__name__, [self.plan(item) for item in value]]
        raise TypeError(f"cannot be stored: {type(value).__name__}")

    def _object(self, value: Any, names: Any) -> list[Any]:
        parts = {name: self.plan(getattr(value, name)) for name in names}
        return ["object", *_named(type(value)), parts]

    def _array(self, value: np.ndarray | np.generic) -> list[Any]:
        if isinstance(value, np.generic) and value.dtype.kind in "fiub":
            return ["number", value.dtype.str, self._lay(np.asarray(value).reshape(1))]
        if id(value) not in self._laid:
            self._laid[id(value)] = value, self._laid_out(value)
        return self._laid[id(value)][1]

    def _laid_out(self, value: np.ndarray) -> list[Any]:
        if value.dtype.kind == "U":
            again = np.array(texts := value.tolist())
            same = (again.dtype, again.shape) == (value.dtype, value.shape)
            return ["texts", texts, *([] if same else [value.dtype.str, list(value.shape)])]
        if value.dtype.names:
            columns = {name: self.plan(np.asarray(value)[name]) for name in value.dtype.names}
            return ["columns", isinstance(value, np.recarray), list(value.shape), columns]
        if value.dtype.kind not in "fiub":
            raise TypeError(f"cannot be stored: an array of {value.dtype}")
        if self._pictures and value.dtype == np.uint8 and value.ndim == 3 and value.shape[2] == 3:
            data = np.frombuffer(_webp(value), np.uint8)
            return ["picture", self._lay(data), len(data)]
        return ["array", value.dtype.str, self._lay(value.ravel()), list(value.shape)]

    def _lay(self, flat: np.ndarray) -> int:
        kind = flat.dtype.str[1:]
        start = self._ends.setdefault(kind, 0)
        self.parts.setdefault(kind, []).append(flat)
        self._ends[kind] += len(flat)
        return start


def _made(plan: list[Any], arrays: Mapping[str, np.ndarray], known: dict[str, np.ndarray]) -> Any:
    """Make a value; arrays that are ``known`` were one object and are one again."""
    how, *rest = plan

    def numbers(dtype: str, start: int, count: int) -> np.ndarray:
        return arrays[dtype[1:]][start : start + count].astype(dtype)

    match how:
        case "as it is":
            return rest[0]
        case "float":
            return float(arrays["f8"][rest[0]])
        case "number":
            return numbers(*rest, 1)[0]
        case "array":
            dtype, start, shape = rest
            if repr(plan) not in known:
                flat = numbers(dtype, start, int(np.prod(shape)))
                known[repr(plan)] = flat.reshape(shape)
            return known[repr(plan)]
        case "texts":
            texts, *more = rest
            return np.array(texts, dtype=more[0]).reshape(more[1]) if more else np.array(texts)
        case "picture":
            start, count = rest
            if repr(plan) not in known:
                data = arrays["u1"][start : start + count].tobytes()
                known[repr(plan)] = np.asarray(Image.open(io.BytesIO(data), formats=("WEBP",)))
            return known[repr(plan)]
        case "columns":
            records, shape, columns = rest
            made = {name: _made(column, arrays, known) for name, column in columns.items()}
            kinds = [(n, column.dtype, column.shape[len(shape) :]) for n, column in made.items()]
            table = np.empty(shape, kinds)
            for name, column in made.items():
                table[name] = column
            return table.view(np.recarray) if records else table
        case "member":
            module, name, member = rest
            return _class(module, name, Enum)[member]
        case "mapping":
            return {
                _made(key, arrays, known): _made(value, arrays, known) for key, value in rest[0]
            }
        case "object":
            module, name, parts = rest
            made = {part: _made(value, arrays, known) for part, value in parts.items()}
            return _object(_class(module, name), made)
        case "list":
            return [_made(item, arrays, known) for item in rest[0]]
        case "tuple":
            return tuple(_made(item, arrays, known) for item in rest[0])
    raise ValueError(f"nothing is made as {how!r}")


def _object(kind: type, parts: Mapping[str, Any]) -> Any:
    """Make a dataclass or named tuple; fields that no argument sets are set afterwards."""
    after = {f.name for f in fields(kind) if not f.init} if is_dataclass(kind) else set()
    made = kind(**{name: value for name, value in parts.items() if name not in after})
    for name in after & parts.keys():
        object.__setattr__(made, name, parts[name])
    return made


def _class(module: str, name: str, base: type | None = None) -> Any:
    """Return a dataclass or named tuple, or a type of some base; nothing else is ever called."""
    if module.partition(".")[0] not in (*known_packages(), LIVE):
        raise ValueError(f"{module} is none of the packages")
    kind = import_module(module)
    for part in name.split("."):
        kind = getattr(kind, part)
    known = isinstance(kind, type) and (
        issubclass(kind, base) if base else is_dataclass(kind) or hasattr(kind, "_fields")
    )
    if not known:
        raise ValueError(f"{module}.{name} is no dataclass")
    return kind


def _named(kind: type) -> tuple[str, str]:
    """Return module and name of a type that can be read again.

    Raises
    ------
    TypeError
        If it is of another package, or made inside a function.
    """
    module, name = kind.__module__, kind.__qualname__
    if module.partition(".")[0] not in (*known_packages(), LIVE) or "<locals>" in name:
        raise TypeError(f"cannot be stored: {module}.{name}")
    return module, name


def _webp(picture: np.ndarray) -> bytes:
    stream = io.BytesIO()
    Image.fromarray(picture).save(stream, "webp", lossless=True, quality=100, method=6)
    return stream.getvalue()
