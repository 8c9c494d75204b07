"""Answers are judged where they did not run, by what is sent of them: nothing else reaches it."""

import contextlib
import json
import math
import os
import signal
import socket
import threading
import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from robot_perception.teaching.course import grading
from robot_perception.teaching.course.answering import LONGEST, serve
from robot_perception.teaching.course.copies import without_sheet
from robot_perception.teaching.course.exercises import Exercise
from robot_perception.teaching.course.grading import Rules, apart, judged, run, sheet_of
from robot_perception.teaching.course.messages import BrokenLine, Line
from studies.keys.cells import folder
from tests.book.computing import COMPUTING, module

STEM = "covariance_intersection"
LINUX = pytest.mark.skipif(not os.path.exists("/proc/self/stat"), reason="as Linux does it")


@contextlib.contextmanager
def ends():
    """Both ends of a line, with the limit of who grades on the first."""
    ours, theirs = socket.socketpair()
    with ours, theirs:
        line = Line(ours, LONGEST)
        line.wait(20)
        yield line, Line(theirs), theirs


@contextlib.contextmanager
def serving(names):
    """A line to a thread that answers in place of a process."""
    ours, theirs = socket.socketpair()
    with theirs:
        thread = threading.Thread(target=serve, args=(Line(theirs), names))
        thread.start()
        with ours:
            yield Line(ours, LONGEST)
        thread.join()


def answered(exercise, source, **names):
    """What comes of an answer that a thread runs."""
    with serving(names) as line:
        return judged(line, exercise, "a", source, 20)


def same(value, other):
    """Whether two values are of one kind and equal, NaN as well."""
    if isinstance(value, np.ndarray | np.generic):
        kinds = value.dtype.kind, other.dtype.kind
        return kinds[0] == kinds[1] and np.array_equal(value, other, equal_nan=kinds[0] == "f")
    if isinstance(value, list | tuple):
        return type(value) is type(other) and all(map(same, value, other))
    if isinstance(value, dict):
        return value.keys() == other.keys() and all(same(value[k], other[k]) for k in value)
    return type(value) is type(other) and (value == other or value != value)


PLAIN = st.none() | st.just(...) | st.booleans() | st.integers() | st.floats() | st.text()
ARRAYS = arrays.arrays(
    st.sampled_from([float, int, bool]), arrays.array_shapes(min_side=1, max_side=3)
)
VALUES = st.recursive(
    PLAIN | ARRAYS,
    lambda inner: st.lists(inner) | st.tuples(inner, inner) | st.dictionaries(st.text(), inner),
    max_leaves=8,
)


@settings(max_examples=50)
@given(VALUES)
def test_a_value_is_what_was_sent(value):
    with ends() as (here, there, _):
        there.reply(lambda: value)
        assert same(value, here.decoded(here.receive()["value"]))


@given(
    st.recursive(
        PLAIN.filter(lambda v: v is not ...),
        lambda inner: (
            st.lists(inner)
            | st.dictionaries(
                st.text()
                | st.sampled_from(
                    ["array", "shape", "tuple", "table", "object", "fields", "function"]
                ),
                inner,
            )
        ),
        max_leaves=12,
    )
)
def test_whatever_json_is_sent_is_a_value_or_none(data):
    with ends() as (here, _, _), contextlib.suppress(BrokenLine):
        here.decoded(data)


@pytest.mark.parametrize(
    "data",
    [
        {"array": [1, "a"], "shape": [2]},
        {"array": [1, 2], "shape": [3]},
        {"array": [10**40], "shape": [1]},
        {"object": ["os", "_exit"], "fields": {"status": 0}},
        {"object": ["robot_perception.companion.interaction", "Interaction"], "fields": {}},
        {"value": 1},
    ],
)
def test_what_is_no_value_is_refused(data):
    with ends() as (here, _, _), pytest.raises(BrokenLine):
        here.decoded(data)


@pytest.mark.parametrize(
    ("sent", "said"),
    [
        (b"x\n", "no value"),
        (b"5\n", "no value"),
        (b'{"value": {"pickle": 1}}\n', "no value"),
        (b"{}\n", "no value"),
        (b"[" * 50_000 + b"\n", "no value"),
        (b"\xff\xfe\n", "no value"),
        (b'{"call": 0, "given": []}\n', "no value"),
        (b"1" * (LONGEST + 9), "more than"),
        (b"", "ended"),
    ],
)
def test_no_bytes_of_an_answer_end_the_grading(sent, said):
    with ends() as (ours, _, theirs):
        theirs.sendall(sent)
        theirs.shutdown(socket.SHUT_WR)
        with pytest.raises(BrokenLine, match=said):
            judged(ours, Exercise(1), "a", "", 5)


def test_half_a_message_is_not_waited_for():
    with ends() as (ours, _, theirs):
        theirs.sendall(b'{"value"')
        with pytest.raises(BrokenLine) as broken:
            judged(ours, Exercise(1), "a", "", 0.1)
        assert broken.value.late


@pytest.mark.parametrize(
    ("source", "outcome", "said"),
    [
        ("check('a', 4)", "right", "Right."),
        ("check('a', True)", "wrong", "Not quite"),
        ("check('a', {1})", "wrong", "of the type set"),
        ("check('a', 1j)", "wrong", "of the type complex"),
        ("check('a', ...)", "not yet", "in place of the dots"),
        ("check('b', 4)", "missing", "nothing to check"),
        ("check('a', 10**5000)", "error", "ValueError"),
        ("x = []; x.append(x); check('a', x)", "error", "RecursionError"),
        ("check('a', '4' * 200_000)", "error", "bytes to judge"),
        ("%magic", "error", "SyntaxError"),
        ("raise SystemExit(3)", "error", "SystemExit: 3"),
        ("class E(Exception):\n    __str__ = None\nraise E", "error", "without a text"),
        ("raise ValueError('\\ud800')", "error", "\ud800"),
    ],
)
def test_what_comes_of_a_cell(source, outcome, said):
    found = answered(Exercise(4), source)
    assert found[0] == outcome
    assert said in found[1]


def test_an_answer_sees_the_names_of_the_book_and_changes_none():
    names = {"LIMIT": 2, "check": None}
    with serving(names) as line:
        assert judged(line, Exercise(4), "a", 'LIMIT *= 2\ncheck("a", LIMIT)', 20)[0] == "right"
    assert names == {"LIMIT": 2, "check": None}


def test_a_function_is_called_there_and_may_call_back():
    doubles = Exercise(lambda given: given(lambda x: 2 * x, np.arange(3), by=(1, 2)) == [0, 4, 8])
    source = "check('a', lambda f, x, by: [v * by[1] for v in f(x)])"
    assert answered(doubles, source)[0] == "right"
    assert answered(doubles, source.replace("by[1]", "by[0]"))[0] == "wrong"


@pytest.mark.parametrize(
    ("function", "said"),
    [
        ("lambda: 1 / 0", "ZeroDivisionError"),
        ("lambda: exit()", "SystemExit"),
        ("lambda: {1}", "of the type set"),
        ("lambda: []", "nothing was returned"),
        ("lambda: [([],), []]", "nothing was returned"),
        ("lambda: __import__('numpy').zeros((2, 0))", "nothing was returned"),
        ("lambda: 'a' * 200_000", "bytes to judge"),
    ],
)
def test_a_function_that_fails_is_wrong_and_said_so(function, said):
    is_one = Exercise(lambda given: np.allclose(given(), 1.0))
    found = answered(is_one, f"check('a', {function})")
    assert found[0] == "wrong"
    assert said in found[1]


def test_a_function_that_takes_too_long_is_no_wrong_answer():
    with serving({}) as line:
        source = "import time\ncheck('a', lambda: time.sleep(1))"
        with pytest.raises(BrokenLine) as broken:
            judged(line, Exercise(lambda given: given()), "a", source, 0.3)
        assert broken.value.late


FUNCTIONS = {
    "belief-word": "lambda b, word: float((says(word) * b).sum())",
    "belief-gate": "lambda i, S: 1 / (1 + i**2 / S / 9)",
    "belief-fuse": "lambda m, v: (np.average(m, weights=1 / np.array(v)), "
    "1 / np.sum(1 / np.array(v)))",
    "belief-range": "lambda x: (x - LAMP[0]) / np.hypot(x - LAMP[0], LAMP[1])",
    "guesses-weights": "lambda x, f, g: f(x) / g(x) / np.sum(f(x) / g(x))",
    "guesses-effective": "lambda w: sum(w) ** 2 / sum(np.array(w) ** 2)",
    "guesses-comb": "lambda w, u: np.searchsorted(np.cumsum(w), "
    "(np.arange(len(w)) + u) / len(w), side='right')",
    "guesses-own": "lambda gaps: -np.log(1 + (gaps / 0.02) ** 2)",
    "numbers-carry": "lambda x, P, z, r: np.array(x) + P[:, 0] * (z - x[0]) / (P[0, 0] + r)",
    "numbers-join": "lambda P, r: np.block([[P, P[:1].T], [P[:1], P[:1, :1] + r]])",
    "numbers-glance": "lambda P, R: 1 + int(np.argmax(P[0][0] + np.diag(P)[1:] - 2 * "
    "np.array(P)[0, 1:]))",
    "numbers-honest": "lambda e, P: np.mean([one @ np.linalg.solve(P, one) for one in e])",
    "walls-2": "[[0, 0], [3, 0], [2, 0]]",
    "walls-far": "lambda a: np.min([np.pad(abs(a), 1)[k : k + len(a)] for k in range(3)], axis=0)",
    "monobot-2": "[1, 0, 0]",
    "monobot-alarm": "lambda i, S, u: abs((i * u / S).sum()) > "
    "2.5 * np.sqrt(len(i) * (u**2 / S).sum())",
    "anchored-2": "lambda t, p: np.array([[0, 1], [-1, 0]]) @ np.array("
    "[[np.cos(t[2]), np.sin(t[2])], [-np.sin(t[2]), np.cos(t[2])]]) @ (p - t[:2])",
    "anchored-turn": "[-2, 2, 1, -4, 0]",
    "anchored-protect": "lambda H, N: H - np.outer(H @ N, N) / (N @ N)",
    "loop-recognise": "lambda old, new: recognise(old, new)",
    "sift-ratio": "lambda d, r: np.where(np.sort(d)[:, 0] <= r * np.sort(d)[:, 1], "
    "d.argmin(axis=1), -1)",
    "mcl-pose": "lambda p, q, m, n: pose_of(p, q, m, n)",
    "mcl-place": "lambda p, m: place_of(p, m)",
    "look-build": "lambda looks, gaps: (lambda c: np.where(c.min(axis=1) <= 1.8, "
    "c.argmin(axis=1), -1))((looks / 149) ** 2 + (gaps / 0.7) ** 2)",
    "slam-propose": "lambda z, r: (z / (1 + r**2), r / np.sqrt(1 + r**2))",
    "ci-weight": "lambda Ci, Cj: max(np.linspace(0, 1, 11), key=lambda w: np.linalg.det("
    "(1 - w) * np.linalg.inv(Ci) + w * np.linalg.inv(Cj)))",
    "people-pairs": "lambda p, near, far: sum(near <= math.dist(p[i], p[j]) <= far "
    "for i in range(len(p)) for j in range(i))",
    "people-counts": "lambda weights: max(weights) > 0.7",
    "people-own": "lambda sensor, p, l, s, c: sensor == 'sonar' or (any(abs(wrap_angle("
    "c[:, 1] - p[1])) < 0.17) and not any(abs(wrap_angle(s[:, 1] - p[1])) < 0.26))",
    "people-update": "lambda w, m, t, a, v, th: (lambda x: x if x >= th else 0)"
    "(w + a * (1 - w) if m else w - (1 - th) * t / v)",
    "head-keep": "lambda M, C, a: np.maximum(M, (1 - a) * M + a * C)",
    "head-own": "lambda first, M, C, phi: M + 0.02 * (C - M) + 0.01 * (first - M)",
    "shape-belongs": "lambda inside, around: inside / inside.sum() > around / around.sum()",
    "shape-weights": "lambda rho, s: np.exp(-rho**2 / 2 / s**2) / np.exp(-rho**2 / 2 / s**2).sum()",
    "pattern-direction": "lambda d, turn: min(d, 10.0) if abs(np.sin(turn)) <= "
    "np.sin(np.radians(20)) else 10.0",
    "pattern-factor": "lambda d: -np.minimum(d, 3.0)**2 / 2 / RULES.deviation**2",
    "nav-law": "lambda x, y, th: (max(x, 0.0), 5.0 * math.atan2(y, x) - 0.8 * "
    "math.remainder(th - math.atan2(y, x), 2 * math.pi))",
    "tutor-limit": "lambda k, s: (np.quantile(s, 0.05), np.mean(k > np.quantile(s, 0.05)))",
    "following-whistle": "Event(lambda seen: seen['whistle'], 3)",
    "tutor-decide": "lambda d: (lambda one, two, *_: one <= 1 and one <= 0.75 * two)"
    "(*np.sort(d.mean(axis=0)))",
    "following-gate": "lambda far, change: np.full(4, far.max() <= 0.4)",
    "likelihoods-cost": "lambda far, seen: "
    "-(np.where(seen, np.minimum(far, 5), 5)**2).mean(axis=1)",
    "arms-motion": "lambda before, last: (0.8 * (last - before), 1.0)",
    "arms-weights": "lambda log, ahead, drawn: (lambda w: w / w.sum())"
    "(np.exp(log - ahead[drawn] - np.max(log - ahead[drawn])))",
    "world-intersect": "lambda P, H, C, w: np.linalg.inv((1 - w) * np.linalg.inv(P) + "
    "w * H.T @ np.linalg.inv(C) @ H)",
    "world-trust": "lambda d: (1 + d / 15) ** 2",
    "parts-code": "lambda C, M: np.sqrt(C / C.sum() * M / M.sum()).sum()",
    "day-rule": "ends_of",
    "parts-rule": "lambda C, M: (lambda c, m: -((c - m)**2 / (c + m + 1e-9)).sum())"
    "(C / C.sum(), M / M.sum())",
}


def recognise(old, new, near=0.3):
    a, b = old @ [1, 1j], new @ [1, 1j]
    gaps, best = np.abs(a[:, None] - a), np.full(len(b), -1)
    for i, j in np.argwhere(np.abs(b[:, None] - b) > 2.0):
        for k, m in np.argwhere(np.abs(gaps - abs(b[i] - b[j])) < near / 2):
            turn = (a[m] - a[k]) / (b[j] - b[i])
            moved = a[k] + turn / abs(turn) * (b - b[i])
            away = np.abs(moved[:, None] - a)
            found = np.where(away.min(axis=1) < near, away.argmin(axis=1), -1)
            if (found >= 0).sum() > (best >= 0).sum():
                best = found
    return best


def pose_of(p, q, m, n):
    turn = math.atan2(n[1] - m[1], n[0] - m[0]) - math.atan2(q[1] - p[1], q[0] - p[0])
    c, s = math.cos(turn), math.sin(turn)
    return m[0] - c * p[0] + s * p[1], m[1] - s * p[0] - c * p[1], turn


def place_of(points, places):
    pairs = [(i, j) for i in range(len(points)) for j in range(i)]
    gaps = [abs(math.dist(*points[[i, j]]) - math.dist(*places[[i, j]])) for i, j in pairs]
    pairs = [pair for pair, gap in zip(pairs, gaps, strict=True) if gap < 0.2]
    poses = [pose_of(points[i], points[j], places[i], places[j]) for i, j in pairs]
    return max(poses, key=lambda pose: agreeing(pose, points, places))


def agreeing(pose, points, places):
    c, s = math.cos(pose[2]), math.sin(pose[2])
    ends = points @ np.array([[c, s], [-s, c]]) + pose[:2]
    return np.sum(np.linalg.norm(ends - places, axis=1) < 0.3)


@pytest.mark.parametrize("stem", COMPUTING)
def test_the_right_answers_of_the_book_are_right_when_they_are_sent(stem):
    """Functions see the names of the page, as they do where students are graded."""
    sheet = sheet_of(stem)
    names = {
        **vars(module(stem)),
        "np": np,
        "math": math,
        "pose_of": pose_of,
        "recognise": recognise,
        "place_of": place_of,
    }
    for key, exercise in sheet.items():
        names["answer"] = exercise.answer
        said = FUNCTIONS[key] if callable(exercise.answer) else "answer"
        given = eval(said, dict(names))  # a page keeps its films before the clock runs
        assert exercise.judge(given)[0] == "right", key
        assert answered(exercise, f"check('a', {said})", **names)[0] == "right", key
        assert answered(exercise, "check('a', lambda *_: [])", **names)[0] == "wrong", key


@pytest.mark.parametrize("stem", COMPUTING)
def test_answers_stand_on_cells_without_a_right_answer(stem):
    page = folder() / f"{stem}.ipynb"
    given = dict(without_sheet(page))
    made = "\n".join(given.values())
    assert "Exercise(" not in made
    assert "Sheet(" not in made
    for exercise in sheet_of(stem).values():
        name = getattr(exercise.answer, "__name__", "")
        assert f"def {name}(" not in made


@pytest.mark.parametrize(
    ("stem", "names"),
    [
        ("ceiling_navigation", ("KNOWN", "SEEN_KNOWN", "SEEN_NEW", "SCALE")),
        ("arm_tracking", ("LOGS", "effective_number")),
        ("arm_likelihoods", ("LOG", "_AT")),
        ("tutor_face", ("KNOWN_OFF", "STRANGERS_OFF", "def met_again")),
    ],
)
def test_data_that_an_exercise_speaks_of_are_there(stem, names):
    made = "\n".join(text for _, text in without_sheet(folder() / f"{stem}.ipynb"))
    places = [made.find(name) for name in names]
    assert min(places) >= 0
    assert made.index("import ") < min(places)  # in their order
    assert "TOGETHER" not in made  # of what is beside them


CHEATS = """
import gc, sys
import numpy as np
from robot_perception.teaching.course.exercises import Exercise, Sheet
np.allclose = np.isclose = np.array_equal = lambda *a, **k: True
Exercise.judge = lambda *a: ("right", "Right.")
found = [x for x in gc.get_objects() if isinstance(x, Exercise | Sheet)]
found += [v for m in list(sys.modules.values()) for v in vars(m).values()
          if isinstance(v, Exercise | Sheet)]
"""


def test_no_answer_finds_the_sheet_or_bends_the_judge_and_memory_is_bounded():
    sheet = sheet_of(STEM)
    with apart(STEM, 2**30) as line:
        told = lambda source: judged(line, sheet["ci-echo"], "a", source, 20)  # noqa: E731
        assert told(f"{CHEATS}check('a', found[0].answer)")[1].startswith("IndexError")
        assert told(f"{CHEATS}check('a', 5.0)")[0] == "wrong"
        assert told(f"from robot_perception.book.{STEM} import EXERCISES")[0] == "error"
        assert told("check('a', EXERCISES)")[1].startswith("NameError")
        assert told("import numpy as np; np.ones(2**28)")[1].startswith("MemoryError")
        assert told(f"check('a', {sheet['ci-echo'].answer})")[0] == "right"


LEAVES = """
import os, time
number, there = os.pipe()
if not os.fork():
    {}
    if not os.fork():
        os.write(there, str(os.getpid()).encode())
        time.sleep(60)
    os._exit(0)
check("ci-echo", int(os.read(number, 9)))
"""


@LINUX
@pytest.mark.parametrize("leaving", ["pass", "os.setsid()"])
def test_processes_that_an_answer_started_end_with_its_notebook(leaving):
    started = []
    with apart(STEM) as line:
        judged(line, Exercise(started.append), "ci-echo", LEAVES.format(leaving), 20)
        os.kill(started[0], 0)
    with pytest.raises(ProcessLookupError):
        os.kill(started[0], 0)


@LINUX
def test_an_answer_that_ends_who_watches_it_ends_itself():
    found = []
    with apart(STEM) as line:
        judged(line, Exercise(found.append), "a", "import os; check('a', os.getpid())", 20)
        source = "import os, signal; os.kill(os.getppid(), signal.SIGKILL)\nwhile True: pass"
        with pytest.raises(BrokenLine):
            judged(line, Exercise(1), "a", source, 20)
    for _ in range(50):
        try:
            os.kill(found[0], 0)
        except ProcessLookupError:
            return
        time.sleep(0.1)
    os.kill(found[0], signal.SIGKILL)
    pytest.fail("it runs on")


def test_a_process_that_never_gets_ready_is_told(monkeypatch):
    monkeypatch.setattr(grading, "START_S", 0.0)
    with pytest.raises(RuntimeError, match=f"study cells of {STEM} did not run"):
        run(STEM, [("ci-echo", "")], Rules(sheet_of(STEM), 1.0))


@pytest.mark.parametrize("kind", ["pipe", "large"])
def test_what_is_no_notebook_is_not_read(tmp_path, monkeypatch, kind):
    path = tmp_path / f"{STEM}.ipynb"
    if kind == "pipe":
        os.mkfifo(path)
    else:
        monkeypatch.setattr(grading, "LARGEST", 10)
        path.write_text(json.dumps({"cells": []}))
    with pytest.raises(grading.DamagedFile, match="no file" if kind == "pipe" else "larger than"):
        grading.answers(path)
