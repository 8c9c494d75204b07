"""Docstrings begin with a noun or a verb, in the plain English of an engineer."""

import ast
import doctest
import importlib
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
FOLDERS = "lib/robot_perception", "lib/explorables", "lib/studies", "data_synth"
FRAGMENT = re.compile(
    r"(What|Which|Who|Whose|Whether|How|Where|When|Of|So|Such|In|By|For|With|From|To|At|On|As|Nothing"
    r"|Nobody) "
)
"""Openings of what is a question or a part of a sentence, and does not stand alone."""


def is_titled(file: Path) -> bool:
    """Tell whether a module begins with the title of its chapter, which may be a question."""
    return file.name == "__init__.py" and file.parents[1].name == "chapters"


def documented(tree: ast.Module) -> Iterator[str]:
    """Yield the docstrings of a module: of itself, of classes and functions, below constants."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
            yield ast.get_docstring(node) or ""
            for above, below in zip(node.body, node.body[1:], strict=False):
                if isinstance(above, ast.Assign | ast.AnnAssign):
                    yield text(below)


def text(node: ast.stmt) -> str:
    """Return a statement that is a text and nothing else, or no text."""
    value = getattr(node, "value", None)
    there = isinstance(node, ast.Expr) and isinstance(value, ast.Constant)
    return value.value if there and isinstance(value.value, str) else ""


@pytest.mark.parametrize("folder", FOLDERS)
def test_first_lines_stand_alone(folder: str):
    files = [file for file in sorted((ROOT / folder).rglob("*.py")) if not is_titled(file)]
    found = [
        f"{file.relative_to(ROOT)}: {line.splitlines()[0]}"
        for file in files
        for line in documented(ast.parse(file.read_text("utf-8")))
        if FRAGMENT.match(line)
    ]
    assert files
    assert not found


EXAMPLES = [
    ".".join(file.relative_to(ROOT / start).with_suffix("").parts)
    for start in ("lib", "")
    for folder in FOLDERS
    if folder.startswith(start or "data_synth")
    for file in sorted((ROOT / folder).rglob("*.py"))
    if ">>> " in file.read_text("utf-8")
]


@pytest.mark.parametrize("module", EXAMPLES)
def test_printed_examples_give_what_they_print(module: str):
    found = doctest.testmod(importlib.import_module(module))
    assert found.attempted > 0
    assert not found.failed


def test_a_fragment_is_found():
    source = (
        'WIDTH = 4\n"""Of a frame, inches."""\n\n\ndef run():\n    """Which steps are taken."""\n'
    )
    lines = list(documented(ast.parse(source)))
    assert [bool(FRAGMENT.match(line)) for line in lines if line] == [True, True]
