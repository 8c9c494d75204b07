"""What a change reaches: in a small house with two chapters, in this one, and by git's word."""

import json
import subprocess
from pathlib import Path

import nbformat
import pytest

from robot_perception.teaching import dependencies
from robot_perception.teaching.dependencies import Dependencies
from tests.tools import reached
from tests.tools.reached import ROOT, Reach, Reached, before, changes, lanes, main, page_tests

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
    monkeypatch.setattr(dependencies, "registry", list)
    monkeypatch.setattr(reached, "PACKAGES", ("house",))
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
    ("name", "tests", "pages"),
    [
        ("house/kalman.py", {"tests/test_kalman.py", "tests/test_mutants.py",
                             f"{SLAM}test_claims.py", "tests/test_drive.py"}, {"slam"}),
        ("house/laser.py", {"tests/test_laser.py", "tests/test_by_name.py",
                            f"{WALLS}test_claims.py", f"{WALLS}test_findings.py"}, {"walls"}),
        ("house/chapters/walls/figures.py", {f"{WALLS}test_findings.py"}, {"walls"}),
        ("house/chapters/walls/office.py",
         {f"{WALLS}test_findings.py", f"{WALLS}test_claims.py"}, {"walls"}),
        ("house/chapters/slam/drive.py", {f"{SLAM}test_claims.py", "tests/test_drive.py"},
         {"slam"}),
        ("tests/worlds.py", {"tests/test_kalman.py"}, set()),
        ("tests/calls/laser.py", {"tests/test_by_name.py"}, set()),
        ("tests/test_laser.py", {"tests/test_laser.py"}, set()),
        ("tests/tools/mutants/rooms.txt", {"tests/test_mutants.py"}, set()),
        ("book/walls.ipynb", {"tests/test_notebooks.py", "tests/test_titles.py"}, {"walls"}),
        ("book/slam.ipynb",
         {"tests/test_notebooks.py", "tests/test_titles.py", "tests/test_drive.py",
          f"{SLAM}test_claims.py"}, {"slam"}),
        ("book/errata.md", set(), {"errata"}),
        ("book/own/map.py", set(), {"scripts"}),
        ("book/_data/park.npz", {f"{SLAM}test_claims.py", "tests/test_drive.py"}, {"slam"}),
        ("CHANGELOG.md", set(), set()),
    ],
)  # fmt: skip
def test_a_change_reaches_who_imports_or_reads_it(
    house: Reach, name: str, tests: set[str], pages: set[str]
):
    assert house.of(name) == Reached(frozenset(tests), frozenset(), frozenset(pages))


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
    return Reach(ROOT, Dependencies(ROOT))


def test_a_line_of_a_chapters_figures_reaches_no_claim_and_no_other_chapter(here: Reach):
    found = here.of("lib/robot_perception/chapters/walls/figures.py")
    assert "tests/chapters/walls/test_findings.py" in found.tests
    assert {"walls", "intro"} <= found.pages
    assert "scorecard" not in found.pages
    everything = ("tests/book/", "tests/hostile/")  # all registries; what any chapter names
    own = {t for t in found.tests if not t.startswith(everything)}
    assert not {t for t in own if "claims" in t or "monobot" in t}
    assert here.of("constraints.txt") is None
    assert here.of("tests/conftest.py") is None


def test_a_line_of_a_notebook_reaches_those_who_import_its_cells_and_ask_for_its_chapter(
    here: Reach,
):
    found = here.of("book/covariance_intersection.ipynb")
    assert "tests/chapters/covariance_intersection/test_studies.py" in found.tests
    assert not {test for test in found.tests if "/monobot/" in test or "/walls/" in test}
    rows = here.of("book/_data/rows/covariance_intersection.worst.npz")
    assert "tests/chapters/covariance_intersection/test_studies.py" in rows.tests


def test_a_line_of_a_room_reaches_those_who_sweep_and_mutate_it(here: Reach):
    found = here.of("lib/robot_perception/kalman.py")
    assert {
        "tests/test_kalman.py",
        "tests/test_mutants.py",
        "tests/hostile/test_hostile.py",
        "tests/chapters/anchored_slam/test_studies.py",
    } <= found.tests
    assert "monobot" in found.pages


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
    tests, site = lanes(Reached(pages=frozenset({"walls"})), 2)
    assert next(tests)[1][-2:] == ["--nbval-lax", "book/walls.ipynb"]
    assert next(site)[0] == "book"


def test_pages_that_are_built_anew_are_run_in_jupyterlab(monkeypatch: pytest.MonkeyPatch):
    commands = []

    def run(command: list[str], **words: object) -> subprocess.CompletedProcess[str]:
        commands.append(command)
        return subprocess.CompletedProcess(command, 0, "\n".join(COLLECTED))

    monkeypatch.setattr(reached.subprocess, "run", run)
    *_, site = lanes(Reached(pages=frozenset({"library/walls", "recordings_walls"})), 2)
    _, (name, command) = site
    told = ["env", "ROBOT_PERCEPTION_LAB_PAGES=library/walls,recordings_walls"]
    assert name == "pages"
    assert [words[:2] for words in (*commands, command)] == [told, told]
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
    monkeypatch.setattr(reached, "Dependencies", lambda root: None)
    monkeypatch.setattr(reached, "Reach", lambda *_: here)
    monkeypatch.setattr(here, "of", lambda name, ledger: OF.get(name))
    monkeypatch.setattr(reached.subprocess, "run", lambda *a, **k: pytest.fail("run"))
    assert main() == code
    assert says in capsys.readouterr().out


def test_a_step_that_fails_is_named_and_ends_its_lane(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], here: Reach
):
    monkeypatch.setattr("sys.argv", ["make check"])
    monkeypatch.setattr(reached, "changes", lambda root, base: ["CHANGELOG.md"])
    monkeypatch.setattr(reached, "Dependencies", lambda root: None)
    monkeypatch.setattr(reached, "Reach", lambda *_: here)
    fails = ["sh", "-c", "echo why >&2; false"]
    commands = [("tests", ["true"])], [("book", fails), ("pages", ["true"])]
    monkeypatch.setattr(reached, "lanes", lambda found, jobs: map(iter, commands))
    assert main() == 1
    said = capfd.readouterr().out
    assert "Failed: book\n" in said
    assert "why\nbook: 0 s\n" in said
    assert "tests: 0 s\n" in said
    assert "pages" not in said.replace("pages: none", "")
