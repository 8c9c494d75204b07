"""The command line: a table, one set in full, fetching, and one-line errors with exit code 1."""

import pytest
from click.testing import CliRunner

from robot_perception.datasets import store
from robot_perception.datasets.commands import datasets
from tests.datasets.conftest import COMMIT, TEXT, answer_404


def run(*words):
    return CliRunner().invoke(datasets, [*words], prog_name="robot-perception datasets")


def failed(result, code=1):
    """Assert a one-line error without traceback, and return it."""
    assert result.exit_code == code
    assert isinstance(result.exception, SystemExit)
    last = result.stderr.strip().splitlines()[-1]
    assert last.startswith("Error: ")
    assert "Traceback" not in result.output
    return last


def test_list(room, monkeypatch):
    (room.data / "hall").mkdir(parents=True)
    (room.data / "hall" / "graph.log").write_bytes(TEXT)
    monkeypatch.setenv(store.DATA_VARIABLE, str(room.data))
    result = run("list")
    assert result.exit_code == 0
    assert [line.split("  ")[0] for line in result.stdout.splitlines()] == [
        "name",
        "hall",
        "attic",
        "cellar",
    ]
    assert "1 of 2 files present, downloadable" in result.stdout
    assert "missing, 1 downloadable" in result.stdout
    assert "missing, not downloadable" in result.stdout
    (room.data / "hall" / "graph.log").write_bytes(b"my own")
    assert "1 of 2 files present, 1 with another hash" in run("list").stdout


def test_info(room):
    text = run("info", "hall").stdout
    assert text.startswith("hall: A hall\nCite: Somebody 2003\nTerms: MIT\n")
    assert "graph.log.gz: missing, downloadable" in text
    assert f"/some/where/{COMMIT}/data/a%20graph.log" in text
    lost = run("info", "attic").stdout
    assert "lost.log: missing, not downloadable" in lost
    assert "made from a rawlog" in lost


def test_info_of_something_unknown(room):
    assert "no data set 'hal'; did you mean 'hall'?" in failed(run("info", "hal"))


def test_fetch(room, server):
    result = run("fetch", "hall", "--address", server.address)
    assert result.exit_code == 0, result.output
    assert result.stdout == "hall: present\n"
    assert "100%" in result.stderr
    assert "graph.log.gz: present, " in run("info", "hall").stdout


def test_fetch_all_passes_over_what_cannot_be_downloaded(room, server):
    result = run("fetch", "--all", "--address", server.address)
    assert result.exit_code == 0, result.output
    assert result.stdout.splitlines() == [
        "hall: present",
        "attic: 1 of 2 files present, not downloadable",
        "cellar: missing, not downloadable",
    ]


def test_fetch_of_what_cannot_be_downloaded(room):
    assert "lost.log has no pinned address" in failed(run("fetch", "cellar"))


def test_fetch_failing(room, server):
    server.answer = answer_404
    error = failed(run("fetch", "hall", "--address", server.address))
    assert "hall/graph.log.gz: download from" in error
    assert error.endswith("failed: the server answered 404 Not Found")


@pytest.mark.parametrize("words", [(), ("hall", "--all")])
def test_fetch_wants_names_or_all(room, words):
    assert "names of data sets, or --all" in failed(run("fetch", *words), code=2)
