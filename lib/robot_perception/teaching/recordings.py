"""Real recordings in a chapter: computed where the recording is, drawn from storage where not."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

from robot_perception import datasets
from robot_perception.teaching.records import records

DECIMALS = 4
"""Decimals that are kept in storage: a tenth of a millimetre where the unit is a metre."""


@dataclass(frozen=True, eq=False, slots=True)
class Read:
    """What a chapter shows of a recording.

    Parameters
    ----------
    result
        Arrays and numbers by name.
    live
        Whether they were computed from the recording just now, rather than read from storage.
    note
        One sentence of Markdown that says which.
    """

    result: Mapping[str, Any]
    live: bool
    note: str


@dataclass(frozen=True, eq=False, slots=True)
class Recording:
    """A computation on a real recording, with a stored result for readers without the recording.

    Parameters
    ----------
    dataset
        Name in the registry of data sets.
    compute
        Function of the folder of the data set that returns arrays and numbers by name.
    store
        Name of the stored result, unique in the book.
    """

    dataset: str
    compute: Callable[[Path], Mapping[str, Any]]
    store: str

    def read(self) -> Read:
        """Compute the result where the recording is present, else return the stored one."""
        folder = datasets.find(self.dataset)
        if folder is not None:
            note = f"Computed on this machine from the recording `{self.dataset}`."
            return Read(self.compute(folder), True, note)
        return self.stored()

    def stored(self) -> Read:
        """Return the stored result."""
        stored = json.loads(self._file().read_text(encoding="utf-8"))
        result = {key: _unpack(value) for key, value in stored["result"].items()}
        note = (
            f"The recording `{self.dataset}` is not on this machine: what follows is the stored "
            f"result of {stored['date']}. `robot-perception datasets info {self.dataset}` says "
            "how to get the recording."
        )
        return Read(result, False, note)

    def write(self) -> Path:
        """Compute the result and store it.

        Raises
        ------
        robot_perception.datasets.DatasetMissing
            If the recording is not on this machine.
        """
        result = self.compute(datasets.path(self.dataset))
        document = {
            "dataset": self.dataset,
            "date": date.today().isoformat(),
            "result": {key: _pack(value) for key, value in result.items()},
        }
        file = self._file()
        file.write_text(json.dumps(document, allow_nan=False) + "\n", encoding="utf-8")
        return file

    def _file(self) -> Path:
        return records() / f"{self.store}.json"


def _pack(value: Any) -> Any:
    array = np.asarray(value)
    if array.dtype.kind in "US":
        return value
    return (
        np.round(array.astype(float), DECIMALS).tolist()
        if array.dtype.kind == "f"
        else array.tolist()
    )


def _unpack(value: Any) -> Any:
    return np.asarray(value) if isinstance(value, list) else value
