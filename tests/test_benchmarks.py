"""The benchmarks run seldom, and not in the tests: what they take from us must be there."""

import ast
from importlib import import_module
from pathlib import Path

import pytest

OURS = ("data_synth", "robot_perception", "tests")
MODULES = sorted((Path(__file__).parent / "tools/benchmarks").glob("bench_*.py"))


@pytest.mark.parametrize("module", MODULES, ids=lambda path: path.stem)
def test_what_a_benchmark_imports_of_ours_is_there(module: Path) -> None:
    imports = [
        node
        for node in ast.walk(ast.parse(module.read_text("utf-8")))
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] in OURS
    ]
    assert imports
    for node in imports:
        home = import_module(node.module)
        for name in (alias.name for alias in node.names):
            assert hasattr(home, name) or import_module(f"{node.module}.{name}"), name
