"""Numbers in the names of pictures: their order, and when they were taken."""

import re
from collections.abc import Sequence
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

from robot_perception.datasets.pictures import CorruptImage

DIGITS = re.compile(r"(?<!\d)\d{1,19}(?!\d)")  # nanoseconds since 1970 have 19 digits
CLOCK = 946_684_800, 4_102_444_800  # s since 1970: the years from 2000 to 2099
LEAST = 3  # decimals of a time of a film; one or two may be anything, such as a month and a day
UNITS = 1, 10**3, 10**6, 10**9  # of a second, in which clocks count
DAY = r"(?<!\d)(20\d\d)([-_.]?)(0[1-9]|1[0-2])\2(0[1-9]|[12]\d|3[01])"
TIME = r"([01]\d|2[0-3])([-_.:]?)([0-5]\d)\6([0-5]\d)"
PARTS = r"(?:[.,]?(?P<decimals>\d{3,9})|[-_](?P<parts>\d{1,9}))?(?!\d)"
DATED = re.compile(DAY + r"\D{0,4}" + TIME + PARTS)
IN_FOLDER = re.compile(DAY + r"/(?:.*\D)?" + TIME.replace("?)(", ")(") + PARTS)
JOINED = re.compile(r"(?<!\d)(\d{9,10})[-_](?P<parts>\d{1,9})(?!\d)")


class Numbering(NamedTuple):
    """Files in the order of the numbers in their names.

    Parameters
    ----------
    paths
        The files in order.
    numbers
        A number for each, rising: the one that changes from name to name. A decimal number is
        counted in units of its last decimal. Of several that change, as many as tell the files
        apart are put together, each as wide as the widest.
    times
        Seconds, where a number that changes is a time stamp: one of seconds, milliseconds,
        microseconds or nanoseconds since 1970 in the years 2000 to 2099, or a decimal number with
        three decimals at least. Seconds and parts of them may be two numbers. Of dates with a time
        of day, whose zone nobody knows, they count from the first picture.
    composed
        Whether a number is put together from several, or is a date, so that it counts nothing.
    dated
        Whether the times are those of dates.
    """

    paths: tuple[Path, ...]
    numbers: tuple[int, ...]
    times: tuple[float, ...] | None
    composed: bool
    dated: bool = False


class _Column(NamedTuple):
    """The same number of all names, how many digits the longest has, and its unit in a second."""

    keys: list[int]
    width: int
    unit: int | None  # none where it is no time

    def padded(self) -> list[str]:
        """Return the digits of the numbers, all as many."""
        return [f"{key:0{self.width}}" for key in self.keys]


def numbering(paths: Sequence[Path]) -> Numbering:
    """Bring files into the order of the numbers in their names.

    Raises
    ------
    CorruptImage
        If a name has no number of 19 digits at most, more of them or fewer than the others, or the
        same as another, or if decimal numbers cannot be told from two counters.
    """
    columns = _columns(paths)
    changing = [column for column in columns if len(set(column.keys)) > 1] or columns[-1:]
    keys = list(zip(*(column.keys for column in changing), strict=True))
    order = sorted(range(len(paths)), key=keys.__getitem__)
    for one, other in pairwise(order):
        if keys[one] == keys[other]:
            raise CorruptImage(f"{paths[other]}: has the number of {paths[one].name}")
    used = next(
        k for k in range(1, len(keys[0]) + 1) if len({key[:k] for key in keys}) == len(keys)
    )
    words = list(zip(*(column.padded() for column in changing[:used]), strict=True))
    ordered = tuple(paths[k] for k in order)
    clocks = [column for column in changing if column.unit and _is_clock(column.keys, column.unit)]
    stamps = _times(clocks, order)
    moments, dated = (None, False) if stamps else _moments(ordered)
    return Numbering(
        paths=ordered,
        numbers=tuple(int("".join(words[k])) for k in order),
        times=stamps or moments or _times(changing, order),
        composed=used > 1 or moments is not None,
        dated=dated,
    )


def _times(columns: list[_Column], order: list[int]) -> tuple[float, ...] | None:
    """Return the seconds of the first time stamps that rise in this order."""
    for keys, _, unit in columns:
        if unit and all(keys[one] < keys[other] for one, other in pairwise(order)):
            return tuple(keys[k] / unit for k in order)
    return None


def _moments(paths: Sequence[Path]) -> tuple[tuple[float, ...] | None, bool]:
    """Return the seconds of names that tell them by several numbers, and whether by dates."""
    texts = [f"{path.parent.name}/{path.stem}" for path in paths]
    for pattern in (JOINED, DATED, IN_FOLDER):
        found = [pattern.search(text) for text in texts]
        if len(paths) < 2 or not all(found):
            continue
        dated = pattern is not JOINED
        seconds = [_date(match) if dated else _clock(match) for match in found]
        if None in seconds or (pattern is DATED and _are_counters(found)):
            continue
        since = seconds[0] if dated else 0
        ticks, unit = _with_parts([second - since for second in seconds], found)
        if all(one < other for one, other in pairwise(ticks)):
            return tuple((tick - ticks[0] * dated) / unit for tick in ticks), dated
    return None, False


def _clock(match: re.Match) -> int | None:
    """Return seconds since 1970, if they are of this century."""
    second = int(match[1])
    return second if _is_clock([second]) else None


def _date(match: re.Match) -> int | None:
    """Return the seconds of a date and a time of day since 1970, if there is such a day."""
    year, _, month, day, hour, _, minute, second = match.groups()[:8]
    parts = map(int, (year, month, day, hour, minute, second))
    try:
        return int(datetime(*parts, tzinfo=UTC).timestamp())
    except ValueError:
        return None


def _are_counters(found: Sequence[re.Match]) -> bool:
    """Return whether what stands behind days counts from nought and is no time of day."""
    return all(not match[6] and match[5] == match[7] == "00" for match in found)


def _with_parts(seconds: list[int], found: Sequence[re.Match]) -> tuple[list[int], int]:
    """Return times and their unit in a second: seconds alone where what follows is a counter."""
    told = [match.groupdict() for match in found]
    decimals, parts = ([one.get(name) for one in told] for name in ("decimals", "parts"))
    if all(decimals):
        behind = [text.ljust(9, "0") for text in decimals]
    elif all(parts) and not _count_up(seconds, parts):
        widest = next(width for width in (3, 6, 9) if width >= max(map(len, parts)))
        behind = [text.rjust(widest, "0").ljust(9, "0") for text in parts]
    else:
        return seconds, 1
    return [10**9 * second + int(text) for second, text in zip(seconds, behind, strict=True)], 10**9


def _count_up(seconds: list[int], parts: list[str]) -> bool:
    """Return whether numbers behind seconds are counters: small, or one apart within a second."""
    widths, numbers = {len(text) for text in parts}, list(map(int, parts))
    if (len(widths) == 1 and not widths <= {3, 6, 9}) or max(numbers) < 100:
        return True
    pairs = pairwise(zip(seconds, numbers, strict=True))
    steps = {after - before for (one, before), (other, after) in pairs if one == other}
    return steps == {1}


def _columns(paths: Sequence[Path]) -> list[_Column]:
    """Return the numbers of all names, column by column; two with a point between may be one."""
    found = [DIGITS.findall(path.stem) for path in paths]
    for path, digits in zip(paths, found, strict=True):
        if not digits:
            raise CorruptImage(f"{path}: the name has no number")
        if len(digits) != len(found[0]):
            raise CorruptImage(
                f"{path}: the name has {len(digits)} numbers, that of {paths[0].name} has"
                f" {len(found[0])}; pattern=… tells which are meant"
            )
    between = [DIGITS.split(path.stem)[1:-1] for path in paths]
    columns, at = list(zip(*found, strict=True)), 0
    result = []
    while at < len(columns):
        point = at + 1 < len(columns) and all(texts[at] == "." for texts in between)
        joined = _decimal(paths, columns[at], columns[at + 1]) if point else None
        result.append(joined or _whole(columns[at]))
        at += 2 if joined else 1
    return result


def _whole(digits: Sequence[str]) -> _Column:
    """Return whole numbers, which may be times."""
    keys = list(map(int, digits))
    return _Column(keys, max(map(len, digits)), clock_unit(keys))


def clock_unit(keys: Sequence[float]) -> int | None:
    """Return what a second holds of the unit in which numbers are times of this century."""
    return next((unit for unit in UNITS if _is_clock(keys, unit)), None)


def _is_clock(keys: Sequence[float], unit: int = 1) -> bool:
    """Return whether numbers are times of this century."""
    return all(CLOCK[0] * unit <= key < CLOCK[1] * unit for key in keys)


def _decimal(paths: Sequence[Path], whole: Sequence[str], behind: Sequence[str]) -> _Column | None:
    """Return decimal numbers, unless what stands round the points are two counters.

    Parts of a second are told from a counter by their size, by zeros in front, which a counter does
    not have, and by zeros at the end, which a decimal number does not have.
    """
    seconds, parts = list(map(int, whole)), list(map(int, behind))
    stamps, widths = _is_clock(seconds), {len(text) for text in behind}
    if not stamps and len(set(seconds)) == 1:
        return None
    widest = max(widths)
    decimals = [int(text.ljust(widest, "0")) for text in behind]
    told = [text for text in behind if len(text) > 1]
    if len(widths) > 1 and not any(text.startswith("0") for text in told):
        if any(text.endswith("0") for text in told):  # seconds, and micro- or nanoseconds
            unit = 10 ** (6 if widest <= 6 else 9)
            return _scaled(seconds, parts, unit) if stamps else None
        if not stamps and _order(seconds, parts) != _order(seconds, decimals):
            raise CorruptImage(
                f"{paths[0]}: the names may be decimal numbers or hold two counters; fill up with"
                " zeros"
            )
    found = _scaled(seconds, decimals, 10**widest)
    return found if stamps or widest >= LEAST else found._replace(unit=None)


def _scaled(seconds: list[int], parts: list[int], unit: int) -> _Column:
    """Return times of seconds and parts of them."""
    keys = [unit * second + part for second, part in zip(seconds, parts, strict=True)]
    return _Column(keys, len(str(max(keys))), unit)


def _order(*columns: Sequence[int]) -> list[int]:
    """Return the places of numbers in their order."""
    keys = list(zip(*columns, strict=True))
    return sorted(range(len(keys)), key=keys.__getitem__)
