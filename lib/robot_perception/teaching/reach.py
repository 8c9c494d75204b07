"""Which code a computation reaches: a module, what it imports, and what these import.

Comments and docstrings do not count. `robot_perception.teaching` is left out: it shows and keeps
what others compute, and decides no number.
"""

import ast
import hashlib
from collections.abc import Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path

import grimp

PACKAGES = ("robot_perception", "data_synth")
LEFT_OUT = "robot_perception.teaching"


@cache
def code_digest(module: str) -> str:
    """Return a hash of the code that runs when a function of a module does.

    Of a module outside the library only its own file counts, and what that imports of the library.
    """
    digest = hashlib.sha256()
    for name in sorted(reached(module)):
        digest.update(f"{name} {_normalised(name)}\n".encode())
    return digest.hexdigest()


def reached(module: str) -> set[str]:
    """Return a module and all modules of the library that are imported with it."""
    todo, seen = {module}, set()
    while todo:
        seen |= todo
        todo = {name for one in todo for name in _next(one)} - seen
    return seen


def _next(module: str) -> Iterator[str]:
    if module.split(".")[0] not in PACKAGES:
        names = _imported(ast.parse(_file(module).read_bytes()))
    else:
        names = _graph().find_modules_directly_imported_by(module)
    for name in names:
        if name.split(".")[0] in PACKAGES and not f"{name}.".startswith(f"{LEFT_OUT}."):
            yield name


def _imported(tree: ast.Module) -> Iterator[str]:
    modules = _graph().modules
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in modules)
        elif isinstance(node, ast.ImportFrom) and node.module in modules:
            names = (f"{node.module}.{alias.name}" for alias in node.names)
            yield from (name if name in modules else node.module for name in names)


@cache
def _graph() -> grimp.ImportGraph:
    return grimp.build_graph(*PACKAGES, cache_dir=None)


@cache
def _normalised(module: str) -> str:
    """Return a hash of the code of a module without comments and docstrings."""
    tree = ast.parse(_file(module).read_bytes())
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list) and body and _is_text(body[0]):
            del body[0]
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest()


def _is_text(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def _file(module: str) -> Path:
    return Path(str(find_spec(module).origin))
