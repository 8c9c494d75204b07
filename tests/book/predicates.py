"""The predicates of explorers, ``finds``, taken to pieces: what of them must matter, and for what.

A *weakened* predicate has one part changed that decides: an ``and`` that becomes ``or``, a
comparison turned round, a conjunct or a filter dropped, ``any`` in the place of ``all``.
*Disturbed* findings are the recorded ones with something broken: a number constant, turned round,
scaled, far too large in one state, or in all states of one value of a control.
"""

import ast
import copy
import random
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product, zip_longest
from statistics import median
from types import ModuleType
from typing import Any

from explorables.snapshots import ARRAY, finding_of
from studies.keys.cells import folder, study_cells
from tests.book.states import leaves

TURNED = {
    ast.Lt: ast.GtE,
    ast.GtE: ast.Lt,
    ast.Gt: ast.LtE,
    ast.LtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
}
OTHERS = {
    "any": "all",
    "all": "any",
    "And": ast.Or,
    "Or": ast.And,
    "BitAnd": ast.BitOr,
    "BitOr": ast.BitAnd,
}
EXPRESSION = "finds"
FACTORS = (-1.0, 0.0, 0.01, 0.5, 0.9, 1.1, 2.0, 100.0)
SEEDS = 3
STRANGE = "a text that no finding has"
CUTS = 12
"""About so many places where the states are cut in two by the size of a number."""
PAIRS = 40
"""Most pairs of values of two controls in whose states findings are disturbed."""

Predicate = Callable[[list[Any]], Any]
Values = list[list[Any]]


@dataclass(frozen=True)
class Source:
    """A predicate as it is written: the expression after ``finds=`` and the functions it calls."""

    module: ModuleType
    expression: ast.expr
    functions: Mapping[str, ast.FunctionDef]

    def predicate(self, changed: tuple[str, ast.AST] | None = None) -> Predicate:
        """Return the predicate, one of its parts, if any, as it was changed."""
        parts: dict[str, ast.AST] = {EXPRESSION: self.expression, **self.functions}
        parts |= dict([changed] if changed else [])
        expression = ast.Expression(parts.pop(EXPRESSION))
        names = dict(vars(self.module))
        body = ast.Module([*parts.values()], type_ignores=[])
        exec(compile(ast.fix_missing_locations(body), "<finds>", "exec"), names)
        return eval(compile(ast.fix_missing_locations(expression), "<finds>", "eval"), names)

    def weakened(self) -> Iterator[tuple[str, Predicate]]:
        """Yield predicates in which one part is changed, with what is changed."""
        for name, part in {EXPRESSION: self.expression, **self.functions}.items():
            for words, tree in weakenings(part):
                yield f"{name}: {words}", self.predicate((name, tree))


def source(module: ModuleType, name: str) -> Source:
    """Return the predicate of an explorer as its notebook has it."""
    trees = [ast.parse(text) for _, text in study_cells(folder() / f"{_stem(module)}.ipynb")]
    nodes = [node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Call)]
    said = ({word.arg: word.value for word in node.keywords} for node in nodes)
    (finds,) = (
        words["finds"]
        for words in said
        if "finds" in words and getattr(words.get("name"), "value", None) == name
    )
    defined = {
        node.name: node
        for tree in trees
        for node in tree.body
        if isinstance(node, ast.FunctionDef) and not node.decorator_list
    }
    reached: dict[str, ast.FunctionDef] = {}
    todo = [finds.id] if isinstance(finds, ast.Name) else list(_asked(finds))
    while todo:
        one = todo.pop()
        if one in defined and one not in reached:
            reached[one] = defined[one]
            todo += _asked(defined[one])
    return Source(module, finds, reached)


def _stem(module: ModuleType) -> str:
    return module.__name__.rpartition(".")[2]


def _asked(node: ast.AST) -> Iterator[str]:
    """Yield the functions that are called with something: what takes nothing knows no finding."""
    for call in (one for one in ast.walk(node) if isinstance(one, ast.Call)):
        if isinstance(call.func, ast.Name) and call.args:
            yield call.func.id


def weakenings(tree: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """Yield copies of a tree in which one part that decides is changed, with words for it."""
    for k, node in enumerate(ast.walk(tree)):
        for number in range(_ways(node)):
            other = copy.deepcopy(tree)
            target = list(ast.walk(other))[k]
            before = ast.unparse(node)
            changed = _changed(target, number)
            if changed is not target:
                other = _Put(target, changed).visit(other)
            yield f"{before} -> {ast.unparse(changed)}", other


def _ways(node: ast.AST) -> int:
    """Return in how many ways a node can be changed."""
    if isinstance(node, ast.BoolOp):
        return 1 + len(node.values)
    if isinstance(node, ast.Compare):
        return len(node.ops) + 2 * (len(node.ops) > 1)
    if isinstance(node, ast.comprehension):
        return len(node.ifs)
    if isinstance(node, ast.BinOp | ast.AugAssign):
        return type(node.op).__name__ in OTHERS
    if isinstance(node, ast.UnaryOp):
        return isinstance(node.op, ast.Not)
    return isinstance(node, ast.Call) and _word(node.func) in OTHERS


def _word(node: ast.expr) -> str:
    return getattr(node, "id", getattr(node, "attr", ""))


def _changed(node: Any, number: int) -> ast.AST:
    """Change a node, and return it or what stands in its place."""
    if isinstance(node, ast.BoolOp) and number:
        node.values.pop(number - 1)
        return node.values[0] if len(node.values) == 1 else node
    if isinstance(node, ast.BoolOp | ast.BinOp | ast.AugAssign):
        node.op = OTHERS[type(node.op).__name__]()
    elif isinstance(node, ast.Compare) and number < len(node.ops):
        node.ops[number] = TURNED[type(node.ops[number])]()
    elif isinstance(node, ast.Compare):
        if number == len(node.ops):
            node.left = node.comparators.pop(0)
            node.ops.pop(0)
        else:
            node.comparators.pop()
            node.ops.pop()
    elif isinstance(node, ast.comprehension):
        node.ifs.pop(number)
    elif isinstance(node, ast.UnaryOp):
        return node.operand
    elif isinstance(node.func, ast.Name):
        node.func.id = OTHERS[node.func.id]
    else:
        node.func.attr = OTHERS[node.func.attr]
    return node


class _Put(ast.NodeTransformer):
    """Puts a node in the place of another."""

    def __init__(self, old: ast.AST, new: ast.AST) -> None:
        self._old, self._new = old, new

    def visit(self, node: ast.AST) -> ast.AST:
        """Return the new node for the old one."""
        return self._new if node is self._old else self.generic_visit(node)


@dataclass(frozen=True)
class Recorded:
    """Recorded findings, which can be disturbed.

    Parameters
    ----------
    stored
        The findings as they are stored, in the order of the states.
    shape
        How many values each control has.
    """

    stored: Sequence[Any]
    shape: Sequence[int]

    def found(self) -> list[Any]:
        """Return the findings as they are recorded."""
        return [finding_of(one) for one in self.stored]

    def disturbed(self) -> Iterator[list[Any]]:
        """Yield the findings with something broken, what is broken everywhere first."""
        found = self.found()
        original = [[value for _, value in leaves(one)] for one in self.stored]
        yield [found[0]] * len(found)
        yield found[::-1]
        yield found[1:]
        yield [*found, found[0]]
        columns = self._columns()
        groups = [*self._groups(), *(group for one in columns for group in _cuts(one, original))]
        changes = (_changes(column, original, groups) for column in columns)
        for change in (one for some in zip_longest(*changes) for one in some if one):
            again = list(found)
            for state, values in change.items():
                again[state] = finding_of(_rebuilt(self.stored[state], iter(values)))
            yield again

    def _columns(self) -> list[dict[int, list[int]]]:
        """Return the columns: by state, which of its numbers and texts belong to it."""
        columns: dict[Any, dict[int, list[int]]] = defaultdict(lambda: defaultdict(list))
        for state, one in enumerate(self.stored):
            for k, (path, _) in enumerate(leaves(one)):
                columns[path][state].append(k)
        return list(columns.values())

    def _groups(self) -> list[list[int]]:
        """Return states that belong together: each alone, those of a control's value, of two."""
        states = list(product(*map(range, self.shape)))
        values = [(axis, value) for axis, size in enumerate(self.shape) for value in range(size)]
        pairs = [pair for pair in combinations(values, 2) if pair[0][0] != pair[1][0]]
        random.Random(0).shuffle(pairs)
        chosen = [*((value,) for value in values), *pairs[:PAIRS]]
        groups = [
            [k for k, state in enumerate(states) if all(state[a] == v for a, v in some)]
            for some in chosen
        ]
        return [[k] for k in range(len(states))] + groups


def _cuts(column: Mapping[int, list[int]], original: Values) -> Iterator[list[int]]:
    """Yield the states in which a column is large, is small, or is each of a few texts."""
    first = {state: original[state][places[0]] for state, places in column.items()}
    if not _are_numbers([*first.values()]):
        for value in dict.fromkeys(first.values()):
            yield [state for state, one in first.items() if one == value]
        return
    levels = sorted(set(first.values()))
    for level in levels[:: max(1, len(levels) // CUTS)]:
        yield [state for state, one in first.items() if one <= level]
        yield [state for state, one in first.items() if one > level]


def _changes(
    column: Mapping[int, list[int]], original: Values, groups: list[list[int]]
) -> Iterator[dict[int, list[Any]]]:
    """Yield, by state, the values of the states in which a column is disturbed."""
    states = list(column)
    own = [[original[state][k] for k in column[state]] for state in states]
    flat = [value for some in own for value in some]

    def put(new: Sequence[Sequence[Any]], where: Sequence[int] = states) -> dict[int, list[Any]]:
        changed = {}
        for state, some in zip(where, new, strict=True):
            values = list(original[state])
            for k, value in zip(column[state], some, strict=False):
                values[k] = value
            changed[state] = values
        return changed

    yield put(own[::-1])
    for seed in range(SEEDS):
        yield put(random.Random(seed).sample(own, len(own)))
    for value in _extremes(flat):
        yield put([[value] * len(some) for some in own])
    if not _are_numbers(flat):
        for group in groups:
            for value in _extremes(flat):
                at = [state for state in group if state in column]
                yield put([[value] * len(column[state]) for state in at], at)
        return
    for factor in FACTORS:
        yield put([[factor * value for value in some] for some in own])
    for backwards in (False, True):
        yield put(sorted(own, reverse=backwards))
        yield put([sorted(some, reverse=backwards) for some in own])
    for group in groups:
        at = [state for state in group if state in column]
        some = [[original[state][k] for k in column[state]] for state in at]
        for value in _extremes(flat):
            yield put([[value] * len(one) for one in some], at)
            yield put([[value, *one[1:]] for one in some], at)
            yield put([[*one[:-1], value] for one in some], at)
        for factor in FACTORS:
            yield put([[factor * value for value in one] for one in some], at)


def _are_numbers(values: Sequence[Any]) -> bool:
    return all(isinstance(one, int | float) and not isinstance(one, bool) for one in values)


def _extremes(values: Sequence[Any]) -> list[Any]:
    """Return values as large and as small as a column has, and far beyond; of texts each.

    And a text that is in no column, where there are texts, and the other truth value.
    """
    if not _are_numbers(values):
        other = (not one if isinstance(one, bool) else STRANGE for one in values)
        return list(dict.fromkeys([*values, *other]))
    low, high = min(values), max(values)
    reach = 10 * max(high - low, abs(high), abs(low), 1)
    return [low, high, median(values), low - reach, high + reach]


def _rebuilt(stored: Any, values: Iterator[Any]) -> Any:
    """Return a stored finding with other numbers and texts, in the order of `leaves`."""
    if isinstance(stored, list):
        return [_rebuilt(one, values) for one in stored]
    if not isinstance(stored, dict):
        return next(values)
    ((kind, parts),) = stored.items()
    if kind == ARRAY:
        return {kind: _rebuilt(parts, values)}
    if isinstance(parts, dict):
        return {kind: {name: _rebuilt(one, values) for name, one in parts.items()}}
    return {kind: [[key, _rebuilt(one, values)] for key, one in parts]}


def outcome(predicate: Predicate, found: list[Any]) -> bool | str:
    """Return what a predicate says; the name of the error where it fails."""
    try:
        return bool(predicate(found))
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        return type(error).__name__


@dataclass(frozen=True)
class Judged:
    """What a predicate says of disturbed findings.

    Parameters
    ----------
    verdicts
        Whether it is true, by the number of the disturbance: of the first of which it is false, and
        of those that tell weakened predicates from it.
    left
        The weakened predicates that say the same of all.
    """

    verdicts: Mapping[int, bool]
    left: Sequence[str]


def judged(written: Source, recorded: Recorded) -> Judged:
    """Let a predicate and all that are weakened judge disturbed findings, until each has differed.

    Where the predicate itself fails, nothing is learnt.
    """
    predicate, left = written.predicate(), dict(written.weakened())
    left = {w: one for w, one in left.items() if outcome(one, recorded.found()) is True}
    verdicts: dict[int, bool] = {}
    for number, found in enumerate(recorded.disturbed()):
        if not left and False in verdicts.values():
            break
        said = outcome(predicate, found)
        if not isinstance(said, bool):
            continue
        same = {w: one for w, one in left.items() if outcome(one, found) == said}
        if len(same) < len(left) or (not said and False not in verdicts.values()):
            verdicts[number] = said
        left = same
    return Judged(verdicts, list(left))


def judged_of(module: ModuleType, name: str, said: Mapping[str, Any]) -> Judged:
    """Judge the predicate of an explorer by what is recorded of it, or would be."""
    shape = [len(values) for values in said["controls"].values()]
    recorded = Recorded([finding for finding, *_ in said["states"]], shape)
    return judged(source(module, name), recorded)


def plain(verdicts: Mapping[int, bool]) -> dict[str, list[int]]:
    """Return the disturbances of which a predicate is true and false, as they are recorded."""
    return {
        word: [number for number, said in verdicts.items() if said is truth]
        for word, truth in (("true", True), ("false", False))
    }
