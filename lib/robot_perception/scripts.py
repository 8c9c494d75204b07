"""What the scripts of "Your own data" share: arguments, places of results, errors in one line."""

import io
import math
import os
import sys
from collections.abc import Callable, Iterator, Mapping
from inspect import signature
from pathlib import Path
from typing import Any, final

from robot_perception import checks
from robot_perception.extras import needing

with needing():
    import click

Main = Callable[..., None]
TIME_UNITS = ("s", "ms", "us", "ns")  # as `datasets.limits` has them
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


class Recording(click.ParamType):
    """An argument that names a file or a folder to read; it becomes a `pathlib.Path`.

    Parameters
    ----------
    or_words
        Whether it may be words as well, which stay a text where there is no such file.
    """

    name = "recording"

    def __init__(self, *, or_words: bool = False) -> None:
        self.or_words = or_words

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the path of what is there, packed or not."""
        path = Path(value)
        packed = path.with_suffix("") if path.suffix == ".gz" else Path(f"{path}.gz")
        if not path.exists() and not packed.is_file():  # readers of text take the one for the other
            if self.or_words:
                return value
            self.fail(f"{value}: no such file or folder", param, ctx)
        return path


@final
class Places(Mapping[str, Path]):
    """Where results go, by the endings of their names.

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


class Results(click.ParamType):
    """An argument that says what the names of results begin with; it becomes `Places`.

    Parameters
    ----------
    endings
        Those of all files that the script may write.
    """

    name = "results"

    def __init__(self, *endings: str) -> None:
        self.endings = endings or ("",)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the places, in a folder that is there."""
        places = Places(str(value), self.endings)
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


class Script(click.Command):
    """A command that refuses to write over what it reads, and ends in one line on bad input."""

    def invoke(self, ctx: click.Context) -> Any:
        """Check the places of results; then run the script, whose words any console can show."""
        if isinstance(sys.stdout, io.TextIOWrapper):
            sys.stdout.reconfigure(errors="backslashreplace")
        values = list(ctx.params.values())
        several = [value if isinstance(value, tuple) else (value,) for value in values]
        recordings = [one for values in several for one in values if isinstance(one, Path)]
        results = [path for value in values if isinstance(value, Places) for path in value.values()]
        try:
            check_results(results, recordings, overwrite=ctx.params.get("force", False))
            return super().invoke(ctx)
        except (OSError, TypeError, ValueError, ModuleNotFoundError) as error:
            raise click.ClickException(str(error)) from error


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


def tell(recording: Any) -> Any:
    """Print what of a recording is not as it should be, a sentence a line, and return it.

    Parameters
    ----------
    recording
        Its ``report`` has the remarks; one of a table has none.
    """
    for remark in recording.report.remarks if recording.report else ():
        print(remark)
    return recording


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
    argument of type `Results`, ``--topic``, once or more, if it takes ``topic``, ``--time-unit`` if
    it takes ``time_unit``, and ``--field`` if it takes ``field``.
    """
    if any(isinstance(one.type, Results) for one in getattr(main, "__click_params__", ())):
        told = "Write over files that are there."
        main = click.option("--force", is_flag=True, help=told)(main)
    if "topic" in signature(main).parameters:
        told = "Of a ROS bag in which several would do; may be given more than once."
        main = click.option("--topic", multiple=True, metavar="NAME", help=told)(main)
    if "time_unit" in signature(main).parameters:
        told = "What the recordings count time in; a bag tells it itself."
        units = click.Choice(TIME_UNITS)
        main = click.option("--time-unit", type=units, default="s", help=told)(main)
    if "field" in signature(main).parameters:
        told = "Directions of the first and last beam, degrees, where a log of a laser tells none."
        main = click.option("--field", type=Field(), metavar="FIRST,LAST", help=told)(main)
    words = {"help_option_names": ["-h", "--help"], "ignore_unknown_options": True}  # -5,3 is none
    return click.command(cls=Script, context_settings=words)(main)


def _holds(recording: Path, path: Path) -> bool:
    """Tell whether a file is a recording, or a picture in the folder that is one."""
    if recording.is_dir():
        inside = path.resolve().is_relative_to(recording.resolve())
        return inside and path.suffix.lower() in READ_IN_FOLDERS
    return recording.exists() and os.path.samefile(recording, path)
