"""Compiled functions, where numba can keep what it compiles and where it cannot."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import data_synth._kernels
import robot_perception.kernels

ROOT = Path(__file__).parents[1]
DECORATORS = [robot_perception.kernels, data_synth._kernels]
SUMS = """
import resource, sys, warnings
import numpy as np
from importlib import import_module

def total(values):
    found = 0.0
    for value in values:
        found += value
    return found

warnings.simplefilter("always")
with warnings.catch_warnings(record=True) as told:
    {before}
    for name in sys.argv[1:]:
        summed = import_module(name).kernel()(total)
        assert summed(np.arange(4.0)) == 6 and summed.signatures
print(len(told), *(f"{{t.category.__name__}} {{t.message}}" for t in told), sep="\\n")
"""
READ_ONLY = """
import tempfile
from errno import EROFS

def refuse(*_, **__):
    raise OSError(EROFS, "Read-only file system")

tempfile.TemporaryFile = refuse  # by which numba asks whether a folder can be written
"""


def run(tmp_path: Path, program: str, *arguments: str) -> list[str]:
    """Return the lines that a program prints, with a cache of its own."""
    file = tmp_path / "program.py"  # numba keeps nothing of what has no file
    file.write_text(program, "utf-8")
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    command = [sys.executable, str(file), *arguments]
    done = subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout.splitlines()


def sums(tmp_path: Path, before: str = "pass") -> list[str]:
    """Return what both decorators' kernels warned of."""
    names = [module.__name__ for module in DECORATORS]
    return run(tmp_path, SUMS.format(before=before.replace("\n", "\n    ")), *names)


def code() -> dict[str, str]:
    """Return the text of each module of ours by its name."""
    tools = (ROOT / "lib" / name for name in ("robot_perception", "explorables", "studies"))
    tops = (*tools, ROOT / "data_synth")
    files = [(file, top.parent) for top in tops for file in sorted(top.rglob("*.py"))]
    return {
        ".".join(file.relative_to(above).with_suffix("").parts): file.read_text("utf-8")
        for file, above in files
    }


def test_no_other_module_asks_numba_to_compile():
    names = {module.__name__ for module in DECORATORS}
    names.add("studies.pages.forked")  # it warms numba up, and keeps nothing
    assert {name for name, text in code().items() if "njit" in text} == names


def test_what_is_compiled_is_kept(tmp_path):
    assert sums(tmp_path) == ["0"]
    assert len([*(tmp_path / "cache").rglob("*.nbi")]) == 1
    assert [*(tmp_path / "cache").rglob("*.nbc")]


def test_without_a_place_kernels_are_compiled_all_the_same(tmp_path):
    count, *told = sums(tmp_path, READ_ONLY)
    assert count == "2"
    assert all("RuntimeWarning no folder can be written" in line for line in told)
    assert not [*tmp_path.rglob("*.nb?")]


def test_on_a_full_disk_kernels_are_compiled_all_the_same(tmp_path):
    pytest.importorskip("resource")
    limit = "resource.setrlimit(resource.RLIMIT_FSIZE, (0, resource.RLIM_INFINITY))"
    count, *told = sums(tmp_path, limit)
    assert count == "2"
    assert all("NUMBA_CACHE_DIR" in line for line in told)


def test_every_module_with_kernels_can_be_imported_without_a_place(tmp_path):
    names = [name for name, text in code().items() if "@kernel(" in text]
    program = f"{READ_ONLY}\nimport sys\nfrom importlib import import_module\n"
    program += "for name in sys.argv[1:]:\n    import_module(name)\nprint(len(sys.argv) - 1)"
    assert len(names) > 30
    assert run(tmp_path, program, *names) == [str(len(names))]
    assert not [*tmp_path.rglob("*.nb?")]


@pytest.mark.parametrize("module", DECORATORS, ids=lambda module: module.__name__)
def test_options_are_numba_s(module):
    @module.kernel(fastmath={"reassoc"}, inline="always")
    def half(value):
        return value / 2

    assert half(3.0) == 1.5
    assert half.targetoptions["fastmath"] == {"reassoc"}
    assert half.targetoptions["inline"] == "always"
    assert half.py_func(np.float64(3)) == 1.5
