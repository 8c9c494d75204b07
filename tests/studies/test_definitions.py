"""What definitions of a module read: edits of each kind, told apart by the digests they change."""

import ast
from pathlib import Path

import pytest

from studies.keys.definitions import WHOLE, Module, asked_of
from studies.keys.dependencies import EFFECTS, Imports

FILES = {
    "yard/__init__.py": "",
    "yard/doors.py": "def door(room, offered, by):\n    return by, None, []",
    "yard/tools.py": "EDGE = 2\nLONG = 3\n\n\ndef saw(x):\n    return x + EDGE\n\n\n"
    "def rake(x):\n    return x",
    "yard/hut/__init__.py": "from importlib import import_module\n\nfrom yard.doors import door\n\n"
    "__getattr__, __dir__, __all__ = door(__name__, {'bench': ('plane',)}, import_module)",
    "yard/hut/bench.py": "def plane(x):\n    return x\n\n\ndef vice(x):\n    return x",
    "yard/work.py": "from yard import tools\nfrom yard.hut import plane\n"
    "from .tools import rake\n\n\ndef cut(x):\n    return tools.saw(x)\n\n\n"
    "def smooth(x):\n    return plane(x)\n\n\ndef tidy(x):\n    return rake(x)\n\n\n"
    "def lend():\n    return tools\n\n\n"
    "def late(x):\n    from yard.hut import bench\n\n    return bench.vice(x)",
}


@pytest.fixture
def yard(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    return tmp_path


def reached(name: str) -> set[str]:
    found = Imports(("yard",), ()).definitions([("yard.work", name)])
    return {f"{module.removeprefix('yard.')}.{one}" for module, one in found}


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("cut", {"work.cut", "tools.saw", "tools.EDGE"}),
        ("tidy", {"work.tidy", "tools.rake"}),
        ("smooth", {"work.smooth", "hut.bench.plane"}),  # behind a door
        ("lend", {"work.lend", *(f"tools.{one}" for one in ("EDGE", "LONG", "saw", "rake"))}),
        ("late", {"work.late", "hut.bench.vice"}),
    ],
)
def test_a_definition_reaches_what_it_reads(yard: Path, name: str, expected: set[str]):
    assert reached(name) == expected


def test_a_name_that_nobody_binds_stands_for_the_whole_module(yard: Path):
    every = {"work.cut", "work.smooth", "work.tidy", "work.lend", "work.late", "tools.LONG"}
    assert every < reached("attic")
    assert reached("attic") == reached(WHOLE)


def test_what_an_import_does_beside_binding_names_counts_for_all_who_cause_it(yard: Path):
    before = Imports(("yard",), ()).digest("yard.work:tidy")
    tools = yard / "yard/tools.py"
    tools.write_text(f"{tools.read_text()}\n\n\nprint(LONG)")
    assert reached("tidy") == {"work.tidy", "tools.rake", f"tools.{EFFECTS}", "tools.LONG"}
    assert Imports(("yard",), ()).digest("yard.work:tidy") != before


@pytest.mark.parametrize(
    ("file", "old", "new", "changed"),
    [
        ("tools", "EDGE = 2", "EDGE = 4", {"cut", "lend"}),
        ("tools", "LONG = 3", "LONG = 4", {"lend"}),
        ("tools", "def rake(x):\n    return x", "def rake(x):\n    return -x", {"tidy", "lend"}),
        ("hut/bench", "def vice(x):\n    return x", "def vice(x):\n    return -x", {"late"}),
        ("work", "import rake", "import saw as rake", {"tidy"}),
        ("work", "return plane(x)", "return plane(-x)", {"smooth"}),
    ],
)
def test_an_edit_changes_the_digests_of_those_that_reach_it(yard, file, old, new, changed):
    names = ("cut", "smooth", "tidy", "lend", "late")

    def digests() -> list[str]:
        imports = Imports(("yard",), ())
        return [imports.digest(f"yard.work:{name}") for name in names]

    before = digests()
    path = yard / f"yard/{file}.py"
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    after = digests()
    assert {name for name, a, b in zip(names, before, after, strict=True) if a != b} == changed


def both(text: str) -> str:
    """Return the digest of what both other definitions are read by."""
    Path("yard/both.py").write_text(f"{text}\n\n\ndef both(x):\n    return saw(rake(x))\n")
    return Imports(("yard",), ()).digest("yard.both:both")


def test_imports_that_change_places_change_the_digest(yard: Path, monkeypatch):
    monkeypatch.chdir(yard)
    first = both("from yard.tools import rake, saw")
    assert both("from yard.tools import rake as saw, saw as rake") != first
    assert both("from yard.tools import saw, rake") == first


def test_a_module_that_is_found_by_its_path_counts_whole(yard: Path):
    (yard / "yard/tools.py").write_text("tools = 1\n\n\ndef saw(x):\n    return x")
    text = "import yard.tools\n\n\ndef cut(x):\n    return yard.tools.saw(x)"
    (yard / "yard/work.py").write_text(text)
    assert reached("cut") == {"work.cut", "tools.tools", "tools.saw"}


PLACE = "yard", {"yard.tools"}
STATEMENTS = """
import os
import yard.tools

RULES = {}
RULES["a"] = 1
COUNT = 0
COUNT += 1
for ROW in range(3):
    LAST = ROW
area = print


@area.register
def _(x):
    return x


@os.register
def other(x):
    return x


os.environ["A"] = "b"
"""


def test_what_adds_to_a_name_is_part_of_its_definition_and_what_adds_to_others_is_an_effect():
    module = Module(ast.parse(STATEMENTS), *PLACE)
    assert module.names == {"os", "yard", *("RULES", "COUNT", "ROW", "LAST", "area", "_", "other")}
    for line in ('RULES["a"] = 1', "COUNT += 1", "    LAST = ROW", "    return x"):
        edited = Module(ast.parse(STATEMENTS.replace(line, f"{line} + 1")), *PLACE)
        changed = {n for n in module.names if module.definition(n) != edited.definition(n)}
        assert changed, line
    effects = module.effects()
    assert effects is not None
    assert effects.taken == {("os", "environ"), ("os", "register")}


@pytest.mark.parametrize(
    ("text", "expected"),
    [("m.a(m.b)", {"a", "b"}), ("f(m)", None), ("m.a + m", None), ("a.m", set())],
)
def test_what_is_asked_of_a_module_is_known_unless_it_is_handed_on(text: str, expected):
    assert asked_of("m", [*ast.walk(ast.parse(text))]) == expected
