"""Downloads from a real server: whole and right, or nothing and a clear error."""

import errno
import os
from pathlib import Path

import pooch
import pytest

from robot_perception.datasets import DatasetMissing, DownloadError, fetch, find, path, status
from tests.datasets import conftest
from tests.datasets.conftest import ALBUM, PACKED, PICTURES, TEXT, put, sha


def leftovers(room) -> list[str]:
    return sorted(file.name for file in room.cache.rglob("*") if file.is_file())


def test_fetched_files_are_whole_under_their_names(room, server):
    graph, scans = fetch("hall")
    assert graph == room.cache / "hall" / "graph.log"
    assert graph.read_bytes() == TEXT
    assert scans.read_bytes() == PACKED
    assert leftovers(room) == ["graph.log", "scans.log.gz"]
    assert server.asked == ["/some/where/a%20graph.log", "/some/where/scans.log.gz"]
    assert find("hall") == room.cache / "hall"
    assert [item.state for item in status("hall")] == ["present", "present"]


def test_what_is_there_is_not_asked_for_again(room, server):
    first = fetch("hall")
    assert fetch("hall") == first
    assert len(server.asked) == 2


def test_one_file_alone(room):
    (scans,) = fetch("hall", "scans.log")
    assert scans.read_bytes() == PACKED
    assert find("hall") is None
    assert find("hall", "scans.log.gz") == scans
    assert find("hall", "graph.log") is None


def test_changed_cached_file_is_replaced(room):
    (graph,) = fetch("hall", "graph.log")
    graph.write_bytes(b"garbage")
    assert status("hall")[0].state == "differs"
    assert fetch("hall", "graph.log") == (graph,)
    assert status("hall")[0].state == "present"


def test_changed_cached_file_stays_until_the_new_one_is_whole(room, server):
    (graph,) = fetch("hall", "graph.log")
    graph.write_bytes(b"garbage")
    server.answer = conftest.in_chunks
    with pytest.raises(DownloadError):
        fetch("hall", "graph.log")
    assert graph.read_bytes() == b"garbage"
    assert leftovers(room) == ["graph.log"]


def test_file_of_the_users_is_taken_as_it_is(room, server, mine):
    own = put(mine, "hall/graph.log.gz", b"my own")
    graph, scans = fetch("hall")
    assert graph == own
    assert scans.parent == room.cache / "hall"
    assert len(server.asked) == 1
    with pytest.raises(DatasetMissing, match=r"partly in .* ask for them one by one"):
        path("hall")


def test_path_downloads_only_when_told(room, server):
    with pytest.raises(DatasetMissing):
        path("hall", "graph.log")
    assert server.asked == []
    assert path("hall", "graph.log", download=True) == room.cache / "hall" / "graph.log"
    assert path("hall", download=True) == room.cache / "hall"


def test_what_cannot_be_downloaded_is_named_after_the_rest_was_fetched(room):
    with pytest.raises(DatasetMissing, match=r"lost\.log is not downloadable: .* a rawlog"):
        fetch("attic")
    assert leftovers(room) == ["scans.log.gz"]


# ---- archives ------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "archive"), [("album", "zip"), ("slides", "tar.gz")])
def test_archive_is_unpacked_into_its_hundreds_of_files(room, server, name, archive):
    assert find(name) is None
    assert status(name)[0].state == "missing"
    files = fetch(name)
    assert {place.relative_to(room.cache / name).as_posix(): place.read_bytes() for place in files}\
        == PICTURES  # fmt: skip
    assert find(name) == room.cache / name
    assert find(name, "img/0299.png") == files[-1]
    assert find(name, "img/0300.png") is None
    (item,) = status(name)
    assert (item.state, item.path) == ("present", room.cache / name / f"pictures.{archive}")
    assert fetch(name) == files
    assert len(server.asked) == 1


def test_archive_with_a_file_lost_is_unpacked_again_without_asking(room, server):
    files = fetch("album")
    files[7].unlink()
    assert find("album") is None
    assert fetch("album") == files
    assert len(server.asked) == 1


@pytest.mark.parametrize(
    ("name", "class_", "archive"),
    [("album", "zipfile.ZipFile", "zip"), ("slides", "tarfile.TarFile", "tar.gz")],
)
def test_unpacking_that_is_interrupted_leaves_no_half_of_a_file(
    room, server, monkeypatch, name, class_, archive
):
    def interrupted(packed, folder, **options) -> None:
        put(Path(folder), "img/0000.png", b"half")
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(f"{class_}.extractall", interrupted)
        with pytest.raises(KeyboardInterrupt):
            fetch(name)
    assert leftovers(room) == [f"pictures.{archive}"]
    assert find(name) is None
    assert len(fetch(name)) == 300
    assert len(server.asked) == 1


def test_unpacked_folder_of_the_users_is_taken_as_it_is(room, server, mine):
    for name, content in PICTURES.items():
        put(mine / "album", name, content)
    assert find("album") == mine / "album"
    assert len(fetch("album")) == 300
    assert status("album")[0].state == "unchecked"
    assert server.asked == []
    with pytest.raises(DatasetMissing, match=r"pictures\.zip of album holds no img/0300\.png"):
        path("album", "img/0300.png")


def test_archive_with_another_number_of_files_is_refused(room, server):
    smaller = conftest.zipped({"a.png": b"a"})
    registry = room.book / "registry.txt"
    registry.write_text(registry.read_text().replace(sha(ALBUM), sha(smaller)))
    server.answer = lambda handler: handler.send(smaller)
    with pytest.raises(DownloadError, match="it holds 1 files, registered are 300"):
        fetch("album")


def test_archive_that_is_none_is_named(room, server):
    registry = room.book / "registry.txt"
    registry.write_text(registry.read_text().replace(sha(ALBUM), sha(b"no archive")))
    server.answer = lambda handler: handler.send(b"no archive")
    with pytest.raises(DownloadError, match=r"album/pictures\.zip: .* failed: File is not a zip"):
        fetch("album")


def test_archive_that_is_encrypted_is_named(room, server):
    locked = ALBUM.replace(b"PK\1\2\x14\3\x14\0\0", b"PK\1\2\x14\3\x14\0\1")
    assert locked != ALBUM
    registry = room.book / "registry.txt"
    registry.write_text(registry.read_text().replace(sha(ALBUM), sha(locked)))
    server.answer = lambda handler: handler.send(locked)
    with pytest.raises(DownloadError, match=r"album/pictures\.zip: .* failed: .*encrypted"):
        fetch("album")
    assert leftovers(room) == ["pictures.zip"]


def test_what_a_kill_has_left_of_unpacking_is_no_part_of_the_recording(room):
    fetch("album")
    for file in list((room.cache / "album/img").iterdir())[:150]:
        put(room.cache / "album/.unfinished-a1b2c3d4/img", file.name)
        file.unlink()
    assert find("album") is None
    assert len(fetch("album")) == 300
    assert find("album") == room.cache / "album"


@pytest.mark.parametrize("name", ["hall", "album"])
def test_what_a_kill_would_leave_of_a_download_is_hidden(room, server, name):
    """A kill leaves what is there while the server sends: nothing that counts as a file of it."""

    def seen(handler) -> None:
        every = (file.relative_to(room.cache) for file in room.cache.rglob("*") if file.is_file())
        there.append(sorted(place.parts[1] for place in every))
        conftest.whole(handler)

    there, server.answer = [], seen
    fetch(name)
    (hidden,) = there[0]
    assert hidden.startswith(".unfinished-")
    assert not list(room.cache.rglob(".unfinished-*"))


# ---- failures ------------------------------------------------------------------------------------


def answered(content, **options):
    return lambda handler: handler.send(content, **options)


FAILURES = {
    "server hangs up early": (
        answered(TEXT[:70_000], announced=len(TEXT)),
        "the transfer was interrupted before the end",
    ),
    "server hangs up at once": (
        answered(b"", announced=len(TEXT)),
        "the transfer was interrupted before the end",
    ),
    "chunks end early": (conftest.in_chunks, "the transfer was interrupted before the end"),
    "connection reset": (conftest.reset, "the transfer was interrupted before the end"),
    "wrong content": (answered(TEXT[:-1] + b"x"), "does not match the known hash"),
    "short content, short length": (answered(TEXT[:70_000]), "does not match the known hash"),
    "empty content": (answered(b""), "does not match the known hash"),
    "404": (answered(b"Not Found", status=404), "the server answered 404 Not Found"),
    "500": (answered(b"", status=500), "the server answered 500 Internal Server Error"),
    "429": (answered(b"", status=429), "the server answered 429 Too Many Requests"),
    "silence": (conftest.silent_from(0), "the server said nothing for 0.3 s"),
    "silence in the middle": (conftest.silent_from(70_000), "the server said nothing for 0.3 s"),
}


@pytest.mark.parametrize(("answer", "cause"), FAILURES.values(), ids=FAILURES)
def test_failure_is_named_and_leaves_nothing_and_a_retry_succeeds(room, server, answer, cause):
    server.answer = answer
    with pytest.raises(DownloadError) as failure:
        fetch("hall", "graph.log", timeout=0.3)
    told = str(failure.value)
    assert told.startswith(f"hall/graph.log: download from {room.url}/a%20graph.log failed: ")
    assert cause in told
    assert "\n" not in told
    assert leftovers(room) == []
    assert find("hall", "graph.log") is None
    server.answer = conftest.whole
    (graph,) = fetch("hall", "graph.log")
    assert graph.read_bytes() == TEXT


def with_address(room, address):
    registry = room.book / "registry.txt"
    registry.write_text(registry.read_text().replace(room.url, address))


def test_no_network(room):
    with conftest.socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        closed = probe.getsockname()[1]
    with_address(room, f"http://127.0.0.1:{closed}")
    with pytest.raises(DownloadError, match=r"no connection to the server \(is there a network"):
        fetch("hall")
    assert leftovers(room) == []


def test_nonsensical_address(room):
    with_address(room, "gopher://127.0.0.1")
    with pytest.raises(DownloadError, match="the request failed"):
        fetch("hall")
    assert leftovers(room) == []


def interrupting(error):
    """Return a downloader's way to write half of the file and fail."""

    def download(_self, _url, output_file, _pooch, **_options):
        with open(output_file, "wb") as stream:
            stream.write(TEXT[:70_000])
        raise error

    return download


def test_no_space_left(room, monkeypatch):
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    with monkeypatch.context() as patch:
        patch.setattr(pooch.HTTPDownloader, "__call__", interrupting(full))
        with pytest.raises(DownloadError, match=r"no space left in .*cache"):
            fetch("hall", "graph.log")
    assert leftovers(room) == []
    fetch("hall", "graph.log")
    assert leftovers(room) == ["graph.log"]


def test_cache_that_cannot_be_written(room, server):
    room.cache.write_text("a file where the folder should be")
    with pytest.raises(DownloadError, match="cannot be written"):
        fetch("hall")
    assert server.asked == []


def test_interruption_by_the_user_leaves_nothing(room, monkeypatch):
    monkeypatch.setattr(pooch.HTTPDownloader, "__call__", interrupting(KeyboardInterrupt()))
    with pytest.raises(KeyboardInterrupt):
        fetch("hall", "graph.log")
    assert leftovers(room) == []


def test_progress_is_shown_on_request_only(room, capsys, caplog):
    logger = pooch.get_logger()  # which stands outside the tree of loggers
    level = logger.level
    logger.addHandler(caplog.handler)
    try:
        fetch("hall", "scans.log.gz")
    finally:
        logger.removeHandler(caplog.handler)
    assert logger.level == level
    assert caplog.records == []
    assert capsys.readouterr() == ("", "")
    fetch("hall", "graph.log", progress=True)
    out, err = capsys.readouterr()
    assert out == ""
    assert "hall" in err
    assert "100%" in err
