"""Parts that all readers of recordings share: lines, read strictly, and laser scans."""

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
LARGEST_RATIO = 100  # of text to file beyond LARGEST_TEXT; known logs have 11
KEYWORD = re.compile(rb"[A-Za-z][A-Za-z0-9_:]*\Z")
QUOTED = re.compile(rb'"[^"]*"|(?:^|(?<=[;,\t ]))"[^"]*$')  # some go on in the next line
ENCODINGS = {  # by the byte order mark; that of UTF-32 begins as that of UTF-16
    codecs.BOM_UTF8: "utf-8",
    codecs.BOM_UTF32_LE: "utf-32-le",
    codecs.BOM_UTF32_BE: "utf-32-be",
    codecs.BOM_UTF16_LE: "utf-16-le",
    codecs.BOM_UTF16_BE: "utf-16-be",
}
CONTROL_BYTES = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f]")
FIELDS_OF_VIEW_DEG = {180: (-90, 89), 181: (-90, 90), 360: (-90, 89.5), 361: (-90, 90)}

KINDS = {  # by the keyword that tells them: what a file is, and what reads it
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

# What laser loggers write where nothing came back: (lowest, highest) largest reading of such a log,
# and the threshold. SICK scanners send error codes for readings: in centimetres 0x1FF7 ... 0x1FFF
# (81.83 ... 81.91 m), in millimetres 0x7FF7 ... 0x7FFF (32.759 ... 32.767 m). ACES, FHW and
# Acapulco hold 50 to 51.25 m there.
NO_RETURN_CODES = ((80.0, np.inf, 80.0), (50.0, 52.0, 50.0), (32.759, 32.767, 32.759))


class CorruptLog(DamagedFile):
    """A recording that cannot be read; the message names the file and the line."""


class OtherUnit(CorruptLog):
    """A recording whose times are in another unit than was said.

    Parameters
    ----------
    message
        What is wrong.
    unit
        The one that its numbers tell, such as ``"ms"``; empty if they tell none.
    """

    def __init__(self, message: str, unit: str) -> None:
        super().__init__(message)
        self.unit = unit


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
        ``"blank"``, and lines that go on in a quoted text ``"continued"``.
    unit
        What was counted, if not lines: messages of a ROS bag, by their topic.
    remarks
        Sentences on what is not as it should be.
    """

    path: Path
    kept: Mapping[str, int]
    others: Mapping[str, int]
    unit: str = "lines"
    remarks: tuple[str, ...] = ()

    @property
    def lines(self) -> int:
        """Number of lines of the file, or of messages."""
        return sum(self.kept.values()) + sum(self.others.values())

    def __str__(self) -> str:
        """Return the report as a sentence for people."""
        kept, others = (
            ", ".join(f"{count} {keyword}" for keyword, count in counts.items()) or "none"
            for counts in (self.kept, self.others)
        )
        told = f"{self.path.name}: {self.lines} {self.unit}; read {kept}; other kinds {others}"
        return "; ".join([told, *self.remarks])


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


def check_reading(max_range: float | None, timed: bool, time_unit: str) -> None:
    """Raise unless the options of a laser log's reader are as they should be."""
    flag("timed", timed)
    limits.per_second(time_unit)
    if max_range is not None and not number("max_range", max_range, finite=False) > 0:
        raise ValueError(f"max_range must be positive, got {max_range}")


@final
class Lines:
    """The lines of a text recording, plain or gzip, read once and strictly, and counted.

    They end as on Linux, Windows or an old Macintosh. The text is UTF-8, with a byte order mark or
    without, or UTF-16 or UTF-32 with one.

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
        self._comments: list[bytes] = []
        self._points_only = True
        self._marks: set[int] = set()

    def error(self, reason: str, line: int | None = None) -> CorruptLog:
        """Return the error that names a line, the present one if none is given."""
        return CorruptLog(f"{self.path}, line {line or self.number}: {reason}")

    def text(self) -> str:
        """Return the whole text."""
        return b"\n".join(self._lines()).decode()

    def words(self) -> Iterator[list[bytes]]:
        """Yield the words of each line that is neither blank nor comment."""
        for line in self._lines():
            if self._counts(line):
                yield line.split()

    def rows(self) -> Iterator[list[bytes]]:
        """Yield the cells of each row of a table.

        The first row tells what stands between them: semicolons, tabs, commas or blanks. A cell in
        quotes may hold all of these, line breaks and, twice, quotes.
        """
        lines, separator = self._lines(), None
        for line in lines:
            if self._counts(line):
                if self.place == 1:
                    separator = _separator(line)
                    self._points_only = separator != b";" and b"\t" not in line
                yield self._cells(line, separator, lines)

    def headings(self) -> list[list[bytes]]:
        """Return the cells of the comments that stood before the first row, the last one first."""
        found = []
        for line in reversed(self._comments):
            line = line.lstrip(b"# \t")
            with suppress(CorruptLog):  # a comment may have quotes of any kind
                found.append(self._cells(line, _separator(line), iter(())))
        return found

    def check(
        self, rows: Float[np.ndarray, "rows columns"], numbers: Sequence[int], *checks: Check
    ) -> None:
        """Raise at the first of rows that fails a check; numbers are those of their lines."""
        for reason, is_bad in checks:
            bad = is_bad(rows)
            if bad.any():
                row, *column = np.argwhere(bad)[0].tolist()
                value = f" ({rows[row, column[0]]:g})" if column else ""
                raise self.error(f"{reason}{value}", numbers[row])

    def points(self, cells: list[bytes]) -> list[bytes]:
        """Return cells that hold numbers, with decimal points where the table has commas.

        Only between semicolons or tabs are there decimal commas, and no table has both marks.
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
            First words of lines.
        needed
            How many of them are such that one must be there.

        Raises
        ------
        CorruptLog
            At the end, if no line begins with one that is needed.
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
        """Count the lines of a keyword among those that the reader has no use for."""
        self.others[keyword.decode()] += self.kept.pop(keyword.decode(), 0)

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
            word = next(word for word in words if not are_numbers([word]))
            raise self.error(f"a value is not a number: {word.decode()!r}") from None
        if not np.isfinite(values).all():
            raise self.error(NOT_FINITE)
        return values

    def integer(self, words: list[bytes], place: int, *, least: int = 0) -> int:
        """Return one of the words as an integer that is not too small."""
        if len(words) <= place:
            raise self.error(SHORT)
        word = words[place]
        if not word.isdigit() or len(word) > 19 or not least <= int(word) < 2**63:
            told = f"{word.decode()!r} stands in its place"
            raise self.error(f"an id or a count is not an integer of at least {least}: {told}")
        return int(word)

    def readings(self, words: list[bytes]) -> Float[np.ndarray, " words"]:
        """Return words as distances."""
        values = self.numbers(words)
        if (values < 0).any():
            raise self.error(f"a reading is negative: {values.min():g}")
        return values

    def expect(self, words: list[bytes], length: int) -> None:
        """Raise if a line has too few or too many words; empty ones at its end are taken off."""
        while len(words) > length and not words[-1]:
            words.pop()
        if len(words) != length:
            raise self.error(SHORT if len(words) < length else LONG)

    def _lines(self) -> Iterator[bytes]:
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
        """Return the cells of a line, and of those after it if they go on in its quotes."""
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
        """Return the text in UTF-8, lines parted by line feeds, without its last line end."""
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
        for mark, encoding in ENCODINGS.items():
            if text.startswith(mark):
                try:
                    return text[len(mark) :].decode(encoding).encode()
                except UnicodeError as error:
                    raise self.error(f"not text in {encoding.upper()} ({error})", 1) from error
        return text


def _separator(line: bytes) -> bytes | None:
    """Return what stands between the cells of a table with such a first line; blanks are none.

    Numbers between tabs may be aligned by several, or by blanks; names and texts are not.
    """
    outside = QUOTED.sub(b"x", line).strip()
    if b";" in outside:
        return b";"
    if b"\t" in outside and b",\t" not in outside:
        return None if are_numbers(outside.replace(b",", b".").split()) else b"\t"
    return b"," if b"," in outside or len(outside.split()) < 2 else None


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


def are_numbers(words: list[bytes]) -> bool:
    """Tell whether all words are numbers."""
    try:
        to_numbers(words)
    except ValueError:
        return False
    return True


def in_seconds(
    path: Path, times: Float[np.ndarray, "*k"], time_unit: str
) -> Float[np.ndarray, "*k"]:
    """Return times in s, or raise `CorruptLog` if they cannot be those of a recording."""
    if fault := limits.time_fault(times, time_unit):
        raise OtherUnit(f"{path}: {fault}", limits.likely_unit(times))
    return times / limits.UNITS[time_unit]


def read_table(
    path: str | Path, what: str, columns: int, checks: Sequence[Check] = ()
) -> tuple[Float[np.ndarray, "rows columns"], ReadReport]:
    """Return the rows of a table of ``columns`` finite numbers a line that pass all checks.

    ``what`` is the keyword under which the report counts the lines.

    Raises
    ------
    CorruptLog
        If the file is damaged or holds no line, or a line is bad.
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
    except ValueError:  # one word of all is no number: find it
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
    """Return the fields of a `LaserLog` after its lines were read.

    A tail is the number of a scan's line and what follows its readings: laser pose and robot pose
    (m and rad) first, time last.

    Raises
    ------
    CorruptLog
        If a pose is too far away or its heading none, or the log should be ``timed`` and the times
        of its scans are all the same or those of no recording.
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
    """Return the beams' directions in rad, or nothing if no convention is known for their number.

    CARMEN logs do not say where their beams point: 180 beams run from -90 deg in steps of 1,
    181 from -90 to +90, 360 from -90 in steps of 0.5, and 361 from -90 to +90.
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
    """Return the reading from which a log means "no return", told from its largest reading.

    80, 50 or 32.759 m when the largest reading is one of the codes loggers write, else ``inf``
    (every reading is a distance).
    """
    largest = ranges.max()
    for lowest, highest, threshold in NO_RETURN_CODES:
        if lowest <= largest <= highest:
            return threshold
    return np.inf
