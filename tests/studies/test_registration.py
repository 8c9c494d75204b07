"""What a claim says and measures is registered, line after line, on replicates of its own."""

from dataclasses import replace

import pytest

from studies import registration
from studies.files import DamagedFile
from studies.keys import dependencies
from studies.registration import (
    Registration,
    anew,
    changed,
    in_words,
    latest,
    measure_of,
    of,
    read,
    replicates,
    replicates_of,
    reused,
    same,
    trial_of,
    words_of,
    write,
)

CELLS = (
    """from robot_perception import kalman
from studies.intervals import exact
from studies.claims import Finding
from studies.trials import Chapter
from studies.verdicts import Accepted

chapter = Chapter("small")
LEVEL, OTHER = 1.0, 2.0
""",
    """@chapter.study(seed=7, film=range(5))
def drawn(film, *, gain=1.0):
    return {"error": gain * film}


@chapter.study(film=range(5))
def another(film):
    return {"error": OTHER * film}
""",
    """def highest(rows):
    return exact(LEVEL * rows.largest("error"))


@drawn.claim("some", paper="perception-issues", place="§1", basis="mathematics",
    statement="Something holds.", says="it is {value}", form="number",
    method="counted", accepted=Accepted(0, 9, "theory"),
    value=lambda rows: highest(rows), paper_value="9",
    sabotage={"a gain of a hundred": drawn.but(gain=100.0)}, stopping="five films")
def some(rows, value):
    return Finding(value, {"lowest": exact(rows.of("error").min())}, note="A note.")
""",
)
LINES = (
    Registration("a", 0, "2026-01-01", "w0", "m0", "drawn film 0-4", registration.BEFORE),
    Registration("b", 0, "2026-01-01", "w", "-", "seed 3", registration.BEFORE),
    Registration("a", 1, "2026-01-02", "w1", "m1", "drawn film 5-9", 'other "range",\tmended'),
)


def made(book, old="", new=""):
    """Return the claim of a notebook in which one place is changed."""
    assert not old or sum(text.count(old) for text in CELLS) == 1
    return book.made(*(text.replace(old, new) if old else text for text in CELLS)).some


# The file


def test_the_file_comes_back_as_it_was_written(book):
    write(LINES)
    assert read() == LINES
    assert registration.file().read_text("utf-8").splitlines()[0] == "\t".join(
        ("claim", "number", "day", "words", "measure", "replicates", "remark", "trial")
    )
    before = registration.file().read_text("utf-8")
    write([*read(), LINES[1]])
    assert registration.file().read_text("utf-8").startswith(before)
    assert of(read(), "b") == (LINES[1], LINES[1])


def test_lines_from_before_trials_were_hashed_stay_as_they_were(book):
    later = replace(LINES[2], trial="t")
    old = "\t".join(("claim", "number", "day", "words", "measure", "replicates", "remark"))
    write([*LINES[:2], later])
    _, *lines, last = registration.file().read_text("utf-8").splitlines()
    assert [line.count("\t") for line in lines] == [6, 6]
    assert last.endswith("\tt")
    assert read() == (*LINES[:2], later)
    registration.file().write_text("\n".join([old, *lines]) + "\n", "utf-8")
    assert read() == LINES[:2]
    registration.file().write_text("\n".join([old, lines[0].rpartition("\t")[0]]), "utf-8")
    with pytest.raises(DamagedFile, match="no list of registrations"):
        read()


@pytest.mark.parametrize(
    "text",
    ["claim\tnumber\na\t0\n", "a\t0\n", "claim\tnumber\tday\twords\tmeasure\treplicates\tremark\n"
     "a\tfirst\t\t\t\t\t\n"],
)  # fmt: skip
def test_a_file_of_another_form_is_damaged(tmp_path, text):
    file = tmp_path / "registrations.tsv"
    file.write_text(text + "a\t1\n")
    with pytest.raises(DamagedFile, match=r"registrations\.tsv: no list of registrations"):
        read(file)


def test_a_file_that_is_not_there_is_an_error(tmp_path):
    with pytest.raises(FileNotFoundError):
        read(tmp_path / "registrations.tsv")


def test_when_a_claim_was_registered_is_said(book):
    again = replace(LINES[2], number=2, day="2026-01-03", remark="again")
    write([*LINES, again])
    assert in_words("a") == "on 2026-01-03"
    assert in_words("b") == "no: it is older than this rule"
    assert in_words("c") == "not registered"
    assert latest()["a"] == again
    write([*LINES, replace(LINES[2], day="2026-01-04", remark="by other code")])
    assert in_words("a") == "on 2026-01-02"  # and is the same since
    assert latest()["a"] == LINES[2]


# What is registered


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("Something holds.", "Something fails."),
        ("counted", "counted twice"),
        ("Accepted(0, 9", "Accepted(1, 9"),
        ("Accepted(0, 9", "Accepted(0, 8"),
        ('9, "theory"', '9, "a guess"'),
        ("a gain of a hundred", "a gain of a thousand"),
        ("five films", "six films"),
        ('basis="mathematics"', 'basis="paper"'),
    ],
)
def test_the_words_change_with_each_part_of_what_is_said(book, old, new):
    assert words_of(made(book)) != words_of(made(book, old, new))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('paper_value="9"', 'paper_value="8"'),
        ("A note.", "Another note."),
        ("LEVEL * rows", "LEVEL + rows"),
        ("gain=100.0", "gain=200.0"),
        ("§1", "§2"),
        ("film=range(5))\ndef drawn", "film=range(6))\ndef drawn"),
    ],
)
def test_the_words_change_with_nothing_else(book, old, new):
    assert words_of(made(book)) == words_of(made(book, old, new))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("A note.", "Another note."),
        ('rows.of("error").min()', 'rows.of("error").max()'),
        ("LEVEL * rows", "LEVEL + rows"),
        ("LEVEL, OTHER = 1.0", "LEVEL, OTHER = 1.5"),
        ("lambda rows: highest(rows)", "lambda rows: exact(1.0)"),
        ("gain=100.0", "gain=200.0"),
        ("drawn.but(gain=100.0)", "another"),
        ("@drawn.claim", "@another.claim"),
    ],
)
def test_the_measure_changes_with_what_makes_value_and_evidence_of_rows(book, old, new):
    assert measure_of(made(book)) != measure_of(made(book, old, new))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("Something holds.", "Something fails."),
        ("Accepted(0, 9", "Accepted(1, 9"),
        ("gain * film", "gain + film"),
        ("film=range(5))\ndef drawn", "film=range(6))\ndef drawn"),
        ("OTHER * film", "OTHER + film"),
        ("import kalman\n", "import gating\n"),
        ("def highest(rows):\n", "def highest(rows):\n    # the highest\n"),
    ],
)
def test_the_measure_changes_with_nothing_else(book, old, new):
    assert measure_of(made(book)) == measure_of(made(book, old, new))


PLAIN = """errors = drawn.says(
    highest=("mean", "error", "in words"),
    other=("mean", "error", "of others"),
)
some = drawn.claim("some", paper="perception-issues", place="§1", basis="mathematics",
    statement="Something holds.", says="it is {value}", form="number",
    method="counted", accepted=Accepted(0, 9, "theory"),
    value=errors("highest", film=3), conditions=(When("dry", outside=highest),),
    sabotage={"a gain of a hundred": drawn.but(gain=100.0)}, note="A note.")
"""


@pytest.mark.parametrize(
    ("old", "new", "changes"),
    [
        ('highest=("mean"', 'highest=("spread"', True),
        ("film=3", "film=4", True),
        ("outside=highest", "inside=highest", True),
        ("LEVEL, OTHER = 1.0", "LEVEL, OTHER = 1.5", True),  # of what decides
        ("in words", "in other words", False),
        ('other=("mean"', 'other=("spread"', False),
        ("gain * film", "gain + film", False),
        ("A note.", "Another note.", False),
        ("Something holds.", "Something fails.", False),
    ],
)
def test_the_measure_of_a_plain_claim_is_its_value_and_what_decides(book, old, new, changes):
    highest, _ = CELLS[2].split("\n\n\n", 1)
    imports = CELLS[0].replace("import Chapter", "import Chapter\nfrom studies.says import When")
    texts = imports, CELLS[1], highest, PLAIN
    assert sum(text.count(old) for text in texts) == 1
    before = measure_of(book.made(*texts).some)
    after = measure_of(book.made(*(text.replace(old, new) for text in texts)).some)
    assert (before != after) == changes


WORLD = """from data_synth import laser

NOISE = 0.1


def scene(film):
    return laser.scan, NOISE * film
"""


def with_world(book, old="", new=""):
    """Return the claim whose trial stands in a world and is followed by a filter."""
    texts = [
        WORLD,
        CELLS[0],
        CELLS[1].replace("gain * film}", 'gain * scene(film), "filtered": kalman.predict}'),
    ]
    assert not old or sum(text.count(old) for text in (*texts, CELLS[2])) == 1
    return book.made(*(text.replace(old, new) if old else text for text in (*texts, CELLS[2]))).some


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("NOISE = 0.1", "NOISE = 0.2"),
        ("NOISE * film", "NOISE + film"),
        ("gain * scene", "gain + scene"),
        ("gain=1.0", "gain=1.5"),
        ("import laser", "import office as laser"),
        ("seed=7", "seed=8"),
        ("gain=100.0", "gain=200.0"),
        ("drawn.but(gain=100.0)", "another"),
        ("drawn.but(gain=100.0)", "drawn.but(film=range(4), gain=100.0)"),
    ],
)
def test_the_trial_changes_with_what_a_claim_and_its_sabotages_are_tested_on(book, old, new):
    before = trial_of(with_world(book))
    assert trial_of(with_world(book, old, new)) != before


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("Something holds.", "Something fails."),
        ("Accepted(0, 9", "Accepted(1, 9"),
        ("LEVEL * rows", "LEVEL + rows"),
        ("OTHER * film", "OTHER + film"),
        ("from robot_perception import kalman", "from robot_perception import gating as kalman"),
        ("def scene(film):\n", "def scene(film):\n    # where it is\n"),
    ],
)
def test_the_trial_changes_with_nothing_else(book, old, new):
    before = trial_of(with_world(book))
    assert trial_of(with_world(book, old, new)) == before


@pytest.mark.parametrize(
    ("old", "new", "changes"),
    [
        ("OTHER * film", "OTHER + film", True),
        ("film=range(5))\ndef another", "film=range(6))\ndef another", True),
        ("film=range(5))\ndef drawn", "film=range(6))\ndef drawn", False),  # has a column
    ],
)
def test_a_sabotage_by_another_study_counts_with_trial_and_replicates(book, old, new, changes):
    texts = [text.replace("drawn.but(gain=100.0)", "another") for text in CELLS]
    assert sum(text.count(old) for text in texts) == 1
    before = trial_of(book.made(*texts).some)
    after = trial_of(book.made(*(text.replace(old, new) for text in texts)).some)
    assert (after != before) == changes


def test_a_world_counts_and_a_room_does_not(book, monkeypatch):
    """What is tested may be mended, what it is tested on may not."""
    found = {"": trial_of(with_world(book))}
    for name in ("data_synth.laser", "robot_perception.kalman"):
        imports = dependencies.Imports()
        imports._meanings[name] = "changed"
        monkeypatch.setattr(dependencies, "_imports", lambda imports=imports: imports)
        found[name] = trial_of(with_world(book))
    assert found["data_synth.laser"] != found[""] == found["robot_perception.kalman"]


def test_replicates_are_those_of_the_study(book):
    assert replicates_of(made(book)) == "drawn film 0-4"
    assert replicates_of(made(book, "seed=7, film=range(5)", "film=(3, 4, 7, 9, 8)")) == (
        "drawn film 3-4,7,9,8"
    )


@pytest.mark.parametrize(
    ("values", "spans", "found"),
    [
        (range(5000, 5003), "5000-5002", {"5000", "5001", "5002"}),
        ((7,), "7", {"7"}),
        ((3, 1, 2), "3,1-2", {"1", "2", "3"}),
        ((9, 10, 12), "9-10,12", {"9", "10", "12"}),
        ((-1, 0), "-1,0", {"-1", "0"}),
        (("hall, dark", "a-b"), "hall__dark,a-b", {"hall__dark", "a-b"}),
    ],
)
def test_spans_say_which_replicates_and_are_read_as_those(values, spans, found):
    assert registration._spans(tuple(values)) == spans
    assert replicates(f"drawn film {spans}") == ("drawn film", frozenset(found))


# Again


def test_the_next_registration_has_the_next_number(book):
    some = made(book)
    first = anew(some, (), "new")
    assert (first.claim, first.number, first.remark) == ("some", 1, "new")
    assert same(first, some)
    assert anew(some, [first, LINES[2]], "again").number == 2
    assert anew(some, [first], "by other code", same=True).number == 1
    old = replace(first, number=0)
    assert anew(some, [old], "mended").number == 1


def test_what_is_called_the_same_has_the_same_words(book):
    some = made(book)
    other = [replace(anew(some, (), "new"), words="other")]
    for before in ((), other):
        with pytest.raises(ValueError, match="some is not the same: its words have changed"):
            anew(some, before, "the same", same=True)


@pytest.mark.parametrize(
    ("name", "said"),
    [("words",) * 2, ("measure",) * 2, ("replicates",) * 2, ("trial", "trial or world")],
)
def test_a_registration_is_of_words_measure_replicates_and_trial(book, name, said):
    some = made(book)
    other = replace(anew(some, (), "new"), **{name: "other"})
    assert not same(other, some)
    assert changed(other, some) == said


def test_a_line_without_its_trial_is_none_of_what_is_declared(book):
    some = made(book)
    assert changed(replace(anew(some, (), "new"), trial=""), some) == "trial or world"


@pytest.mark.parametrize(
    ("later", "shares"),
    [
        ({"replicates": "drawn film 5-9"}, ""),
        ({"replicates": "drawn film 4-9"}, "a: 1 scores drawn film 4 of 0"),
        ({"replicates": "other film 3-4"}, "a: 1 scores other film 3, 4 of 0"),
        ({"replicates": "drawn person 0-4"}, ""),
        ({"replicates": "drawn film 0-4", "claim": "b"}, ""),
        ({"replicates": "drawn film 0-4", "number": 0, "words": "w0"}, ""),
        ({"replicates": "drawn film 0-4", "number": 0}, "a: 0 scores drawn film 0, 1, 2 of 0"),
    ],
)
def test_replicates_that_were_scored_before_are_found(later, shares):
    found = list(reused([LINES[0], replace(LINES[2], **later)]))
    assert found == [shares] * bool(shares)


def test_every_earlier_registration_counts():
    third = replace(LINES[2], number=2, replicates="drawn film 3,7")
    found = list(reused([*LINES, third]))
    assert found == ["a: 2 scores drawn film 3 of 0", "a: 2 scores drawn film 7 of 1"]
