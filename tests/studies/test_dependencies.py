"""What the results on a page depend on, in a small house with three pages."""

import json
from dataclasses import dataclass, replace
from pathlib import Path

import nbformat
import pytest

from robot_perception.chapters import CHAPTERS
from robot_perception.project import ROOT
from studies.files import DamagedFile
from studies.keys import dependencies
from studies.keys.dependencies import (
    IRRELEVANT,
    Dependencies,
    Imports,
    code_digest,
    known_packages,
    said_in,
)
from studies.project import NoData, project


@dataclass(frozen=True)
class Recordings(NoData):
    """Two data sets, one of which may be here."""

    here: str = ""

    def names(self) -> tuple[str, ...]:
        """Return both names."""
        return "park", "attic"

    def find(self, name: str) -> Path | None:
        """Return a folder of the one that is here."""
        return Path() if name == self.here else None


HOUSE = {
    "house/__init__.py": "",
    "house/records.py": 'LEDGER = "claims.json"',
    "house/front_end/explorer.js": "",
    "house/rooms/__init__.py": "",
    "house/rooms/walls.py": "",
    "house/rooms/slam.py": 'TABLE = "landmarks.toml"',
    "house/rooms/landmarks.toml": "",
    "house/rooms/unused.py": "",
    "house/chapters/__init__.py": "from importlib import import_module",
    "house/chapters/walls.py": 'from house.rooms import walls\nSTORED = "walls-map"',
    "house/chapters/slam/__init__.py": "",
    "house/chapters/slam/study.py": "def run():\n    from ...rooms.slam import TABLE, __name__",
    "house/chapters/slam/drives.py": 'DRIVES = "park"',
    "constraints.txt": "numpy==2",
    "book/notes.md": "No code.",
    "book/slam.md": """---
kernelspec: {name: python3, display_name: Python 3}
jupytext: {text_representation: {format_name: myst}}
---
```{code-cell}
from house import records
from house.chapters.slam import drives, study
say("straight")
```
""",
    "book/_data/walls-map.npz": "",
    "book/_data/films/park/1.webp": "",
    "book/_data/nobodys.json": "",
}
CELLS = {
    "walls": ["import house.records", "from house.chapters import walls"],
    "scorecard": ["from house import records\nfrom house.chapters import CHAPTERS"],
}
CLAIMS = {"straight": "walls", "square": "walls", "consistent": "slam"}
EVERY = {"walls", "slam", "scorecard"}


@pytest.fixture
def house(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A repository with a package, three pages with code and one without, and recorded data."""
    for name, text in HOUSE.items():
        write(tmp_path / name, text)
    for name, cells in CELLS.items():
        cells = [nbformat.v4.new_code_cell(cell) for cell in cells]
        write(
            tmp_path / f"book/{name}.ipynb", nbformat.writes(nbformat.v4.new_notebook(cells=cells))
        )
    record(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    of(monkeypatch, data=Recordings())
    return tmp_path


def of(monkeypatch: pytest.MonkeyPatch, **changes: object) -> None:
    """Let studies belong to a project that is another one in something."""
    monkeypatch.setattr("studies.project._used", [replace(project(), **changes)])


def write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def record(root: Path, **verdicts: str) -> None:
    """Write a ledger."""
    claims = [
        {"id": name, "chapter": chapter, "verdict": verdicts.get(name, "reproduced")}
        for name, chapter in CLAIMS.items()
    ]
    write(root / "book/_data/claims.json", json.dumps({"claims": claims}))


def keys(root: Path) -> dict[str, str | None]:
    found = Dependencies(root, ("house",))
    return {page.stem: found.key(page) for page in (root / "book").iterdir() if page.is_file()}


def expired(before: dict[str, str | None], root: Path) -> set[str]:
    after = keys(root)
    return {name for name in after if after[name] != before[name]}


@pytest.mark.parametrize(
    ("name", "pages"),
    [
        ("house/rooms/walls.py", {"walls", "scorecard"}),
        ("house/rooms/slam.py", {"slam", "scorecard"}),
        ("house/chapters/slam/study.py", {"slam", "scorecard"}),
        ("house/rooms/landmarks.toml", {"slam", "scorecard"}),
        ("house/rooms/__init__.py", EVERY),
        ("house/chapters/__init__.py", EVERY),
        ("house/rooms/unused.py", set()),
        ("house/front_end/explorer.js", set()),
        ("constraints.txt", EVERY),
        ("book/notes.md", set()),
        ("book/_data/walls-map.npz", {"walls", "scorecard"}),
        ("book/_data/films/park/1.webp", {"slam", "scorecard"}),
        ("book/_data/nobodys.json", EVERY),
    ],
)
def test_a_change_expires_the_pages_that_reach_it(house: Path, name: str, pages: set[str]):
    before = keys(house)
    write(house / name, HOUSE[name] + "\n# changed")
    assert expired(before, house) == pages


@pytest.mark.parametrize(
    ("name", "pages"),
    [
        ("house/chapters/walls.py", {"walls", "scorecard"}),
        ("house/chapters/slam/__init__.py", {"slam", "scorecard"}),
        ("house/chapters/slam/study.py", {"slam", "scorecard"}),
        ("house/chapters/slam/drives.py", {"slam"}),
        ("house/chapters/slam/notes.py", {"scorecard"}),
        ("house/chapters/attic/study.py", set()),
    ],
)
def test_who_imports_by_name_reaches_what_it_names(house: Path, name: str, pages: set[str]):
    chapters = house / "house/chapters"
    names = 'FOUND = "walls", "slam"\ndef notes(stem): return f"{stem}.notes"\n'
    write(chapters / "__init__.py", f"import importlib\n{names}")
    write(chapters / "slam/notes.py", "")
    write(chapters / "slam/__init__.py", "PARTS = ['study']")
    write(chapters / "attic/__init__.py", "PARTS = ['study']")
    write(chapters / "attic/study.py", "")
    before = keys(house)
    write(house / name, (house / name).read_text() + "\n# changed")
    assert expired(before, house) == pages
    write(chapters / "__init__.py", "from importlib.metadata import version\nimport house.records")
    before = keys(house)
    write(house / name, (house / name).read_text() + "\n# changed")
    assert expired(before, house) == pages - {"scorecard"}  # it imports nothing by name
    write(chapters / "__init__.py", '"""Of walls."""\nimport pkgutil\n')
    before = keys(house)
    write(house / name, (house / name).read_text() + "\n# changed")
    assert expired(before, house) == pages | {"scorecard"}  # nothing is named: it may be any


@pytest.mark.parametrize(
    ("claim", "pages"),
    [
        ("straight", EVERY),  # the other chapter's page names it
        ("square", {"walls", "scorecard"}),
        ("consistent", {"slam", "scorecard"}),
    ],
)
def test_a_claim_recorded_anew_expires_its_chapter(house: Path, claim: str, pages: set[str]):
    before = keys(house)
    record(house, **{claim: "conditional"})
    assert expired(before, house) == pages


@pytest.mark.parametrize(
    ("name", "pages"),
    [
        ("rows/walls.bent.npz", {"walls", "borrows", "asks"}),  # "slam" runs what says "walls"
        ("rows/slam.driven.json", {"asks"}),  # asks all chapters
        ("sketch.npz", {"walls", "borrows", "asks"}),  # a notebook alone names it
    ],
)
def test_rows_and_what_a_notebook_names_expire_who_runs_its_cells(
    house: Path, monkeypatch: pytest.MonkeyPatch, name: str, pages: set[str]
):
    of(monkeypatch, reading_notebooks="house.rooms.unused")
    cells = {
        "walls": 'from house.rooms import slam\nchapter = "walls"\nkept("sketch")',
        "borrows": "from robot_perception.book.walls import chapter",
        "asks": 'from house.rooms import unused\nchapter = "slam"',
    }
    for page, cell in cells.items():
        made = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell)])
        write(house / f"book/{page}.ipynb", nbformat.writes(made))
    write(house / "house/rooms/slam.py", 'NAMES = "walls", "slam"')
    write(house / f"book/_data/{name}", "before")
    before = keys(house)
    write(house / f"book/_data/{name}", "after")
    assert expired(before, house) == pages


@pytest.mark.parametrize(("name", "pages"), [("park", {"slam", "scorecard"}), ("attic", EVERY)])
def test_a_recording_that_arrives_expires_who_names_it(
    house: Path, monkeypatch: pytest.MonkeyPatch, name: str, pages: set[str]
):
    before = keys(house)
    of(monkeypatch, data=Recordings(name))
    assert expired(before, house) == pages


@pytest.mark.parametrize("cell", ["import house", "from house.rooms import unused"])
def test_a_page_that_asks_its_own_module_reaches_no_more_than_its_cells(house: Path, cell: str):
    """Its pictures may come before what they are made of."""
    asks = "from robot_perception.book import hero"
    before = {}
    for name, text in (("plain", "pass"), ("own", asks)):
        cells = [nbformat.v4.new_code_cell(one) for one in (text, cell)]
        page = house / "book/hero.ipynb"
        write(page, nbformat.writes(nbformat.v4.new_notebook(cells=cells)))
        before[name] = keys(house)["hero"]
    assert before["own"] == before["plain"] is not None


def test_bytecode_expires_nothing_and_a_page_without_code_has_no_key(house: Path):
    before = keys(house)
    write(house / "house/__pycache__/records.pyc", "anything")
    assert expired(before, house) == set()
    assert before["notes"] is None
    assert len({before[name] for name in EVERY}) == 3


def test_a_page_that_reads_the_contents_reads_every_page():
    book, found = ROOT / "book", Dependencies(ROOT)
    for name in ("words", "course", "intro"):
        read = {file.name for file in found._read_by([said_in(book / f"{name}.md")])}
        assert {"_toc.yml", "walls.ipynb", "your_own_data.md"} <= read
    assert not {file.name for file in found._read_by([said_in(book / "walls.ipynb")])} & {
        "_toc.yml"
    }


def test_the_monobot_stands_on_no_walls_and_the_scorecard_on_every_chapter():
    book, found = ROOT / "book", Dependencies(ROOT)
    monobot = found.modules([said_in(book / "monobot.ipynb")])
    scorecard = found.modules([said_in(book / "scorecard.ipynb")])
    assert {"robot_perception.slam.monobot", "data_synth.monobot"} <= monobot
    assert not {name for name in monobot if "walls" in name}
    assert {f"robot_perception.chapters.{stem}" for stem in CHAPTERS} <= scorecard


COMPUTES = """
def area(width, height):
    return width * height
"""
SAME = [
    COMPUTES.replace("\n", "  # of a wall\n"),
    f'"""Of walls."""{COMPUTES}',
    COMPUTES.replace("    return", '    """Return it, in m²."""\n    return'),
    COMPUTES.replace("width * height", "(\n        width\n        * height\n    )"),
    COMPUTES + '"""Of the scans."""',
]
OTHER = [
    COMPUTES.replace("*", "+"),
    COMPUTES.replace("width, height", "height, width"),
    COMPUTES.replace("width * height", "width * height * 1.0"),
    COMPUTES.replace("return ", ""),
    COMPUTES.replace("    return", "    width = None\n    return"),
    COMPUTES + "LEAST = 4",
    COMPUTES + 'LEAST = "4"',
    COMPUTES + "LEAST = [[1], 2]",
    COMPUTES + "LEAST = [[1, 2]]",
]


def digest(root: Path, *modules: str) -> str:
    found = Imports(("house",), ("house.records",))
    return found.digest(*(modules or ("house.chapters.walls",)))


@pytest.mark.parametrize("text", SAME)
def test_what_does_nothing_changes_no_digest(house: Path, text: str):
    write(house / "house/rooms/walls.py", COMPUTES)
    before = digest(house)
    write(house / "house/rooms/walls.py", text)
    assert digest(house) == before


def test_what_does_something_else_has_another_digest(house: Path):
    digests = []
    for text in (COMPUTES, *OTHER):
        write(house / "house/rooms/walls.py", text)
        digests.append(digest(house))
    assert len(set(digests)) == len(digests)


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("house/rooms/walls.py", True),
        ("house/chapters/walls.py", True),
        ("house/chapters/slam/study.py", False),
        ("house/rooms/__init__.py", True),  # "from house.rooms import …" says that it is meant
        ("house/chapters/__init__.py", False),
        ("house/__init__.py", False),
        ("house/records.py", False),
    ],
)
def test_a_digest_is_of_what_a_module_reaches(house: Path, name: str, changes: bool):
    write(house / "house/rooms/walls.py", "from house import records")
    write(house / "house/rooms/__init__.py", "from house.rooms import slam")
    write(
        house / "house/chapters/walls.py", "from house.rooms import slam, walls\nimport house.rooms"
    )
    before = digest(house)
    write(house / name, (house / name).read_text() + "\nMORE = 1")
    assert (digest(house) != before) == changes


def test_a_digest_of_two_modules_is_of_both_and_an_unknown_one_is_named(house: Path):
    two = ("house.chapters.walls", "house.chapters.slam.study")
    assert digest(house, *two) == digest(house, *reversed(two))
    assert len({digest(house, *two), *(digest(house, name) for name in two)}) == 3
    with pytest.raises(ValueError, match=r"no module 'house\.attic' in house"):
        digest(house, "house.attic")


@pytest.fixture
def hands(house: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Records, of which a chapter reads one."""
    folder = house / "book/_data"
    monkeypatch.setattr(dependencies, "RECORDS", "house.records")
    monkeypatch.setattr(dependencies, "records", lambda: folder)
    text = "from house import records\nHAND, STORED, LEDGER = 'hand', 'walls-map', 'claims.json'"
    write(house / "house/chapters/walls.py", text)
    for name in ("hand.json", "foot.json", "walls-map.npz", "walls-map.json"):
        write(folder / name, "1")
    return folder


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("hand.json", True),
        ("foot.json", False),  # nobody names it
        ("walls-map.json", False),  # a result, which has a key of its own
        ("walls-map.npz", False),
        ("claims.json", False),  # says what results are, so that none may depend on it
    ],
)
def test_a_digest_is_of_the_recorded_files_that_a_module_reads(hands: Path, name, changes):
    root = hands.parents[1]
    before = digest(root)
    write(hands / name, "22")
    assert (digest(root) != before) == changes


def test_who_does_not_ask_for_records_reads_none(hands: Path):
    root = hands.parents[1]
    write(root / "house/chapters/walls.py", "HAND = 'hand'")
    before = digest(root)
    write(hands / "hand.json", "22")
    assert digest(root) == before


def test_a_file_is_read_through_what_shows_it_or_by_a_name_that_is_handed_on(hands: Path):
    root = hands.parents[1]
    write(root / "house/show.py", "from house import records\nTABLE = 'foot.json'")
    write(root / "house/chapters/walls.py", "from house import show")

    def both() -> tuple[str, str]:
        imports = Imports(("house",), ("house.records", "house.show"))
        named = frozenset({"hand"})
        return imports.digest("house.chapters.walls"), imports.digest("house.show", named=named)

    first = both()
    write(hands / "foot.json", "22")
    second = both()
    write(hands / "hand.json", "22")
    third = both()
    assert first[0] != second[0] == third[0]
    assert len({first[1], second[1], third[1]}) == 3


def test_a_digest_within_packages_is_of_their_modules_alone(house: Path):
    write(house / "house/chapters/walls.py", "from house.rooms import slam")

    def within(package: str) -> str:
        return Imports(("house",)).modules_digest("house.chapters.walls", within=(package,))

    before = within("house.rooms"), within("house.chapters")
    write(house / "house/rooms/slam.py", "TABLE = 3")
    after = within("house.rooms"), within("house.chapters")
    assert (before[0] != after[0], before[1] != after[1]) == (True, False)


def test_a_trained_detector_and_measured_times_are_read_by_results():
    imports = Imports()
    hand = imports.read(
        imports.reached(["robot_perception.chapters.tutor_following.training"], results=True)
    )
    assert [file.name for file in hand] == ["open_hand.json", "open_hand_photographs.json"]
    (times,) = imports.read(["robot_perception.teaching.scores.performance"])
    assert times.name == "performance.json"
    assert not imports.read(["robot_perception.kalman"])


def test_a_chapter_is_no_part_of_the_digest_of_another():
    monobot = Imports().reached(["robot_perception.chapters.monobot.recordings"], results=True)
    assert {"robot_perception.slam.monobot", "robot_perception.datasets.carmen"} <= monobot
    assert not {name for name in monobot if "teaching" in name or "chapters.walls" in name}
    assert "robot_perception.chapters" not in monobot  # or the next chapter would change it
    assert code_digest("robot_perception.slam.monobot") != code_digest("robot_perception.kalman")


@pytest.mark.parametrize("name", [".unfinished-a1b2c3d4/claims.json", "rows/.half.npz"])
def test_what_is_hidden_among_the_records_changes_no_page(house, name):
    before = keys(house)
    write(house / "book/_data" / name, '{"claims": [{"id": ')
    assert keys(house) == before


def test_a_ledger_that_is_damaged_is_named(house):
    write(house / "book/_data/claims.json", '{"claims": [{"id": ')
    with pytest.raises(DamagedFile, match=r"_data/claims\.json: is not what is recorded there"):
        keys(house)


def test_no_table_lies_beside_the_code_that_no_digest_would_see():
    """The registry says where recordings are; whoever reads one names its hash."""
    folders = (Path(Imports().files[name]).parent for name in known_packages())
    files = (file for folder in folders for file in folder.rglob("*") if file.is_file())
    tables = {f.name for f in files if f.suffix != ".py" and IRRELEVANT.isdisjoint(f.parts)}
    assert tables == {"registry.txt", "sets.toml"}
