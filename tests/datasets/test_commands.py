"""The command line: a table, one set in full, fetching, adding, and one-line errors."""

import pytest
from click.testing import CliRunner

from robot_perception.cli.datasets import datasets
from robot_perception.datasets import find, registry, status
from tests.datasets.conftest import TEXT, answer_404, put, sha


def run(*words):
    return CliRunner().invoke(datasets, [*map(str, words)], prog_name="robot-perception datasets")


def failed(result, code=1):
    """Assert a one-line error without traceback, and return it."""
    assert result.exit_code == code
    assert isinstance(result.exception, SystemExit)
    last = result.stderr.strip().splitlines()[-1]
    assert last.startswith("Error: ")
    assert "Traceback" not in result.output
    return last


def test_list(room, mine):
    put(mine, "hall/graph.log", TEXT)
    result = run("list")
    assert result.exit_code == 0
    rows = {line.split()[0]: line for line in result.stdout.splitlines()}
    assert list(rows) == ["name", "hall", "attic", "cellar", "album", "slides"]
    assert "1 of 2 files present, downloadable  2      0.4 MB  MIT" in rows["hall"]
    assert "missing, 1 downloadable" in rows["attic"]
    assert "missing, not downloadable" in rows["cellar"]
    assert "missing, downloadable" in rows["album"]
    assert " 300 " in rows["album"]
    put(mine, "hall/graph.log", b"my own")
    assert "1 of 2 files present, 1 with another hash" in run("list").stdout


def test_info(room):
    text = run("info", "hall").stdout
    assert text.startswith("hall: A hall\nOrigin: Somebody 2003\nLicence: MIT\n")
    assert "graph.log: missing" in text
    assert f"{room.url}/a%20graph.log" in text
    lost = run("info", "attic").stdout
    assert "not downloadable: no address is pinned" in lost
    assert "made from a rawlog" in lost
    assert "Files: 300, 0.4 MB; missing, downloadable" in run("info", "album").stdout


def test_info_of_something_unknown(room):
    assert "no data set 'hal'; did you mean 'hall'?" in failed(run("info", "hal"))


def test_directory_that_does_not_exist_is_named(room, monkeypatch):
    monkeypatch.setenv("ROBOT_PERCEPTION_DATA", "/nowhere/at/all")
    expected = "ROBOT_PERCEPTION_DATA is /nowhere/at/all, which is not a directory"
    for words in (("list",), ("info", "hall"), ("fetch", "hall")):
        assert expected in failed(run(*words))


def test_fetch(room):
    result = run("fetch", "hall")
    assert result.exit_code == 0, result.output
    assert result.stdout == "hall: present\n"
    assert "100%" in result.stderr
    assert "graph.log: present, " in run("info", "hall").stdout


def test_fetch_all_passes_over_what_cannot_be_downloaded(room):
    result = run("fetch", "--all")
    assert result.exit_code == 0, result.output
    assert result.stdout.splitlines() == [
        "hall: present",
        "attic: 1 of 2 files present, not downloadable",
        "cellar: missing, not downloadable",
        "album: present",
        "slides: present",
    ]


def test_fetch_of_what_cannot_be_downloaded(room):
    assert "lost.log is not downloadable: no address is pinned" in failed(run("fetch", "cellar"))


def test_fetch_failing(room, server):
    server.answer = answer_404
    error = failed(run("fetch", "hall"))
    assert "hall/graph.log: download from" in error
    assert error.endswith("failed: the server answered 404 Not Found")


@pytest.mark.parametrize("words", [(), ("hall", "--all")])
def test_fetch_wants_names_or_all(room, words):
    assert "names of data sets, or --all" in failed(run("fetch", *words), code=2)


# ---- adding --------------------------------------------------------------------------------------

TOLD = ("--title", "Mine", "--licence", 'my "own"', "--origin", "I, 2026")


def test_added_folder_is_registered_and_checked_from_then_on(room, mine):
    for number in range(30):
        put(mine, f"my_robot/img/{number} a.png", b"picture %d" % number)
    put(mine, "my_robot/run.log.gz", b"log")
    put(mine, "my_robot/.hidden", b"")
    result = run("add", mine / "my_robot", *TOLD)
    assert result.exit_code == 0, result.output
    assert result.stdout == "my_robot: 31 files, 0.3 kB\n"
    entry = registry()["my_robot"]
    assert (entry.title, entry.licence, entry.origin) == ("Mine", 'my "own"', "I, 2026")
    assert [item.state for item in status("my_robot")] == ["present"] * 31
    put(mine, "my_robot/img/7 a.png", b"another")
    assert "30 more" not in run("info", "my_robot").stdout
    changed = [item.file.name for item in status("my_robot") if item.state == "differs"]
    assert changed == ["img/7 a.png"]
    (mine / "my_robot/img/8 a.png").unlink()
    assert find("my_robot") is None
    assert "my_robot" in run("list").stdout


def test_a_second_folder_stands_beside_the_first(room, mine):
    for name in ("one", "two"):
        put(mine, f"{name}/a.txt", name.encode())
        assert run("add", mine / name, *TOLD).exit_code == 0
    lines = (mine / "registry.txt").read_text().split("\n")
    assert [line for line in lines if line] == [
        f"one/a.txt {sha(b'one')}",
        f"two/a.txt {sha(b'two')}",
    ]
    assert list(registry())[-2:] == ["one", "two"]


def test_maintainers_add_to_the_books_registry_with_addresses(room, tmp_path):
    folder = put(tmp_path, "scans/a b.txt", b"a").parent
    words = ("--url", "https://x.org/base/", "--note", "Halved.", "--to", room.book)
    assert run("add", folder, *TOLD, *words).exit_code == 0
    (file,) = registry()["scans"].files
    assert (file.name, file.sha256) == ("a b.txt", sha(b"a"))
    assert file.url == "https://x.org/base/a%20b.txt"
    assert registry()["scans"].note == "Halved."


@pytest.mark.parametrize("missing", ["title", "licence", "origin"])
@pytest.mark.parametrize("blank", [True, False])
def test_no_recording_is_added_without_saying_whose_it_is(room, mine, missing, blank):
    put(mine, "my_robot/run.log", b"log")
    words = list(TOLD)
    place = words.index(f"--{missing}")
    words[place : place + 2] = [f"--{missing}", "  "] if blank else []
    expected = f"my_robot has no {missing}: a recording without one is not added"
    assert expected in failed(run("add", mine / "my_robot", *words))
    assert not (mine / "registry.txt").exists()


@pytest.mark.parametrize(
    ("name", "file", "expected"),
    [
        ("hall", "a.log", "there is a data set 'hall' already"),
        ("my robot", "a.log", "'my robot' is no name for a data set"),
        ("empty", ".hidden", "holds no files"),
        ("elsewhere/deep", "a.log", "it would not be found"),
    ],
)
def test_what_cannot_be_added_is_said(room, mine, name, file, expected):
    put(mine / name, file)
    assert expected in failed(run("add", mine / name, *TOLD))
    assert not (mine / "sets.toml").exists()


def test_without_a_directory_there_is_no_registry_to_add_to(room, tmp_path):
    folder = put(tmp_path, "my_robot/run.log").parent
    assert "no registry to add to: set ROBOT_PERCEPTION_DATA" in failed(run("add", folder, *TOLD))
