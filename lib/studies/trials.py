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
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache, partial
from importlib import import_module
from itertools import pairwise, product
from shutil import rmtree
from textwrap import dedent
from typing import Any

import numpy as np
import pandas as pd

from studies.claims import STOPPING, Claim
from studies.files import DamagedFile, reading, written
from studies.keys.cells import code_of
from studies.keys.definitions import meaning
from studies.keys.dependencies import hashed
from studies.keys.versions import differing, installed
from studies.project import project
from studies.rows import Rows, framed
from studies.says import Says
from studies.stored import recorded_rows
from studies.stored.results import TRIALS, TRIALS_ANEW, use
from studies.sweep import sweep

FEW = 3
"""Replicates that are computed at once of a study that a reader has changed."""
PATIENCE_S = 120.0
"""Seconds that computing these may take; beyond, the recorded rows are shown."""
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
    scales
        By measure, what its numbers are compared with: below 1e-9 of that they are zero. Of those
        that are not named it is 0.001, a millimetre.
    changed
        Words for what differs from the declared study; empty for that.
    """

    one: Callable[..., Mapping[str, Any]]
    stem: str
    axes: Mapping[str, tuple]
    fixed: Mapping[str, Any] = field(default_factory=dict)
    seed: int = 0
    scales: Mapping[str, float] = field(default_factory=dict)
    changed: str = ""
    declared: tuple = ()

    def __reduce__(self) -> tuple[Any, ...]:
        """Let a worker import the study from its notebook's module where it comes from there."""
        state = tuple(getattr(self, name) for name in self.__dataclass_fields__)
        if not self.one.__module__.startswith(project().modules):
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
        """Replicates on which the trials are repeated."""
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
        found, _ = chosen._computed(TRIALS)
        note = f"Computed just now: {_counted(chosen)}."
        return Rows(framed(found), self.replicate, dict(chosen.fixed), note)

    def _computed(self, folder: str) -> tuple[list[dict[str, Any]], np.ndarray]:
        """Return what all trials give, and their seconds by replicate and combination.

        Those that a folder of the cache has are not computed.
        """
        task, rng = partial(_kept, self, self.code(), folder), np.random.default_rng(self.seed)
        done = sweep(task, self.trials(), rng=rng, desc=self.name)  # trials have own generators
        found, seconds = zip(*done, strict=True)
        return [*found], np.reshape(seconds, (len(self.replicates), -1))

    @property
    def is_drawn(self) -> bool:
        """Tell whether its replicates number draws, of which a few stand for all.

        Such numbers follow each other, or lie as near together as seeds do. Words, measures and
        sizes are settings, each another one.
        """
        numbers = self.replicates
        if not all(isinstance(number, int) for number in numbers):
            return False
        return all(b - a == 1 for a, b in pairwise(numbers)) or max(numbers) < 2 * min(numbers)

    def rows(self) -> Rows:
        """Return the recorded rows; of a study that was changed since, rows of a few replicates.

        Rows of the library's own study are always the recorded ones; their note says so where the
        code has changed since they were recorded.

        Raises
        ------
        FileNotFoundError
            If nothing is recorded of a study of the library.
        DamagedFile
            If what is recorded is damaged.
        """
        recorded = self.recorded()
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
                f"{project().storing('--chapter', self.stem)} computes them"
            )
        return self._as_rows(recorded, f"Computed on {recorded.date} by earlier code")

    def _few(self) -> Rows:
        """Compute a few replicates of a study that a reader has changed, and say so once.

        If that takes longer than a reader waits, and only the code was changed, the recorded rows
        are returned, and it is said that they are of other code.
        """
        few = self.but(**{self.replicate: self.replicates[:FEW]}) if self.is_drawn else self
        recorded, took = self.recorded(), self._takes(few)
        if took > PATIENCE_S and recorded is not None and recorded.declared == self._declared():
            self._tell(
                f"{_counted(few)} computed here would take some {took / 60:.0f} minutes, so the "
                f"rows are those of the book's code; {self.name}.run() computes all"
            )
            return self._as_rows(recorded, f"Computed on {recorded.date} by other code")
        said = f"{_counted(few)} computed here"
        if few is not self and len(self.replicates) > FEW:
            said += f" of {len(self.replicates)}; {self.name}.run() computes all"
        self._tell(said)
        return few.run()

    def _takes(self, some: "Trials") -> float:
        """Return how long trials of a variant take by what was recorded of this one, s."""
        times = recorded_rows.seconds(self.stem, self.name)
        return len(list(some.trials())) * sum(times.get(self.changed or AS_DECLARED, ())) / 2

    def _tell(self, what: str) -> None:
        """Print once what is done about a change of the study."""
        if (key := (self.code(), self._declared())) not in _TOLD:
            _TOLD.add(key)
            print(f"{self.name} was changed: {what}.")

    def recorded(self) -> recorded_rows.Recorded | None:
        """Return what is recorded of the study, ``None`` if nothing is.

        Raises
        ------
        DamagedFile
            If it is damaged.
        """
        return recorded_rows.read(self.stem, self.name, self.changed or AS_DECLARED)

    def is_current(self) -> bool:
        """Tell whether this code, with these replicates and levels, gave what is recorded.

        What is damaged is not current.
        """
        with suppress(DamagedFile):
            recorded = self.recorded()
            return recorded is not None and recorded.fits(self.code(), self._declared())
        return False

    def other_packages(self) -> str:
        """Return in words which packages other than those here gave what is recorded."""
        recorded = recorded_rows.read(self.stem, self.name, self.changed or AS_DECLARED)
        return "" if recorded is None else differing(recorded.versions)

    def record(self, *, anew: bool = False) -> None:
        """Compute all trials that this computer does not have, and record their rows.

        With `anew` what it has of other runs does not count, only what this one left when it was
        interrupted.
        """
        found, seconds = self._computed(TRIALS_ANEW if anew else TRIALS)
        first = seconds[:, 0].max()  # computes what the other combinations find
        longest = first + seconds[:, 1:].max(initial=0.0)
        recorded_rows.write(
            self.stem,
            self.name,
            self.changed or AS_DECLARED,
            framed(found),
            self.code(),
            self._declared(),
            (float(f"{first:.2g}"), float(f"{longest:.2g}")),
        )

    def renew(self, drawn: Sequence[dict[str, Any]]) -> list[str]:
        """Record that this code gives the recorded rows, if some drawn trials say so.

        Returns
        -------
        list of str
            What differs; nothing is changed then.
        """
        task, rng = partial(_differing, self), np.random.default_rng(self.seed)
        found = sweep(task, drawn, rng=rng, desc=self.name)
        lines = [*dict.fromkeys(line for some in found for line in some)]
        if not lines:
            key = self.code(), self._declared()
            recorded_rows.renew(self.stem, self.name, self.changed or AS_DECLARED, *key)
        return lines

    def differs(self, **where: Any) -> list[str]:
        """Compute a recorded trial anew and return what differs, a line each.

        What is the same is said by :func:`recorded_rows.alike`, with the recorded rows of the
        trial's combination of factors. Where another kind of processor has recorded them a trial
        may also have as many rows as theirs have, or as far outside as these reach.
        """
        try:
            recorded = self.recorded()
        except DamagedFile as error:
            return [f"{error}"]
        if recorded is None:
            return [f"{self.name}: no rows are recorded"]
        elsewhere = recorded.processor != recorded_rows.processor()
        rows = self._as_rows(recorded, "")
        again = framed([self.trial(**where)])
        before = rows.where(**where).table.reset_index(drop=True)
        factors = {name: level for name, level in where.items() if name != self.replicate}
        others = rows.where(**factors).table if factors else rows.table
        sizes = others.groupby(self.replicate, sort=False).size()
        some, many = sizes.min(), sizes.max()
        fits = 2 * some - many <= len(again) <= 2 * many - some
        if list(again) != list(before) or not (fits if elsewhere else len(again) == len(before)):
            return [f"{self.name} {where}: other columns or another number of rows"]
        return [
            f"{self.name} {where}: {name} is {again[name].tolist()[:4]}, "
            f"recorded {before[name].tolist()[:4]}"
            for name in self._unlike(again, before, others, elsewhere=elsewhere)
        ]

    def same(self, again: pd.DataFrame, before: pd.DataFrame) -> bool:
        """Tell whether rows of all trials are those that were there before, on one processor."""
        if list(again) != list(before) or len(again) != len(before):
            return False
        factors = [name for name in self.axes if name != self.replicate]
        groups = before.groupby(factors, sort=False, dropna=False) if factors else None
        group = np.zeros(len(before)) if groups is None else groups.ngroup().to_numpy()
        return not any(
            self._unlike(again[group == k], before[group == k], before[group == k])
            for k in np.unique(group)
        )

    def _unlike(
        self,
        again: pd.DataFrame,
        before: pd.DataFrame,
        others: pd.DataFrame,
        *,
        elsewhere: bool = False,
    ) -> list[str]:
        """Return the columns in which rows of a combination are not the recorded ones."""
        return [
            name
            for name in again
            if not recorded_rows.alike(
                again[name],
                before[name],
                others[name],
                self.scales.get(name, recorded_rows.COMPARED),
                elsewhere=elsewhere,
            )
        ]

    def claim(
        self,
        id: str,
        *,
        sabotage: Mapping[str, "Trials"],
        stopping: str = STOPPING,
        **words: Any,
    ) -> Any:
        """Declare a claim.

        Where it has no value, or more to find than its fields say, it is a decorator of the
        function that says what rows show.

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
        own = {"study": self, "sabotages": changes, "stopping": stopping}
        declare = partial(Claim, id=id, chapter=self.stem, **own, **words)
        return declare() if "value" in words else lambda found: declare(compute=found)

    def says(self, about: str = "", **measures: tuple[Any, ...]) -> Says:
        """Say the measures of its rows, each once; see :class:`.says.Says`."""
        return Says(self, about, **measures)

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
            own: Any = getattr(import_module(f"{project().modules}{self.stem}"), self.name, None)
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
        self, *, seed: int = 0, scales: Mapping[str, float] | None = None, **axes: Any
    ) -> Callable[[Callable[..., Mapping[str, Any]]], Trials]:
        """Declare a study on the function of one trial: replicates first, then factors.

        Parameters
        ----------
        seed
            Of the generators of the replicates.
        scales
            What numbers of a measure are compared with where that is no millimetre: what differs
            by less than 1e-9 of it is rounding, as the difference of two ways to one result is.
        **axes
            Replicates, then the levels of each factor.

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
            return Trials(one, self.stem, levels, {}, seed, dict(scales or {}), "", declared)

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
    rmtree(project().cache() / TRIALS_ANEW, ignore_errors=True)


def _kept(
    study: Trials, code: str | None, folder: str, where: dict[str, Any], *, rng: object
) -> tuple[dict[str, Any], float]:
    """Return a trial and its seconds, from this computer if the same code computed it before."""
    if code is None:
        return _timed(study, where)
    drawn = (study.seed, study.key(where[study.replicate]), _seeds()) if study.draws() else None
    libraries = [*installed().items()]
    key = repr((code, libraries, recorded_rows.processor(), drawn, where, study.fixed))
    file = project().cache() / folder / f"{study.stem}.{study.name}-{hashed(key)}.json"
    with suppress(OSError, DamagedFile), reading(file, "no trial"):
        kept = json.loads(file.read_text("utf-8"))
        found, seconds = _unplain(kept["trial"]), float(kept["seconds"])
        use(file)
        return found, seconds
    found, seconds = _timed(study, where)
    plain = {name: np.asarray(value).tolist() for name, value in found.items()}
    with suppress(OSError):
        file.parent.mkdir(parents=True, exist_ok=True)
        with written(file) as beside:
            beside.write_text(json.dumps({"trial": plain, "seconds": seconds}), "utf-8")
    return _unplain(plain), seconds


def _differing(study: Trials, where: dict[str, Any], *, rng: object) -> list[str]:
    return study.differs(**where)


def _timed(study: Trials, where: dict[str, Any]) -> tuple[dict[str, Any], float]:
    """Compute a trial; return it and the seconds of this process that it took."""
    start = time.process_time()
    found = study.trial(**where)
    return found, time.process_time() - start


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
