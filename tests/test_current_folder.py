"""What lies in the current folder is data: no process that the book starts runs it."""

import ast
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from robot_perception import datasets
from robot_perception.cli.workers import working
from studies.sweep import sweep

ROOT = Path(__file__).parents[1]
EXECUTABLE = "sys.executable"
PACKAGES = "lib", "data_synth", "book/own_data"
MODULES = ("numpy", "scipy", "pandas", "joblib", "robot_perception")
TOLD = "from pathlib import Path\nPath({!r}).touch()\n"


def vehicle() -> None:
    ones = np.ones((3, 1))
    savemat("a.mat", {"time": np.array([[0], [25], [50]]), "speed": ones, "steering": 0 * ones})
    datasets.read_vehicle("a.mat")


def fixes() -> None:
    ones = np.ones((3, 1))
    savemat("a.mat", {"timeGps": np.array([[0], [25], [50]]), "Lo_m": ones, "La_m": ones})
    datasets.read_fixes("a.mat")


def root(item: int, *, rng: np.random.Generator) -> float:
    return float(np.sqrt(item))


def worker() -> None:
    with working(2, None, None):
        assert sweep(root, [4, 9], rng=np.random.default_rng(0)) == [2, 3]


@pytest.mark.parametrize("start", [vehicle, fixes, worker])
def test_a_process_takes_no_module_from_the_current_folder(
    start: Callable[[], None], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONSAFEPATH", "")
    monkeypatch.chdir(tmp_path)
    for name in MODULES:
        (tmp_path / f"{name}.py").write_text(TOLD.format(str(tmp_path / "executed")))
    start()
    assert not (tmp_path / "executed").exists()


def started(tree: ast.Module) -> Iterator[list[str]]:
    """Yield the words of each command that begins with this interpreter."""
    for node in ast.walk(tree):
        if isinstance(node, ast.List) and node.elts and ast.unparse(node.elts[0]) == EXECUTABLE:
            yield [ast.unparse(word) for word in node.elts[1:]]


def test_every_command_with_this_interpreter_leaves_the_current_folder_out() -> None:
    files = [file for name in PACKAGES for file in (ROOT / name).rglob("*.py")]
    found = [words for file in files for words in started(ast.parse(file.read_bytes()))]
    assert found
    assert all(words[0] == "'-P'" for words in found)
