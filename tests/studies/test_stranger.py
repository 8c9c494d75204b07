"""A stranger's studies: the script of the README, and a book of its own, without ours."""

import re
import subprocess
import sys
from pathlib import Path

import nbformat
import pytest
from nbformat.v4 import new_code_cell, new_notebook

LIB = Path(__file__).parents[2] / "lib"
ALONE = """
import sys
for name in ("robot_perception", "data_synth"):
    sys.modules[name] = None  # importing it raises
exec(compile(sys.stdin.read(), "script.py", "exec"))
"""
BLOCKS = re.findall(
    r"```python\n(.*?)```", (LIB / "studies" / "README.md").read_text("utf-8"), re.S
)


def alone(script: str, folder: Path) -> list[str]:
    """Run a script where there is no book of ours, and return what it prints."""
    run = subprocess.run(
        [sys.executable, "-c", ALONE],
        input=script,
        cwd=folder,
        env={"PYTHONPATH": f"{LIB}:{folder}", "HOME": str(folder), "PATH": ""},
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr
    return run.stdout.splitlines()


def test_a_script_runs_a_study(tmp_path: Path):
    found = alone(BLOCKS[0], tmp_path)
    assert re.match(r"0\.[67]\d* \[0\.6\d*, 0\.7\d*\]", found[0])
    assert found[1].split() == ["bias", "share"]
    assert not list(tmp_path.glob("**/*.npz"))


@pytest.fixture
def book(tmp_path: Path) -> Path:
    """The book of the README, in which one notebook has the study of its script."""
    package, pages = re.split(r"# mybook/(?:pages/)?__init__\.py\n", BLOCKS[1])[1:]
    (tmp_path / "mybook" / "pages").mkdir(parents=True)
    (tmp_path / "mybook" / "__init__.py").write_text(package)
    (tmp_path / "mybook" / "pages" / "__init__.py").write_text(pages)
    (tmp_path / "book" / "_data").mkdir(parents=True)
    return tmp_path


def write(book: Path, change: str = "") -> None:
    """Write the notebook."""
    source = BLOCKS[0].partition("print(")[0].replace("< bias", f"< bias{change}")
    cell = new_code_cell(source, metadata={"tags": ["study"]})
    nbformat.write(new_notebook(cells=[cell]), book / "book" / "coins.ipynb")


def test_a_book_of_a_stranger_records_rows_and_knows_when_they_are_old(book: Path):
    write(book)
    asks = "import mybook\nfrom mybook.pages.coins import tossed\n"
    says = "print(tossed.is_current(), tossed.rows().note)"
    recorded = alone(f"{asks}tossed.record()\n{says}", book)
    assert recorded[0].startswith("True Computed on")
    assert (book / "book" / "_data" / "rows" / "coins.tossed.npz").exists()
    again = alone(f"{asks}{says}", book)
    assert again[0].endswith("by this code: 200 coins.")
    write(book, " / 2")
    changed = alone(f"{asks}{says}", book)
    assert changed[0].startswith("False Computed on")
    assert changed[0].endswith("by earlier code: 200 coins.")
