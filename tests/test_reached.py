"""What a change reaches: in a small house with two chapters, in this one, and by git's word."""

import json
import subprocess
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import nbformat
import pytest

from studies.keys.dependencies import Dependencies, said_in
from studies.project import NoData, project
from tests.tools import reached
from tests.tools.chosen import is_chosen
from tests.tools.reached import (
    BY_ROOM,
    BY_STEM,
    NO_PROSE,
    ROOT,
    Kept,
    Reach,
    Reached,
    before,
    changes,
    lanes,
    main,
    page_tests,
)

HOUSE = {
    "house/__init__.py": "",
    "house/kalman.py": "",
    "house/laser.py": "",
    "house/records.py": 'LEDGER = "claims.json"',
    "house/chapters/__init__.py": 'import importlib\nCHAPTERS = "walls", "slam"\n',
    "house/chapters/walls/__init__.py": 'PARTS = ("office",)',
    "house/chapters/walls/office.py": "from house import laser",
    "house/chapters/walls/figures.py": "from house.chapters.walls import office",
    "house/chapters/slam/__init__.py": 'PARTS = ("drive",)',
    "house/chapters/slam/drive.py": 'from house import kalman\nSTORED = "park"',
    "tests/__init__.py": "",
    "tests/conftest.py": "",
    "tests/ledger.py": "from house import chapters, records",
    "tests/worlds.py": "",
    "tests/tools/reached.py": "",
    "tests/tools/mutants/rooms.txt": "house/kalman.py: `+` -> `-`",
    "tests/test_kalman.py": "from house.kalman import __name__\nfrom tests import worlds",
    "tests/test_laser.py": "import house.laser",
    "tests/test_drive.py": "from robot_perception.book import slam",
    "tests/tools/mutants/__init__.py": 'ROOMS = "*.txt"',
    "tests/test_mutants.py": "from tests.tools import mutants",
    "tests/test_notebooks.py": 'BOOK, EVERY = "book", "*.ipynb"',
    "tests/test_titles.py": 'def title(stem): return f"book/{stem}.ipynb"',
    "tests/test_scripts.py": 'EVERY = "*.py", "*.md"',
    "tests/test_by_name.py": 'def module(name): return f"tests.calls.{name}"',
    "tests/calls/__init__.py": "",
    "tests/calls/laser.py": "from house import laser",
    "tests/chapters/__init__.py": "",
    "tests/chapters/walls/test_claims.py": "from tests.ledger import chapters",
    "tests/chapters/walls/test_findings.py": "from house.chapters.walls import figures",
    "tests/chapters/slam/test_claims.py": "from tests.ledger import chapters",
    "tests/site/__init__.py": "",
    "tests/site/driver.py": "",
    "tests/site/test_pages.py": 'from tests.site import driver\nBOOK = "*.ipynb"',
    "book/errata.md": "No code.",
    "book/scripts.md": "```{literalinclude} own/map.py\n```",
    "book/own/map.py": "",
    "book/_data/park.npz": "",
    "book/_static/theme.css": "",
    "constraints.txt": "",
    "CHANGELOG.md": "",
}
CELLS = {
    "walls": "from house.chapters.walls import figures\nfrom house.records import LEDGER",
    "slam": "from house.chapters.slam import drive\nfrom house.records import LEDGER",
}
WALLS, SLAM = ("tests/chapters/walls/", "tests/chapters/slam/")


@pytest.fixture
def house(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Reach:
    """A repository with two chapters, a test of each, and a site."""
    root = tmp_path
    for name, text in HOUSE.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    for name, cell in CELLS.items():
        made = nbformat.v4.new_code_cell(cell)
        made.metadata["tags"] = ["study"] if name == "slam" else []
        notebook = nbformat.v4.new_notebook(cells=[made])
        nbformat.write(notebook, root / f"book/{name}.ipynb")
    (root / "book/_data/claims.json").write_text(ledger())
    monkeypatch.syspath_prepend(root)
    own = replace(project(), packages=("house",), data=NoData())
    monkeypatch.setattr("studies.project._used", [own])
    monkeypatch.setattr(reached, "CHAPTERS", "house.chapters")
    return Reach(root, Dependencies(root, ("house",)))


def ledger(**verdicts: str) -> str:
    """Write a claim of each chapter."""
    claims = [
        {"id": f"of-{name}", "chapter": name, "verdict": verdicts.get(name, "reproduced")}
        for name in CELLS
    ]
    return json.dumps({"claims": claims})


@pytest.mark.parametrize(
    ("name", "tests", "left", "pages"),
    [
        ("house/kalman.py", {"tests/test_kalman.py", "tests/test_mutants.py"},
         {f"{SLAM}test_claims.py", "tests/test_drive.py"}, {"slam"}),
        ("house/laser.py", {"tests/test_laser.py", "tests/test_by_name.py"},
         {f"{WALLS}test_claims.py", f"{WALLS}test_findings.py"}, {"walls"}),
        ("house/chapters/walls/figures.py", {f"{WALLS}test_findings.py"}, set(), {"walls"}),
        ("house/chapters/walls/office.py",
         {f"{WALLS}test_findings.py", f"{WALLS}test_claims.py"}, set(), {"walls"}),
        ("house/chapters/slam/drive.py", {f"{SLAM}test_claims.py", "tests/test_drive.py"},
         set(), {"slam"}),
        ("tests/worlds.py", {"tests/test_kalman.py"}, set(), set()),
        ("tests/calls/laser.py", {"tests/test_by_name.py"}, set(), set()),
        ("tests/test_laser.py", {"tests/test_laser.py"}, set(), set()),
        ("tests/tools/mutants/rooms.txt", {"tests/test_mutants.py"}, set(), set()),
        ("book/walls.ipynb", {"tests/test_notebooks.py"}, {"tests/test_titles.py"}, {"walls"}),
        ("book/slam.ipynb",
         {"tests/test_notebooks.py", "tests/test_drive.py", f"{SLAM}test_claims.py"},
         {"tests/test_titles.py"}, {"slam"}),
        ("book/errata.md", set(), set(), {"errata"}),
        ("book/own/map.py", set(), set(), {"scripts"}),
        ("book/_data/park.npz", {f"{SLAM}test_claims.py", "tests/test_drive.py"}, set(), {"slam"}),
        ("CHANGELOG.md", set(), set(), set()),
    ],
)  # fmt: skip
def test_a_change_reaches_who_imports_or_reads_it(
    house: Reach, name: str, tests: set[str], left: set[str], pages: set[str]
):
    found = house.of(name)
    assert found.tests | found.parts.keys() == tests
    assert found.left == left
    assert found.pages == pages
    assert not found.site


def test_of_planted_errors_those_are_tried_that_name_the_file(house: Reach):
    for name in ("house/kalman.py", "tests/tools/mutants/rooms.txt"):
        assert house.of(name).parts == {"tests/test_mutants.py": {"rooms"}}


# What a cell reaches, in a chapter with two studies, and a page that borrows of it

STUDIES = """
from house import kalman

chapter = "slam"
LEVEL, FAR = 0.9, 3


def gate(level=LEVEL):
    return kalman, level


@chapter.study(sample=4)
def gated(sample):
    return gate()


@gated.claim("gates-hold", sabotage={})
def gates_hold(rows):
    return rows


@chapter.study(sample=4)
def far(sample):
    return FAR


@recorded("far-away")
def away():
    return far
"""
PAGES = {
    "slam": [(STUDIES, "study"), ("gated.rows()", "code"), ("A word.", "Markdown")],
    "borrows": [
        ("from robot_perception.book.slam import gate\nSEEN = Exploration(gate, name='s')", "study")
    ],
}
BOOK = ("tests/book/test_rows.py", "tests/book/test_prose.py")


@pytest.fixture
def pages(house: Reach, tmp_path: Path) -> dict[str, bytes]:
    """Tests of the book and its pages, as they were."""
    (tmp_path / "tests/book").mkdir()
    for name in BOOK:
        (tmp_path / name).write_text('BOOK = "book", "*.ipynb"')
    return {stem: write(tmp_path, stem, cells) for stem, cells in PAGES.items()}


def write(root: Path, stem: str, cells: list[tuple[str, str]]) -> bytes:
    """Write a notebook."""
    made = []
    for number, (text, kind) in enumerate(cells):
        new = nbformat.v4.new_markdown_cell if kind == "Markdown" else nbformat.v4.new_code_cell
        made.append(new(text, id=f"cell-{number}"))
        made[-1].metadata["tags"] = ["study"] if kind == "study" else []
    file = root / f"book/{stem}.ipynb"
    nbformat.write(nbformat.v4.new_notebook(cells=made), file)
    return file.read_bytes()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("A word.", "Another word.", None),
        ("gated.rows()", "gated.rows().by()", {"slam."}),
        ("FAR = 0.9, 3", "FAR = 0.9, 3  # metres", {"slam."}),
        ("    return FAR", "    return 2 * FAR", {"slam.", "slam.far", "far-away"}),
        (
            "return kalman, level",
            "return level",
            {"slam.", "slam.gated", "gates-hold", "borrows.s"},
        ),
        ("    return rows", "    return 2 * rows", {"slam.", "gates-hold"}),
        ("sabotage={}", "sabotage={1: far}", {"slam.", "gates-hold"}),
    ],
)
def test_a_cell_reaches_what_is_made_of_it(
    house: Reach, tmp_path: Path, pages: dict[str, bytes], old: str, new: str, words: set | None
):
    write(tmp_path, "slam", [(text.replace(old, new), kind) for text, kind in PAGES["slam"]])
    found = Reach(tmp_path, Dependencies(tmp_path, ("house",))).of("book/slam.ipynb", pages["slam"])
    assert found.parts.get(BOOK[0]) == words
    assert BOOK[1] in found.tests
    assert ("tests/test_drive.py" in found.tests) == (words is not None)
    assert found.notebooks == (set() if words is None else {"slam"})
    of_study = words is not None and new != "gated.rows().by()"
    assert found.pages == ({"slam", "borrows"} if of_study else {"slam"})


@pytest.mark.parametrize(
    ("name", "was", "words"),
    [
        ("house/kalman.py", "GATE = 1", {"slam.gated", "gates-hold", "borrows.s"}),
        ("house/kalman.py", "# a comment", None),
        ("house/laser.py", "FAR = 1", None),
        ("book/_data/rows/slam.far.npz", "", {"slam.far", "far-away"}),
        ("book/_data/far-away.npz", "", {"far-away"}),
    ],
)
def test_code_and_records_reach_the_studies_that_rest_on_them(
    house: Reach, tmp_path: Path, pages: dict, name: str, was: str, words: set | None
):
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).write_text("GATE = 2" if was == "GATE = 1" else "")
    (tmp_path / BOOK[0]).write_text(
        "from house import kalman\nfrom robot_perception.book import slam"
    )
    found = Reach(tmp_path, Dependencies(tmp_path, ("house",))).of(name, was.encode())
    assert found.parts.get(BOOK[0]) == words


def test_what_files_say_is_kept_by_their_contents(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    file = tmp_path / "module.py"
    file.write_text("import os")
    for text in ("import os", "import sys"):
        file.write_text(text)
        kept = Kept(tmp_path / "kept")
        assert {name for name, _ in kept.said(file).imported} == {text.split()[1]}
        kept.write()
    (stored,) = (tmp_path / "kept").iterdir()
    assert list(json.loads(stored.read_text())) == [*kept._asked]  # and no more than was asked
    monkeypatch.setattr(reached, "said_in", lambda file: pytest.fail("read again"))
    assert Kept(tmp_path / "kept").said(file) == said_in(file)


def test_what_two_changes_reach_is_run_once_and_no_part_of_what_is_run_whole():
    part = Reached(parts={"a": frozenset({"x"}), "b": frozenset({"x"})}, left=frozenset({"c", "d"}))
    other = Reached(frozenset({"a", "c"}), {"b": frozenset({"y"})})
    both = part | other
    assert both.tests == {"a", "c"}
    assert both.parts == {"b": {"x", "y"}}
    assert both.left == {"d"}


@pytest.mark.parametrize(
    ("test", "runs"),
    [
        ("tests/a.py::test[monobot.joseph-1]", True),
        ("tests/a.py::test[monobot.factors]", False),
        ("tests/a.py::test[monobot]", False),
        ("tests/a.py::test[kalman]", True),
        ("tests/a.py::test[walls]", False),
        ("tests/a.py::test[slam]", False),
        ("tests/a.py::test[loop-grown]", True),
        ("tests/a.py::test[-1.5]", True),
        ("tests/a.py::test", True),
        ("tests/b.py::test[walls]", True),
    ],
)
def test_of_a_file_the_chosen_tests_run_and_those_that_are_of_nothing(test: str, runs: bool):
    words = {"tests/a.py": ["monobot.joseph", "kalman", "loop-grown"]}
    assert is_chosen(test, words, frozenset({"kalman", "slam"})) == runs


@pytest.mark.parametrize("name", ["tests/site/driver.py", "tests/site/test_pages.py"])
def test_what_the_sites_tests_share_runs_all_that_use_it(house: Reach, name: str):
    assert house.of(name) == Reached(site=frozenset({"tests/site/test_pages.py"}))


@pytest.mark.parametrize(
    "name",
    [
        "constraints.txt",
        "tests/conftest.py",
        "tests/tools/reached.py",
        "house/chapters/__init__.py/gone.py",
        "house/gone.py",
        "house/table.toml",
        "book/_static/theme.css",
        ".ci/run",
    ],
)
def test_what_lies_under_everything_is_not_traced(house: Reach, name: str):
    assert house.of(name) is None


def test_a_claim_recorded_anew_reaches_its_chapter_and_all_who_read_the_ledger(house: Reach):
    name = "book/_data/claims.json"
    found = house.of(name, ledger(slam="refuted").encode())
    assert found.pages == {"slam"}
    assert found.tests == {
        f"{SLAM}test_claims.py", f"{WALLS}test_claims.py", "tests/test_drive.py",
    }  # fmt: skip
    assert house.of(name, ledger().encode()).pages == set()


@pytest.fixture(scope="module")
def here() -> Reach:
    kept = Kept()
    return Reach(ROOT, Dependencies(ROOT, reads=kept.said), kept)


def test_a_line_of_a_chapters_figures_reaches_no_claim_and_no_other_chapter(here: Reach):
    found = here.of("lib/robot_perception/chapters/walls/figures.py")
    assert "tests/chapters/walls/test_findings.py" in found.tests
    assert {"walls", "intro"} <= found.pages
    assert "scorecard" not in found.pages
    own = {t for t in found.tests if not t.startswith(("tests/book/", "tests/hostile/"))}
    assert not {t for t in own if "claims" in t or "monobot" in t}
    assert here.of("constraints.txt") is None
    assert here.of("tests/conftest.py") is None


def test_a_line_of_a_notebook_reaches_those_who_import_its_cells_and_ask_for_its_chapter(
    here: Reach,
):
    page = ROOT / "book/covariance_intersection.ipynb"
    was = page.read_bytes().replace(b"pairs=500", b"pairs=499", 1)
    assert was != page.read_bytes()
    found = here.of("book/covariance_intersection.ipynb", was)
    assert "tests/chapters/covariance_intersection/test_studies.py" in found.tests
    assert not {test for test in found.tests if "/monobot/" in test or "/walls/" in test}
    searched = {"covariance_intersection.", "covariance_intersection.searched", "ci-omega-least"}
    assert found.parts["tests/book/test_rows.py"] == searched
    rows = here.of("book/_data/rows/covariance_intersection.worst.npz")
    assert "tests/chapters/covariance_intersection/test_studies.py" in rows.tests
    assert not {test for test in rows.tests if "/monobot/" in test or "/walls/" in test}
    assert "covariance_intersection.worst" in rows.parts["tests/book/test_rows.py"]
    assert {"covariance_intersection", "intro"} <= rows.pages
    assert not {"walls", "monobot"} & rows.pages


def test_a_word_of_prose_reaches_who_reads_prose(here: Reach):
    page = ROOT / "book/walls.ipynb"
    cells = json.loads(page.read_text("utf-8"))
    first = next(cell for cell in cells["cells"] if cell["cell_type"] == "markdown")
    first["source"] = ["Another word.\n"]
    found = here.of("book/walls.ipynb", json.dumps(cells).encode())
    names = ("prose", "terms", "citations", "quotations", "course", "front_door")
    assert {f"tests/book/test_{name}.py" for name in names} <= found.tests
    assert not found.parts
    assert not {test for test in found.tests if "hostile/" in test or "chapters/" in test}
    assert found.pages == {"walls"}


def test_a_line_of_a_room_reaches_those_who_sweep_and_mutate_it(here: Reach):
    file = ROOT / "lib/robot_perception/kalman.py"
    was = file.read_bytes().replace(b"F @ prior.cov @ F.mT + Q", b"Q + F @ prior.cov @ F.mT")
    assert was != file.read_bytes()
    found = here.of("lib/robot_perception/kalman.py", was)
    assert {"tests/test_kalman.py", "tests/slam/planar/test_filtering.py"} <= found.tests
    assert found.parts["tests/hostile/test_hostile.py"] == {"kalman"}
    assert "ground" in found.parts["tests/test_mutants.py"]
    assert "monobot.misprinted" in found.parts["tests/book/test_rows.py"]
    assert "walls.fitted" not in found.parts["tests/book/test_rows.py"]
    gone = here.of("lib/robot_perception/kalman.py", file.read_bytes() + b"LEVEL = 1")
    rows = gone.parts["tests/book/test_rows.py"]
    assert found.parts["tests/book/test_rows.py"] <= rows
    assert "walls.fitted" not in rows
    assert "tests/chapters/anchored_slam/test_studies.py" in found.left
    assert "monobot" in found.pages


def test_files_of_tests_that_are_named_are_there():
    finds = "tests/book/test_finds.py"
    named = {*BY_STEM, *BY_ROOM, *NO_PROSE} - {finds}
    assert not [name for name in named if not (ROOT / name).exists()]


COLLECTED = [
    "tests/site/test_pages.py::test_page[walls]",
    "tests/site/test_pages.py::test_page[recordings_walls]",
    "tests/site/test_pages.py::test_page[library/walls]",
    "tests/site/test_pages.py::test_search_finds",
    "tests/site/test_jupyterlab.py::test_explorers_survive_run_all_cells[walls]",
]


def test_pages_are_tested_by_their_own_names():
    assert page_tests(["walls"], COLLECTED) == [COLLECTED[0], COLLECTED[4]]
    assert page_tests(["library/walls"], COLLECTED) == [COLLECTED[2]]
    assert page_tests([], COLLECTED) == []
    with pytest.raises(LookupError, match="no test of the site names monobot: run `make test`"):
        page_tests(["walls", "monobot"], COLLECTED)


KALMAN = frozenset({"tests/test_kalman.py"})


def test_nothing_reached_is_no_step_and_notebooks_are_run():
    assert list(lanes(Reached(), 2)) == []
    ((name, command),) = (step for lane in lanes(Reached(tests=KALMAN), 2) for step in lane)
    assert (name, command[-1]) == ("tests and notebooks", *KALMAN)
    assert "--nbval-lax" not in command
    walls = frozenset({"walls"})
    tests, site = lanes(Reached(pages=walls, notebooks=walls), 2)
    assert next(tests)[1][-2:] == ["--nbval-lax", "book/walls.ipynb"]
    assert next(site)[0] == "book"


def test_parts_of_files_are_chosen_and_many_pages_are_left():
    found = Reached(parts={"a.py": frozenset({"y", "x"})}, pages=frozenset({"a", "b", "c"}))
    (((name, command),),) = (list(lane) for lane in lanes(found, 2))
    assert name == "tests and notebooks"
    assert command[:2] == ["env", 'ROBOT_PERCEPTION_CHOSEN={"a.py": ["x", "y"]}']
    assert command[-1] == "a.py"
    assert ["-p", "tests.tools.chosen"] in [list(pair) for pair in pairwise(command)]


def test_pages_that_are_built_anew_are_opened(monkeypatch: pytest.MonkeyPatch):
    def run(command: list[str], **words: object) -> subprocess.CompletedProcess[str]:
        return subprocess.CompletedProcess(command, 0, "\n".join(COLLECTED))

    monkeypatch.setattr(reached.subprocess, "run", run)
    (site,) = lanes(Reached(pages=frozenset({"library/walls", "recordings_walls"})), 2)
    _, (name, command) = site
    assert name == "pages"
    assert command[-2:] == COLLECTED[1:3]


@pytest.fixture
def repository(tmp_path: Path) -> Path:
    """A repository with a commit, a branch, and changes of every kind."""

    def git(*words: str) -> None:
        who = ["-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false"]
        subprocess.run(["git", *who, *words], cwd=tmp_path, check=True, capture_output=True)

    git("init", "--initial-branch", "main")
    (tmp_path / "claims.json").write_text("{\n}")
    for name in ("same", "edited", "staged", "gone", "moved"):
        (tmp_path / name).write_text(name)
    (tmp_path / ".gitignore").write_text("built")
    git("add", ".")
    git("commit", "-m", "first")
    git("switch", "-c", "branch")
    (tmp_path / "committed").write_text("")
    git("add", ".")
    git("commit", "-m", "second")
    git("switch", "main")
    (tmp_path / "theirs").write_text("")
    git("add", ".")
    git("commit", "-m", "third")
    git("switch", "branch")
    (tmp_path / "edited").write_text("anew")
    (tmp_path / "staged").write_text("anew")
    (tmp_path / "claims.json").write_text("[]")
    git("add", "staged")
    git("mv", "moved", "größer")
    (tmp_path / "gone").unlink()
    (tmp_path / "new").write_text("")
    (tmp_path / "built").write_text("")
    return tmp_path


def test_git_says_what_has_changed(repository: Path):
    edits = ["claims.json", "edited", "gone", "größer", "moved", "new", "staged"]
    assert changes(repository, "HEAD") == edits
    assert changes(repository, "main") == sorted([*edits, "committed"])
    assert before(repository, "main", "claims.json") == b"{\n}"
    assert before(repository, "main", "new") == b""
    with pytest.raises(subprocess.CalledProcessError):
        changes(repository, "nowhere")


OF = {"CHANGELOG.md": Reached()}


@pytest.mark.parametrize(
    ("changed", "says", "code"),
    [
        ([], "Nothing has changed since HEAD, so nothing was tested.", 0),
        (["CHANGELOG.md", "constraints.txt"],
         "What constraints.txt reaches cannot be told: run `make test`.", 2),
        (["CHANGELOG.md"], "CHANGELOG.md: 0 files of tests, pages: none", 0),
    ],
)  # fmt: skip
def test_it_says_when_it_tests_nothing(
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    here: Reach,
    changed: list[str],
    says: str,
    code: int,
):
    monkeypatch.setattr("sys.argv", ["make check"])
    monkeypatch.setattr(reached, "changes", lambda root, base: changed)
    monkeypatch.setattr(reached, "before", lambda *_: b"")
    monkeypatch.setattr(reached, "Kept", lambda folder: Kept())
    monkeypatch.setattr(reached, "reach_of", lambda root, kept: here)
    monkeypatch.setattr(here, "of", lambda name, ledger: OF.get(name))
    monkeypatch.setattr(reached.subprocess, "run", lambda *a, **k: pytest.fail("run"))
    assert main() == code
    assert says in capsys.readouterr().out


def test_a_step_that_fails_is_named_and_ends_its_lane(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], here: Reach
):
    monkeypatch.setattr("sys.argv", ["make check"])
    monkeypatch.setattr(reached, "changes", lambda root, base: ["CHANGELOG.md"])
    monkeypatch.setattr(reached, "before", lambda *_: b"")
    monkeypatch.setattr(reached, "Kept", lambda folder: Kept())
    monkeypatch.setattr(reached, "reach_of", lambda root, kept: here)
    fails = ["sh", "-c", "echo why >&2; false"]
    commands = [("tests", ["true"])], [("book", fails), ("pages", ["true"])]
    monkeypatch.setattr(reached, "lanes", lambda found, jobs: map(iter, commands))
    assert main() == 1
    said = capfd.readouterr().out
    assert "Failed: book\n" in said
    assert "why\nbook: 0 s\n" in said
    assert "tests: 0 s\n" in said
    assert "pages" not in said.replace("pages: none", "")
