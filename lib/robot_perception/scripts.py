"""Parts that the scripts of "Your own data" share: arguments, results, errors in one line."""

import io
import math
import os
import re
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from inspect import signature
from itertools import pairwise, product
from pathlib import Path
from statistics import median
from typing import Any, final

import robot_perception
from robot_perception import checks
from robot_perception.extras import NAMES, extra_of


@contextmanager
def installed() -> Iterator[None]:
    """End the program in one line if an import inside finds no package.

    Raises
    ------
    SystemExit
        In place of ``ModuleNotFoundError``; it says what to install.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        if _is_ours(error):
            raise
        raise SystemExit(f"Error: {_advice(error)}") from None


def _is_ours(error: ModuleNotFoundError) -> bool:
    return str(error.name).partition(".")[0] in ("robot_perception", "data_synth", "None")


def _advice(error: ModuleNotFoundError) -> str:
    """Return what to install: a package of the index, or an extra in the folder of the book."""
    package = str(error.name).partition(".")[0]
    return (
        f"this needs {package}: pip install {NAMES.get(package, package)}"
        f" (or, in the folder of the book, pip install '.[{extra_of(package)}]')"
    )


with installed():
    import click

Main = Callable[..., None]
WORDS = {
    r"\b\w+(=.*?)?, in a script:? ": "",
    r" \(time_unit='\w+'\)": "",  # `Clocks` says how to give it
    r"\bcalibration=…, in stereo_slam\.py CALIBRATION\b": "CALIBRATION in the script gives it",
    r"\b\w+=…, in \w+\.py ": "",
    r"\ballow_gaps=True\b": "GAPS = True in the script",
    r"\bpattern=… tells which are meant": "leave only those that are meant in the folder",
    r"\bfield_of_view\b": "--field",
    r"\bmax_range\b": "MAX_RANGE",
    r"\blongest_gap\b": "GAP",
    r"\btimed=False\b": "walls.py",
    r"\boverwrite=True replaces\b": "--force writes over",
    r"\bread_carmen_log\b": "walls.py carmen",
    r"\bread_graph_log\b": "walls.py graph",
    r"\b(use )?read_landmark_graph\b": "no script reads one",
    r"\bread_space_track\b": "judge.py",
    r"\bread_film takes\b": "give",
}
"""Names in the library's sentences, and a script's words for them: options, constants, scripts."""
FILM = "A film, a folder of pictures with numbers in their names, or a ROS bag."
TIME_UNITS = ("s", "ms", "us", "ns")  # as `datasets.limits` has them: of each a thousandth
USUAL_STEP = 0.1  # s between two times of a recording
HARDLY = 0.01  # of the longer recording: with so little in common, units are looked at
SINCE_1970 = 9e8  # s: a clock that tells more counts from there
READ_IN_FOLDERS = {
    ".bmp",
    ".gif",
    ".jpeg",
    ".jpg",
    ".pgm",
    ".png",
    ".ppm",
    ".tif",
    ".tiff",
    ".webp",
}


class Form(click.ParamType):
    """The form of an argument, which ``--help`` tells.

    Parameters
    ----------
    what
        What it is.
    """

    name = "word"

    def __init__(self, what: str) -> None:
        self.what = what

    def rows(self, name: str) -> list[tuple[str, str]]:
        """Return what stands beside the name of an argument of this form."""
        return [(name, self.what)]


class Kinds(click.Choice, Form):
    """An argument that is one of a few words.

    Parameters
    ----------
    words
        Each, and what it stands for.
    """

    def __init__(self, words: Mapping[str, str]) -> None:
        super().__init__(list(words))
        self.words = dict(words)

    def rows(self, name: str) -> list[tuple[str, str]]:
        """Return a row for each word."""
        return list(self.words.items())


class Recording(Form):
    """An argument that names a file or a folder to read; it becomes a `pathlib.Path`.

    Parameters
    ----------
    what
        What is read there.
    """

    name = "recording"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path of what is there, packed or not."""
        if not _is_there(value):
            self.fail(f"{value}: no such file or folder", param, ctx)
        return Path(value)


class Numbers(Form):
    """An argument of finite numbers between commas; it becomes a tuple.

    Parameters
    ----------
    form
        Their names between commas.
    what
        What they are, and their unit.
    word
        What may stand in their place, and stays as it is.
    or_file
        Whether it may be the name of a file as well, which becomes a `pathlib.Path`.
    """

    name = "numbers"

    def __init__(self, form: str, what: str, *, word: str = "", or_file: bool = False) -> None:
        super().__init__(f"{form}{f', or {word}' if word else ''}: {what}")
        self.form, self.word, self.or_file = form, word, or_file

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the numbers, the word or the path."""
        if self.or_file and _is_there(value):
            return Path(value)
        if self.word and value == self.word:
            return value
        try:
            found = tuple(map(float, value.split(",")))
        except ValueError:
            found = ()
        if len(found) != len(self.form.split(",")) or not all(map(math.isfinite, found)):
            others = [self.word] * bool(self.word) + ["a file"] * self.or_file
            self.fail(f"must be {' or '.join([self.form, *others])}, got {value!r}", param, ctx)
        return found


@final
class Places(Mapping[str, Path]):
    """Places of results, by the endings of their names.

    Parameters
    ----------
    stem
        What their names begin with.
    endings
        What follows, such as ``.csv`` or ``_map.csv``; nothing if the stem is the name.
    """

    def __init__(self, stem: str, endings: tuple[str, ...]) -> None:
        self.stem = stem
        self._paths = {ending: Path(f"{stem}{ending}") for ending in endings}

    def __getitem__(self, ending: str) -> Path:
        """Return the path of one result."""
        return self._paths[ending]

    def __iter__(self) -> Iterator[str]:
        return iter(self._paths)

    def __len__(self) -> int:
        return len(self._paths)


class Results(Form):
    """An argument that says what the names of results begin with; it becomes `Places`.

    A name that ends as one of the results does is taken without this ending.

    Parameters
    ----------
    files
        The endings of all files that the script may write, and what each holds.
    """

    name = "results"

    def __init__(self, files: Mapping[str, str]) -> None:
        super().__init__("What the names of the files that are written begin with.")
        self.files = dict(files)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the places, in a folder that is there."""
        stem, suffix = os.path.splitext(str(value))
        places = Places(stem if suffix in self.files else str(value), tuple(self.files))
        for path in places.values():
            if not path.parent.is_dir():
                self.fail(f"{path.parent} is no folder: cannot write {path} there", param, ctx)
            if path.is_dir():
                self.fail(f"{path} is a folder, not a file to write", param, ctx)
        return places


class Field(click.ParamType):
    """An option with the directions of a laser's first and last beam, degrees; it becomes rad."""

    name = "field"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the two angles, which lie within a turn."""
        try:
            first, last = (float(word) for word in str(value).split(","))
        except ValueError:
            self.fail(f"{value}: not two angles in degrees, such as -135,135", param, ctx)
        if not max(abs(first), abs(last)) <= 360:
            self.fail(f"{value}: an angle beyond a full turn of 360 degrees", param, ctx)
        return math.radians(first), math.radians(last)


@final
class Clocks:
    """The clocks of a script's recordings, each with its unit of time.

    Parameters
    ----------
    given
        Values of ``--time-unit``: none, one for all recordings, or one for each in their order.
    paths
        The recordings that have times.

    Raises
    ------
    ValueError
        If there are more units than recordings.
    """

    def __init__(self, given: Sequence[str], *paths: Path) -> None:
        told = for_each("--time-unit", given, len(paths))
        self.units = dict(zip(paths, told, strict=True))
        self._is_of_each = len(given) > 1
        self._again: dict[Path, Callable[[str], Any]] = {}

    def read(self, reader: Callable[..., Any], path: Path, *more: Any, **how: Any) -> Any:
        """Return what a reader reads, in the unit that is given, or else that its numbers tell.

        Parameters
        ----------
        reader
            It takes ``time_unit``; its errors have a ``unit`` where the numbers tell another one.
        path
            One of the recordings.
        more, how
            What else the reader takes.
        """
        self._again[path] = lambda unit: reader(path, *more, time_unit=unit, **how)
        unit = self.units[path]
        try:
            found = self._again[path](unit or TIME_UNITS[0])
        except ValueError as error:
            told = getattr(error, "unit", None)
            if not told:
                raise
            self.units[path] = told
            if unit:
                raise ValueError(f"{error}; {_call(self.units.values())}") from error
            found = self._again[path](told)
            print(f"{path}: its times are read in {told}, as their size tells")
        return found

    def check(self, *timed: tuple[Path, Collection[float]]) -> None:
        """Raise ``ValueError`` unless two recordings have times in common.

        Where they hardly have, and would have most in units in which their steps are more usual, it
        raises as well, unless each has been given its own unit.

        Parameters
        ----------
        timed
            Both, each with its times in s.
        """
        times = [times for _, times in timed]
        common = _in_common(*times)
        if common > HARDLY or (common >= 0 and self._is_of_each):
            return
        advice = self._advice(timed, sum(map(_oddity, times)) if common >= 0 else math.inf)
        if common >= 0 and not advice:
            return
        if not advice and len({max(of) > SINCE_1970 for of in times}) > 1:
            advice = "; one clock counts from 1970, the other does not"
        spans = (f"{path} {_span(of)}" for path, of in timed)
        few = "hardly a time" if common >= 0 else "no time"
        raise ValueError(f"{few} in common: {' and '.join(spans)}{advice}")

    def _advice(self, timed: Sequence[tuple[Path, Collection[float]]], oddity: float) -> str:
        """Return which units would give two recordings times in common, in less odd steps."""
        choices = [self._possible(path) or [("", times)] for path, times in timed]
        found = [
            (sum(_oddity(times) for _, times in both), [unit for unit, _ in both if unit])
            for both in product(*choices)
            if _in_common(*(times for _, times in both)) > HARDLY
        ]
        least, units = min(found, default=(math.inf, []))
        return f"; {_call(units)}" if least < oddity else ""

    def _possible(self, path: Path) -> list[tuple[str, Collection[float]]]:
        """Return the units in which a recording can be read, each with its times, s."""
        possible = []
        for unit in TIME_UNITS if path in self._again else ():
            with suppress(ValueError):
                possible.append((unit, self._again[path](unit).times))
        return possible


def _call(units: Iterable[str | None]) -> str:
    """Return what to call a script with for units of its recordings."""
    return f"{' '.join(f'--time-unit {unit or TIME_UNITS[0]}' for unit in units)} would help"


def _span(times: Collection[float]) -> str:
    """Return from when to when times reach, in words."""
    first, last = min(times), max(times)
    return f"at {first:.3f} s" if first == last else f"from {first:.3f} to {last:.3f} s"


def _in_common(first: Collection[float], second: Collection[float]) -> float:
    """Return the share of the longer one of two recordings in which there is the other, too.

    Below 0 where they do not overlap.
    """
    ends = [(min(times), max(times)) for times in (first, second)]
    begin, end = max(low for low, _ in ends), min(high for _, high in ends)
    longest = max(high - low for low, high in ends)
    if begin > end:
        return -1.0
    return (end - begin) / longest if longest else 1.0


def _oddity(times: Collection[float]) -> float:
    """Return how far from usual the steps between times are, as a power of ten."""
    places = sorted({*times})
    steps = [b - a for a, b in pairwise(places)]
    return abs(math.log10(median(steps) / USUAL_STEP)) if steps else 0.0


def for_each(option: str, given: Sequence[str], count: int) -> list[str | None]:
    """Return what an option says of each of some files: nothing, one for all, or one for each.

    Raises
    ------
    ValueError
        If it was given another number of times.
    """
    if len(given) not in (0, 1, count):
        times = "once" if count == 1 else f"once, or {count} times in the order of the files"
        raise ValueError(f"{option} may be given {times}, got {' '.join(given)}")
    return [*given] if len(given) == count else [given[0] if given else None] * count


class Script(click.Command):
    """A command that refuses to write over what it reads, and ends in one line on bad input."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the forms of the arguments, the options, and which files there will be."""
        own = [one for one in self.params if isinstance(one, click.Argument)]
        named = [(one.human_readable_name, one.type) for one in own if isinstance(one.type, Form)]
        if rows := [row for name, form in named for row in form.rows(name)]:
            with formatter.section("Arguments"):
                formatter.write_dl(rows)
        super().format_options(ctx, formatter)
        for name, form in named:
            if isinstance(form, Results):
                with formatter.section("Files that are written"):
                    formatter.write_dl([(f"{name}{end}", what) for end, what in form.files.items()])

    def invoke(self, ctx: click.Context) -> Any:
        """Check the places of results; then run the script, whose words any console can show.

        The last line that it prints names the files that it has written.
        """
        if isinstance(sys.stdout, io.TextIOWrapper):
            sys.stdout.reconfigure(errors="backslashreplace")
        values = list(ctx.params.values())
        several = [value if isinstance(value, tuple) else (value,) for value in values]
        recordings = [one for values in several for one in values if isinstance(one, Path)]
        results = [path for value in values if isinstance(value, Places) for path in value.values()]
        before = list(map(_state, results))
        try:
            check_results(results, recordings, overwrite=ctx.params.get("force", False))
            value = super().invoke(ctx)
        except ModuleNotFoundError as error:
            if _is_ours(error):
                raise
            raise click.ClickException(_advice(error)) from error
        except (OSError, TypeError, ValueError) as error:
            raise click.ClickException(worded(str(error))) from error
        after = zip(results, before, map(_state, results), strict=True)
        if written := [str(path) for path, was, now in after if now != was]:
            print(f"written: {', '.join(written)}")
        return value


def check_results(results: list[Path], recordings: list[Path], *, overwrite: bool) -> None:
    """Raise if a result would take the place of a recording, or of any file without leave.

    Parameters
    ----------
    results
        What will be written.
    recordings
        What will be read: files, and folders with all pictures in them.
    overwrite
        Whether other files may be written over.

    Raises
    ------
    ValueError
        If a result is, under whatever name, one of the recordings, or a picture in one.
    FileExistsError
        If there is such a file, and leave is not given.
    """
    there = [path for path in results if path.exists()]
    for path in there:
        for recording in recordings:
            if _holds(recording, path):
                raise ValueError(f"{path} would be written over, and it is read: {recording}")
    if there and not overwrite and any(path.is_file() for path in there):
        names = ", ".join(str(path) for path in there)
        raise FileExistsError(f"{names}: there already; --force writes over what is there")


def worded(text: str) -> str:
    """Return a sentence of the library as a script says it, in one line: see `WORDS`."""
    for ours, theirs in WORDS.items():
        text = re.sub(ours, theirs, text)
    return " ".join(text.splitlines())


def tell(recording: Any) -> Any:
    """Print what of a recording is not as it should be, a sentence a line, and return it.

    Parameters
    ----------
    recording
        It has the remarks, as a film, or its ``report``; one of a table has none.
    """
    told = recording if hasattr(recording, "remarks") else recording.report
    for remark in told.remarks if told else ():
        print(worded(remark))
    return recording


def of_the_book(name: str) -> Path:
    """Return a file that the book has recorded: of the checkout, or shipped inside the package.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    """
    package = Path(robot_perception.__file__).parent
    for folder in (package.parents[1] / "book" / "_data", package / "_data"):
        if (folder / name).is_file():
            return folder / name
    raise FileNotFoundError(f"{name} is not beside the library: install it from the book's folder")


def within(name: str, value: Any, least: float, most: float, unit: str) -> float:
    """Return a constant of a script if it is sensible in the unit in which it is asked for.

    Raises
    ------
    TypeError
        If it is no number.
    ValueError
        If it is out of range.
    """
    found = checks.number(name, value)
    if not least <= found <= most:
        raise ValueError(f"{name} must be from {least:g} to {most:g} {unit}, got {found:g}")
    return found


def script(main: Main) -> Script:
    """Make a script of a function whose parameters are arguments and options of `click`.

    Its docstring is the help. It gets ``--force``, which reaches it as ``force``, if it has an
    argument of type `Results`, ``--topic`` if it takes ``topic``, and ``--time-unit`` if it takes
    ``time_unit``, both once or more, and ``--field`` if it takes ``field``.
    """
    if any(isinstance(one.type, Results) for one in getattr(main, "__click_params__", ())):
        told = "Write over files that are there."
        main = click.option("--force", is_flag=True, help=told)(main)
    if "topic" in signature(main).parameters:
        told = "Of a ROS bag in which several would do; may be given more than once."
        main = click.option("--topic", multiple=True, metavar="NAME", help=told)(main)
    if "time_unit" in signature(main).parameters:
        told = "What the recordings count time in, once or for each in their order; else it is told"
        told += " by the numbers, or by a bag."
        units = click.Choice(TIME_UNITS)
        main = click.option("--time-unit", type=units, multiple=True, help=told)(main)
    if "field" in signature(main).parameters:
        told = "Directions of the first and last beam, degrees, where a log of a laser tells none."
        main = click.option("--field", type=Field(), metavar="FIRST,LAST", help=told)(main)
    words = {"help_option_names": ["-h", "--help"], "ignore_unknown_options": True}  # -5,3 is none
    return click.command(cls=Script, context_settings=words)(main)


def _is_there(name: Any) -> bool:
    """Tell whether there is a file or a folder of that name, packed or not.

    Readers of text take the one for the other.
    """
    path = Path(name)
    packed = path.with_suffix("") if path.suffix == ".gz" else Path(f"{path}.gz")
    return bool(name) and (path.exists() or packed.is_file())


def _state(path: Path) -> tuple[int, int] | None:
    """Return what changes when a file is written, none if there is no file."""
    if not path.exists():
        return None
    found = path.stat()
    return found.st_ino, found.st_mtime_ns


def _holds(recording: Path, path: Path) -> bool:
    """Tell whether a file is a recording, or a picture in the folder that is one."""
    if recording.is_dir():
        inside = path.resolve().is_relative_to(recording.resolve())
        return inside and path.suffix.lower() in READ_IN_FOLDERS
    return recording.exists() and os.path.samefile(recording, path)
