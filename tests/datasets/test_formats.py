"""The laws that every format keeps: what is good is read, whatever is damaged is named or counted.

The formats are declared in `tests.datasets.formats`.
"""

import re
from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_perception import datasets
from robot_perception.datasets import CorruptLog
from tests.datasets import formats
from tests.datasets.formats import ALL
from tests.datasets.formats.declared import joined, packed

LINED = {name: one for name, one in ALL.items() if one.is_lined}
TEXTS = {name: one for name, one in ALL.items() if one.is_lined or one.form == "text"}
TABLES = {name: one for name, one in ALL.items() if one.form in ("rows", "named")}
NAMED = {name: one for name, one in ALL.items() if one.form == "named"}
WORDED = {name: one for name, one in ALL.items() if one.words}
BINARY = {name: one for name, one in ALL.items() if one.form == "bytes"}
DAMAGES = [
    pytest.param(one, damage, id=f"{name}-{what}")
    for name, one in ALL.items()
    for what, damage in one.damages.items()
]


def each(kinds):
    """Run a law for each of some formats."""
    return pytest.mark.parametrize("kind", kinds.values(), ids=kinds)


def part(found: Any, place: str) -> Any:
    """Return what stands at a place such as ``robots.3.times``."""
    for name in place.split("."):
        if name.isdigit():
            found = found[int(name)]
        else:
            found = found[name] if isinstance(found, Mapping) else getattr(found, name)
    return found


def check(found: Any, kind, but: str = "") -> None:
    """Assert that all was read that a format declares, but perhaps for one place."""
    for place, wanted in kind.reads.items():
        if but and place.endswith(but):
            continue
        value = part(found, place)
        if isinstance(wanted, re.Pattern):
            assert wanted.search(str(value)), place
        elif isinstance(wanted, np.ndarray) or (
            isinstance(wanted, list) and np.asarray(wanted).dtype.kind in "biuf"
        ):
            assert np.shape(value) == np.shape(wanted), place
            np.testing.assert_allclose(value, wanted, rtol=0, atol=kind.atol, err_msg=place)
        else:
            value = value.tolist() if isinstance(value, np.ndarray) else value
            assert value == wanted, place


def named(kind, words: str, file: str = "", error: type[Exception] | None = None):
    """Expect the error of a format, with the file's name and then these words."""
    name = re.escape(file or kind.name.rpartition("/")[2].removesuffix(".*"))
    return pytest.raises(error or kind.error, match=rf"{name}.*{words}")


ELSEWHERE = {"read_images", "read_stereo", "read_video", "read_bag_commands"}
"""Readers of folders, by `test_images` and `test_stereo`, and readers that another one calls."""


def test_every_reader_has_a_format():
    modules = Path(formats.__file__).parent.glob("*.py")
    texts = "".join(path.read_text("utf-8") for path in modules)
    readers = {name for name in datasets.__all__ if name.startswith("read_")}
    assert readers - set(re.findall(r"read_\w+", texts)) == ELSEWHERE


@each(ALL)
def test_a_good_file_is_read(kind, tmp_path):
    check(kind.opened(tmp_path, kind.put(tmp_path)), kind)


@each(LINED)
def test_packed_or_not_a_file_is_the_same(kind):
    assert kind.outcome(packed(kind.good), ".gz") == kind.as_good


@pytest.mark.parametrize(("kind", "damage"), DAMAGES)
def test_damage_is_named(kind, damage, tmp_path):
    place = kind.put(tmp_path, damage.content, damage.file)
    file = tmp_path.name if damage.of_folder else place.name
    with named(kind, damage.words, file, damage.error):
        kind.opened(tmp_path, place)
    if kind.is_lined and place.is_file() and not damage.file and not damage.of_folder:
        with named(kind, damage.words, file, damage.error):
            kind.outcome(packed(place.read_bytes()), ".gz")


@each(ALL)
def test_an_empty_file_is_named(kind, tmp_path):
    place = kind.put(tmp_path)
    place.write_bytes(b"")
    with named(kind, kind.empty):
        kind.opened(tmp_path, place)


@each(ALL)
def test_a_file_that_is_not_there_is_named(kind, tmp_path):
    """Or the folder, if a recording is one."""
    place = kind.put(tmp_path)
    with pytest.raises((FileNotFoundError, NotADirectoryError)):
        kind.read(place.with_name("nowhere") if kind.opens is None else tmp_path / "nowhere")


# What was cut off ---------------------------------------------------------------------------------


@each(TEXTS)
def test_a_text_that_was_cut_is_refused_or_counted(kind, tmp_path):
    """Never silently short: either all that is declared is there, or the count tells."""
    place, good = kind.put(tmp_path), kind.good
    for length in np.linspace(1, len(good) - 1, 25).astype(int):
        cut = good[:length]
        place.write_bytes(cut)
        try:
            found = kind.opened(tmp_path, place)
        except (CorruptLog, ValueError) as error:
            assert str(error).startswith(str(tmp_path))  # noqa: PT017 - either outcome is right
            continue
        if kind.count(found) != len(cut.splitlines()):
            check(found, kind)


@each(BINARY)
def test_bytes_that_were_cut_are_refused_or_read_as_whole(kind, tmp_path):
    """Only a file whose last bytes mean nothing is read without them."""
    place = kind.put(tmp_path)
    whole = place.read_bytes()
    shares = (0.5, 0.95) if kind.costs else (0.002, 0.3, 0.5, 0.7, 0.9)
    for length in [int(share * len(whole)) for share in shares] + [len(whole) - 1]:
        place.write_bytes(whole[:length])
        try:
            found = kind.opened(tmp_path, place)
        except kind.error as error:
            assert str(error).startswith(str(tmp_path))  # noqa: PT017 - either outcome is right
            assert re.search(kind.cut, str(error))  # noqa: PT017
        else:
            assert not kind.cut
            assert length > len(whole) - 20
            check(found, kind)


# What is skipped ----------------------------------------------------------------------------------


@each(LINED)
def test_what_is_skipped_is_counted_and_changes_no_number(kind, tmp_path):
    place, good = kind.put(tmp_path), kind.good
    before = kind.count(kind.opened(tmp_path, place))
    place.write_bytes(joined(b"# comment", b"#", b"", b"  ") + good + b"\n# end\n")
    found = kind.opened(tmp_path, place)
    assert kind.count(found) - before == 6 * kind.accounts
    check(found, kind, but="others")


# How a text is written ----------------------------------------------------------------------------

ENCODED = {
    "byte order mark": lambda text: text.decode().encode("utf-8-sig"),
    "UTF-16": lambda text: ("\ufeff" + text.decode()).encode("utf-16-le"),
    "UTF-16 of the other end": lambda text: ("\ufeff" + text.decode()).encode("utf-16-be"),
    "UTF-32": lambda text: ("\ufeff" + text.decode()).encode("utf-32-le"),
    "CRLF": lambda text: text.replace(b"\n", b"\r\n"),
    "CR": lambda text: text.replace(b"\n", b"\r"),
    "no last line end": lambda text: text.removesuffix(b"\n"),
    "blanks at the ends": lambda text: text.replace(b"\n", b" \t\n"),
}


@pytest.mark.parametrize("change", ENCODED.values(), ids=ENCODED)
@each(LINED)
def test_an_encoding_changes_no_number(kind, change):
    assert kind.outcome(change(kind.good)) == kind.as_good


@each(LINED)
def test_what_is_no_text_is_named_with_its_line(kind, tmp_path):
    """A letter of Latin 1 in the last line, and UTF-16 that does not say so."""
    place, good = kind.put(tmp_path), kind.good
    last = len(kind.lines)
    for content, line in ((good[:-1] + b" \xe4\n", last), (good.decode().encode("utf-16-le"), 1)):
        place.write_bytes(content)
        with named(kind, rf", line {line}: not text in UTF-8", error=CorruptLog):
            kind.opened(tmp_path, place)


def rendered(kind, separator, *, quoted=False, comma=False, trailing=False):
    """Return the lines of a table with other marks between its cells."""
    lines = []
    for line in kind.lines:
        cells = re.split(rb"[,\s]+", line)
        if not line.startswith(b"#"):
            cells = [cell.replace(b".", b",") for cell in cells] if comma else cells
            cells = [b'"' + cell + b'"' for cell in cells] if quoted else cells
            line = separator.join(cells) + separator * trailing
        lines.append(line)
    return b"\n".join(lines) + b"\n"


SEPARATORS = {"comma": b",", "semicolon": b";", "tab": b"\t", "blank": b" ", "wide": b" ; "}
DIALECTS = {
    f"{name}{', quoted' * quoted}{', decimal commas' * comma}{', trailing' * trailing}": {
        "separator": separator, "quoted": quoted, "comma": comma, "trailing": trailing
    }
    for (name, separator), quoted, comma, trailing in product(
        SEPARATORS.items(), (False, True), (False, True), (False, True)
    )
    if not (comma and name in ("comma", "blank")) and not (quoted and name == "wide")
}  # fmt: skip


@pytest.mark.parametrize("dialect", DIALECTS.values(), ids=DIALECTS)
@each(TABLES)
def test_a_dialect_changes_no_number(kind, dialect):
    assert kind.outcome(rendered(kind, **dialect)) == kind.as_good


@pytest.mark.parametrize("mark", [b"#", b"# ", b"\xef\xbb\xbf#"])
@pytest.mark.parametrize("separator", [b",", b";", b"\t", b" "])
@each(NAMED)
def test_names_may_stand_behind_a_hash(kind, separator, mark):
    text, quoted = rendered(kind, separator), rendered(kind, separator, quoted=True)
    for content in (
        mark + text,
        b'# "odd, comment\n' + b"#" + text,
        b"#" + kind.lines[0] + b"\n" + text,
        b"#" + quoted,
    ):
        found = re.sub(r"others=mappingproxy\(\{'#': \d\}\)", "others=", kind.outcome(content))
        assert found == kind.as_good.replace("others=mappingproxy({})", "others=")


@each(TABLES)
def test_a_comment_may_have_quotes_of_any_kind(kind):
    comments = [b'# "odd', b'# "rgb" trajectory, "desk', b'# "", "a"b', b"# it's"]
    text = b"\n".join([*comments, kind.good])
    assert kind.outcome(text) == kind.outcome(b"# x\n" * 4 + kind.good)


# Damage anywhere ----------------------------------------------------------------------------------

NUMBER, FINITE = "a value is not a number", "a value is NaN or infinite"
COUNT, TEXT = "an id or a count is not an integer", "not text"
WRONG_NUMBERS = {b"x": NUMBER, b"1_0": NUMBER, b"nan": FINITE, b"-inf": FINITE, b"1e999": FINITE}
WRONG_COUNTS = (b"x", b"-1", b"1.5", b"9" * 30)
NO_WORDS = (b"\xff", b"1\x00", bytes(range(128, 256)))


@each(WORDED)
@given(st.data())
@settings(max_examples=50, deadline=None)
def test_a_bad_line_is_named_with_its_reason(kind, data):
    """A line that is cut, too long, or has a word that is wrong where it stands."""
    rows = [row for row, line in enumerate(kind.lines) if not line.startswith(b"#")]
    row = data.draw(st.sampled_from(rows))
    words = kind.lines[row].split()
    ids, numbers = kind.words(words)
    wrong = {
        "cut": (words[: data.draw(st.integers(1, len(words) - 1))], "fewer values than announced"),
        "long": ([*words, *words[: data.draw(st.integers(1, 9))]], "more values than announced"),
    }
    for name, places, values in (
        ("number", numbers, WRONG_NUMBERS),
        ("count", ids, dict.fromkeys(WRONG_COUNTS, COUNT)),
        ("text", [*range(len(words))], dict.fromkeys(NO_WORDS, TEXT)),
    ):
        if places:
            place, value = (data.draw(st.sampled_from([*some])) for some in (places, values))
            wrong[name] = [*words[:place], value, *words[place + 1 :]], values[value]
    words, reason = wrong[data.draw(st.sampled_from([*wrong]))]
    lines = [*kind.lines[:row], b" ".join(words), *kind.lines[row + 1 :]]
    with named(kind, f", line {row + 1}: {reason}"):
        kind.outcome(b"\n".join(lines))


@each(LINED)
def test_a_file_that_holds_nothing_is_named(kind):
    whole, last = packed(kind.good), len(kind.lines) + 1
    for content, suffix, reason in (
        (b"", ".gz", ": the file is empty"),
        (b"# nothing\n", "", kind.nothing),
        (b"<html>404</html>", ".gz", r", line 1: the gzip file is damaged here \(Not a gzipped"),
        (whole + b"<html>", ".gz", rf", line {last}: the gzip file is damaged here"),
        (whole[:-8], ".gz", rf", line {last}: the gzip file is damaged here"),  # no checksum
    ):
        with named(kind, reason, kind.name + suffix):
            kind.outcome(content, suffix)


@each(WORDED)
@given(st.data(), st.binary(max_size=40))
@settings(max_examples=30, deadline=None)
def test_no_damage_of_a_packed_file_passes_unnoticed(kind, data, junk):
    """Whatever is cut off, put in or written over: its name is in the error, or nothing is lost."""
    whole = packed(kind.good)
    place = data.draw(st.integers(1, len(whole) - 1))
    rest = data.draw(st.sampled_from([b"", whole[place:], whole[place + len(junk) :]]))
    try:
        found = kind.outcome(whole[:place] + junk + rest, ".gz")
    except kind.error as error:
        assert kind.name in str(error)  # noqa: PT017 - either outcome is right
    else:
        assert found == kind.as_good


@each(LINED)
@given(st.integers(0, 10**6), st.binary(min_size=1, max_size=40))
@settings(max_examples=20, deadline=None)
def test_bytes_anywhere_raise_nothing_but_the_error_of_the_format(kind, place, junk):
    good = kind.good
    place %= len(good) + 1
    try:
        found = kind.outcome(good[:place] + junk + good[place:])
    except (kind.error, ValueError) as error:
        assert kind.name in str(error)  # noqa: PT017 - either outcome is right
    else:
        assert "nan" not in found or "nan" in kind.as_good


@each({name: one for name, one in BINARY.items() if not one.costs})
def test_a_bit_that_fell_over_ends_in_no_foreign_error(kind, tmp_path):
    place = kind.put(tmp_path)
    whole, rng = place.read_bytes(), np.random.default_rng(1)
    for _ in range(30):
        wrong = bytearray(whole)
        wrong[rng.integers(len(whole))] ^= 1 << rng.integers(8)
        place.write_bytes(wrong)
        try:
            kind.opened(tmp_path, place)
        except kind.error as error:
            assert tmp_path.name in str(error)  # noqa: PT017 - either outcome is right


# What is written ----------------------------------------------------------------------------------

WRITTEN = {name: one for name, one in ALL.items() if one.again}


@each(WRITTEN)
def test_what_is_written_anew_is_read_as_before(kind, tmp_path):
    place = kind.put(tmp_path)
    found = kind.opened(tmp_path, place)
    place.unlink()
    kind.again(place, found)
    check(kind.opened(tmp_path, place), kind)
