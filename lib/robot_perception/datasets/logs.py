"""What every reader of recordings shares: lines, read strictly, and laser scans."""

import gzip
import os
import re
import zlib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any, final

import numpy as np
from jaxtyping import Bool, Float

from robot_perception.checks import flag, instance, number, reals
from robot_perception.files import DamagedFile

GZIP_MAGIC = b"\x1f\x8b"
CHUNK, LONGEST_LINE, LARGEST_TEXT = 2**16, 2**18, 2**20  # bytes
LARGEST_RATIO = 100  # of text to file beyond LARGEST_TEXT; known logs have 11
LONGEST_LOG = 7 * 86400.0  # s
KEYWORD = re.compile(rb"[A-Za-z][A-Za-z0-9_]*\Z")
CONTROL_BYTES = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f]")
FIELDS_OF_VIEW_DEG = {180: (-90, 89), 181: (-90, 90), 360: (-90, 89.5), 361: (-90, 90)}

KINDS = {  # by the keyword that tells them: what a file is, and what reads it
    "FLASER": ("a CARMEN log", "read_carmen_log"),
    "VERTEX2": ("a pose graph", "read_graph_log"),
    "VERTEX_SE2": ("a pose graph", "read_graph_log"),
    "ODOMETRY": ("a chain of motions", "read_landmark_graph"),
}

NOT_FINITE = "a value is NaN or infinite"
SHORT = "fewer values than announced"
OTHER_BEAMS = "its number of beams differs from the first scan's"

# What laser loggers write where nothing came back: (lowest, highest) largest reading of such a log,
# and the threshold. SICK scanners send error codes for readings: in centimetres 0x1FF7 ... 0x1FFF
# (81.83 ... 81.91 m), in millimetres 0x7FF7 ... 0x7FFF (32.759 ... 32.767 m). ACES, FHW and
# Acapulco hold 50 to 51.25 m there.
NO_RETURN_CODES = ((80.0, np.inf, 80.0), (50.0, 52.0, 50.0), (32.759, 32.767, 32.759))

Check = tuple[str, Callable[[np.ndarray], np.ndarray]]
"""Why rows of a table are bad, and which are."""
FINITE: Check = (NOT_FINITE, lambda rows: ~np.isfinite(rows).all(axis=1))


class CorruptLog(DamagedFile):
    """A recording that cannot be read; the message names the file and the line."""


@final
@dataclass(frozen=True, slots=True)
class ReadReport:
    """Account of every line of a recording: what became data, and what the reader has no use for.

    Parameters
    ----------
    path
        The file.
    kept
        Lines that became data, by keyword.
    others
        Lines of kinds this reader does not read, by keyword; comments are ``"#"``, empty lines
        ``"blank"``.
    """

    path: Path
    kept: Mapping[str, int]
    others: Mapping[str, int]

    @property
    def lines(self) -> int:
        """Number of lines of the file."""
        return sum(self.kept.values()) + sum(self.others.values())

    def __str__(self) -> str:
        """Return the report as a sentence for people."""
        kept, others = (
            ", ".join(f"{count} {keyword}" for keyword, count in counts.items()) or "none"
            for counts in (self.kept, self.others)
        )
        return f"{self.path.name}: {self.lines} lines; read {kept}; other kinds {others}"


@dataclass(frozen=True, eq=False, slots=True)
class LaserLog:
    """Planar laser scans with the poses they were taken from.

    Parameters
    ----------
    ranges : (scans, beams)
        Distances in m; ``inf`` where the beam came back from nothing.
    angles : (beams,)
        Beam directions in rad, counter-clockwise, in the laser's frame (0 is straight ahead).
    poses : (scans, 3)
        Laser pose (x, y, theta) in the map, in m and rad: the best estimate the log holds.
    odometry : (scans, 3)
        Robot pose (x, y, theta) by wheel odometry, in m and rad, where the log has it; logs that
        were corrected afterwards repeat the corrected pose.
    times : (scans,)
        Time stamps in s.
    max_range
        Readings of at least this many metres were taken for "no return".
    report
        What became of every line of the file.
    """

    ranges: Float[np.ndarray, "scans beams"]
    angles: Float[np.ndarray, " beams"]
    poses: Float[np.ndarray, "scans 3"]
    odometry: Float[np.ndarray, "scans 3"]
    times: Float[np.ndarray, " scans"]
    max_range: float
    report: ReadReport


def as_path(path: str | os.PathLike[str], name: str = "path") -> Path:
    """Return the path of a file or folder, or raise ``TypeError``."""
    return Path(instance(name, path, str, os.PathLike))


def check_reading(max_range: float | None, timed: bool) -> None:
    """Raise unless the options of a laser log's reader are as they should be."""
    flag("timed", timed)
    if max_range is not None and not number("max_range", max_range, finite=False) > 0:
        raise ValueError(f"max_range must be positive, got {max_range}")


@final
class Lines:
    """The lines of a text recording, plain or gzip, read once and strictly, and counted.

    Parameters
    ----------
    path
        The file; whether it is gzip is told from its first bytes. If there is none of that name,
        the same name with or without ``.gz`` will do.

    Raises
    ------
    CorruptLog
        While reading: if the file is empty or damaged, a line is not text, or it unpacks to more
        than a recording could.
    FileNotFoundError
        While reading: if there is no such file.
    """

    def __init__(self, path: str | Path) -> None:
        path = as_path(path)
        other = path.with_suffix("") if path.suffix == ".gz" else path.with_name(f"{path.name}.gz")
        self.path = other if other.is_file() and not path.exists() else path
        self.number = 0
        self.place = 0  # number among the lines that are neither blank nor comment
        self.kept: Counter[str] = Counter()
        self.others: Counter[str] = Counter()

    def error(self, reason: str, line: int | None = None) -> CorruptLog:
        """Return the error that names a line, the present one if none is given."""
        return CorruptLog(f"{self.path}, line {line or self.number}: {reason}")

    def words(self) -> Iterator[list[bytes]]:
        """Yield the words of each line that is neither blank nor comment."""
        text = self._text()
        for self.number, line in enumerate(text.split(b"\n"), start=1):
            if len(line) > LONGEST_LINE:
                raise self.error(f"longer than {LONGEST_LINE} bytes")
            if CONTROL_BYTES.search(line) or not (line.isascii() or _is_utf8(line)):
                raise self.error("not text")
            words = line.split()
            if not words or words[0].startswith(b"#"):
                self.others["#" if words else "blank"] += 1
            else:
                self.place += 1
                yield words

    def of(self, *keywords: bytes) -> Iterator[list[bytes]]:
        """Yield the words of each line that begins with one of the keywords; count the rest.

        Raises
        ------
        CorruptLog
            At the end, if no line begins with the first keyword.
        """
        for words in self.words():
            if not KEYWORD.match(words[0]):
                raise self.error("does not begin with a keyword")
            wanted = words[0] in keywords
            (self.kept if wanted else self.others)[words[0].decode()] += 1
            if wanted:
                yield words
        self.need(keywords[0].decode())

    def need(self, what: str) -> None:
        """Raise if no line of a kind was kept."""
        if not self.kept[what]:
            seems = [KINDS[word] for word in self.others if word in KINDS]
            hint = "; it seems to be {}: use {}".format(*seems[0]) if seems else ""
            raise CorruptLog(f"{self.path}: no {what} line ({self.report()}){hint}")

    def report(self) -> ReadReport:
        """Close the account."""
        counts = (MappingProxyType(dict(+count)) for count in (self.kept, self.others))
        return ReadReport(self.path, *counts)

    def numbers(self, words: list[bytes]) -> Float[np.ndarray, " words"]:
        """Return words as finite numbers."""
        try:
            values = to_numbers(words)
        except ValueError:
            raise self.error("a value is not a number") from None
        if not np.isfinite(values).all():
            raise self.error(NOT_FINITE)
        return values

    def integer(self, words: list[bytes], place: int, *, least: int = 0) -> int:
        """Return one of the words as an integer that is not too small."""
        if len(words) <= place:
            raise self.error(SHORT)
        if not words[place].isdigit() or len(words[place]) > 18 or int(words[place]) < least:
            raise self.error(f"an id or a count is not an integer of at least {least}")
        return int(words[place])

    def readings(self, words: list[bytes]) -> Float[np.ndarray, " words"]:
        """Return words as distances."""
        values = self.numbers(words)
        if (values < 0).any():
            raise self.error("a reading is negative")
        return values

    def expect(self, words: list[bytes], length: int) -> None:
        """Raise if a line has too few or too many words."""
        if len(words) != length:
            raise self.error(SHORT if len(words) < length else "more values than announced")

    def _text(self) -> bytes:
        """Return the text without its last line end."""
        size = self.path.stat().st_size
        if not size:
            raise CorruptLog(f"{self.path}: the file is empty")
        limit = max(LARGEST_TEXT, LARGEST_RATIO * size)
        text = bytearray()
        with self.path.open("rb") as raw:
            packed = raw.read(2) == GZIP_MAGIC or self.path.suffix == ".gz"
            raw.seek(0)
            stream = gzip.GzipFile(fileobj=raw) if packed else raw
            try:
                while len(text) <= limit and (chunk := stream.read1(CHUNK)):
                    text += chunk
            except (EOFError, gzip.BadGzipFile, zlib.error) as error:
                line = text.count(b"\n") + 1
                raise self.error(f"the gzip file is damaged here ({error})", line) from error
        if len(text) > limit:
            raise CorruptLog(f"{self.path}: {size} bytes unpack to more than {limit}")
        return bytes(text.removesuffix(b"\n"))


def _is_utf8(line: bytes) -> bool:
    try:
        line.decode()
    except UnicodeDecodeError:
        return False
    return True


def to_numbers(words: list[bytes]) -> Float[np.ndarray, " words"]:
    """Return words as numbers, or raise ``ValueError``; NaN and infinity are numbers."""
    if b"_" in b"".join(words):  # Python reads 1_0 as ten
        raise ValueError
    return np.array(words, dtype=float)


def read_table(
    path: str | Path, what: str, columns: int, checks: Sequence[Check] = ()
) -> tuple[Float[np.ndarray, "rows columns"], ReadReport]:
    """Return the rows of a file of ``columns`` finite numbers a line that pass all checks.

    ``what`` is the keyword under which the report counts the lines.

    Raises
    ------
    CorruptLog
        If the file is damaged or holds no line, or a line is bad.
    """
    lines = Lines(path)
    places: list[int] = []
    table: list[bytes] = []
    for words in lines.words():
        if len(words) != columns:
            lines.expect(words, columns)
        places.append(lines.number)
        table += words
    lines.kept[what] = len(places)
    lines.need(what)
    try:
        rows = to_numbers(table).reshape(-1, columns)
    except ValueError:  # one word of all is no number: find it
        for lines.number, start in zip(places, range(0, len(table), columns), strict=True):
            lines.numbers(table[start : start + columns])
        raise
    for reason, is_bad in (FINITE, *checks):
        bad = is_bad(rows)
        if bad.any():
            raise lines.error(reason, places[int(np.argmax(bad))])
    return rows, lines.report()


def repeats(rows: Float[np.ndarray, "rows columns"]) -> Bool[np.ndarray, " rows"]:
    """Tell which rows repeat an earlier one."""
    bad = np.ones(len(rows), dtype=bool)
    bad[np.unique(rows, axis=0, return_index=True)[1]] = False
    return bad


def make_laser_log(
    lines: Lines,
    readings: list[Float[np.ndarray, " beams"]],
    angles: Float[np.ndarray, " beams"],
    tails: list[Float[np.ndarray, " tail"]],
    *,
    max_range: float | None,
    timed: bool,
) -> dict[str, Any]:
    """Return the fields of a `LaserLog` after its lines were read.

    A tail is what follows the readings: laser pose and robot pose (m and rad) first, time (s) last.

    Raises
    ------
    CorruptLog
        If the log should be ``timed`` and the times of its scans are all the same or span more than
        a week.
    """
    ranges, tail = np.array(readings), np.array(tails)
    times = tail[:, -1]
    if timed and len(times) > 1 and not 0 < np.ptp(times) <= LONGEST_LOG:
        raise CorruptLog(
            f"{lines.path}: the times of its {len(times)} scans span {np.ptp(times):g} s"
            " (timed=False reads the log all the same)"
        )
    limit = no_return_threshold(ranges) if max_range is None else float(max_range)
    return {
        "ranges": np.where(ranges >= limit, np.inf, ranges),
        "angles": angles,
        "poses": tail[:, :3],
        "odometry": tail[:, 3:6],
        "times": times,
        "max_range": limit,
        "report": lines.report(),
    }


def beam_angles(
    beams: int, field_of_view: tuple[float, float] | None
) -> Float[np.ndarray, " beams"] | None:
    """Return the beams' directions in rad, or nothing if no convention is known for their number.

    CARMEN logs do not say where their beams point: 180 beams run from -90 deg in steps of 1,
    181 from -90 to +90, 360 from -90 in steps of 0.5, and 361 from -90 to +90.
    """
    if field_of_view is not None:
        ends = reals("field_of_view", field_of_view)
        if ends.shape != (2,) or not np.isfinite(ends).all():
            raise ValueError(f"field_of_view must be two finite angles, got {field_of_view}")
        return np.linspace(*ends, beams)
    if beams not in FIELDS_OF_VIEW_DEG:
        return None
    return np.deg2rad(np.linspace(*FIELDS_OF_VIEW_DEG[beams], beams))


def no_return_threshold(ranges: Float[np.ndarray, "scans beams"]) -> float:
    """Return the reading from which a log means "no return", told from its largest reading.

    80, 50 or 32.759 m when the largest reading is one of the codes loggers write, else ``inf``
    (every reading is a distance).
    """
    largest = ranges.max()
    for lowest, highest, threshold in NO_RETURN_CODES:
        if lowest <= largest <= highest:
            return threshold
    return np.inf
