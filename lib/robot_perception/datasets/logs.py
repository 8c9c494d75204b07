"""What every reader of recordings shares: scans, reading reports, and files that may be damaged."""

import re
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

import numpy as np
from jaxtyping import Float

GZIP_MAGIC = b"\x1f\x8b"
COMPRESSED_CHUNK = 4096
LINE_NUMBERS_KEPT = 5
KEYWORD = re.compile(rb"[A-Za-z][A-Za-z0-9_]*\Z")
CONTROL_BYTES = re.compile(rb"[\x00-\x08\x0e-\x1f\x7f]")
FIELDS_OF_VIEW_DEG = {
    180: (-90.0, 89.0),
    181: (-90.0, 90.0),
    360: (-90.0, 89.5),
    361: (-90.0, 90.0),
}

NOT_TEXT = "not text: bytes outside UTF-8"
CONTROL = "not text: control characters"
NO_KEYWORD = "does not begin with a keyword"
NOT_NUMBERS = "a value is not a number"
NOT_FINITE = "a value is NaN or infinite"
BAD_READING = "a reading is NaN, infinite or negative"
BAD_COUNT = "the number of readings is not a positive integer"
SHORT = "fewer values than announced"
LONG = "more values than announced"
UNKNOWN_FIELD = "no field of view is known for its number of beams (give field_of_view)"
OTHER_BEAMS = "its number of beams differs from the first scan's"
CUT = "cut short by the end of the damaged file"

# What laser loggers write where nothing came back: (lowest, highest) largest reading of such a log,
# and the threshold. SICK scanners send error codes for readings: in centimetres 0x1FF7 ... 0x1FFF
# (81.83 ... 81.91 m), in millimetres 0x7FF7 ... 0x7FFF (32.759 ... 32.767 m). ACES, FHW and
# Acapulco hold 50 to 51.25 m there.
NO_RETURN_CODES = ((80.0, np.inf, 80.0), (50.0, 52.0, 50.0), (32.759, 32.767, 32.759))


class CorruptLog(ValueError):  # noqa: N818 - it names the thing, not the failure
    """A recording that cannot be read, or (with ``strict=True``) a line of it that cannot."""


@dataclass(frozen=True, slots=True)
class SkippedLines:
    """Lines left out for one reason.

    Parameters
    ----------
    reason
        Why they were left out.
    count
        How many they are.
    first
        Line numbers (from 1) of the first few.
    """

    reason: str
    count: int
    first: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class ReadReport:
    """Account of every line of a recording: read, of another kind, or skipped.

    ``lines`` is the sum of the counts in ``kept``, ``others`` and ``skipped``.

    Parameters
    ----------
    path
        The file.
    lines
        How many lines it has (in a file cut short: had, up to the cut).
    kept
        Lines that became data, by keyword.
    others
        Lines of kinds this reader does not read, by keyword; comments are ``"#"``, empty lines
        ``"blank"``.
    skipped
        Lines that should have become data and could not, by reason.
    truncated
        Whether the file was cut short or damaged and only what came before was read.
    """

    path: Path
    lines: int
    kept: Mapping[str, int]
    others: Mapping[str, int]
    skipped: tuple[SkippedLines, ...]
    truncated: bool

    @property
    def scans(self) -> int:
        """Number of laser scans kept."""
        return self.kept.get("FLASER", 0) + self.kept.get("ROBOTLASER1", 0)

    @property
    def skipped_lines(self) -> int:
        """Number of lines skipped, for all reasons together."""
        return sum(item.count for item in self.skipped)

    def __str__(self) -> str:
        """Return the report as a sentence for people."""
        text = f"{self.path.name}: {self.lines} lines; read {_counts(self.kept)}"
        if self.others:
            text += f"; other kinds {_counts(self.others)}"
        if self.skipped:
            text += f"; skipped {_skips(self.skipped)}"
        return text + ("; the file is cut short" if self.truncated else "")


def _counts(counts: Mapping[str, int]) -> str:
    return ", ".join(f"{count} {keyword}" for keyword, count in counts.items()) or "nothing"


def _skips(skipped: tuple[SkippedLines, ...]) -> str:
    return ", ".join(
        f"{item.count} ({item.reason}; line {', '.join(map(str, item.first))}"
        f"{', …' if item.count > len(item.first) else ''})"
        for item in skipped
    )


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


@dataclass(slots=True)
class Tally:
    """Running account of the lines of one file; raises at the first bad line when strict."""

    path: Path
    strict: bool
    lines: int = 0
    kept: Counter[str] = field(default_factory=Counter)
    others: Counter[str] = field(default_factory=Counter)
    skipped: dict[str, list[int]] = field(default_factory=dict)

    def skip(self, line: int, reason: str) -> None:
        """Count line number ``line`` as skipped, or raise."""
        if self.strict:
            raise CorruptLog(f"{self.path}, line {line}: {reason}")
        self.skipped.setdefault(reason, []).append(line)

    def report(self, *, truncated: bool) -> ReadReport:
        """Close the account."""
        skipped = tuple(
            SkippedLines(reason, len(lines), tuple(sorted(lines)[:LINE_NUMBERS_KEPT]))
            for reason, lines in self.skipped.items()
        )
        return ReadReport(
            self.path,
            self.lines,
            MappingProxyType(dict(self.kept)),
            MappingProxyType(dict(self.others)),
            skipped,
            truncated,
        )


@dataclass(frozen=True, slots=True)
class Recording:
    """The text of a recording, and what was wrong with the file that held it.

    Parameters
    ----------
    path
        The file.
    lines
        Its lines, without line ends.
    damage
        How the file is cut short or damaged; ``None`` when it is whole.
    ends_in_fragment
        Whether the last line is only what the damage left of it.
    """

    path: Path
    lines: tuple[bytes, ...]
    damage: str | None
    ends_in_fragment: bool


def read_recording(path: str | Path) -> Recording:
    """Read a text recording, plain or gzip, up to its end or to the place where it is damaged.

    Parameters
    ----------
    path
        The file; whether it is gzip is told from its first bytes. If there is none of that name,
        the same name with or without ``.gz`` will do.

    Returns
    -------
    Recording
        The lines. Of a damaged file the last line is what was left of it.

    Raises
    ------
    CorruptLog
        If the file is empty, or is called ``.gz`` and is not gzip.
    """
    path = _existing(Path(path))
    content = path.read_bytes()
    if not content:
        raise CorruptLog(f"{path}: the file is empty")
    damage = None
    if content.startswith(GZIP_MAGIC):
        content, damage = _gunzip(content)
    elif path.suffix == ".gz":
        raise CorruptLog(f"{path}: not a gzip file (it starts with {content[:4]!r})")
    lines = content.split(b"\n")
    if not lines[-1]:
        lines.pop()
    fragment = damage is not None and not content.endswith(b"\n")
    return Recording(path, tuple(lines), damage, fragment and bool(lines))


def _existing(path: Path) -> Path:
    """Return the path, or its plain or compressed form if only that exists."""
    other = path.with_suffix("") if path.suffix == ".gz" else path.with_name(f"{path.name}.gz")
    return other if other.is_file() and not path.exists() else path


def _gunzip(content: bytes) -> tuple[bytes, str | None]:
    """Decompress as far as possible; also say how the file is damaged, if it is."""
    text = []
    while content:
        stream = zlib.decompressobj(wbits=zlib.MAX_WBITS | 16)
        for start in range(0, len(content), COMPRESSED_CHUNK):  # small: an error loses its chunk
            try:
                text.append(stream.decompress(content[start : start + COMPRESSED_CHUNK]))
            except zlib.error as error:
                return b"".join(text), f"damaged gzip file ({error})"
            if stream.eof:
                break
        if not stream.eof:
            return b"".join(text), "gzip file cut short"
        content = (stream.unused_data + content[start + COMPRESSED_CHUNK :]).lstrip(b"\0")
        if content and not content.startswith(GZIP_MAGIC):
            return b"".join(text), "something that is not gzip follows the gzip stream"
    return b"".join(text), None


def text_lines(recording: Recording, tally: Tally) -> Iterator[tuple[int, list[bytes]]]:
    """Yield line number and tokens of the lines that hold text; count the others.

    Parameters
    ----------
    recording
        The text.
    tally
        Account in which blank lines, comments (``#``) and lines that are not text are counted.
    """
    for number, line in enumerate(recording.lines, start=1):
        tally.lines = number
        if number == len(recording.lines) and recording.ends_in_fragment:
            tally.skipped.setdefault(CUT, []).append(number)  # strict or not: `close` decides
            continue
        problem = _not_text(line)
        tokens = line.split()
        if problem:
            tally.skip(number, problem)
        elif not tokens:
            tally.others["blank"] += 1
        elif tokens[0].startswith(b"#"):
            tally.others["#"] += 1
        else:
            yield number, tokens


def keyword_lines(
    recording: Recording, tally: Tally, wanted: frozenset[bytes]
) -> Iterator[tuple[int, list[bytes]]]:
    """Yield line number and tokens of the lines that begin with a wanted keyword; count the rest.

    Parameters
    ----------
    recording
        The text.
    tally
        Account in which every line that is not yielded is counted.
    wanted
        The keywords.
    """
    for number, tokens in text_lines(recording, tally):
        if tokens[0] in wanted:
            yield number, tokens
        elif KEYWORD.match(tokens[0]):
            tally.others[tokens[0].decode("ascii")] += 1
        else:
            tally.skip(number, NO_KEYWORD)


def _not_text(line: bytes) -> str | None:
    """Say why a line is not text, or nothing."""
    if CONTROL_BYTES.search(line):
        return CONTROL
    if not line.isascii():
        try:
            line.decode("utf-8")
        except UnicodeDecodeError:
            return NOT_TEXT
    return None


def numbers(tokens: list[bytes]) -> Float[np.ndarray, " tokens"] | None:
    """Return words as numbers (NaN and infinity included), or nothing if one of them is none."""
    if b"_" in b"".join(tokens):  # Python reads 1_0 as ten
        return None
    try:
        return np.array(tokens, dtype=float) if tokens else np.empty(0)
    except ValueError:
        return None


def beam_angles(
    beams: int, field_of_view: tuple[float, float] | None
) -> Float[np.ndarray, " beams"] | None:
    """Return the beams' directions, or nothing if no convention is known for their number.

    CARMEN logs do not say where their beams point: 180 beams run from -90 deg in steps of 1,
    181 from -90 to +90, 360 from -90 in steps of 0.5, and 361 from -90 to +90.

    Parameters
    ----------
    beams
        How many.
    field_of_view
        Directions of the first and the last beam in rad, if the convention is not meant.

    Returns
    -------
    (beams,) or None
        Angles in rad, counter-clockwise.

    Raises
    ------
    ValueError
        If ``field_of_view`` is not finite.
    """
    if field_of_view is not None:
        if not np.isfinite(field_of_view).all():
            raise ValueError(f"field_of_view must be two finite angles, got {field_of_view}")
        return np.linspace(*field_of_view, beams)
    if beams not in FIELDS_OF_VIEW_DEG:
        return None
    return np.deg2rad(np.linspace(*FIELDS_OF_VIEW_DEG[beams], beams))


def no_return_threshold(ranges: Float[np.ndarray, "scans beams"]) -> float:
    """Return the reading from which a log means "no return", told from its largest reading.

    Parameters
    ----------
    ranges : (scans, beams)
        Readings in m.

    Returns
    -------
    float
        80, 50 or 32.759 m when the largest reading is one of the codes loggers write, else ``inf``
        (every reading is a distance).
    """
    largest = ranges.max()
    for lowest, highest, threshold in NO_RETURN_CODES:
        if lowest <= largest <= highest:
            return threshold
    return np.inf


def close(recording: Recording, tally: Tally, *, allow_truncated: bool, what: str) -> ReadReport:
    """Close the account of a file, or raise because it is damaged or holds nothing of use.

    Parameters
    ----------
    recording
        The text.
    tally
        Its account.
    allow_truncated
        Whether a damaged file is accepted.
    what
        Keyword of the lines without which the recording is of no use.

    Raises
    ------
    CorruptLog
        If the file is damaged and that is not accepted, or no such line was read.
    """
    report = tally.report(truncated=recording.damage is not None)
    count = report.kept.get(what, 0)
    if recording.damage is not None and not allow_truncated:
        raise CorruptLog(
            f"{recording.path}: {recording.damage}; {count} complete {what} lines stand before"
            " that place (allow_truncated=True reads those)"
        )
    if not count:
        damage = f"{recording.damage}; " if recording.damage else ""
        raise CorruptLog(f"{recording.path}: {damage}no {what} line could be read ({report})")
    return report


def mark_no_returns(
    readings: Float[np.ndarray, "scans beams"], max_range: float | None
) -> tuple[Float[np.ndarray, "scans beams"], float]:
    """Return the readings with ``inf`` for "no return", and the threshold that was applied.

    Parameters
    ----------
    readings : (scans, beams)
        Distances in m as logged.
    max_range
        The threshold in m; without it `no_return_threshold` tells it.

    Raises
    ------
    ValueError
        If ``max_range`` is not positive.
    """
    if max_range is None:
        max_range = no_return_threshold(readings)
    elif not max_range > 0:
        raise ValueError(f"max_range must be positive, got {max_range}")
    return np.where(readings >= max_range, np.inf, readings), float(max_range)


def positive_integer(tokens: list[bytes]) -> int | None:
    """Return the single token as a positive integer, or nothing."""
    if len(tokens) == 1 and len(tokens[0]) <= 9 and tokens[0].isdigit():
        return int(tokens[0]) or None
    return None


def wrong_length(tokens: list[bytes], expected: int) -> str | None:
    """Say whether a line has too few or too many words, or nothing."""
    if len(tokens) == expected:
        return None
    return SHORT if len(tokens) < expected else LONG


def bad_readings(readings: Float[np.ndarray, " beams"]) -> bool:
    """Tell whether a reading is NaN, infinite or negative."""
    return not bool(np.all(np.isfinite(readings) & (readings >= 0)))
