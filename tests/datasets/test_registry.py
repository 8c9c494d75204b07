"""The registry: every set says whose it is, every file can be checked, and mistakes are named."""

import re
import subprocess
import sys

import pytest

from robot_perception.datasets import registry
from robot_perception.datasets.entries import some
from tests.datasets.conftest import sha, write_registry

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
    "no files": ({"mine": ABOUT, "two": ABOUT}, [LINE], "two must stand in both sets.toml and"),
    "no table": ({}, [LINE], "mine must stand in both"),
    "no hash": ({"mine": ABOUT}, ["mine/a.txt abc"], r"registry\.txt: mine/a\.txt is not FOLDER"),
    "no folder": ({"mine": ABOUT}, [LINE[5:]], r"registry\.txt: a\.txt is not FOLDER"),
    "outside": ({"mine": ABOUT}, [f"mine/../a {sha(b'a')}"], r"mine/\.\./a is not FOLDER/FILE"),
    "no archive": ({"mine": ABOUT | {"members": 9}}, [LINE], "mine has members, so it must be one"),
    "half a line": ({"mine": ABOUT}, ["mine/a.txt"], "expected 2 or 3 elements"),
}


@pytest.mark.parametrize(("sets", "lines", "message"), MISTAKES.values(), ids=MISTAKES)
def test_mistakes_of_a_registry_are_named(mine, sets, lines, message):
    write_registry(mine, sets, lines)
    with pytest.raises(ValueError, match=message):
        registry()


@pytest.mark.parametrize("lost", ["sets.toml", "registry.txt"])
def test_half_a_registry_is_named(mine, lost):
    write_registry(mine, {"mine": ABOUT}, [LINE])
    (mine / lost).unlink()
    with pytest.raises(ValueError, match=rf"cannot be read: .*{lost}"):
        registry()
    (mine / "registry.txt").touch()
    (mine / "sets.toml").write_text("[mine")
    with pytest.raises(ValueError, match=r"sets.toml: cannot be read \(Expected ']'"):
        registry()


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
