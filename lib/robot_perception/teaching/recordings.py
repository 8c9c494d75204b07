"""Real recordings in a chapter: computed where the recording is, drawn from storage where not.

A result is a frozen dataclass of arrays, numbers, texts, and mappings or nested dataclasses of
them. It is stored in full precision as ``.npz`` beside a summary in JSON, which a diff can be read
of; reading it makes the same type again.
"""

import json
import zipfile
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Generic, TypeVar

from robot_perception import datasets
from robot_perception.checks import dataclass_type, instance, shown
from robot_perception.teaching import storage
from robot_perception.teaching.records import records

Result = TypeVar("Result")


@dataclass(frozen=True, eq=False, slots=True)
class Read(Generic[Result]):
    """What a chapter shows of a recording.

    Parameters
    ----------
    result
        What was computed.
    live
        Whether it was computed from the recording just now, rather than read from storage.
    note
        One sentence of Markdown that says which.
    """

    result: Result
    live: bool
    note: str


@dataclass(frozen=True, eq=False, slots=True)
class Recording(Generic[Result]):
    """A computation on a real recording, with a stored result for readers without the recording.

    Parameters
    ----------
    dataset
        Name in the registry of data sets.
    compute
        Function of the folder of the data set that returns a result.
    result
        Type of the result, a dataclass.
    store
        Name of the stored result, unique in the book.
    """

    dataset: str
    compute: Callable[[Path], Result]
    result: type[Result]
    store: str

    def __post_init__(self) -> None:
        instance("dataset", self.dataset, str)
        instance("store", self.store, str)
        if not callable(self.compute):
            raise TypeError(f"compute must be a function, got {shown(self.compute)}")
        dataclass_type("result", self.result)

    def read(self) -> Read[Result]:
        """Compute the result where the recording is present, else return the stored one."""
        folder = datasets.find(self.dataset)
        if folder is not None:
            note = f"Computed on this machine from the recording `{self.dataset}`."
            return Read(self.compute(folder), True, note)
        return self.stored()

    def stored(self) -> Read[Result]:
        """Return the stored result.

        Raises
        ------
        ValueError
            If what is stored is not a result of this type.
        """
        file = self._file()
        summary = json.loads(file.with_suffix(".json").read_text(encoding="utf-8"))
        note = (
            f"The recording `{self.dataset}` is not on this machine: what follows is the stored "
            f"result of {summary['date']}. `robot-perception datasets info {self.dataset}` says "
            "how to get the recording."
        )
        try:
            return Read(storage.load(file, self.result), False, note)
        except (ValueError, KeyError, zipfile.BadZipFile) as error:
            raise ValueError(
                f"{file.name} holds no {self.result.__name__} ({error}); store it anew with "
                f"`robot-perception store --only {self.store}`"
            ) from error

    def write(self) -> Path:
        """Compute the result and store it; return the file.

        Raises
        ------
        robot_perception.datasets.DatasetMissing
            If the recording is not on this machine.
        ValueError
            If a number is not finite.
        """
        result = self.compute(datasets.path(self.dataset))
        summary = {"dataset": self.dataset, "date": date.today().isoformat()}
        file = self._file()
        summary["result"] = storage.save(file, result)
        lines = ",\n".join(
            f"  {json.dumps(name)}: {json.dumps(value, ensure_ascii=False)}"
            for name, value in summary.pop("result").items()
        )
        head = json.dumps(summary)[1:-1]
        text = f'{{{head},\n "result": {{\n{lines}\n}}}}\n'
        file.with_suffix(".json").write_text(text, encoding="utf-8")
        return file

    def _file(self) -> Path:
        return records() / f"{self.store}.npz"
