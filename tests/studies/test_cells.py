"""Study cells are a module, and the hash of a function is that of what it computes with."""

import ast
import inspect
import traceback
from types import SimpleNamespace

import pytest
from IPython.core.compilerop import CachingCompiler

from robot_perception.book import covariance_intersection
from robot_perception.project import BOOK
from studies.files import DamagedFile
from studies.keys import cells, dependencies
from studies.keys.cells import LIVE, code_of, study_cells, tried_on

SETUP = """import numpy as np
from math import floor, sin as wave
from robot_perception import kalman
from robot_perception.beliefs import Gaussian
from studies.tables import Table
LEVEL, UNUSED = 2.0, 1.0
RULES = {"one": 1.0}
"""
HELPER = """def helper(x):
    return LEVEL * wave(x)


def untouched(x):
    return UNUSED * x
"""
TRIAL = """def plain(function):
    return function


@plain
def trial(film, *, gain=1.0, scale=helper):
    \"\"\"Say it.\"\"\"
    UNUSED = film  # a name of its own
    found = [scale(Table) for Table in range(3)]
    return {"x": np.sqrt(gain * UNUSED) + sum(found) + RULES["one"]}
"""
OTHER = """LATER = 3.0


def other(film):
    return kalman.predict, Gaussian, trial(film)
"""
TEXTS = (SETUP, HELPER, TRIAL, OTHER)


def digest(book, texts=TEXTS, name="trial"):
    return code_of(getattr(book.made(*texts), name))


def changed(old, new):
    """Return the cells with one place of one of them changed."""
    assert sum(text.count(old) for text in TEXTS) == 1
    return [text.replace(old, new) for text in TEXTS]


# The module


def test_the_module_has_what_the_study_cells_define_in_their_order(book):
    module = book.made("A = 1", "def f():\n    return A + B", "B = 2\nA = 3")
    assert (module.f(), module.A) == (5, 3)
    assert module.__name__ == f"{BOOK}small"
    assert module.__file__ == str(book.folder / "small.ipynb")
    assert module.f.__module__ == f"{BOOK}small"


def test_cells_without_the_tag_are_no_part_of_it(book):
    page = book.write("small", "A = 1")
    assert study_cells(page) == [(f"{page}[c0]", "A = 1")]


def test_the_source_of_a_function_is_that_of_its_cell(book):
    function = "def f(x):\n    return 1 / x\n"
    module = book.made("A = 1\n", f"B = 2\n\n\n{function}")
    assert inspect.getsource(module.f) == function
    assert inspect.getsourcefile(module.f).endswith("small.ipynb[c1]")
    with pytest.raises(ZeroDivisionError) as raised:
        module.f(0)
    said = "".join(traceback.format_exception(raised.value))
    assert 'small.ipynb[c1]", line 5, in f' in said
    assert "return 1 / x" in said


def test_a_notebook_without_study_cells_is_no_module_and_says_so(book):
    book.write("plain")
    with pytest.raises(ImportError, match=r"plain\.ipynb has no study cells"):
        book.module("plain")


def test_a_notebook_that_is_not_there_is_no_module(book):
    with pytest.raises(ModuleNotFoundError, match=f"{BOOK}none"):
        book.module("none")


@pytest.mark.parametrize("text", ["{", "[]", '{"cells": [{"cell_type": "code"}]}'])
def test_a_damaged_notebook_is_named(book, text):
    (book.folder / "small.ipynb").write_text(text)
    with pytest.raises(DamagedFile, match=r"small\.ipynb: no notebook"):
        book.module("small")


def test_a_cell_that_fails_is_named(book):
    page = book.write("small", "A = 1", "\nB = A / 0")
    with pytest.raises(ZeroDivisionError) as raised:
        book.module("small")
    last = traceback.extract_tb(raised.value.__traceback__)[-1]
    assert (last.filename, last.lineno, last.line) == (f"{page}[c1]", 2, "B = A / 0")


def test_one_notebook_imports_from_another(book):
    book.write("first", "def f():\n    return 1")
    second = book.made("from robot_perception.book.first import f\nA = f()", stem="second")
    assert second.A == 1


# The hash


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("np.sqrt(gain", "np.cbrt(gain"),
        ("gain=1.0", "gain=1.5"),
        ("def trial(film, *", "def trial(film, clip=1, *"),
        ("UNUSED = film", "UNUSED = 2 * film"),
        ("LEVEL * wave", "LEVEL + wave"),
        ("= 2.0, 1.0", "= 2.5, 1.0"),
        ('{"one": 1.0}', '{"one": 1.5}'),
        ('{"one": 1.0}\n', '{"one": 1.0}\nRULES["one"] = 2.0\n'),
        ('{"one": 1.0}\n', '{"one": 1.0}\nRULES |= {"one": 2.0}\n'),
        ("import floor, sin as wave", "import floor, cos as wave"),
        ("from math import floor, sin", "from cmath import exp as floor, sin"),
        ("import numpy as np", "import scipy as np"),
        ("LATER = 3.0", "LEVEL = 3.0"),
        ("LATER = 3.0", "def helper(x):\n    return 0"),
    ],
)
def test_the_hash_changes_with_all_that_a_function_computes_with(book, old, new):
    assert digest(book) != digest(book, changed(old, new))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("  # a name of its own", ""),
        ('    """Say it."""\n', ""),
        ("    found = [scale(Table) for Table in range(3)]",
         "    found = [\n        scale(Table)\n        for Table in range(3)\n    ]"),
        ("@plain\n", "@plain\n@plain\n"),
        ("= 2.0, 1.0", "= 2.0, 1.0\nMORE = 4"),
        ("return UNUSED * x", "return UNUSED + x"),
        ("kalman.predict, Gaussian", "kalman.update, Gaussian"),
        ("from robot_perception import kalman", "from robot_perception import gating as kalman"),
        ("from studies.tables import Table", "Table = 3"),
        ("LATER = 3.0", "LATER = 4.0"),
        ("LATER = 3.0", "wave_of = LATER = 3.0\nhidden = [LEVEL for LEVEL in range(3)]"),
    ],
)  # fmt: skip
def test_the_hash_stays_where_nothing_that_a_function_computes_with_changes(book, old, new):
    before = digest(book)
    assert before is not None
    assert digest(book, changed(old, new)) == before


def test_a_constant_that_is_reached_in_one_function_is_not_hidden_by_a_name_in_another(book):
    texts = "LEVEL = {}", "def f(x):\n    inner = lambda LEVEL: LEVEL\n    return inner(x) * LEVEL"
    one, other = (digest(book, [texts[0].format(k), texts[1]], "f") for k in (1, 2))
    assert one != other


def test_definitions_move_between_cells_without_a_trace(book):
    assert digest(book) == digest(book, ["".join((SETUP, HELPER)), TRIAL, OTHER])


@pytest.mark.parametrize("line", [
    "from robot_perception import kalman",
    "from robot_perception.kalman import predict",
    "import robot_perception.kalman",
    "    from robot_perception import kalman",
    "    import robot_perception.kalman",
])  # fmt: skip
def test_the_code_of_what_is_imported_counts_where_it_is_used(book, monkeypatch, line):
    asked = []
    monkeypatch.setattr(
        dependencies, "code_digest", lambda *names, named: asked.append(names) or ""
    )
    use = "predict" if "predict" in line else line.split()[-1] if "import r" in line else "kalman"
    body = f"{line}\n    return {use}" if line.startswith(" ") else f"    return {use}"
    top = "" if line.startswith(" ") else line
    digest(book, [f"{top}\ndef f():\n{body}\n\ndef g():\n    return 1"], "f")
    assert [[one.partition(":")[0] for one in names] for names in asked] == [
        ["robot_perception.kalman"]
    ]
    code_of(book.module("small").g)
    assert len(asked) == 1


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("from robot_perception.kalman import predict\ndef f():\n    return predict", ["predict"]),
        ("from robot_perception import kalman\ndef f():\n    return kalman.predict", ["predict"]),
        (
            "from robot_perception import kalman as k\ndef f():\n    return k.predict, k.update",
            ["predict", "update"],
        ),
        ("from robot_perception import kalman\ndef f():\n    return vars(kalman)", [""]),
        (
            "import robot_perception.kalman\ndef f():\n    return robot_perception.kalman.predict",
            [""],
        ),
        ("def f():\n    from robot_perception import kalman\n    return kalman.predict", [""]),
    ],
)
def test_of_a_module_those_names_count_that_are_asked_of_it(book, monkeypatch, text, expected):
    asked = []
    monkeypatch.setattr(
        dependencies, "code_digest", lambda *names, named: asked.append(names) or ""
    )
    digest(book, [text], "f")
    assert [one.partition(":")[2] for one in asked[0]] == expected


def test_the_code_of_the_library_is_part_of_the_hash(book, monkeypatch):
    texts = ["from robot_perception import kalman\ndef f():\n    return kalman.predict"]
    found = set()
    for said in ("old", "new"):
        monkeypatch.setattr(dependencies, "code_digest", lambda *names, named, said=said: said)
        found.add(digest(book, texts, "f"))
    assert len(found) == 2


@pytest.mark.parametrize(
    "texts",
    [
        "from robot_perception.book.first import helper\ndef f():\n    return helper(1)",
        "from robot_perception.book import first\ndef f():\n    return first.helper(1)",
    ],
)
def test_the_cells_of_another_notebook_count_as_far_as_they_are_reached(book, texts):
    found = []
    for level in (2, 3):
        book.write("first", f"LEVEL = {level}\ndef helper(x):\n    return LEVEL * x")
        found.append(digest(book, [texts], "f"))
    assert found[0] != found[1]


def test_another_function_of_another_notebook_does_not_count(book):
    found = []
    for level in (2, 3):
        book.write("first", f"def helper(x):\n    return x\n\ndef more(x):\n    return {level}")
        texts = ["from robot_perception.book.first import helper\ndef f():\n    return helper(1)"]
        found.append(digest(book, texts, "f"))
    assert found[0] == found[1]


@pytest.mark.parametrize(
    ("use", "whole"),
    [("first.helper(1)", False), ("first.helper(first)", True), ("vars(first)", True)],
)
@pytest.mark.parametrize("hashed", [tried_on, code_of])
def test_another_notebook_is_asked_by_name(book, use, whole, hashed):
    found = []
    for level, more in ((2, 2), (3, 2), (2, 3)):
        book.write("first", f"LEVEL = {level}\ndef helper(x):\n    return LEVEL\nMORE = {more}")
        text = f"from robot_perception.book import first\ndef f():\n    return {use}"
        found.append(hashed(book.made(text).f))
    assert found[0] != found[1]
    assert (found[0] != found[2]) == whole


def test_what_stands_in_no_cell_has_no_hash(book):
    module = book.made(
        "def f():\n    def g():\n        return 1\n    return g\n\ndef g():\n    return 2"
    )
    assert code_of(module.f()) is None
    assert code_of(module.g) is not None


def test_a_function_of_the_library_has_one_too():
    assert code_of(study_cells) is not None
    assert code_of(study_cells) != code_of(cells.run)


# In a notebook


def test_in_a_notebook_the_hash_is_that_of_the_module(book, live):
    expected = digest(book)
    assert code_of(live(*TEXTS).trial) == expected


def test_in_a_notebook_the_last_definition_counts(book, live):
    expected = digest(book)
    assert code_of(live(*TEXTS, "LEVEL = 5.0").trial) != expected
    assert code_of(live("LEVEL, UNUSED = 2.0, 1.0").trial) == expected
    assert code_of(live(TRIAL.replace("1.0", "1.5", 1)).trial) != expected
    assert code_of(live(TRIAL).trial) == expected


def test_in_a_notebook_a_cell_is_read_once_however_many_follow(book, live, monkeypatch):
    live(*TEXTS)
    digest(book), code_of(live("FIRST = 1").trial)
    read = []
    monkeypatch.setattr(cells, "_added_to", lambda statement: read.append(ast.unparse(statement)))
    code_of(live("SECOND = 2").trial)
    assert read == ["SECOND = 2"]


def test_in_a_notebook_magics_and_cells_that_were_not_run_through_are_passed_over(book, live):
    expected = digest(book)
    assert code_of(live("%timeit trial(3)", *TEXTS, "%%time\nLEVEL = 7").trial) == expected


def test_where_no_history_is_kept_what_was_compiled_counts(book, monkeypatch):
    """So nbval runs a notebook; the compiler is IPython's own."""
    expected, compiler = digest(book), CachingCompiler()
    shell = SimpleNamespace(user_ns={"__name__": LIVE, "In": [""]}, compile=compiler)
    monkeypatch.setattr("IPython.get_ipython", lambda: shell)
    for text in TEXTS:
        exec(compile(text, compiler.cache(text, 1), "exec"), shell.user_ns)
    assert code_of(shell.user_ns["trial"]) == expected


def test_without_a_notebook_what_is_typed_has_no_hash(monkeypatch):
    monkeypatch.setattr("IPython.get_ipython", lambda: None)
    namespace = {"__name__": "__main__"}
    exec("def f():\n    return 1", namespace)
    assert code_of(namespace["f"]) is None


# The book's own


def test_a_study_of_the_book_reaches_what_it_reads():
    texts = cells.sources(covariance_intersection.__name__)
    reached, imports, modules = cells.Definitions(texts).reached("weighing")
    assert {"random_pairs", "error", "ROUNDING", "by_equation_4", "det"} <= reached.keys()
    assert not {"chapter", "Exploration", "weigh", "ci_omega_least"} & reached.keys()
    assert "numpy" in " ".join(imports)
    assert "robot_perception.beliefs:Gaussian" in modules
    assert {one.partition(":")[0] for one in modules} >= {"robot_perception.fusion"}
