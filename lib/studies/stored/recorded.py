"""Recorded states: what explorers and figures show of long runs, stored with the book.

.. code-block:: python

    @recorded("ceiling-driven", product(FACTORS, BEARINGS))
    def driven(factor: float, bearing: float) -> Driven: ...

The function is `kept`; for the calls that the book makes its results are stored beside the ledger
as well, so that a page is built without computing them. The summary in JSON has the hash of the
code that computed them and that of the stored file: where one does not fit, they are computed as if
nothing were stored, and the cell or a warning says why.
"""

import hashlib
import inspect
import json
import logging
from collections.abc import Callable, Iterable
from datetime import date
from functools import cached_property, update_wrapper
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Generic, ParamSpec, TypeVar

from studies.files import DamagedFile, reading, written
from studies.keys.cells import code_of, in_cells, shell
from studies.keys.dependencies import code_digest
from studies.keys.versions import differing, here
from studies.records import records
from studies.stored import storage
from studies.stored.results import kept, told
from studies.stored.structures import Packed, packed, unpacked

P = ParamSpec("P")
Result = TypeVar("Result")

log = logging.getLogger(__name__)


class Recorded(Generic[P, Result]):
    """A function of which some results are stored with the book; use `recorded` to make one."""

    def __init__(
        self, compute: Callable[P, Result], store: str, calls: Iterable[tuple[Any, ...]]
    ) -> None:
        self.store = store
        self._compute, self._signature = kept(compute), inspect.signature(compute)
        self._module = inspect.unwrap(compute).__module__  # what checks shapes stands elsewhere
        self._calls = {repr(self._values(*call)): call for call in calls}
        update_wrapper(self, compute)

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> Result:
        """Return a result: the stored one if it is what this code computes."""
        call = repr(self._values(*args, **kwargs))
        if call in self._calls and self._stored is not None:
            return self._stored[call]
        return self._compute(*args, **kwargs)

    def is_stored(self) -> bool:
        """Tell whether results of these calls are stored, and nobody has replaced their numbers."""
        try:
            said, data = self._summary(), self._file().read_bytes()
        except FileNotFoundError:
            return False
        return (said["content"], said["calls"]) == (_hash(data), self._called())

    def is_current(self) -> bool:
        """Tell whether what is stored is what this code computes."""
        return not self._outdated()

    def other_packages(self) -> str:
        """Return in words which packages other than those here gave what is stored."""
        return differing(self._summary()["versions"])

    def _outdated(self) -> str:
        """Return why what is stored is not what this code computes; nothing if it is."""
        if not self._file().exists():
            return "nothing is stored"
        if not self.is_stored():
            return f"{self._file().name} is not what was stored for these calls"
        said = self._summary()
        if said["code"] == self._code():
            return ""
        return f"the code has changed since they were stored on {said['date']}"

    def write(self) -> Path:
        """Compute the results and store them; return the file.

        Raises
        ------
        TypeError
            If a result cannot be stored as it is.
        """
        parts, file = self._computed(), self._file()
        again = packed(unpacked(parts))
        if not again.alike(parts):
            raise TypeError(f"{self.store}: what is read would not be what was stored")
        words = storage.save(file, parts, finite=False)
        self._describe(date.today().isoformat(), words)
        return file

    def renew(self) -> bool:
        """Compute the results and, if they are the stored ones, store the keys of this code only.

        Returns
        -------
        bool
            Whether they are, each number to 1e-9. If not, nothing is changed.
        """
        if not self._file().exists():
            return False
        with TemporaryDirectory() as folder:
            again = Path(folder) / self._file().name
            storage.save(again, self._computed(), finite=False)
            ours, theirs = (storage.load(file, Packed) for file in (again, self._file()))
        same = ours.alike(theirs)
        if same:
            said = self._summary()
            self._describe(said["date"], said["result"])
        return same

    @cached_property
    def _stored(self) -> dict[str, Result] | None:
        """Stored results by call; none where they are not what this code computes."""
        try:
            why = self._outdated()
            if not why:
                with reading(self._file(), "holds no states"):
                    return unpacked(storage.load(self._file(), Packed))
        except DamagedFile as error:
            why = f"{error}"
        self._say(f"{self.store}: states are computed anew, for {why}.")
        return None

    def _say(self, line: str) -> None:
        """Say a line where the reader is: below the cell that asks, in a notebook or on a page."""
        if shell() is None:
            log.warning("%s", line)
        else:
            print(line)

    def _computed(self) -> Packed:
        return packed({name: self._compute(*call) for name, call in self._calls.items()})

    def _values(self, *args: Any, **kwargs: Any) -> tuple[Any, ...]:
        bound = self._signature.bind(*args, **kwargs)
        bound.apply_defaults()
        values = tuple(bound.arguments.values())
        told(values)
        return values

    def _code(self) -> str | None:
        """Hash the code that the results depend on: of study cells what the function reaches."""
        function: Any = inspect.unwrap(self._compute)
        if in_cells(self._module):
            return code_of(function)
        return code_digest(f"{self._module}:{function.__qualname__.partition('.')[0]}")

    def _called(self) -> str:
        return _hash("\n".join(self._calls).encode())

    def _describe(self, day: str, words: dict[str, str]) -> None:
        """Write the summary: of what the states are, what computed them, and their hash."""
        self.__dict__.pop("_stored", None)
        said = {
            "function": f"{self._module}.{self.__name__}",
            "date": day,
            "code": self._code(),
            "content": _hash(self._file().read_bytes()),
            "calls": self._called(),
            "versions": here(),
            "result": {name: text for name, text in words.items() if name != "structure"},
        }
        with written(self._file().with_suffix(".json")) as beside:
            beside.write_text(json.dumps(said, indent=1, ensure_ascii=False) + "\n", "utf-8")

    def _summary(self) -> dict[str, Any]:
        file = self._file().with_suffix(".json")
        keys = "code", "content", "calls", "date", "result"
        with reading(file, "no summary of states"):
            said = json.loads(file.read_text("utf-8"))
            return {"versions": said.get("versions", "")} | {key: said[key] for key in keys}

    def _file(self) -> Path:
        return records() / f"{self.store}.npz"


def recorded(
    store: str, calls: Iterable[tuple[Any, ...]] = ((),)
) -> Callable[[Callable[P, Result]], Recorded[P, Result]]:
    """Let a function be `kept`, and its results of some calls be stored with the book.

    Parameters
    ----------
    store
        Name of what is stored, unique in the book.
    calls
        The arguments of each call; a single one without arguments by default.
    """
    return lambda compute: Recorded(compute, store, calls)


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:16]
