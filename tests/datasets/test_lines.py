"""What readers of lines share: whatever is damaged, the file and its first bad line are named."""

import gzip
import re
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from robot_perception.datasets import (
    CorruptLog,
    read_carmen_log,
    read_graph_log,
    read_landmark_graph,
    read_mrclam,
    read_relations,
    read_stereo_features,
    read_track,
)
from robot_perception.datasets.poses import Layout, read_poses
from robot_perception.datasets.space_tracks import read_matrices
from tests.datasets import test_graph, test_mrclam, test_stereo, test_victoria
from tests.datasets.writing import carmen_truth


@dataclass(frozen=True)
class Kind:
    """Files of a kind.

    Parameters
    ----------
    read
        Reads a file, or the folder where something stands beside it.
    name, lines
        Of a good one.
    words
        Of a line: the places of whole numbers, and those of numbers.
    beside
        Writes the other files of the folder.
    """

    read: Callable[[Path], Any]
    name: str
    lines: list[bytes]
    words: Callable[[list[bytes]], tuple[list[int], list[int]]]
    beside: Callable[[Path], Any] | None = None

    def outcome(self, content: bytes, suffix: str = "") -> str:
        """Return every number that is read of a file of this content, and the account of it."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"{self.name}{suffix}"
            if self.beside:
                self.beside(Path(folder))
            path.write_bytes(content)
            found = self.read(Path(folder) if self.beside else path)
            with np.printoptions(threshold=10**9, floatmode="unique"):
                return repr(found).replace(folder, "").replace(".gz", "")

    @property
    def good(self) -> bytes:
        """The content of a good file."""
        return b"\n".join(self.lines) + b"\n"


def plain(words):
    return [], [*range(len(words))]


def chain(words):
    return [1, 2], [*range(3, len(words))]


def graph(words):
    after = 9 + test_graph.BEAMS
    if words[0] == b"ROBOTLASER1":
        return [8, after], [*range(1, 8), *range(9, after), *range(after + 1, len(words) - 2)]
    return ([1], [2, 3, 4]) if words[0] == b"VERTEX2" else chain(words)


def utias(name):
    lines, beside = test_mrclam.FILES[name], partial(test_mrclam.folder, suffix=".dat")
    return Kind(read_mrclam, f"Robot2_{name}.dat", lines, plain, beside)


FLASER = carmen_truth(scans=3).lines
FACTORS = [b"1 7 115 65 79 1 1 7", b"3 9 65 15 10 0.5 0 7"]
TURNED = b"0 1 0 1 0 0 1 2 1 0 0 3"
KINDS = {
    "CARMEN": Kind(read_carmen_log, "a.log", FLASER, lambda w: ([1], [*range(2, len(w) - 2)])),
    "graph": Kind(read_graph_log, "a.log", test_graph.GOOD, graph),
    "chain": Kind(read_landmark_graph, "a.txt", test_victoria.LINES, chain),
    "relations": Kind(read_relations, "a.relations", [b"1 2 3 4 5 0.6 0.7 0.8"] * 3, plain),
    "TUM": Kind(read_track, "a.tum", [b"1 0 0 0 0 0 0 1", b"#", b"2 1 0 0 0 0 0 1"], plain),
    "TUM in space": Kind(
        partial(read_poses, found=Layout("TUM"), time_unit="s"),
        "a.tum",
        [b"1 0 0 0 1 0 0 0", b"#", b"2 1 2 3 0 0 0 1"],
        plain,
    ),
    "KITTI poses": Kind(
        read_matrices,
        "a.txt",
        [b"1 0 0 1 0 1 0 2 0 0 1 3", b"#", TURNED],
        plain,
    ),
    "wheels": utias("Odometry"),
    "camera": utias("Measurement"),
    "stereo": Kind(
        read_stereo_features, "VO_stereo_factors_large.txt", FACTORS, plain, test_stereo.tracks
    ),
}
each_kind = pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)

NUMBER, FINITE = "a value is not a number", "a value is NaN or infinite"
COUNT, TEXT = "an id or a count is not an integer", "not text"
WRONG_NUMBERS = {b"x": NUMBER, b"1_0": NUMBER, b"nan": FINITE, b"-inf": FINITE, b"1e999": FINITE}
WRONG_COUNTS = (b"x", b"-1", b"1.5", b"9" * 30)
NO_WORDS = (b"\xff", b"1\x00", bytes(range(128, 256)))


@each_kind
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
    with pytest.raises(CorruptLog, match=rf"{re.escape(kind.name)}, line {row + 1}: {reason}"):
        kind.outcome(b"\n".join(lines))


@each_kind
def test_a_file_that_holds_nothing_is_named(kind, tmp_path):
    packed, last = gzip.compress(kind.good), len(kind.lines) + 1
    for content, suffix, reason in (
        (b"", "", ": the file is empty"),
        (b"", ".gz", ": the file is empty"),
        (b"# nothing\n", "", r": no \w+ line \(.*; read none; other kinds 1 #\)"),
        (b"<html>404</html>", ".gz", r", line 1: the gzip file is damaged here \(Not a gzipped"),
        (packed + b"<html>", ".gz", rf", line {last}: the gzip file is damaged here"),
        (packed[:-8], ".gz", rf", line {last}: the gzip file is damaged here"),  # no checksum
    ):
        with pytest.raises(CorruptLog, match=rf"{re.escape(kind.name + suffix)}{reason}"):
            kind.outcome(content, suffix)
    with pytest.raises(FileNotFoundError):
        kind.read(tmp_path / "nowhere")


@each_kind
@given(st.data(), st.binary(max_size=40))
@settings(max_examples=50, deadline=None)
def test_no_damage_of_a_packed_file_passes_unnoticed(kind, data, junk):
    """Whatever is cut off, put in or written over: its name is in the error, or nothing is lost."""
    packed = gzip.compress(kind.good, mtime=0)
    place = data.draw(st.integers(1, len(packed) - 1))
    rest = data.draw(st.sampled_from([b"", packed[place:], packed[place + len(junk) :]]))
    try:
        found = kind.outcome(packed[:place] + junk + rest, ".gz")
    except CorruptLog as error:
        assert kind.name in str(error)  # noqa: PT017 - either outcome is right
    else:
        assert found == kind.outcome(kind.good)


@each_kind
@given(st.integers(0, 10**6), st.binary(min_size=1, max_size=40))
@settings(max_examples=50, deadline=None)
def test_bytes_anywhere_raise_nothing_but_corrupt_log(kind, place, junk):
    place %= len(kind.good) + 1
    try:
        found = kind.outcome(kind.good[:place] + junk + kind.good[place:])
    except CorruptLog:
        pass
    else:
        assert "nan" not in found
