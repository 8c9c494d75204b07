"""Real recordings in a chapter: read from storage unless their code or the recording has changed.

A result is a frozen dataclass of arrays, numbers, texts, and mappings or nested dataclasses of
them. It is stored in full precision as ``.npz`` beside a summary in JSON, which a diff can be read
of; reading it makes the same type again. The summary has three keys: of the code that computed the
result, of the recording that it was computed from, and of what was stored. Where all fit,
computing it again would give what is stored; what does not fit the third is nothing that this book
has stored, and is never shown. Where study cells of a notebook compute it, the key of
the code is that of the definitions that this reaches. A field with ``metadata={"timed": True}``
holds times that were measured, which are never the same again.
"""

import hashlib
import inspect
import json
import logging
from collections.abc import Callable
from dataclasses import dataclass, fields
from datetime import date
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Generic, TypeVar

from studies.files import DamagedFile, reading, written
from studies.keys.cells import code_of, in_cells
from studies.keys.dependencies import code_digest, hashed
from studies.keys.versions import differing, here
from studies.project import project
from studies.records import records
from studies.stored import storage

Result = TypeVar("Result")

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False, slots=True)
class Read(Generic[Result]):
    """Result of a recording as a chapter shows it.

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

    def read(self) -> Read[Result]:
        """Return the stored result if it is what this recording and this code give.

        Otherwise compute it; without the recording the stored result is all there is.
        """
        folder = project().data.find(self.dataset)
        if folder is None:
            return self.stored()
        damaged = False
        try:
            why = self._outdated()
            if not why:
                result, day, others = self._load(), self._summary()["date"], self.other_packages()
                by = f"this code with {others}" if others else "this code"
                note = f"Computed from the recording `{self.dataset}` on {day}, by {by}."
                return Read(result, False, note)
        except DamagedFile as error:
            why, damaged = f"{error}", True
        if damaged or (self._file().exists() and not self.is_what_was_stored()):
            log.warning("%s is computed anew: %s", self.store, why)
        note = f"Computed on this machine from the recording `{self.dataset}`: {why}."
        return Read(self.compute(folder), True, note)

    def is_current(self) -> bool:
        """Tell whether the stored result comes from this code and the recording that is here.

        Numbers that somebody has put in their place do not.
        """
        return not self._outdated()

    def is_what_was_stored(self) -> bool:
        """Tell whether the file holds what was stored, and nobody has replaced its numbers."""
        return self._file().exists() and self._summary().get("content") == self._content()

    def of_this_code(self) -> bool:
        """Tell whether this code computed what is stored, wherever the recording is."""
        return self._summary().get("code") in {self._code()} - {None}

    def other_packages(self) -> str:
        """Return in words which packages other than those here gave what is stored."""
        return differing(self._summary().get("versions", ""))

    def _outdated(self) -> str:
        """Return why what is stored is not what would be computed here; nothing if it is."""
        if not self._file().exists():
            return "nothing is stored"
        if not self.is_what_was_stored():
            return f"{self._file().name} is not what was stored"
        if not self.of_this_code():
            return "what is stored was computed by other code"
        if self._summary().get("data") in {self._data()} - {None}:
            return ""
        return "what is stored was computed from other files"

    def stored(self) -> Read[Result]:
        """Return the stored result.

        Raises
        ------
        DamagedFile
            If the file is not what was stored, or no result of this type.
        """
        if self._file().exists() and not self.is_what_was_stored():
            raise DamagedFile(
                f"{self._file()} is not what was stored, as the hash in its summary says: get the "
                f"file of the release back (`git checkout`, or install the package anew), or with "
                f"the recording `{self.dataset}` {self._anew()}"
            )
        note = (
            f"The recording `{self.dataset}` is not on this machine: what follows is the stored "
            f"result of {self._summary()['date']}."
        )
        if way := project().command:
            note += f" `{way} datasets info {self.dataset}` says how to get the recording."
        return Read(self._load(), False, note)

    def write(self) -> Path:
        """Compute the result and store it; return the file.

        Raises
        ------
        FileNotFoundError
            If the recording is not on this machine.
        ValueError
            If a number is not finite.
        """
        result = self.compute(project().data.path(self.dataset))
        file = self._file()
        self._describe(date.today().isoformat(), storage.save(file, result))
        return file

    def renew(self) -> bool:
        """Compute the result and, if it is the stored one, store the keys of this code only.

        Returns
        -------
        bool
            Whether it is, each number to 1e-9 but for measured times. If not, nothing is changed.

        Raises
        ------
        FileNotFoundError
            If the recording is not on this machine.
        ValueError
            If a number is not finite.
        """
        file, result = self._file(), self.compute(project().data.path(self.dataset))
        timed = {part.name for part in fields(self.result) if part.metadata.get("timed")}
        with TemporaryDirectory() as folder:
            again = Path(folder) / file.name
            storage.save(again, result)
            same = file.exists() and storage.same(again, file, but=timed)
        if same:
            stored = self._summary()
            self._describe(stored["date"], stored["result"])
        return same

    def _code(self) -> str | None:
        """Return the digest of what computes the result; ``None`` if it is not the book's own.

        Of study cells that is what the function reaches there, and what it is given.
        """
        function: Any = self.compute
        given: list[tuple[Any, ...]] = []
        while isinstance(function, partial):
            given.append((function.args, sorted(function.keywords.items())))
            function = function.func
        function = inspect.unwrap(function)
        if in_cells(function.__module__):
            keys = [code_of(one) for one in (function, self.result)]
            return None if None in keys else hashed(f"{keys} {given}")
        both = (function, self.result)
        asked = {f"{one.__module__}:{one.__qualname__.partition('.')[0]}" for one in both}
        try:
            return code_digest(*sorted(asked))
        except ValueError:  # the reader's own
            return None

    def _data(self) -> str | None:
        """Return a digest of the recording; ``None`` if the files are others."""
        return project().data.digest(self.dataset)

    def _content(self) -> str | None:
        """Return the digest of what is stored; files of the same numbers are the same."""
        if not self._file().exists():
            return None
        return hashlib.sha256(self._file().read_bytes()).hexdigest()[:16]

    def _describe(self, day: str, parts: dict[str, str]) -> None:
        """Write the summary: what the result is, and what it was computed by and from."""
        keys = {"code": self._code(), "data": self._data(), "content": self._content()}
        known = {name: key for name, key in keys.items() if key is not None}
        about = {"dataset": self.dataset, "date": day, **known, "versions": here()}
        head = json.dumps(about)[1:-1]
        lines = ",\n".join(
            f"  {json.dumps(name)}: {json.dumps(value, ensure_ascii=False)}"
            for name, value in parts.items()
        )
        text = f'{{{head},\n "result": {{\n{lines}\n}}}}\n'
        with written(self._file().with_suffix(".json")) as beside:
            beside.write_text(text, encoding="utf-8")

    def _summary(self) -> dict[str, Any]:
        file = self._file().with_suffix(".json")
        with reading(file, "no summary of a result"):
            stored = json.loads(file.read_text(encoding="utf-8"))
            return {"date": str(stored["date"]), **stored}

    def _load(self) -> Result:
        file = self._file()
        try:
            return storage.load(file, self.result)
        except DamagedFile as error:
            raise DamagedFile(f"{error}; {self._anew()}") from error

    def _anew(self) -> str:
        return f"store it anew with {project().storing('--only', self.store)}"

    def _file(self) -> Path:
        return records() / f"{self.store}.npz"
