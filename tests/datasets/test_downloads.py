"""Downloads from a real server: whole and right, or nothing and a clear error."""

import errno
import gzip
import os
from pathlib import Path

import pytest

from robot_perception.datasets import (
    DatasetMissing,
    DownloadError,
    fetch,
    find,
    path,
    status,
    store,
)
from tests.datasets import conftest
from tests.datasets.conftest import COMMIT, PACKED, TEXT


def leftovers(room) -> list[str]:
    return sorted(file.name for file in room.cache.rglob("*") if file.is_file())


def test_fetched_files_are_whole_under_their_names(room, server):
    graph, scans = fetch("hall", address=server.address)
    assert graph == room.cache / "hall" / "graph.log.gz"
    assert gzip.decompress(graph.read_bytes()) == TEXT
    assert scans.read_bytes() == PACKED
    assert leftovers(room) == ["graph.log.gz", "scans.log.gz"]
    assert server.asked == [
        f"/some/where/{COMMIT}/data/a%20graph.log",
        f"/some/where/{COMMIT}/data/scans.log.gz",
    ]
    assert find("hall") == room.cache / "hall"
    assert [item.state for item in status("hall")] == ["present", "present"]


def test_what_is_there_is_not_asked_for_again(room, server):
    first = fetch("hall", address=server.address)
    assert fetch("hall", address=server.address) == first
    assert len(server.asked) == 2


def test_one_file_alone(room, server):
    (scans,) = fetch("hall", "scans.log", address=server.address)
    assert scans.read_bytes() == PACKED
    assert find("hall") is None
    assert find("hall", "scans.log.gz") == scans
    assert find("hall", "graph.log.gz") is None


def test_changed_cached_file_is_replaced(room, server):
    (graph,) = fetch("hall", "graph.log.gz", address=server.address)
    graph.write_bytes(b"garbage")
    assert status("hall")[0].state == "differs"
    assert fetch("hall", "graph.log.gz", address=server.address) == (graph,)
    assert status("hall")[0].state == "present"


def test_changed_cached_file_stays_until_the_new_one_is_whole(room, server):
    (graph,) = fetch("hall", "graph.log.gz", address=server.address)
    graph.write_bytes(b"garbage")
    server.answer = conftest.in_chunks
    with pytest.raises(DownloadError):
        fetch("hall", "graph.log.gz", address=server.address)
    assert graph.read_bytes() == b"garbage"
    assert leftovers(room) == ["graph.log.gz"]


def test_file_of_the_users_is_taken_as_it_is(room, server, monkeypatch):
    (room.data / "hall").mkdir(parents=True)
    (room.data / "hall" / "graph.log").write_bytes(b"my own")
    monkeypatch.setenv(store.DATA_VARIABLE, str(room.data))
    graph, scans = fetch("hall", address=server.address)
    assert graph == room.data / "hall" / "graph.log"
    assert scans.parent == room.cache / "hall"
    assert len(server.asked) == 1
    with pytest.raises(DatasetMissing, match=r"partly in .* ask for them one by one"):
        path("hall")


def test_path_downloads_only_when_told(room, monkeypatch, server):
    monkeypatch.setattr(store, "fetch", lambda *a, **k: fetch(*a, address=server.address, **k))
    with pytest.raises(DatasetMissing):
        path("hall", "graph.log.gz")
    assert server.asked == []
    assert path("hall", "graph.log.gz", download=True) == room.cache / "hall" / "graph.log.gz"
    assert path("hall", download=True) == room.cache / "hall"


def test_what_cannot_be_downloaded_is_named_after_the_rest_was_fetched(room, server):
    with pytest.raises(DatasetMissing, match=r"lost\.log has no pinned address .* a rawlog"):
        fetch("attic", address=server.address)
    assert leftovers(room) == ["scans.log.gz"]


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
    "wrong content": (answered(TEXT[:-1] + b"x"), "what came has sha256"),
    "short content, short length": (answered(TEXT[:70_000]), "what came has sha256"),
    "empty content": (answered(b""), "what came has sha256"),
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
        fetch("hall", "graph.log.gz", address=server.address, timeout=0.3)
    error, address = failure.value, f"{server.address}/some/where/{COMMIT}/data/a%20graph.log"
    assert (error.dataset, error.file, error.address) == ("hall", "graph.log.gz", address)
    assert cause in error.cause
    assert str(error) == f"hall/graph.log.gz: download from {address} failed: {error.cause}"
    assert "\n" not in str(error)
    assert leftovers(room) == []
    assert find("hall", "graph.log.gz") is None
    server.answer = conftest.whole
    (graph,) = fetch("hall", "graph.log.gz", address=server.address)
    assert gzip.decompress(graph.read_bytes()) == TEXT


def test_no_network(room, closed_port):
    with pytest.raises(DownloadError, match=r"no connection to the server \(is there a network"):
        fetch("hall", address=f"http://127.0.0.1:{closed_port}")
    assert leftovers(room) == []


def test_nonsensical_address(room):
    with pytest.raises(DownloadError, match="the request failed"):
        fetch("hall", address="gopher://127.0.0.1")
    assert leftovers(room) == []


class Filling:
    """A file on a disk that is full after so many bytes."""

    def __init__(self, stream, room):
        self.stream, self.room = stream, room

    def __enter__(self):
        return self

    def __exit__(self, *_error):
        self.stream.close()

    def write(self, content):
        self.room -= self.stream.write(content[: self.room])
        if self.room <= 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    def flush(self):
        self.stream.flush()


def test_no_space_left(room, server, monkeypatch):
    opened = Path.open
    with monkeypatch.context() as patch:
        patch.setattr(Path, "open", lambda self, mode: Filling(opened(self, mode), 100_000))
        with pytest.raises(DownloadError, match=r"no space left in .*cache"):
            fetch("hall", "graph.log.gz", address=server.address)
    assert leftovers(room) == []
    fetch("hall", "graph.log.gz", address=server.address)
    assert leftovers(room) == ["graph.log.gz"]


def test_no_space_left_when_compressing(room, server, monkeypatch):
    def full(self, content):
        with self.open("wb") as stream:
            stream.write(content[:100])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(Path, "write_bytes", full)
    with pytest.raises(DownloadError, match="no space left"):
        fetch("hall", "graph.log.gz", address=server.address)
    assert leftovers(room) == []


def test_cache_that_cannot_be_written(room, server):
    room.cache.write_text("a file where the folder should be")
    with pytest.raises(DownloadError, match="cannot be written"):
        fetch("hall", address=server.address)
    assert server.asked == []


def test_interruption_by_the_user_leaves_nothing(room, server, monkeypatch):
    def interrupted(*_args):
        raise KeyboardInterrupt

    monkeypatch.setattr(store.pooch, "file_hash", interrupted)
    with pytest.raises(KeyboardInterrupt):
        fetch("hall", "graph.log.gz", address=server.address)
    assert leftovers(room) == []


def test_progress_is_shown_on_request_only(room, server, capsys):
    fetch("hall", "scans.log.gz", address=server.address)
    assert capsys.readouterr() == ("", "")
    fetch("hall", "graph.log.gz", address=server.address, progress=True)
    out, err = capsys.readouterr()
    assert out == ""
    assert "hall/graph.log.gz" in err
    assert "100%" in err
