"""Where recordings are looked for, in which order, and what is said when they are missing."""

import gzip

import pytest

from robot_perception.datasets import (
    DatasetMissing,
    UnknownDataset,
    fetch,
    find,
    path,
    status,
    store,
)
from tests.datasets.conftest import PACKED, TEXT, put


def test_users_directory_comes_before_the_cache(room, mine):
    cached = put(room.cache / "hall", "graph.log.gz")
    assert find("hall", "graph.log.gz") == cached
    own = put(mine / "hall", "graph.log.gz")
    assert find("hall", "graph.log.gz") == own
    assert path("hall", "graph.log.gz") == own


@pytest.mark.parametrize("asked", ["graph.log", "graph.log.gz"])
@pytest.mark.parametrize("stored", ["graph.log", "graph.log.gz"])
def test_either_form_is_found_under_either_name(mine, asked, stored):
    assert find("hall", asked) is None
    assert find("hall", asked) is None
    own = put(mine / "hall", stored)
    assert find("hall", asked) == own


def test_of_both_forms_the_one_that_was_asked_for_is_found(mine):
    both = {name: put(mine / "hall", name) for name in ("graph.log", "graph.log.gz")}
    assert find("hall", "graph.log.gz") == both["graph.log.gz"]


@pytest.mark.parametrize(
    ("size", "text"), [(1, "0.1 kB"), (2_340, "2.3 kB"), (99_900, "99.9 kB"), (100_000, "0.1 MB")]
)
def test_sizes_are_shown_in_the_unit_that_suits(size, text):
    assert store.size_text(size) == text


def test_folder_is_found_when_it_is_complete(room, mine):
    assert find("hall") is None
    put(mine / "hall", "graph.log")
    assert find("hall") is None
    put(mine / "hall", "scans.log.gz")
    assert find("hall") == path("hall") == mine / "hall"


def test_complete_cache_serves_beside_an_incomplete_directory(room, mine):
    put(mine / "hall", "graph.log")
    put(room.cache / "hall", "graph.log.gz")
    put(room.cache / "hall", "scans.log.gz")
    assert find("hall") == room.cache / "hall"


def test_recordings_of_ones_own(mine):
    own = put(mine / "my_robot", "run.log")
    assert find("my_robot") == path("my_robot") == mine / "my_robot"
    assert find("my_robot", "run.log") == own
    assert find("my_robot", "other.log") is None
    with pytest.raises(DatasetMissing, match=r"my_robot/other\.log is not in "):
        path("my_robot", "other.log")
    extra = put(mine / "hall", "notes.txt")
    assert find("hall", "notes.txt") == extra


@pytest.mark.parametrize("name", ["hal", "", "/etc", "../hall", "~/hall", "a\\b", "hall/.."])
def test_unknown_names_are_refused(mine, name):
    for function in (find, path, status):
        with pytest.raises(UnknownDataset):
            function(name)


def test_unknown_names_come_with_a_hint(room):
    with pytest.raises(UnknownDataset, match=r"did you mean 'hall'\? \(known: hall, attic, "):
        find("hal")
    with pytest.raises(UnknownDataset, match=r"hall has no file 'x'; it has graph\.log, scan"):
        find("hall", "x")
    with pytest.raises(UnknownDataset, match="not a name inside"):
        find("hall", "../../etc/passwd")


def test_missing_set_says_the_two_ways_to_get_it(room):
    with pytest.raises(DatasetMissing) as failure:
        path("hall")
    assert str(failure.value) == (
        "hall: graph.log, scans.log.gz are not on this computer. Either run"
        " `robot-perception datasets fetch hall` (all of it: 0.4 MB), or put the recording into"
        " hall/ in a directory of yours and set ROBOT_PERCEPTION_DATA to it."
    )


def test_missing_set_that_cannot_be_downloaded_says_so(mine):
    with pytest.raises(DatasetMissing) as failure:
        path("cellar")
    assert str(failure.value) == (
        "cellar: lost.log is not on this computer. Put the recording into"
        f" {mine / 'cellar'} (ROBOT_PERCEPTION_DATA is {mine}). lost.log is not downloadable: no"
        " address is pinned. lost.log was made from a rawlog."
    )


@pytest.mark.parametrize("kind", ["nothing", "file"])
def test_directory_that_is_none_is_named(room, monkeypatch, kind):
    place = put(room.data, "a") if kind == "file" else room.data
    monkeypatch.setenv("ROBOT_PERCEPTION_DATA", str(place))
    for function in (find, path, status):
        with pytest.raises(NotADirectoryError) as failure:
            function("hall")
        assert str(failure.value) == f"ROBOT_PERCEPTION_DATA is {place}, which is not a directory"


@pytest.mark.parametrize("variable", ["ROBOT_PERCEPTION_DATA", "ROBOT_PERCEPTION_CACHE"])
def test_directory_of_somebody_unknown_is_named(room, monkeypatch, variable):
    monkeypatch.setenv(variable, "~nobody-of-that-name/x")
    for function in (find, path, status, fetch):
        with pytest.raises(NotADirectoryError) as failure:
            function("hall")
        expected = f"{variable} is ~nobody-of-that-name/x, whose home is not known"
        assert str(failure.value) == expected


@pytest.mark.parametrize(
    ("name", "content", "state"),
    [
        ("graph.log", TEXT, "present"),
        ("graph.log.gz", gzip.compress(TEXT, compresslevel=1, mtime=7), "present"),
        ("graph.log", TEXT[:-1], "differs"),
        ("graph.log.gz", gzip.compress(TEXT[:-1]), "differs"),
        ("graph.log.gz", gzip.compress(TEXT)[:-9], "differs"),
        ("graph.log.gz", b"not gzip", "differs"),
    ],
)
def test_state_is_that_of_the_content(mine, name, content, state):
    own = put(mine / "hall", name, content)
    put(mine / "hall", "scans.log.gz", PACKED)
    graph, scans = status("hall")
    assert (graph.state, graph.path) == (state, own)
    assert scans.state == "present"


def test_plain_form_of_a_compressed_original_cannot_be_checked(mine):
    own = put(mine / "hall", "scans.log", gzip.decompress(PACKED))
    assert find("hall", "scans.log.gz") == own
    assert status("hall", "scans.log.gz")[0].state == "unchecked"


def test_missing_state(room):
    assert [(item.state, item.path) for item in status("hall")] == [("missing", None)] * 2


def test_cache_is_the_platforms_unless_named(room, monkeypatch):
    assert store.cache_directory() == room.cache
    monkeypatch.delenv(store.CACHE_VARIABLE)
    assert store.cache_directory().name == "robot-perception"
    assert store.cache_directory().is_absolute()
