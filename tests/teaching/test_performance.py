"""The benchmark page shows what was recorded, row by row, and says what was not reached."""

import json

import pytest

from robot_perception.teaching import performance
from robot_perception.teaching.performance import duration, performance_table, times


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(12.34, "12.3 s"), (0.0358, "35.8 ms"), (6.56e-6, "6.56 µs"), (3.1e-8, "31 ns"), (1, "1 s")],
)
def test_durations_in_the_unit_that_suits(seconds, text):
    assert duration(seconds) == text


@pytest.mark.parametrize(("ratio", "text"), [(1114.2, "1114×"), (9.968, "9.97×"), (0.69, "0.69×")])
def test_ratios_are_never_powers_of_ten(ratio, text):
    assert times(ratio) == text


def test_table_shows_every_row_and_names_what_is_missed(tmp_path, monkeypatch):
    rows = [
        {"work": "a <scan>", "ours_s": 6e-6, "peer": "fastrdp", "peer_s": 4e-6, "ratio": 0.67}
        | {"target": "≥ 0.5× fastrdp", "reached": True},
        {"work": "a page", "ours_s": 0.2, "peer": "", "peer_s": None, "ratio": None}
        | {"target": "≤ 100 ms", "reached": False},
        {"work": "a map", "ours_s": 2.0, "peer": "one", "peer_s": 1.0, "ratio": 0.5}
        | {"target": "≥ 1×", "reached": False},
    ]
    record = {"date": "2026-01-01", "machine": "a & b", "versions": {"numpy": "2"}, "rows": rows}
    (tmp_path / "performance.json").write_text(json.dumps(record))
    monkeypatch.setattr(performance, "records", lambda: tmp_path)
    shown = performance_table()
    html = shown.bundle["text/html"]
    assert "a &lt;scan&gt;" in html
    assert "a &amp; b" in html
    assert html.count("<strong>no</strong>") == 2
    assert repr(shown) == "1 of 3 targets reached on 2026-01-01"


def test_nothing_recorded_is_a_clear_error(tmp_path, monkeypatch):
    monkeypatch.setattr(performance, "records", lambda: tmp_path)
    with pytest.raises(FileNotFoundError, match=r"performance\.json"):
        performance_table()
