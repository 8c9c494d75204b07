"""The command line prints the recorded ledger, as a table and as JSON, and recomputes it."""

import json

import pytest
from click.testing import CliRunner

from robot_perception import chapters
from robot_perception.cli import main
from robot_perception.teaching.records import records

FIELDS = {
    "id",
    "paper",
    "place",
    "statement",
    "paper_value",
    "method",
    "accepted",
    "accepted_why",
    "seed",
    "verdict",
    "value",
    "conditions",
}


@pytest.fixture
def run():
    return lambda *words: CliRunner().invoke(main, words)


def test_table_has_a_line_per_claim(run):
    result = run("claims")
    assert result.exit_code == 0
    for claim in chapters.claims():
        assert any(line.startswith(f"{claim.id} ") for line in result.output.splitlines())


def test_json_is_valid_and_has_the_fields_of_the_ledger(run):
    document = json.loads(run("claims", "--json").output, parse_constant=pytest.fail)
    assert {"date", "versions", "claims"} <= set(document)
    for row in document["claims"]:
        assert set(row) >= FIELDS
        assert {"estimate", "low", "high", "unit", "about"} == set(row["value"])


def test_one_chapter_is_recomputed_and_written(run, tmp_path, monkeypatch):
    claims = [c for c in chapters.claims(("monobot",)) if c.id == "fisher-one-landmark"]
    monkeypatch.setattr(chapters, "claims", lambda chapters: tuple(claims))
    file = tmp_path / "claims.json"
    result = run("claims", "--run", "quick", "--chapter", "monobot", "--write", str(file))
    assert result.exit_code == 0, result.output
    assert [row["id"] for row in json.loads(file.read_text())["claims"]] == ["fisher-one-landmark"]


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("claims", "--chapter", "kitchen"), "no chapter 'kitchen'"),
        (("claims", "--run", "huge"), "'huge' is not one of"),
        (("store", "--chapter", "kitchen"), "no chapter 'kitchen'"),
    ],
)
def test_wrong_words_are_named(run, words, says):
    result = run(*words)
    assert result.exit_code != 0
    assert says in result.output
    assert "Traceback" not in result.output


def test_store_keeps_results_whose_recording_is_not_here(run, tmp_path, monkeypatch):
    monkeypatch.setenv("ROBOT_PERCEPTION_DATA", str(tmp_path))
    monkeypatch.setenv("ROBOT_PERCEPTION_CACHE", str(tmp_path))
    before = (records() / "monobot-corridor.json").read_bytes()
    result = run("store", "--chapter", "monobot")
    assert result.exit_code == 0
    assert "monobot-corridor: kept as it is" in result.output
    assert (records() / "monobot-corridor.json").read_bytes() == before
