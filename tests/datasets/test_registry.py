"""The registry: every set says whose it is, every file can be checked, and mistakes are named."""

import os
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given
from hypothesis import strategies as st

from robot_perception.datasets import add_dataset, dataset, entries, find, registry
from robot_perception.datasets.entries import some
from tests.datasets.conftest import put, sha, write_registry

NEEDED = {
    "carmen_intel",
    "carmen_fr079",
    "carmen_corrected",
    "malaga_sena",
    "utias_mrclam_6",
    "victoria_park",
    "head_girl",
    "faces_orl",
    "kitti_stereo_turn",
    "leg_scans",
}


def test_the_books_recordings_are_registered():
    assert set(registry()) >= NEEDED


@pytest.mark.parametrize("entry", registry().values(), ids=list(registry()))
def test_every_set_says_whose_it_is_and_every_file_can_be_checked(entry):
    for text in (entry.title, entry.licence, entry.origin):
        assert text.strip() == text != ""
    names = [file.name.removesuffix(".gz") for file in entry.files]
    assert len(set(names)) == len(names) > 0
    for file in entry.files:
        assert re.fullmatch(r"[0-9a-f]{64}", file.sha256)
        pinned = r"https://raw\.githubusercontent\.com/[\w.-]+/[\w.-]+/[0-9a-f]{40}/.+"
        assert file.url is None or re.fullmatch(pinned, file.url)


def test_file_is_found_with_or_without_gz():
    entry = registry()["carmen_fr079"]
    assert entry.file("fr079_graph.log") is entry.file("fr079_graph.log.gz")


def test_hundreds_of_pictures_are_one_set():
    files = registry()["head_girl"].files
    assert len(files) == 251
    assert sum(file.url is not None for file in files) == 250


ABOUT = {"title": "Mine", "licence": "MIT", "origin": "I", "bytes": 1}
LINE = f"mine/a.txt {sha(b'a')}"
MISTAKES = {
    "no licence": ({"mine": ABOUT | {"licence": " "}}, [LINE], r"sets\.toml: mine has no licence"),
    "no origin": ({"mine": {"title": "A"}}, [LINE], r"sets\.toml: mine has no licence"),
    "unknown word": ({"mine": ABOUT | {"colour": "red"}}, [LINE], "mine: .*colour"),
    "no size": ({"mine": dict(list(ABOUT.items())[:3])}, [LINE], "mine: .*'bytes'"),
    "no files": ({"mine": ABOUT, "two": ABOUT}, [LINE], r"sets\.toml: two without files in reg"),
    "no hash": ({"mine": ABOUT}, ["mine/a.txt abc"], r"registry\.txt: mine/a\.txt is not FOLDER"),
    "no folder": ({"mine": ABOUT}, [LINE[5:]], r"registry\.txt: a\.txt is not FOLDER"),
    "outside": ({"mine": ABOUT}, [f"mine/../a {sha(b'a')}"], r"mine/\.\./a is not FOLDER/FILE"),
    "backslash": ({"mine": ABOUT}, [rf"'mine/a\b' {sha(b'a')}"], r"mine/a\\b is not FOLDER/FILE"),
    "no archive": ({"mine": ABOUT | {"members": 9}}, [LINE], "mine has members, so it must be one"),
    "half a line": ({"mine": ABOUT}, ["mine/a.txt"], "expected 2 or 3 elements"),
}


@pytest.mark.parametrize(("sets", "lines", "message"), MISTAKES.values(), ids=MISTAKES)
def test_mistakes_of_a_registry_are_named(mine, sets, lines, message):
    write_registry(mine, sets, lines)
    with pytest.raises(ValueError, match=message):
        dataset("mine")
    with pytest.raises(ValueError, match=message):
        add(mine, "another")
    write_registry(mine / "book", sets, lines)
    with pytest.raises(ValueError, match=message):
        entries._load(mine / "book")


@pytest.mark.parametrize(("sets", "lines", "message"), MISTAKES.values(), ids=MISTAKES)
def test_the_book_goes_on_where_the_readers_registry_is_damaged(mine, caplog, sets, lines, message):
    before = list(registry())
    write_registry(mine, sets, lines)
    assert list(registry()) == list(registry()) == before
    assert dataset("hall").title == "A hall"
    (said,) = caplog.messages
    assert re.search(message, said)
    assert said.startswith(str(mine))


def test_half_a_registry_is_named(mine):
    write_registry(mine, {"mine": ABOUT}, [LINE])
    (mine / "registry.txt").unlink()
    with pytest.raises(ValueError, match=r"cannot be read: .*registry\.txt"):
        dataset("mine")
    (mine / "registry.txt").touch()
    (mine / "sets.toml").write_text("[mine")
    with pytest.raises(ValueError, match=r"sets.toml: cannot be read \(Expected ']'"):
        dataset("mine")


# ---- adding --------------------------------------------------------------------------------------


def add(folder, name, **words):
    put(folder / name, "a b.txt", name.encode())
    told = {"title": "Mine", "licence": "MIT", "origin": "I"} | words
    return add_dataset(folder / name, **told)


def killed(mine, monkeypatch, call, after):
    """Kill what is called as soon as it has put so many files in their place."""
    replace, done = os.replace, []

    def replaced(*places):
        if len(done) == after:
            raise KeyboardInterrupt
        done.append(replace(*places))

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", replaced)
        with pytest.raises(KeyboardInterrupt):
            call()


@pytest.mark.parametrize("others", [0, 1, 2])
@pytest.mark.parametrize("after", [0, 1])
def test_an_entry_is_there_or_not_whenever_the_writing_is_killed(
    mine, monkeypatch, caplog, others, after
):
    names = [f"other{k}" for k in range(others)]
    for name in names:
        add(mine, name)
    before = dict(registry())
    killed(mine, monkeypatch, lambda: add(mine, "mine"), after)
    assert dict(registry()) == before
    assert find("mine") == mine / "mine"  # as any folder there
    assert ("registry.txt: mine left out, without a table" in caplog.text) == (after == 1)
    add(mine, "mine")
    assert list(registry()) == [*before, "mine"]
    assert [file.sha256 for file in dataset("mine").files] == [sha(b"mine")]
    lines = (mine / "registry.txt").read_text().split()
    assert [line for line in lines if "/" in line] == [f"'{name}/a" for name in [*names, "mine"]]


NAMES = [b"a\rb", b"a\x1b[2J", b"a\x7f", b"a\xc2\x85b", b"a\xff", b"a\nb", b"a\\b"]
UNWRITABLE = ["\r", "\0", "\x1b[2J", "\x7f", "\x85", "\ud800"]


@pytest.mark.parametrize("name", NAMES)
def test_a_file_whose_name_no_registry_can_hold_is_refused_before_anything_is_written(mine, name):
    put(mine / "mine", os.fsdecode(name))
    with pytest.raises(ValueError, match="the name of a file must be without"):
        add(mine, "mine")
    assert sorted(file.name for file in mine.iterdir()) == ["mine"]


@pytest.mark.parametrize("word", ["title", "licence", "origin", "note", "url"])
@pytest.mark.parametrize("character", UNWRITABLE)
def test_a_text_that_no_registry_can_hold_is_refused_before_anything_is_written(
    mine, word, character
):
    with pytest.raises(ValueError, match=f"{word} must be without control characters, got 'a"):
        add(mine, "mine", **{word: f"a{character}b"})
    assert sorted(file.name for file in mine.iterdir()) == ["mine"]


PART = st.text(st.characters(exclude_characters="/"), min_size=1)
"""A part of a path: with a slash it may lie in another folder."""


@given(texts=st.lists(st.text(min_size=1), min_size=4, max_size=4), name=PART)
def test_every_text_that_is_taken_is_read_again(texts, name):
    with TemporaryDirectory() as folder:
        words = dict(zip(("title", "licence", "origin", "note"), texts, strict=True))
        try:
            made = put(Path(folder) / "mine", name, b"mine")
        except (OSError, ValueError):  # no name of a file
            return
        try:
            entry = add_dataset(made.parent, **words, to=Path(folder))
        except ValueError:
            assert sorted(file.name for file in Path(folder).iterdir()) == ["mine"]
            return
        assert {word: getattr(entry, word) for word in words} == words
        assert [file.name for file in entry.files] == [made.name]


def test_a_changed_registry_is_read_again(mine):
    write_registry(mine, {"mine": ABOUT}, [LINE])
    assert len(registry()["mine"].files) == 1
    write_registry(mine, {"mine": ABOUT}, [LINE, LINE.replace("/a", "/bcd")])
    assert len(registry()["mine"].files) == 2
    write_registry(mine, {"mine": ABOUT}, [LINE, LINE.replace("/a", "/xyz")])  # of the same size
    assert registry()["mine"].files[1].name.startswith("xyz")


def test_many_names_are_shortened():
    assert some([*"abc"], 3) == "a, b, c"
    assert some([*"abcd"], 3) == "a, b, c, … (4 files)"


ALONE = """
import sys
for name in ("pooch", "requests", "tqdm", "urllib3", "click"):
    sys.modules[name] = None
from robot_perception.datasets import read_relations, registry
print(len(read_relations(sys.argv[1]).times))
registry()
"""


def test_readers_need_numpy_alone_and_the_registry_says_what_it_needs(tmp_path):
    (tmp_path / "a.relations").write_text("1 2 0 0 0 0 0 0")
    command = [sys.executable, "-c", ALONE, str(tmp_path / "a.relations")]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.stdout == "1\n"
    assert done.stderr.strip().endswith("This needs pooch: pip install 'robot-perception[data]'")
