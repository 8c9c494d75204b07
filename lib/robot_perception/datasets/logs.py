"""Common parts of the readers of recordings: text lines that are read strictly, and laser logs."""

import codecs
import csv
import gzip
import os
import re
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from types import MappingProxyType
from typing import Any, final

import numpy as np
from jaxtyping import Bool, Float

from robot_perception.checks import flag, instance, number, reals
from robot_perception.datasets import limits
from robot_perception.datasets.limits import Check
from studies.files import DamagedFile

GZIP_MAGIC = b"\x1f\x8b"
CHUNK, LONGEST_LINE, LARGEST_TEXT = 2**16, 2**18, 2**20  # bytes
LARGEST_RATIO = 100  # of unpacked to packed bytes beyond LARGEST_TEXT; known logs have 11
KEYWORD = re.compile(rb"[A-Za-z][A-Za-z0-9_:]*\Z")
QUOTED = re.compile(rb'"[^"]*"|(?:^|(?<=[;,\t ]))"[^"]*$')  # may go on in the next line
ENCODINGS = {  # by byte order mark; UTF-32 first, because its mark begins with that of UTF-16
    codecs.BOM_UTF8: "utf-8",
    codecs.BOM_UTF32_LE: "utf-32-le",
    codecs.BOM_UTF32_BE: "utf-32-be",
    codecs.BOM_UTF16_LE: "utf-16-le",
    codecs.BOM_UTF16_BE: "utf-16-be",
}
CONTROL_BYTES = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f]")
FIELDS_OF_VIEW_DEG = {180: (-90, 89), 181: (-90, 90), 360: (-90, 89.5), 361: (-90, 90)}

KINDS = {  # by a keyword that occurs in it: what a file is, and the function that reads it
    "FLASER": ("a CARMEN log", "read_carmen_log"),
    "ROBOTLASER1": ("a CARMEN log", "read_carmen_log"),
    "VERTEX2": ("a pose graph", "read_graph_log"),
    "VERTEX_SE2": ("a pose graph", "read_graph_log"),
    "VERTEX_SE3:QUAT": ("a pose graph", "read_graph_log"),
    "ODOMETRY": ("a chain of motions", "read_landmark_graph"),
}

NOT_FINITE = "a value is NaN or infinite"
SHORT, LONG = "fewer values than announced", "more values than announced"
UNTIMED = "timed=False reads the log all the same"
OTHER_BEAMS = "its number of beams differs from the first scan's"

# Laser loggers write a code where nothing came back. If the largest reading of a log lies between
# the first two numbers, m, readings from the third on mean "no return". SICK scanners send error
# codes in place of readings: in centimetres 0x1FF7 ... 0x1FFF (81.83 ... 81.91 m), in millimetres
# 0x7FF7 ... 0x7FFF (32.759 ... 32.767 m). The logs ACES, FHW and Acapulco hold 50 to 51.25 m there.
NO_RETURN_CODES = ((80.0, np.inf, 80.0), (50.0, 52.0, 50.0), (32.759, 32.767, 32.759))


class CorruptLog(DamagedFile):
    """A recording that cannot be read; the message names the file and the line."""


class OtherUnit(CorruptLog):
    """A recording whose times are not in the unit that the caller gave.

    Parameters
    ----------
    message
        Text of the error.
    unit
        Unit that fits the numbers, such as ``"ms"``; empty if none does.
    """

    def __init__(self, message: str, unit: str) -> None:
        super().__init__(message)
        self.unit = unit


@final
@dataclass(frozen=True, slots=True)
class ReadReport:
    """Counts of all lines of a recording: those that became data, and those that are not read.

    Parameters
    ----------
    path
        File of the recording.
    kept
        Number of lines that became data, by keyword.
    others
        Number of lines that this reader does not read, by keyword. Comments are ``"#"``, empty
        lines ``"blank"``, and further lines of a quoted text ``"continued"``.
    unit
        Name of what is counted: lines, or messages of a ROS bag, by topic.
    remarks
        Sentences about faults of the recording.
    """

    path: Path
    kept: Mapping[str, int]
    others: Mapping[str, int]
    unit: str = "lines"
    remarks: tuple[str, ...] = ()

    @property
    def lines(self) -> int:
        """Number of all lines of the file, or of all messages."""
        return sum(self.kept.values()) + sum(self.others.values())

    def __str__(self) -> str:
        """Return the report as one sentence."""
        kept, others = (
            ", ".join(f"{count} {keyword}" for keyword, count in counts.items()) or "none"
            for counts in (self.kept, self.others)
        )
        told = f"{self.path.name}: {self.lines} {self.unit}; read {kept}; other kinds {others}"
        return "; ".join([told, *self.remarks])


@dataclass(frozen=True, eq=False, slots=True)
class LaserLog:
    """Planar laser scans with the poses from which they were taken.

    Parameters
    ----------
    ranges : (scans, beams)
        Distances in m; ``inf`` where the beam did not come back.
    angles : (beams,)
        Beam directions in rad, counter-clockwise, in the laser's frame (0 is straight ahead).
    poses : (scans, 3)
        Laser pose (x, y, theta) in the map, in m and rad: the best estimate the log holds.
    odometry : (scans, 3)
        Robot pose (x, y, theta) by wheel odometry, in m and rad. A log that was corrected
        afterwards may hold the corrected pose here, too.
    times : (scans,)
        Time stamps in s.
    max_range
        Readings from this one on were taken for "no return", m.
    report
        Counts of the lines of the file.
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


def check_reading(max_range: float | None, timed: bool, time_unit: str) -> None:
    """Raise unless the options of a reader of laser logs are valid."""
    flag("timed", timed)
    limits.per_second(time_unit)
    if max_range is not None and not number("max_range", max_range, finite=False) > 0:
        raise ValueError(f"max_range must be positive, got {max_range}")


@final
class Lines:
    """Lines of a text recording, plain or gzip, that are read once, checked and counted.

    Line ends are those of Linux, Windows or an old Macintosh. The text is UTF-8 with or without a
    byte order mark, or UTF-16 or UTF-32 with one.

    Parameters
    ----------
    path
        The file; its first bytes tell whether it is gzip. If there is none of that name, the same
        name with or without ``.gz`` is tried.

    Raises
    ------
    CorruptLog
        While reading: if the file is empty or damaged, a line is not text, or the file unpacks to
        more bytes than a recording could have.
    FileNotFoundError
        While reading: if there is no such file.
    """

    def __init__(self, path: str | Path) -> None:
        path = as_path(path)
        other = path.with_suffix("") if path.suffix == ".gz" else path.with_name(f"{path.name}.gz")
        self.path = other if other.is_file() and not path.exists() else path
        self.number = 0
        self.place = 0  # count of lines so far that are neither blank nor comment
        self.kept: Counter[str] = Counter()
        self.others: Counter[str] = Counter()
        self._comments: list[bytes] = []
        self._points_only = True
        self._marks: set[int] = set()

    def error(self, reason: str, line: int | None = None) -> CorruptLog:
        """Return an error that names a line, the present one if none is given."""
        return CorruptLog(f"{self.path}, line {line or self.number}: {reason}")

    def text(self) -> str:
        """Return the whole text of the recording."""
        return b"\n".join(self._lines()).decode()

    def words(self) -> Iterator[list[bytes]]:
        """Yield the words of each line that is neither blank nor comment."""
        for line in self._lines():
            if self._counts(line):
                yield line.split()

    def rows(self) -> Iterator[list[bytes]]:
        """Yield the cells of each row of a table.

        The first row tells the separator of cells: semicolon, tab, comma or blanks. A cell in
        quotes may hold separators, line breaks and doubled quotes.
        """
        lines, separator = self._lines(), None
        for line in lines:
            if self._counts(line):
                if self.place == 1:
                    separator = _separator(line)
                    self._points_only = separator != b";" and b"\t" not in line
                yield self._cells(line, separator, lines)

    def headings(self) -> list[list[bytes]]:
        """Return the cells of the comment lines before the first row, the last line first."""
        found = []
        for line in reversed(self._comments):
            line = line.lstrip(b"# \t")
            with suppress(CorruptLog):  # a comment may have quotes of any kind
                found.append(self._cells(line, _separator(line), iter(())))
        return found

    def check(
        self, rows: Float[np.ndarray, "rows columns"], numbers: Sequence[int], *checks: Check
    ) -> None:
        """Raise at the first row that fails a check; ``numbers`` are the lines of the rows."""
        for reason, is_bad in checks:
            bad = is_bad(rows)
            if bad.any():
                row, *column = np.argwhere(bad)[0].tolist()
                value = f" ({rows[row, column[0]]:g})" if column else ""
                raise self.error(f"{reason}{value}", numbers[row])

    def points(self, cells: list[bytes]) -> list[bytes]:
        """Return cells that hold numbers, with decimal points in place of decimal commas.

        Decimal commas occur only in tables with semicolons or tabs. A table with decimal commas and
        decimal points raises `CorruptLog`.
        """
        if self._points_only:
            return cells
        text = b"".join(cells)
        self._marks |= {mark for mark in b",." if mark in text}
        if len(self._marks) > 1:
            raise self.error("decimal commas and decimal points")
        return [cell.replace(b",", b".") for cell in cells]

    def of(self, *keywords: bytes, needed: int = 1) -> Iterator[list[bytes]]:
        """Yield the words of each line that begins with one of the keywords; count the rest.

        Parameters
        ----------
        keywords
            First words of the lines that are wanted.
        needed
            At least one line must begin with one of this many first keywords.

        Raises
        ------
        CorruptLog
            If a line does not begin with a keyword; at the end, if no line begins with one of those
            that are needed.
        """
        for words in self.words():
            if not KEYWORD.match(words[0]):
                raise self.error("does not begin with a keyword")
            wanted = words[0] in keywords
            (self.kept if wanted else self.others)[words[0].decode()] += 1
            if wanted:
                yield words
        if not any(self.kept[keyword.decode()] for keyword in keywords[:needed]):
            self.need(keywords[0].decode())

    def pass_over(self, keyword: bytes) -> None:
        """Count the lines of a keyword, so far kept, as lines that are not read."""
        self.others[keyword.decode()] += self.kept.pop(keyword.decode(), 0)

    def need(self, what: str) -> None:
        """Raise if no line of a keyword was kept; the message names the reader of such a file."""
        if not self.kept[what]:
            seems = [KINDS[word] for word in self.others if word in KINDS]
            hint = "; it seems to be {}: use {}".format(*seems[0]) if seems else ""
            raise CorruptLog(f"{self.path}: no {what} line ({self.report()}){hint}")

    def report(self) -> ReadReport:
        """Return the counts of the lines so far."""
        counts = (MappingProxyType(dict(+count)) for count in (self.kept, self.others))
        return ReadReport(self.path, *counts)

    def numbers(self, words: list[bytes]) -> Float[np.ndarray, " words"]:
        """Return words as finite numbers, or raise `CorruptLog`."""
        try:
            values = to_numbers(words)
        except ValueError:
            word = next(word for word in words if not are_numbers([word]))
            raise self.error(f"a value is not a number: {word.decode()!r}") from None
        if not np.isfinite(values).all():
            raise self.error(NOT_FINITE)
        return values

    def integer(self, words: list[bytes], place: int, *, least: int = 0) -> int:
        """Return the word at a place as an integer of at least ``least``, or raise `CorruptLog`."""
        if len(words) <= place:
            raise self.error(SHORT)
        word = words[place]
        if not word.isdigit() or len(word) > 19 or not least <= int(word) < 2**63:
            told = f"{word.decode()!r} stands in its place"
            raise self.error(f"an id or a count is not an integer of at least {least}: {told}")
        return int(word)

    def readings(self, words: list[bytes]) -> Float[np.ndarray, " words"]:
        """Return words as distances of at least 0, or raise `CorruptLog`."""
        values = self.numbers(words)
        if (values < 0).any():
            raise self.error(f"a reading is negative: {values.min():g}")
        return values

    def expect(self, words: list[bytes], length: int) -> None:
        """Raise if a line has too few or too many words; surplus empty ones at its end go."""
        while len(words) > length and not words[-1]:
            words.pop()
        if len(words) != length:
            raise self.error(SHORT if len(words) < length else LONG)

    def _lines(self) -> Iterator[bytes]:
        """Yield all lines, each checked to be text; ``number`` is that of the present one."""
        text = self._text()
        for self.number, line in enumerate(text.split(b"\n"), start=1):
            if len(line) > LONGEST_LINE:
                raise self.error(f"longer than {LONGEST_LINE} bytes")
            if CONTROL_BYTES.search(line) or not (line.isascii() or _is_utf8(line)):
                raise self.error("not text in UTF-8")
            yield line

    def _counts(self, line: bytes) -> bool:
        """Tell whether a line is neither blank nor comment, and count those that are."""
        start = line.lstrip()[:1]
        if start and start != b"#":
            self.place += 1
            return True
        self.others["#" if start else "blank"] += 1
        if start and not self.place:
            self._comments.append(line)
        return False

    def _cells(self, line: bytes, separator: bytes | None, more: Iterator[bytes]) -> list[bytes]:
        """Return the cells of a line; a cell in quotes may go on in the lines of ``more``."""
        if b'"' not in line:
            return [cell.strip() for cell in line.split(separator)]
        first, mark = self.number, (separator or b" ").decode()
        texts = (f"{text.decode()}\n" for text in chain([line.strip(b" ")], more))
        rows = csv.reader(texts, delimiter=mark, skipinitialspace=mark != " ", strict=True)
        try:
            cells = next(rows)
        except csv.Error as error:
            raise self.error(f"its quotes are wrong ({error})", first) from error
        self.others["continued"] += self.number - first
        self.number = first
        return [cell.encode().strip() for cell in cells]

    def _text(self) -> bytes:
        """Return the text in UTF-8 with line feeds between lines, without the last line end."""
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
        text = self._as_utf8(bytes(text))
        if b"\r" in text:
            text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        return text.removesuffix(b"\n")

    def _as_utf8(self, text: bytes) -> bytes:
        """Return a text in UTF-8 without its byte order mark."""
        for mark, encoding in ENCODINGS.items():
            if text.startswith(mark):
                try:
                    return text[len(mark) :].decode(encoding).encode()
                except UnicodeError as error:
                    raise self.error(f"not text in {encoding.upper()} ({error})", 1) from error
        return text


def _separator(line: bytes) -> bytes | None:
    """Return the separator of a table with this first line; ``None`` stands for blanks and tabs.

    Columns of numbers may be aligned by several tabs or blanks, which then are one separator. In
    other tables each tab is one.
    """
    outside = QUOTED.sub(b"x", line).strip()
    if b";" in outside:
        return b";"
    if b"\t" in outside and b",\t" not in outside:
        return None if are_numbers(outside.replace(b",", b".").split()) else b"\t"
    return b"," if b"," in outside or len(outside.split()) < 2 else None


def _is_utf8(line: bytes) -> bool:
    """Tell whether a line is valid UTF-8."""
    try:
        line.decode()
    except UnicodeDecodeError:
        return False
    return True


def to_numbers(words: list[bytes]) -> Float[np.ndarray, " words"]:
    """Return words as numbers, or raise ``ValueError``; NaN and infinity are allowed."""
    if b"_" in b"".join(words):  # Python reads 1_0 as ten
        raise ValueError
    return np.array(words, dtype=float)


def are_numbers(words: list[bytes]) -> bool:
    """Tell whether all words are numbers, as in `to_numbers`."""
    try:
        to_numbers(words)
    except ValueError:
        return False
    return True


def in_seconds(
    path: Path, times: Float[np.ndarray, "*k"], time_unit: str
) -> Float[np.ndarray, "*k"]:
    """Return times in s, or raise `OtherUnit` if no recording has such times in this unit."""
    if fault := limits.time_fault(times, time_unit):
        raise OtherUnit(f"{path}: {fault}", limits.likely_unit(times))
    return times / limits.UNITS[time_unit]


def read_table(
    path: str | Path, what: str, columns: int, checks: Sequence[Check] = ()
) -> tuple[Float[np.ndarray, "rows columns"], ReadReport]:
    """Return the rows of a table of finite numbers, and the report.

    Parameters
    ----------
    path
        File of the table.
    what
        Keyword under which the report counts the lines.
    columns
        Number of columns.
    checks
        Checks that all rows must pass.

    Raises
    ------
    CorruptLog
        If the file is damaged or has no row, a row has another number of columns, a value is not a
        finite number, or a row fails a check.
    """
    lines = Lines(path)
    numbers: list[int] = []
    table: list[bytes] = []
    for words in lines.rows():
        if len(words) != columns:
            lines.expect(words, columns)
        numbers.append(lines.number)
        table += lines.points(words)
    lines.kept[what] = len(numbers)
    lines.need(what)
    try:
        rows = to_numbers(table).reshape(-1, columns)
    except ValueError:  # some word is not a number: find its line for the message
        for lines.number, start in zip(numbers, range(0, len(table), columns), strict=True):
            lines.numbers(table[start : start + columns])
        raise
    bad = np.argwhere(~np.isfinite(rows))
    if bad.size:
        raise lines.error(f"{NOT_FINITE}, in column {bad[0, 1] + 1}", numbers[bad[0, 0]])
    lines.check(rows, numbers, *checks)
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
    tails: list[tuple[int, Float[np.ndarray, " tail"]]],
    *,
    max_range: float | None,
    timed: bool,
    time_unit: str,
) -> dict[str, Any]:
    """Return the fields of a `LaserLog` from what its lines hold.

    Parameters
    ----------
    lines
        Lines of the log, all read.
    readings
        Readings of each scan, m.
    angles
        Directions of the beams, rad.
    tails
        For each scan the number of its line, and the numbers after its readings: laser pose and
        robot pose (m and rad) first, time last.
    max_range
        Readings from this one on mean "no return", m; by `no_return_threshold` if not given.
    timed
        Whether times are checked.
    time_unit
        Unit of the times.

    Raises
    ------
    CorruptLog
        If a pose is too far away or its heading cannot be in rad; with ``timed``, if all times are
        the same, or no recording has such times in this unit.
    """
    numbers, tail = [number for number, _ in tails], np.array([values for _, values in tails])
    checks = limits.far_places(0, 1, 3, 4), *limits.no_headings(2), *limits.no_headings(5)
    lines.check(tail, numbers, *checks)
    ranges, times = np.array(readings), tail[:, -1]
    if timed:
        try:
            in_seconds(lines.path, times, time_unit)
        except OtherUnit as error:
            raise OtherUnit(f"{error} ({UNTIMED})", error.unit) from None
        if len(times) > 1 and not np.ptp(times):
            raise CorruptLog(f"{lines.path}: its {len(times)} times are all the same ({UNTIMED})")
    limit = no_return_threshold(ranges) if max_range is None else float(max_range)
    return {
        "ranges": np.where(ranges >= limit, np.inf, ranges),
        "angles": angles,
        "poses": tail[:, :3],
        "odometry": tail[:, 3:6],
        "times": times / limits.UNITS[time_unit],
        "max_range": limit,
        "report": lines.report(),
    }


def beam_angles(
    beams: int, field_of_view: tuple[float, float] | None
) -> Float[np.ndarray, " beams"] | None:
    """Return the directions of beams, rad, or ``None`` if no convention for their number is known.

    ``FLASER`` lines do not hold these directions. By convention 180 beams run from -90° by 1°,
    181 from -90° to 90°, 360 from -90° in steps of 0.5°, and 361 from -90° to 90°.

    Parameters
    ----------
    beams
        Number of beams.
    field_of_view
        Directions of the first and the last beam, rad, which replace the convention.
    """
    if field_of_view is not None:
        ends = reals("field_of_view", field_of_view)
        if ends.shape != (2,) or not (np.abs(ends) <= limits.TURN).all():
            raise ValueError(f"field_of_view must be two angles within a turn, got {field_of_view}")
        return np.linspace(*ends, beams)
    if beams not in FIELDS_OF_VIEW_DEG:
        return None
    return np.deg2rad(np.linspace(*FIELDS_OF_VIEW_DEG[beams], beams))


def no_return_threshold(ranges: Float[np.ndarray, "scans beams"]) -> float:
    """Return the reading from which on readings of a log mean "no return", m.

    It is 80, 50 or 32.759 m if the largest reading is one of the codes that loggers write. Else it
    is ``inf``: all readings are distances.
    """
    largest = ranges.max()
    for lowest, highest, threshold in NO_RETURN_CODES:
        if lowest <= largest <= highest:
            return threshold
    return np.inf
