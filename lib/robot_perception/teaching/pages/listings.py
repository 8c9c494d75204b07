"""Listing of a function for a reader: its body without docstring, validation and annotations.

The source is cut, never rewritten: layout and comments stay. What goes is

* the docstring, annotations, and decorators that serve checks alone;
* a statement that only calls a check: a function of :mod:`robot_perception.checks`, one of the
  library of which the same cuts leave nothing or an argument, or one that is told the ``name`` of
  what it judges;
* ``if …: raise …``, a name bound to itself, and a loop or branch of nothing else;
* names that were bound for the sake of these alone.

The result of a check, where it is used, becomes the argument that was checked. For valid arguments
of the stated types what is left computes the same; the tests try it.
"""

import ast
import inspect
import textwrap
import tokenize
from collections.abc import Callable
from copy import deepcopy
from functools import cache

from robot_perception import checks

LIBRARY = "robot_perception."
WIDEST = 100
TYPED = frozenset({"no_type_check", "jaxtyped", "typechecked", checks.computable.__name__})
"""Decorators that serve checks alone."""

ARRAYS = frozenset({"array", "covariance", "integers", "reals", "vector"})
"""Checks that make an array of what is none; they are left out where it is one already."""

_SIMPLE = (ast.Name, ast.Attribute, ast.Subscript, ast.Call, ast.Constant, ast.Tuple)
_judgements: dict[Callable, str | None] = {}


def reduced(function: Callable) -> str:
    """Return the code that a reader needs of a function with Python source."""
    return _cut(inspect.unwrap(function)).text()


def validates(function: Callable) -> bool:
    """Return whether :func:`reduced` leaves validation out of a function."""
    return _cut(inspect.unwrap(function)).validated


@cache
def _cut(function: Callable) -> "_Cutter":
    return _Cutter(function)


def _judged(function: object) -> str | None:
    """Return which parameter a check hands back, ``""`` if none; ``None`` if it is no check."""
    if not _is_ours(function):
        return None
    if function not in _judgements:
        _judgements[function] = None  # a function that calls itself is no check
        _judgements[function] = _handed_back(function)
    return _judgements[function]


def _handed_back(function: Callable) -> str | None:
    if function.__module__ == checks.__name__:
        names = list(inspect.signature(function).parameters)
        return names[1] if names[:1] == ["name"] and len(names) > 1 else ""
    return _cut(inspect.unwrap(function)).judged


def _is_told_a_name(function: object) -> bool:
    return _is_ours(function) and next(iter(inspect.signature(function).parameters), "") == "name"


def _is_ours(function: object) -> bool:
    return inspect.isfunction(function) and function.__module__.startswith(LIBRARY)


class _Cutter(ast.NodeTransformer):
    """Cuts the source of one function.

    Parameters
    ----------
    function
        The function, unwrapped.
    """

    def __init__(self, function: Callable) -> None:
        self._source = textwrap.dedent(inspect.getsource(function))
        self._lines = self._source.splitlines(keepends=True)
        self._globals = function.__globals__
        self._locals = frozenset(function.__code__.co_varnames)
        self._arrays: set[str] = set()
        self._cuts: list[tuple[int, int, str]] = []
        self._idle: set[str] = set()  # names that what was cut had read
        self._needed: set[str] | None = None  # names that are read, once this is known
        self._dropped = 0
        (node,) = ast.parse(self._source).body
        self._cut_types(node)
        if ast.get_docstring(node) is not None:
            self._cut_lines(node.body.pop(0))
        above = len(self._cuts)
        self.generic_visit(node)
        dropped = -1
        while dropped < self._dropped:
            dropped, self._needed = self._dropped, _read(*node.body)
            self.generic_visit(node)
        self.judged = _left(node)
        if self.judged is not None:  # a check is shown as it is
            del self._cuts[above:]
        self.validated = len(self._cuts) > above

    def text(self) -> str:
        """Return what is left of the source."""
        data, parts, end = self._source.encode(), [], 0
        for start, stop, new in sorted(self._cuts, key=lambda cut: (cut[0], -cut[1])):
            if start >= end:  # else it lies in the cut before
                parts += [data[end:start], new.encode()]
                end = stop
        lines: list[str] = []
        for line in b"".join([*parts, data[end:]]).decode().splitlines():
            above = lines[-1].partition("#")[0].rstrip() if lines else ":"
            if line.strip() or (above and not above.endswith(":")):
                lines.append(line.rstrip())
        return "\n".join(lines).rstrip() + "\n"

    # ---- types ----

    def _cut_types(self, node: ast.FunctionDef) -> None:
        for decorator in node.decorator_list:
            if _name_of(decorator) in TYPED:
                self._cut_lines(decorator)
        for inner in ast.walk(node):
            if isinstance(inner, ast.FunctionDef):
                self._cut_header(inner)
            if isinstance(inner, ast.arg) and _is_array(inner.annotation):
                self._arrays.add(inner.arg)

    def _cut_header(self, node: ast.FunctionDef) -> None:
        """Write the line of a definition anew, without annotations; a comment behind it stays."""
        arguments = deepcopy(node.args)
        for argument in ast.walk(arguments):
            if isinstance(argument, ast.arg):
                argument.annotation = None
        text = ast.unparse(arguments)
        header = f"def {node.name}({text}):"
        if node.col_offset + len(header) > WIDEST:
            indent = " " * node.col_offset
            header = f"def {node.name}(\n{indent}    {text}\n{indent}):"
        self._cuts.append((self._start(node), self._end_of_header(node), header))

    def _end_of_header(self, node: ast.FunctionDef) -> int:
        line = iter(self._lines[node.lineno - 1 :])
        depth = 0
        for token in tokenize.generate_tokens(lambda: next(line, "")):
            depth += (token.string in ("(", "[", "{")) - (token.string in (")", "]", "}"))
            if token.string == ":" and depth == 0:
                break
        row, column = token.end
        before = self._lines[node.lineno + row - 2][:column]
        return self._place(node.lineno + row - 1, len(before.encode()))

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.AST:
        """Cut the annotation of a name that is bound."""
        self.generic_visit(node)
        if node.value is not None:
            self._cuts.append((self._stop(node.target), self._stop(node.annotation), ""))
        return node

    # ---- validation ----

    def visit_Call(self, node: ast.Call) -> ast.AST:
        """Put the argument in the place of the check that hands it back."""
        self.generic_visit(node)
        function = self._behind(node.func)
        judged = _judged(function)
        given = _given(function, node).get(judged) if judged else None
        if given is None:
            return node
        converts = function.__name__ in ARRAYS and function.__module__ == checks.__name__
        if converts and ast.unparse(given) not in self._arrays:
            return node
        opening, closing = ("", "") if isinstance(given, _SIMPLE) else ("(", ")")
        self._cuts.append((self._start(node), self._start(given), opening))
        self._cuts.append((self._stop(given), self._stop(node), closing))
        self._note(node)
        return given

    def visit_IfExp(self, node: ast.IfExp) -> ast.AST:
        """Put the value in the place of a choice between it and itself."""
        self.generic_visit(node)
        if ast.unparse(node.body) != ast.unparse(node.orelse):
            return node
        self._cuts.append((self._stop(node.body), self._stop(node), ""))
        self._note(node)
        return node.body

    def visit_If(self, node: ast.If) -> ast.AST | None:
        """Drop a guard, and a branch of which nothing is left."""
        if not node.orelse and isinstance(node.body[-1], ast.Raise):
            return self._drop(node)
        before = len(self._cuts), set(self._idle), self._dropped
        whole = deepcopy(node)
        self.generic_visit(node)
        if node.body:
            return node
        if not node.orelse:
            return self._drop(node)
        cuts, self._idle, self._dropped = before
        del self._cuts[cuts:]
        return whole

    def visit_For(self, node: ast.For) -> ast.AST | None:
        """Drop a loop of which nothing is left."""
        self.generic_visit(node)
        return node if node.body else self._drop(node)

    def visit_Expr(self, node: ast.Expr) -> ast.AST | None:
        """Drop a call that is there for what it may raise."""
        if isinstance(node.value, ast.Call):
            function = self._behind(node.value.func)
            if _judged(function) is not None or _is_told_a_name(function):
                return self._drop(node)
        return self.generic_visit(node)

    def visit_Assign(self, node: ast.Assign) -> ast.AST | None:
        """Drop names that are bound to themselves, or had only served what is cut."""
        read, names = _read(node), _bound(node)
        self.generic_visit(node)
        if len(node.targets) == 1 and ast.unparse(node.targets[0]) == ast.unparse(node.value):
            self._idle |= read
            return self._drop(node)
        if self._needed is not None and names & self._idle and not names & self._needed:
            return self._drop(node)
        return node

    def _drop(self, node: ast.stmt) -> None:
        self._dropped += 1
        self._note(node)
        self._cut_lines(node)

    def _note(self, node: ast.AST) -> None:
        self._idle |= _read(node)

    def _behind(self, node: ast.expr) -> object:
        """Return the object behind a name that is no variable of the function, or ``None``."""
        if isinstance(node, ast.Name):
            return None if node.id in self._locals else self._globals.get(node.id)
        if isinstance(node, ast.Attribute):
            return getattr(self._behind(node.value), node.attr, None)
        return None

    # ---- places ----

    def _cut_lines(self, node: ast.stmt | ast.expr) -> None:
        """Cut the lines of a statement or decorator, and the comment that stands above it."""
        first = node.lineno
        while self._lines[first - 2].lstrip().startswith("#") and first > 1:
            first -= 1
        self._cuts.append((self._place(first, 0), self._place(node.end_lineno + 1, 0), ""))

    def _start(self, node: ast.AST) -> int:
        return self._place(node.lineno, node.col_offset)

    def _stop(self, node: ast.AST) -> int:
        return self._place(node.end_lineno, node.end_col_offset)

    def _place(self, line: int, column: int) -> int:
        """Return the place of a byte in the source."""
        return len("".join(self._lines[: line - 1]).encode()) + column


def _left(node: ast.FunctionDef) -> str | None:
    """Return which parameter is all that a function gives, ``""`` for nothing; else ``None``."""
    names = {arg.arg for arg in ast.walk(node.args) if isinstance(arg, ast.arg)}
    match node.body:
        case []:
            return ""
        case [ast.Return(value=ast.Name(id=name))] if name in names:
            return name
    return None


def _given(function: Callable, node: ast.Call) -> dict[str, ast.expr]:
    """Return the arguments of a call by parameter; none if one is starred."""
    if any(isinstance(a, ast.Starred) for a in node.args) or not all(k.arg for k in node.keywords):
        return {}
    named = {keyword.arg: keyword.value for keyword in node.keywords}
    return inspect.signature(function).bind_partial(*node.args, **named).arguments


def _name_of(node: ast.expr) -> str:
    """Return the last name of a decorator."""
    return ast.unparse(node).partition("(")[0].rpartition(".")[2]


def _is_array(annotation: ast.expr | None) -> bool:
    """Return whether an annotation says that a value is an array, or none."""
    kinds = ast.unparse(annotation).split(" | ") if annotation is not None else [""]
    return all("np.ndarray" in kind or kind == "None" for kind in kinds)


def _read(*nodes: ast.AST) -> set[str]:
    """Return the names that code reads; one that it counts up is read."""
    names = [inner for node in nodes for inner in ast.walk(node)]
    counted = {n.target.id for n in names if isinstance(n, ast.AugAssign) and _is_name(n.target)}
    return counted | {n.id for n in names if _is_name(n) and isinstance(n.ctx, ast.Load)}


def _is_name(node: ast.AST) -> bool:
    return isinstance(node, ast.Name)


def _bound(statement: ast.Assign) -> set[str]:
    """Return the names that a statement binds, if it does nothing else."""
    targets = [inner for target in statement.targets for inner in ast.walk(target)]
    if not all(isinstance(t, ast.Name | ast.Tuple | ast.expr_context) for t in targets):
        return set()
    return {target.id for target in targets if _is_name(target)}
