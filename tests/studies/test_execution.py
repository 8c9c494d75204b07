"""Pages are executed at the same time, and those who read them find the results."""

from pathlib import Path

import nbformat
import pytest
from myst_nb.core.config import NbParserConfig
from myst_nb.core.execute import create_client
from myst_nb.core.loggers import DocutilsDocLogger
from myst_parser.config.main import MdParserConfig

from studies.pages import execution
from studies.pages.execution import execute

MEET = """
import time
from pathlib import Path
Path("{me}").touch()
end = time.monotonic() + 60
while not Path("{other}").exists() and time.monotonic() < end:
    time.sleep(0.02)
print(Path("{other}").exists())
"""
TEXT = """---
kernelspec: {name: python3, display_name: Python 3}
jupytext: {text_representation: {format_name: myst}}
---
```{code-cell}
print("of a text")
```
"""


def notebook(file: Path, code: str) -> None:
    cells = [nbformat.v4.new_code_cell(code)]
    kernel = {"kernelspec": {"name": "python3", "display_name": "Python 3"}}
    nbformat.write(nbformat.v4.new_notebook(cells=cells, metadata=kernel), file)


def config(page: Path) -> NbParserConfig:
    cache = page.parent / "caches" / page.stem
    return NbParserConfig(
        execution_mode="cache", execution_cache_path=str(cache), execution_raise_on_error=True
    )


@pytest.fixture
def pages(tmp_path: Path) -> list[Path]:
    """Two pages that wait for each other, one that fails, and a text."""
    notebook(tmp_path / "one.ipynb", MEET.format(me="1", other="2"))
    notebook(tmp_path / "two.ipynb", MEET.format(me="2", other="1"))
    notebook(tmp_path / "wrong.ipynb", "1 / 0")
    (tmp_path / "text.md").write_text(TEXT)
    return [tmp_path / name for name in ("one.ipynb", "two.ipynb", "wrong.ipynb", "text.md")]


def test_pages_run_together_and_their_reader_finds_the_results(
    pages: list[Path], monkeypatch: pytest.MonkeyPatch
):
    execute([(page, config(page)) for page in pages], MdParserConfig(), 2)
    *found, wrong, text = pages
    monkeypatch.setattr("myst_nb.core.execute.cache.single_nb_execution", not_again)
    assert [printed(page) for page in (*found, text)] == ["True", "True", "of a text"]
    with pytest.raises(AssertionError, match="executed again"):
        printed(wrong)
    execute([(page, config(page)) for page in found], MdParserConfig(), 2)
    with pytest.raises(AssertionError, match="executed again"):
        execute([(wrong, config(wrong))], MdParserConfig(), 2)


def not_again(*args: object, **kwargs: object) -> None:
    raise AssertionError("executed again")


def printed(page: Path) -> str:
    """Read a page as Sphinx does; return what its cell has printed."""
    text, own = page.read_text(), config(page)
    reader = execution.create_nb_reader(str(page), MdParserConfig(), own, text)
    told = DocutilsDocLogger.__new__(DocutilsDocLogger)  # says nothing in this test
    told.info = lambda *words: None
    client = create_client(reader.read(text), str(page), own, told, reader.read_fmt)
    client.start_client()
    return client.notebook.cells[-1].outputs[0].text.strip()
