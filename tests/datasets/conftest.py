"""A small registry, an empty data directory and cache, and a server that can fail in many ways."""

import gzip
import hashlib
import io
import json
import socket
import tarfile
import threading
import time
import zipfile
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import SimpleNamespace

import pytest

from robot_perception.datasets import entries, store

TEXT = b"".join(b"VERTEX2 %d 0 0 0\n" % number for number in range(20_000))
PACKED = gzip.compress(b"FLASER\n" * 5000, mtime=0)
PICTURES = {f"img/{number:04}.png": b"picture %d" % number for number in range(300)}


def zipped(files: dict[str, bytes]) -> bytes:
    with zipfile.ZipFile(file := io.BytesIO(), "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return file.getvalue()


def tarred(files: dict[str, bytes]) -> bytes:
    with tarfile.open(fileobj=(file := io.BytesIO()), mode="w:gz") as archive:
        for name, content in files.items():
            entry = tarfile.TarInfo(name)
            entry.size = len(content)
            archive.addfile(entry, io.BytesIO(content))
    return file.getvalue()


ALBUM, SLIDES = zipped(PICTURES), tarred(PICTURES)


def sha(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def write_registry(folder, sets: dict[str, dict], lines: list[str]) -> None:
    """Write a registry: tables by name, and lines of pooch's format."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "sets.toml").write_text(
        "".join(
            f"[{name}]\n" + "".join(f"{key} = {json.dumps(table[key])}\n" for key in table)
            for name, table in sets.items()
        )
    )
    (folder / "registry.txt").write_text("\n".join(["# a comment", *lines, ""]))


@pytest.fixture
def room(tmp_path, monkeypatch, server):
    """Return a small registry's folders, with neither data directory nor cached files."""
    about = {"licence": "MIT", "origin": "Somebody 2003", "bytes": 440_000}
    sets = {
        "hall": {"title": "A hall"} | about,
        "attic": {"title": "An attic", "note": "lost.log was made from a rawlog."} | about,
        "cellar": {"title": "A cellar", "note": "lost.log was made from a rawlog."} | about,
        "album": {"title": "Pictures", "members": 300} | about,
        "slides": {"title": "The same", "members": 300} | about,
    }
    base = f"{server.address}/some/where"
    lines = [
        f"hall/graph.log {sha(TEXT)} '{base}/a%20graph.log'",
        f"hall/scans.log.gz {sha(PACKED)} {base}/scans.log.gz",
        f"attic/lost.log {sha(b'lost')}",
        f"attic/scans.log.gz {sha(PACKED)} {base}/scans.log.gz",
        f"cellar/lost.log {sha(b'lost')}",
        f"album/pictures.zip {sha(ALBUM)} {base}/pictures.zip",
        f"slides/pictures.tar.gz {sha(SLIDES)} {base}/pictures.tar.gz",
    ]
    write_registry(tmp_path / "book", sets, lines)
    monkeypatch.setattr(entries, "BOOK", tmp_path / "book")
    monkeypatch.setenv(store.CACHE_VARIABLE, str(tmp_path / "cache"))
    monkeypatch.delenv(entries.DATA_VARIABLE, raising=False)
    for name in ("http_proxy", "HTTP_PROXY", "all_proxy", "ALL_PROXY"):
        monkeypatch.delenv(name, raising=False)
    return SimpleNamespace(
        book=tmp_path / "book", cache=tmp_path / "cache", data=tmp_path / "data", url=base
    )


@pytest.fixture
def mine(room, monkeypatch):
    """Return the user's directory."""
    room.data.mkdir()
    monkeypatch.setenv(entries.DATA_VARIABLE, str(room.data))
    return room.data


def put(folder, name, content=b"x"):
    """Write a file, with the folders above it, and return its path."""
    (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / name).write_bytes(content)
    return folder / name


class Handler(BaseHTTPRequestHandler):
    """Answers as the test says."""

    protocol_version = "HTTP/1.1"

    def do_GET(self):
        self.server.asked.append(self.path)
        self.server.answer(self)

    def log_message(self, *_args):
        pass

    def send(self, content: bytes, *, status: int = 200, announced: int | None = None):
        """Send a whole answer, announcing perhaps another length, and hang up."""
        self.send_response(status)
        self.send_header("Content-Length", str(len(content) if announced is None else announced))
        self.end_headers()
        self.wfile.write(content)
        self.close_connection = True


CONTENT = {"a%20graph.log": TEXT, "scans.log.gz": PACKED, "pictures.zip": ALBUM,
           "pictures.tar.gz": SLIDES}  # fmt: skip


def whole(handler: Handler) -> None:
    handler.send(CONTENT[handler.path.rpartition("/")[2]])


@pytest.fixture
def server():
    """A real server on the loopback device; set ``server.answer`` to make it fail."""
    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as listening:
        listening.daemon_threads = True
        listening.answer = whole
        listening.asked = []
        listening.address = f"http://127.0.0.1:{listening.server_port}"
        thread = threading.Thread(target=listening.serve_forever, args=(0.02,))
        thread.start()
        yield listening
        listening.shutdown()
        thread.join()


def in_chunks(handler: Handler) -> None:
    """Send the text chunked, without saying how long it is, and stop in the middle."""
    handler.send_response(200)
    handler.send_header("Transfer-Encoding", "chunked")
    handler.end_headers()
    handler.wfile.write(b"%x\r\n%s\r\n" % (1000, TEXT[:1000]))
    handler.close_connection = True


def reset(handler: Handler) -> None:
    """Send half, then reset the connection as a crashing server would."""
    handler.send_response(200)
    handler.send_header("Content-Length", str(len(TEXT)))
    handler.end_headers()
    handler.wfile.write(TEXT[: len(TEXT) // 2])
    handler.wfile.flush()
    linger = b"\x01\x00\x00\x00\x00\x00\x00\x00"
    handler.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, linger)
    handler.close_connection = True
    handler.connection.close()


def silent_from(sent: int) -> Callable[[Handler], None]:
    """Return an answer that falls silent after so many bytes of text, and holds the line."""

    def answer(handler: Handler) -> None:
        if sent:
            handler.send_response(200)
            handler.send_header("Content-Length", str(len(TEXT)))
            handler.end_headers()
            handler.wfile.write(TEXT[:sent])
            handler.wfile.flush()
        time.sleep(1.5)
        handler.close_connection = True

    return answer


def answer_404(handler: Handler) -> None:
    handler.send(b"Not Found", status=404)
