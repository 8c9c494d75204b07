"""The benchmark page shows what was recorded, row by row, and says what was missed."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from matplotlib.text import Annotation

from robot_perception.teaching.scores import performance
from robot_perception.teaching.scores.performance import Record, duration, times
from studies.files import DamagedFile

FAST = "median ≤ 100 ms, none above 500 ms"


def row(work, ours, peer="", peer_s=None, target="–", reached=True):
    ratio = None if peer_s is None else peer_s / ours
    times = {"ours_s": ours, "peer": peer, "peer_s": peer_s, "ratio": ratio}
    return {"work": work, **times, "target": target, "reached": reached}


ROWS = [
    row("walls, Step, in JupyterLab (16 moves, longest 90 ms)", 0.05, target=FAST),
    row("walls, Step, built page (16 moves, longest 3 ms)", 0.004, target="median ≤ 50 ms, none"),
    row("simplify a <scan>", 6e-6, "fastrdp", 4e-6, "≥ 0.75× fastrdp", reached=False),
    row("planar EKF-SLAM, 20 steps", 2e-3, "filterpy", 0.3, "≥ 9× filterpy"),
    row("planar EKF-SLAM, 20 steps", 2e-3, "toolbox", 0.1),
    row("path hulls: exponent 1.02", 0.09, target="exponent ≤ 1.35"),
]


@pytest.fixture
def store(tmp_path, monkeypatch):
    """Return a function that records rows."""
    monkeypatch.setattr(performance, "records", lambda: tmp_path)

    def write(rows):
        plain = {"date": "2026-01-01", "machine": "a & b", "versions": {"numpy": "2"}}
        performance.write(plain | {"rows": rows}, tmp_path / "performance.json")
        return Record.read()

    return write


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(12.34, "12.3 s"), (0.0358, "35.8 ms"), (6.56e-6, "6.56 µs"), (3.1e-8, "31 ns"), (1, "1 s")],
)
def test_durations_in_the_unit_that_suits(seconds, text):
    assert duration(seconds) == text


@pytest.mark.parametrize(("ratio", "text"), [(1114.2, "1114×"), (9.968, "9.97×"), (0.69, "0.69×")])
def test_ratios_are_never_powers_of_ten(ratio, text):
    assert times(ratio) == text


def test_work_is_found_by_how_its_words_begin(store):
    record = store(ROWS)
    for work in record.work:
        assert record.find(work.work[:-1]).ours_s == work.ours_s
    with pytest.raises(LookupError, match="no row 'legs'"):
        record.find("legs")


def test_where_and_when_and_how_many_targets_were_reached(store):
    shown = store(ROWS).about()
    assert repr(shown) == "5 of 6 targets reached on 2026-01-01"
    assert "a &amp; b" in shown.bundle["text/html"]


def test_tables_by_theme_show_every_row_and_name_what_is_missed(store):
    shown = store(ROWS).tables()
    after = shown.bundle["text/html"].split("<h3>Planar EKF-SLAM</h3>")[1]
    planar, lines, *others = after.split("<h3>")
    assert planar.count("<tr>") == 3
    assert lines.startswith("Simplifying a line</h3>")
    assert lines.count("<tr>") == 3
    assert [theme.count("<tr>") for theme in others] == [1, 1, 1, 1, 1, 1]  # no work, and the head
    assert "a &lt;scan&gt;" in lines
    assert '<td data-name="Ratio"><strong>0.667×</strong></td>' in lines
    assert '<td data-name="Target">≥ 0.75× <strong>missed</strong></td>' in lines
    assert '<td data-name="Target">exponent ≤ 1.35</td>' in lines
    assert (planar + lines).count("missed") == 1
    assert "JupyterLab" not in planar + lines
    assert repr(shown).splitlines()[0] == "simplify a <scan>: 6 µs, 0.667× against fastrdp"


def test_the_themes_count_their_work_and_its_peers(store):
    themes = store(ROWS).themes()
    assert themes.rows == {
        "The robot on a line": (0, 0),
        "Planar EKF-SLAM": (2, 2),
        "Simplifying a line": (2, 1),
        "Pictures": (0, 0),
        "Particles": (0, 0),
        "Fusion and people": (0, 0),
        "Patterns on a ceiling": (0, 0),
        "The tutor": (0, 0),
        "Two arms": (0, 0),
    }


def test_work_without_a_theme_is_a_clear_error(store):
    with pytest.raises(ValueError, match="'monobot', 'planar'"):
        store([row("cooking an egg", 300.0)]).tables()


def points(ax):
    """Return the places of the round marks of a picture, from top to bottom."""
    marks = [line.get_xydata() for line in ax.lines if line.get_marker() == "o"]
    return np.array(sorted((y, x) for places in marks for x, y in places))


def test_picture_has_each_ratio_once_inside_the_axes_and_its_target(store):
    (ax,) = performance.draw_ratios(store(ROWS)).axes
    found = points(ax)
    np.testing.assert_allclose(found[:, 1], [150, 50, 2 / 3])
    targets = [line.get_xdata()[0] for line in ax.lines if line.get_marker() == "|"]
    np.testing.assert_allclose(targets, [9, 0.75])
    low, high = ax.get_xlim()
    assert low < min(*targets, *found[:, 1], 1)
    assert max(found[:, 1]) < high
    words = [text.get_text() for text in ax.texts]
    assert {"150×", "50×", "0.667×"} <= set(words)
    assert max(map(len, words)) <= performance.LINE


def test_rows_of_a_picture_do_not_meet(store):
    for fig in (performance.draw_ratios(store(ROWS)), performance.draw_latencies(store(ROWS))):
        (ax,) = fig.axes
        words = [t.get_position()[1] for t in ax.texts if not isinstance(t, Annotation)]
        heights = sorted({*words, *points(ax)[:, 0]})
        assert min(np.diff(heights)) >= 0.99, "a line apart"
        bottom, top = ax.get_ylim()
        assert top < heights[0]
        assert heights[-1] < bottom


def test_picture_of_latencies_has_both_media_and_their_targets(store):
    (ax,) = performance.draw_latencies(store(ROWS)).axes
    np.testing.assert_allclose(sorted(points(ax)[:, 1]), [4, 50])
    assert len(set(points(ax)[:, 0])) == 1, "one explorer, one row"
    dashed = [line.get_xdata()[0] for line in ax.lines if line.is_dashed()]
    assert sorted(dashed) == [50, 100]
    assert [text.get_text() for text in ax.texts] == ["walls", "Step"]


@pytest.mark.parametrize(
    "change", [('"ours_s": 0.002', '"ours_s": 0.0002'), ("a & b", "another"), ('"content"', '"c"')]
)
def test_a_number_that_nobody_measured_is_refused(store, tmp_path, change):
    store(ROWS)
    file = tmp_path / "performance.json"
    text = file.read_text("utf-8")
    assert change[0] in text
    file.write_text(json.dumps(json.loads(text)), "utf-8")  # the same numbers in one line
    assert performance.rows() == ROWS
    file.write_text(text.replace(*change), "utf-8")
    for read in (Record.read, performance.rows):
        with pytest.raises(DamagedFile, match=r"performance\.json: no record of benchmarks"):
            read()


def test_what_is_recorded_can_be_read():
    record = Record.read()
    assert record.latencies
    assert {work.theme for work in record.work} == set(performance.ORDER)


def test_nothing_recorded_is_a_clear_error(tmp_path, monkeypatch):
    monkeypatch.setattr(performance, "records", lambda: tmp_path)
    with pytest.raises(FileNotFoundError, match=r"performance\.json"):
        Record.read()


def test_what_is_benchmarked_begins_with_a_word_that_has_a_theme():
    """Else it is measured, recorded, and stops the page."""
    files = (Path(__file__).parents[1] / "tools/benchmarks").glob("bench_*.py")
    words = re.findall(r'work=f?"(\w[\w-]*)', "".join(file.read_text("utf-8") for file in files))
    assert len(words) > 20
    assert set(words) <= set(performance.THEMES)


def test_all_that_was_missed_stands_in_one_table(store):
    slow = row(
        "walls, Step, in JupyterLab (16 moves, longest 90 ms)", 0.2, target=FAST, reached=False
    )
    record = store([*ROWS, slow])
    shown = record.missed()
    assert repr(shown).splitlines() == [
        "simplify a <scan> (Simplifying a line): 6 µs, 0.667×; wanted ≥ 0.75× fastrdp",
        f"Step (walls, In Jupyter): median 200 ms, longest 90 ms; wanted {FAST}",
    ]
    assert shown.bundle["text/html"].count("<tr>") == 3
    (ax,) = performance.draw_latencies(record).axes
    rings = [line for line in ax.lines if line.get_fillstyle() == "none"]
    assert [line.get_xdata()[0] for line in rings] == [200]


def test_peers_are_packages_of_others_or_plain_versions_of_ours(store):
    assert store(ROWS).peers == (3, 0)
    assert store([*ROWS, row("arms in outline", 1e-3, "as written", 1e-1)]).peers == (3, 1)


def test_every_plain_version_of_ours_is_a_recorded_peer():
    recorded = {work.peer for work in Record.read().work}
    assert recorded >= performance.OWN


def test_targets_have_three_digits(store):
    shown = store([row("colour histograms", 3e-3, target="≤ 5.71429 ms")]).tables()
    assert '<td data-name="Target">≤ 5.71 ms</td>' in shown.bundle["text/html"]
