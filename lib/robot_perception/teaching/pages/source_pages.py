"""Pages of source code: every module of the library, with a target at every definition.

The module of a notebook is its study cells, each below a line that names it.

They take the place of those of `sphinx.ext.viewcode`, which has targets only for what autodoc
documents; its links from the library's pages lead here, too.
"""

import ast
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from robot_perception.project import BOOK
from studies.keys.cells import study_cells

FOLDER = "_modules"
TEMPLATE = "page.html"


def address(module: str, name: str) -> str:
    """Return the address of the source of a definition, seen from a page of the book."""
    return f"{FOLDER}/{module.replace('.', '/')}.html#{name}"


def modules(root: Path) -> dict[str, Path]:
    """Return the files whose source is shown, by module: the library, and the tests of claims."""
    library, tests = root / "lib", root / "tests"
    notebooks = {
        f"{BOOK}{page.stem}": page
        for page in sorted((root / "book").glob("*.ipynb"))
        if study_cells(page)
    }
    files = [(file, library) for file in sorted(library.rglob("*.py"))]
    files += [(file, root) for file in sorted(tests.rglob("test_claims.py"))]
    return {_module(file.relative_to(above)): file for file, above in files} | notebooks


def text(file: Path) -> str:
    """Return the source of a module: of a notebook, that of its study cells."""
    if file.suffix != ".ipynb":
        return file.read_text("utf-8")
    return "\n\n".join(f"# {name.removeprefix(f'{file.parent}/')}\n{code}\n"
                       for name, code in study_cells(file))  # fmt: skip


def pages(
    root: Path, built: Path, highlight: Callable[[str], str]
) -> Iterator[tuple[str, dict[str, Any], str]]:
    """Yield the pages whose source is newer than what is built, and the list of all, for Sphinx."""
    names = modules(root)
    for name, file in names.items():
        page = f"{FOLDER}/{name.replace('.', '/')}"
        target = built / f"{page}.html"
        if not target.exists() or target.stat().st_mtime < file.stat().st_mtime:
            code = text(file)
            up = "../" * name.count(".")
            body = (
                f'<h1><code>{name}</code></h1><p><a href="{up}index.html">All modules</a></p>'
                f"{with_targets(highlight(code), definitions(code))}"
            )
            yield page, {"title": name, "body": body}, TEMPLATE
    links = (f'<li><a href="{n.replace(".", "/")}.html"><code>{n}</code></a></li>' for n in names)
    body = f"<h1>All modules</h1><ul>{''.join(links)}</ul>"
    yield f"{FOLDER}/index", {"title": "All modules", "body": body}, TEMPLATE


def definitions(code: str) -> dict[int, str]:
    """Return the qualified names of functions and classes by their first lines, decorators too.

    Names that are bound to a call, as claims are, have a place, too.
    """
    return dict(_defined(ast.parse(code), ""))


def _defined(node: ast.AST, above: str) -> Iterator[tuple[int, str]]:
    for inner in ast.iter_child_nodes(node):
        if isinstance(inner, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            first = min(line.lineno for line in (inner, *inner.decorator_list))
            yield first, f"{above}{inner.name}"
            if isinstance(inner, ast.ClassDef):
                yield from _defined(inner, f"{above}{inner.name}.")
        elif isinstance(inner, ast.Assign) and isinstance(inner.value, ast.Call) and not above:
            yield from ((inner.lineno, one.id) for one in inner.targets if hasattr(one, "id"))


def with_targets(highlighted: str, names: dict[int, str]) -> str:
    """Return highlighted code with a target before each line that begins a definition."""
    before, opening, code = re.split(r"(<pre[^>]*>)", highlighted, maxsplit=1)
    lines = code.split("\n")
    for number, name in names.items():
        target = f'<span class="rp-definition" id="{name}"></span>'
        lines[number - 1] = target + lines[number - 1]
    return before + opening + "\n".join(lines)


def _module(file: Path) -> str:
    parts = file.with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
