"""Definitions of a module: what each does, and the names that it reads.

A definition is what binds a name of the module: a function, a class, a constant. It reads names of
its own module and names of others; of a module that is used by its name, ``kalman.predict``, those
that are asked of it. Where it hands a module on whole, all of it counts. A name that a function
uses for a variable of its own counts as the module's: too much is reached then, never too little.
"""

import ast
import hashlib
from collections.abc import Collection, Container, Iterable, Iterator
from dataclasses import dataclass

WHOLE = ""
"""Stands for all names of a module."""
DOOR = "door"
"""The function by which a package offers what its modules define (`robot_perception.doors`)."""
DEFINES = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
_END = object()


@dataclass(frozen=True)
class Definition:
    """Definition of a name.

    Parameters
    ----------
    meaning
        Hash of its statements, and of what the imported names stand for that it reads.
    names
        Of its own module that it reads.
    taken
        Pairs of a module and a name that it takes from others; the name may be `WHOLE`.
    """

    meaning: str
    names: frozenset[str] = frozenset()
    taken: frozenset[tuple[str, str]] = frozenset()


class Module:
    """Definitions of a module; it is parsed when they are asked for.

    Parameters
    ----------
    tree
        Its syntax tree.
    package
        Name of the package in which it is, or that it is.
    modules
        Names of all modules that are ours, to tell a module from what it defines.
    """

    def __init__(self, tree: ast.Module, package: str, modules: Container[str]) -> None:
        self._package, self._modules = package, modules
        self._found: dict[str, Definition] = {}
        self._statements: dict[str, list[ast.stmt]] = {}
        self._effects: list[ast.stmt] = []
        statements = [one for one in tree.body if not is_text(one)]
        outside = (one for one in statements if not isinstance(one, DEFINES))
        self._imports = self._imported(node for one in outside for node in ast.walk(one))
        for statement in statements:
            bound, changed = {*_binding([statement])}, _changed(statement)
            if changed & self._imports.keys() or not bound | changed:
                self._effects.append(statement)
            for name in bound | changed - self._imports.keys():
                self._statements.setdefault(name, []).append(statement)
        self.names = frozenset(self._statements)
        """Names that it binds."""
        self.offered = {name: home for one in statements for name, home in _offered(one).items()}
        """The module below a package in which a name is found that the package offers."""

    def definition(self, name: str) -> Definition:
        """Return what binds a name.

        Raises
        ------
        KeyError
            If nothing does.
        """
        if name not in self._found:
            self._found[name] = self._read(self._statements[name])
        return self._found[name]

    def effects(self) -> Definition | None:
        """Return what it does when it is imported, beside binding names; ``None`` if nothing."""
        return self._read(self._effects) if self._effects else None

    def _read(self, statements: list[ast.stmt]) -> Definition:
        nodes = [node for statement in statements for node in ast.walk(statement)]
        inside = self._imported(nodes)
        imports = {**self._imports, **inside}
        read = {node.id for node in nodes if isinstance(node, ast.Name)} | inside.keys()
        taken: set[tuple[str, str]] = set()
        said = [meaning(statement) for statement in statements]
        for alias in sorted(read & imports.keys()):
            module, name = imports[alias]
            said.append(f"{alias} {module} {name}")
            by_path = alias == module.partition(".")[0] != module  # as `import a.b` is
            asked = None if name != WHOLE or by_path else asked_of(alias, nodes)
            taken |= {(module, one) for one in asked} if asked else {(module, name)}
        digest = hashlib.sha256("\n".join(said).encode()).hexdigest()[:16]
        return Definition(
            digest, frozenset(read & self.names - self._imports.keys()), frozenset(taken)
        )

    def _imported(self, nodes: Iterable[ast.AST]) -> dict[str, tuple[str, str]]:
        """Return the module and the name for which each imported name stands."""
        found = {}
        for node in nodes:
            if isinstance(node, ast.Import):
                for alias in node.names:  # `import a.b` binds a, by which a.b is found
                    found[alias.asname or alias.name.partition(".")[0]] = alias.name, WHOLE
            elif isinstance(node, ast.ImportFrom):
                above = self._package.split(".")
                above = above[: len(above) + 1 - node.level] if node.level else []
                module = ".".join([*above, *filter(None, [node.module])])
                for alias in node.names:
                    whole = f"{module}.{alias.name}"
                    place = (whole, WHOLE) if whole in self._modules else (module, alias.name)
                    found[alias.asname or alias.name] = place
        return found


def meaning(tree: ast.AST) -> str:
    """Hash a syntax tree without what does nothing: texts that are statements."""
    said: list[str] = []
    todo: list[object] = [tree]
    while todo:
        node = todo.pop()
        if isinstance(node, ast.AST):  # `ast.dump` differs between versions of Python
            said.append(f"{type(node).__name__}(")
            todo.append(_END)
            for name, value in ast.iter_fields(node):
                if value is not None and value != []:
                    todo += [value, name]
        elif isinstance(node, list):
            todo += reversed([part for part in node if not is_text(part)])
        else:
            said.append(")" if node is _END else repr(node))
    return hashlib.sha256(" ".join(said).encode()).hexdigest()


def is_text(node: object) -> bool:
    """Tell whether a statement is a text and nothing else, as a docstring is."""
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def asked_of(alias: str, nodes: Collection[ast.AST]) -> set[str] | None:
    """Return what some nodes ask of a module by its name; ``None`` if they hand it on whole."""
    named = sum(isinstance(node, ast.Name) and node.id == alias for node in nodes)
    asked = [
        node.attr
        for node in nodes
        if isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Name)
        and node.value.id == alias
    ]
    return {*asked} if len(asked) == named else None


def _binding(nodes: Iterable[ast.AST]) -> Iterator[str]:
    """Yield the names of the module that statements bind."""
    for node in nodes:
        if isinstance(node, DEFINES):
            yield node.name
        elif isinstance(node, ast.Import | ast.ImportFrom):
            yield from ((alias.asname or alias.name).partition(".")[0] for alias in node.names)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id
        elif not isinstance(node, ast.Lambda):
            yield from _binding(ast.iter_child_nodes(node))


def _changed(statement: ast.stmt) -> set[str]:
    """Return the names to whose values a statement adds: ``RULES[…] = …``, ``@area.register``."""
    targets: list[ast.expr] = []
    if isinstance(statement, ast.Assign):
        targets = [t for t in statement.targets if isinstance(t, ast.Subscript | ast.Attribute)]
    elif isinstance(statement, ast.FunctionDef | ast.ClassDef):
        calls = [d.func if isinstance(d, ast.Call) else d for d in statement.decorator_list]
        targets = [c for c in calls if isinstance(c, ast.Attribute) and c.attr == "register"]
    found = set()
    for target in targets:
        while isinstance(target, ast.Subscript | ast.Attribute):
            target = target.value
        found |= {target.id} if isinstance(target, ast.Name) else set()
    return found


def _offered(statement: ast.stmt) -> dict[str, str]:
    """Return the modules of the names that a package offers by its door."""
    value = getattr(statement, "value", None)
    if not (isinstance(value, ast.Call) and getattr(value.func, "id", "") == DOOR):
        return {}
    homes = ast.literal_eval(value.args[1])
    return {name: home for home, names in homes.items() for name in names}
