"""Studies as tables of trials: one function for one replicate and one combination of factors.

.. code-block:: python

    chapter = Chapter("tutor_face")

    @chapter.study(film=range(5000, 5024), scene=("short", "long", "fast"))
    def bridged(film, scene, *, patience=20):
        ...
        return {"missed": gaps.sum(), "filter": near[gaps].sum()}

    bridged.rows().share("filter", "missed", scene="short")
    bridged.run(film=range(3))          # a reader's own, on few films
    bridged.but(patience=0)             # the same with one thing changed

A trial returns a number for each measure, or arrays of one length for several rows: what one film
tells of four rules. The runner loops; all rows are recorded, with the hash of the code that gave
them (:mod:`.cells`) and the hash of the numbers themselves. Trials that were computed once on this
computer are not computed again, so a long study goes on where it was interrupted.
"""

import ast
import inspect
import json
import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache, partial
from importlib import import_module
from itertools import product
from shutil import rmtree
from textwrap import dedent
from typing import Any

import numpy as np

from robot_perception.datasets.store import cache_directory
from robot_perception.evaluation.sweep import sweep
from robot_perception.files import DamagedFile, reading, written
from robot_perception.teaching import recorded_rows
from robot_perception.teaching.cells import BOOK, code_of
from robot_perception.teaching.claims import STOPPING, Claim, Finding
from robot_perception.teaching.dependencies import hashed, meaning
from robot_perception.teaching.results import TRIALS, TRIALS_ANEW, use
from robot_perception.teaching.rows import Rows, framed
from robot_perception.teaching.versions import differing, installed

FEW = 3
"""So many replicates of a study that a reader has changed are computed at once."""
AS_DECLARED = "as declared"
_TOLD: set[tuple[str | None, str]] = set()

log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Sabotage:
    """A study in which the truth of a statement is turned; words complete "The same with …".

    Parameters
    ----------
    text
        What was changed.
    study
        The changed study, or another one whose rows have the same columns.
    """

    text: str
    study: "Trials"


@dataclass(frozen=True, eq=False)
class Trials:
    """A function of one trial, and the replicates and factors that it is run with.

    Parameters
    ----------
    one
        Function of a replicate, a level of each factor, and keywords; of ``rng``, too, if it draws
        anything that the replicate alone does not decide. Returns measures by name.
    stem
        Of the chapter.
    axes
        Replicates by the name of their parameter, then the levels of each factor.
    fixed
        Keywords that are not as the function has them.
    seed
        Of the generators of the replicates.
    chaotic
        Whether single pixels of a film, or ties, decide what a trial gives: then its rows are
        compared one by one only where the same kind of processor has recorded them.
    changed
        Words for what differs from the declared study; empty for that.
    """

    one: Callable[..., Mapping[str, Any]]
    stem: str
    axes: Mapping[str, tuple]
    fixed: Mapping[str, Any] = field(default_factory=dict)
    seed: int = 0
    chaotic: bool = False
    changed: str = ""
    declared: tuple = ()

    def __reduce__(self) -> tuple[Any, ...]:
        """Let a worker import the study from its notebook's module where it comes from there."""
        state = tuple(getattr(self, name) for name in self.__dataclass_fields__)
        if not self.one.__module__.startswith(BOOK):
            return Trials, state
        return _imported, (
            self.one.__module__,
            self.name,
            dict(self.axes),
            self.fixed,
            self.changed,
        )

    @property
    def name(self) -> str:
        """Name of the study, that of its function."""
        return self.one.__name__

    @property
    def replicate(self) -> str:
        """Name of what is repeated."""
        return next(iter(self.axes))

    @property
    def replicates(self) -> tuple:
        """What the trials are repeated on."""
        return self.axes[self.replicate]

    def but(self, **changes: Any) -> "Trials":
        """Return the study with other levels of a factor, other replicates, or other keywords.

        Raises
        ------
        TypeError
            If the trial has no such parameter.
        ValueError
            If an axis has no or the same level twice.
        """
        known = inspect.signature(self.one).parameters
        for name in changes:
            if name not in known:
                raise TypeError(f"{self.name} has no {name!r}; it has {', '.join(known)}")
        axes = _axes({name: changes.get(name, levels) for name, levels in self.axes.items()})
        fixed = dict(self.fixed) | {k: v for k, v in changes.items() if k not in self.axes}
        said = ", ".join(f"{name}={_said(value)}" for name, value in changes.items())
        words = f"{self.changed}, {said}" if self.changed else said
        return replace(self, axes=axes, fixed=fixed, changed=words)

    def trials(self) -> Iterator[dict[str, Any]]:
        """Yield replicate and levels of each trial, the replicates in the outer loop."""
        for values in product(*self.axes.values()):
            yield dict(zip(self.axes, values, strict=True))

    def trial(self, **where: Any) -> dict[str, Any]:
        """Compute one trial, whatever is recorded, and return replicate, levels and measures."""
        words = dict(self.fixed)
        if self.draws():
            words["rng"] = self.generator(where[self.replicate])
        return where | dict(self.one(**where, **words))

    def draws(self) -> bool:
        """Tell whether a trial draws anything that its replicate alone does not decide."""
        return "rng" in inspect.signature(self.one).parameters

    def generator(self, replicate: Any) -> np.random.Generator:
        """Return the generator of a replicate, the same for every combination of factors."""
        return np.random.default_rng(
            np.random.SeedSequence(self.seed, spawn_key=self.key(replicate))
        )

    def key(self, replicate: Any) -> tuple[int, ...]:
        """Return what tells the generator of a replicate: its place among those declared."""
        declared = self.declared or self.replicates
        if replicate in declared:
            return (declared.index(replicate),)
        other = isinstance(replicate, int) and replicate >= 0
        return len(declared), replicate if other else int(hashed(repr(replicate)), 16)

    def run(self, **levels: Any) -> Rows:
        """Compute the trials of some replicates and levels, of all by default, and return rows.

        What this computer has computed before with the same code is not computed again.
        """
        chosen = self.but(**levels) if levels else self
        found = chosen._computed(TRIALS)
        note = f"Computed just now: {_counted(chosen)}."
        return Rows(framed(found), self.replicate, dict(chosen.fixed), note)

    def _computed(self, folder: str) -> list[dict[str, Any]]:
        """Return what all trials give; those that a folder of the cache has are not computed."""
        task, rng = partial(_kept, self, self.code(), folder), np.random.default_rng(self.seed)
        return sweep(task, self.trials(), rng=rng, desc=self.name)  # trials have own generators

    def rows(self) -> Rows:
        """Return the recorded rows; of a study that was changed since, rows of a few replicates.

        Rows of the library's own study are always the recorded ones; their note says so where the
        code has changed since they were recorded.

        Raises
        ------
        FileNotFoundError
            If nothing is recorded of a study of the library.
        """
        recorded = recorded_rows.read(self.stem, self.name, self.changed or AS_DECLARED)
        code, live = self.code(), self.one.__module__ == "__main__"
        if recorded is not None and recorded.fits(code, self._declared()):
            others = differing(recorded.versions)
            by = f"this code with {others}" if others else "this code"
            return self._as_rows(recorded, f"Computed on {recorded.date} by {by}")
        if live and (recorded is None or not self._is_the_books(code)):
            return self._few()
        if recorded is None:
            raise FileNotFoundError(
                f"no rows of {self.name} ({self.changed or AS_DECLARED}) are recorded: "
                f"`robot-perception store --chapter {self.stem}` computes them"
            )
        return self._as_rows(recorded, f"Computed on {recorded.date} by earlier code")

    def _few(self) -> Rows:
        """Compute a few replicates of a study that a reader has changed, and say so once."""
        few = self.but(**{self.replicate: self.replicates[:FEW]})
        said = f"{self.name} was changed: {_counted(few)} computed here"
        if len(self.replicates) > FEW:
            said += f" of {len(self.replicates)}; {self.name}.run() computes all"
        if (key := (self.code(), self._declared())) not in _TOLD:
            _TOLD.add(key)
            print(f"{said}.")
        return few.run()

    def is_current(self) -> bool:
        """Tell whether this code, with these replicates and levels, gave what is recorded."""
        recorded = recorded_rows.read(self.stem, self.name, self.changed or AS_DECLARED)
        return recorded is not None and recorded.fits(self.code(), self._declared())

    def other_packages(self) -> str:
        """Return in words which packages other than those here gave what is recorded."""
        recorded = recorded_rows.read(self.stem, self.name, self.changed or AS_DECLARED)
        return "" if recorded is None else differing(recorded.versions)

    def record(self, *, anew: bool = False) -> None:
        """Compute all trials that this computer does not have, and record their rows.

        With `anew` what it has of other runs does not count, only what this one left when it was
        interrupted.
        """
        table = framed(self._computed(TRIALS_ANEW if anew else TRIALS))
        recorded_rows.write(
            self.stem, self.name, self.changed or AS_DECLARED, table, self.code(), self._declared()
        )

    def renew(self, drawn: Sequence[dict[str, Any]]) -> list[str]:
        """Record that this code gives the recorded rows, if some drawn trials say so.

        Returns
        -------
        list of str
            What differs; nothing is changed then.
        """
        lines = [*dict.fromkeys(line for where in drawn for line in self.differs(**where))]
        if not lines:
            key = self.code(), self._declared()
            recorded_rows.renew(self.stem, self.name, self.changed or AS_DECLARED, *key)
        return lines

    def differs(self, **where: Any) -> list[str]:
        """Compute a recorded trial anew and return what differs, a line each.

        Each number must be the recorded one to 1e-6 of the largest of its column. Of a chaotic
        study that another kind of processor has recorded it must lie where those of its
        combination lie, or as far outside as these reach.
        """
        recorded = recorded_rows.read(self.stem, self.name, self.changed or AS_DECLARED)
        if recorded is None:
            return [f"{self.name}: no rows are recorded"]
        rows = self._as_rows(recorded, "")
        again = framed([self.trial(**where)])
        before = rows.where(**where).table.reset_index(drop=True)
        if list(again.columns) != list(before.columns) or len(again) != len(before):
            return [f"{self.name} {where}: other columns or another number of rows"]
        factors = {name: level for name, level in where.items() if name != self.replicate}
        alike = rows.where(**factors).table if factors else rows.table
        elsewhere = self.chaotic and recorded.processor != recorded_rows.processor()
        return [
            f"{self.name} {where}: {name} is {again[name].tolist()[:4]}, "
            f"recorded {before[name].tolist()[:4]}"
            for name in again
            if not recorded_rows.alike(again[name], before[name], alike[name], elsewhere)
        ]

    def claim(
        self,
        id: str,
        *,
        sabotage: Mapping[str, "Trials"],
        stopping: str = STOPPING,
        **words: Any,
    ) -> Callable[[Callable[[Rows], Finding]], Claim]:
        """Declare a claim on the function that says what rows show of it.

        Parameters
        ----------
        id
            Identifier of the claim.
        sabotage
            By the words that complete "The same with …", a study in which the statement is false,
            or true where it fails.
        stopping
            When there are enough replicates, as registered.
        **words
            The other fields of `Claim`.
        """
        changes = tuple(Sabotage(text, study) for text, study in sabotage.items())

        def declare(finding: Callable[[Rows], Finding]) -> Claim:
            own = {"study": self, "compute": finding, "sabotages": changes, "stopping": stopping}
            return Claim(id=id, chapter=self.stem, **own, **words)

        return declare

    def code(self) -> str | None:
        """Return the hash of the code of a trial; ``None`` if its source is not known."""
        return code_of(self.one)

    def _declared(self) -> str:
        """Hash what the trials are run with."""
        levels = {name: list(values) for name, values in self.axes.items()}
        return hashed(repr((self.seed, levels, self.fixed, _seeds())))

    def _is_the_books(self, code: str | None) -> bool:
        """Tell whether a study in a notebook is that of the book's module, code and levels."""
        try:
            own: Any = getattr(import_module(f"{BOOK}{self.stem}"), self.name, None)
        except ImportError:
            return False
        if not isinstance(own, Trials) or own.code() != code:
            return False
        return own.but(**self._changes())._declared() == self._declared()

    def _changes(self) -> dict[str, Any]:
        return dict(self.fixed) | (dict(self.axes) if self.changed else {})

    def _as_rows(self, recorded: "recorded_rows.Recorded", start: str) -> Rows:
        return Rows(recorded.table, self.replicate, dict(self.fixed), f"{start}: {_counted(self)}.")


@dataclass(frozen=True, eq=False)
class Chapter:
    """The studies of a notebook.

    Parameters
    ----------
    stem
        Of the notebook.
    """

    stem: str

    def study(
        self, *, seed: int = 0, chaotic: bool = False, **axes: Any
    ) -> Callable[[Callable[..., Mapping[str, Any]]], Trials]:
        """Declare a study on the function of one trial: replicates first, then factors.

        Raises
        ------
        ValueError
            If there are no replicates, or an axis has no or the same level twice.
        """
        if not axes:
            raise ValueError("a study needs replicates: name them first")
        levels = _axes(axes)
        declared = levels[next(iter(levels))]

        def declare(one: Callable[..., Mapping[str, Any]]) -> Trials:
            return Trials(one, self.stem, levels, {}, seed, chaotic, "", declared)

        return declare


def _seeds() -> str:
    """Hash how the generator of a replicate is made: no code that a trial reaches says so."""
    return hashed(f"{_meaning(Trials.generator)} {_meaning(Trials.key)}")


@cache
def _meaning(function: Callable[..., Any]) -> str:
    return meaning(ast.parse(dedent(inspect.getsource(function))))


def _imported(
    module: str, name: str, axes: dict[str, tuple], fixed: Mapping[str, Any], changed: str
) -> Trials:
    own: Trials = getattr(import_module(module), name)
    return replace(own, axes=axes, fixed=fixed, changed=changed)


def forget_anew() -> None:
    """Forget the trials of a run that computed all anew; the next one begins at the start."""
    rmtree(cache_directory() / TRIALS_ANEW, ignore_errors=True)


def _kept(
    study: Trials, code: str | None, folder: str, where: dict[str, Any], *, rng: object
) -> dict[str, Any]:
    """Return a trial, from this computer if it was computed before by the same code."""
    if code is None:
        return study.trial(**where)
    drawn = (study.seed, study.key(where[study.replicate]), _seeds()) if study.draws() else None
    libraries = [*installed().items()]
    key = repr((code, libraries, recorded_rows.processor(), drawn, where, study.fixed))
    file = cache_directory() / folder / f"{study.stem}.{study.name}-{hashed(key)}.json"
    with suppress(OSError, DamagedFile), reading(file, "no trial"):
        found = json.loads(file.read_text("utf-8"))
        use(file)
        return _unplain(found)
    plain = {name: np.asarray(value).tolist() for name, value in study.trial(**where).items()}
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        with written(file) as beside:
            beside.write_text(json.dumps(plain), "utf-8")
    return _unplain(plain)


def _unplain(found: Mapping[str, Any]) -> dict[str, Any]:
    """Return a trial as it is read, so that rows are the same whether it was kept or not."""
    return {name: np.array(v) if isinstance(v, list) else v for name, v in found.items()}


def _axes(axes: Mapping[str, Any]) -> dict[str, tuple]:
    levels = {name: _levels(values) for name, values in axes.items()}
    for name, values in levels.items():
        if not values or len(set(values)) < len(values):
            raise ValueError(f"{name} needs levels, each once, got {_said(values)}")
    return levels


def _levels(values: Any) -> tuple:
    return (values,) if isinstance(values, str | int | float | None) else tuple(values)


def _said(values: Any) -> str:
    """Return levels in words, those that follow each other as their ends."""
    some = _levels(values)
    whole = all(isinstance(v, int) and not isinstance(v, bool) for v in some)
    if len(some) > 2 and whole and list(some) == list(range(some[0], some[-1] + 1)):
        return f"{some[0]} to {some[-1]}"
    return " ".join(f"{v}" for v in some)


def _counted(study: Trials) -> str:
    """Return how many replicates there are, in words."""
    number = len(study.replicates)
    return f"{number} {study.replicate}{'' if number == 1 else 's'}"
