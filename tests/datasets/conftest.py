"""A small registry, an empty data directory and cache, and a server that can fail in many ways."""

import gzip
import hashlib
import socket
import threading
import time
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import MappingProxyType, SimpleNamespace

import pytest

from robot_perception.datasets import commands, entries, store
from robot_perception.datasets.entries import DataFile, Dataset, Origin

TEXT = b"".join(b"VERTEX2 %d 0 0 0\n" % number for number in range(20_000))
PACKED = gzip.compress(b"FLASER\n" * 5000)
STORED = gzip.compress(TEXT)
COMMIT = "0123456789" * 4


def sha(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


@pytest.fixture
def room(tmp_path, monkeypatch):
    """Return the small registry's names, with neither data directory nor cached files."""
    graph = DataFile(
        name="graph.log.gz",
        sha256=sha(STORED),
        bytes=len(STORED),
        copy="gzip",
        origin=Origin("some/where", COMMIT, "data/a graph.log"),
        content_sha256=sha(TEXT),
        content_bytes=len(TEXT),
    )
    packed = DataFile(
        name="scans.log.gz",
        sha256=sha(PACKED),
        bytes=len(PACKED),
        copy="as is",
        origin=Origin("some/where", COMMIT, "data/scans.log.gz"),
    )
    lost = DataFile("lost.log", sha(b"lost"), 4, "converted", made_from="made from a rawlog")
    sets = (
        Dataset("hall", "A hall", "MIT", "MIT", "Somebody 2003", (graph, packed)),
        Dataset("attic", "An attic", "BSD", "BSD", "Somebody else", (lost, packed)),
        Dataset("cellar", "A cellar", "BSD", "BSD", "Nobody", (lost,)),
    )
    known = MappingProxyType({entry.name: entry for entry in sets})
    for module in (commands, entries, store):
        monkeypatch.setattr(module, "registry", lambda: known)
    monkeypatch.setenv(store.CACHE_VARIABLE, str(tmp_path / "cache"))
    monkeypatch.delenv(store.DATA_VARIABLE, raising=False)
    for name in ("http_proxy", "HTTP_PROXY", "all_proxy", "ALL_PROXY"):
        monkeypatch.delenv(name, raising=False)
    return SimpleNamespace(cache=tmp_path / "cache", data=tmp_path / "data", text=TEXT)


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


def whole(handler: Handler) -> None:
    handler.send(PACKED if handler.path.endswith(".gz") else TEXT)


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


@pytest.fixture
def closed_port() -> int:
    """Return a port nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def answer_404(handler: Handler) -> None:
    handler.send(b"Not Found", status=404)
