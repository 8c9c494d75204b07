"""What a student edits reaches what the page shows: pictures, films, explorers and sentences."""

import ast
import dis
import json
import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from types import CodeType

import nbformat
import pytest
from nbclient import NotebookClient
from nbformat import NotebookNode
from nbformat.v4 import new_code_cell, new_notebook

from tests.book import slices
from tests.book.computing import COMPUTING, FURTHER, code_cells, is_study
from tests.book.pages import BOOK

ALONE = {
    "head_tracking": ("draw.step_aside()",),  # pixels of two ellipses, no result
    "tutor_following": ("draw.features()", "reports = stored()"),  # of the detector that is stored
}
"""Beginnings of cells that take nothing from study cells, and why that is so."""
MODEL = re.compile(r"\b[0-9a-f]{32}\b")
"""Name of a widget, another one in each kernel."""
OTHER = "robot_perception.book."
NOW = re.compile(r'now\(\s*"([^"]+)"')


def lent(source: str) -> set[str]:
    """Return the names that a cell takes from another page's cells, or from recordings."""
    names = set[str]()
    for one in ast.parse(source).body:
        if isinstance(one, ast.ImportFrom) and f"{one.module}.".startswith(OTHER):
            names |= slices.bound(one)
        elif isinstance(one, ast.ImportFrom):
            read = f"{one.module}".endswith(".recordings")
            names |= {n for n in slices.bound(one) if read or n == "recordings"}
    return names


def is_plain(cell: NotebookNode) -> bool:
    """Tell whether a cell shows words that were typed: a sentence, or a table of what is set up."""
    last = ast.parse(cell.source).body[-1].value
    typed = isinstance(last, ast.Call) and getattr(last.func, "id", "") == "tell"
    return (typed and not last.keywords) or ast.unparse(last).startswith("Table({")


def reached(stem: str) -> list[tuple[str, bool]]:
    """Return what each cell shows, and whether it takes something from a study cell.

    A name counts that a study cell defines, or that another page's gave; one that it only imports
    does not, although the same cell may define others.
    """
    cells = code_cells(stem)
    studied = {name for cell in cells if is_study(cell) for name in slices.defines(cell)}
    studied |= {name for cell in cells for name in lent(cell.source)}
    plain = [slices.Names.of(cell.source) for cell in cells if not is_study(cell)]
    return [
        (cell.source, leads(slices.Names.of(cell.source).read, plain, studied))
        for cell in cells
        if not is_study(cell) and slices.shows(cell) and not is_plain(cell)
    ]


def leads(names: Iterable[str], cells: Sequence[slices.Names], studied: set[str]) -> bool:
    """Tell whether names, by way of other cells, lead to one that is studied."""
    known, todo = set[str](), {*names}
    while todo:
        name = todo.pop()
        known.add(name)
        if name in studied:
            return True
        todo |= {one for cell in cells if name in cell.bound for one in cell.read} - known
    return False


@pytest.mark.parametrize("stem", [*COMPUTING, *FURTHER])
def test_what_a_page_shows_is_made_by_its_study_cells(stem: str):
    shown = reached(stem)
    alone = [source for source, from_study in shown if not from_study]
    alone = [source for source in alone if not source.startswith(ALONE.get(stem, ()))]
    assert not alone
    assert len(shown) >= 3


def test_a_cell_that_only_imports_from_a_study_cell_is_found():
    setup, shown = "from book import draw\nPAPER = 'a'", "it = draw.hero()\nit"
    cells, studied = [slices.Names.of(shown)], slices.defines(new_code_cell(setup))
    assert studied == {"PAPER"}
    assert not leads(cells[0].read, cells, studied)
    assert leads(slices.Names.of("draw.hero(it, PAPER)").read, cells, studied)


CACHES = re.compile(r"\b(lru_)?cache\b")
"""Decorators of a function that stays as it is while cells below it are run again."""
GLOBAL = frozenset({"LOAD_GLOBAL", "LOAD_NAME"})


def taken(statement: ast.stmt) -> set[str]:
    """Return the names that a statement, and the functions in it, take from the notebook."""
    todo, names = [compile(ast.Module([statement], []), "<cell>", "exec")], set[str]()
    while todo:
        code = todo.pop()
        names |= {step.argval for step in dis.get_instructions(code) if step.opname in GLOBAL}
        todo += [one for one in code.co_consts if isinstance(one, CodeType)]
    return names


def late(sources: Sequence[str]) -> dict[str, set[str]]:
    """Return which functions with a cache reach names that a later cell defines, and these."""
    defined, needs, caches = dict[str, int](), dict[str, set[str]](), dict[str, int]()
    for number, source in enumerate(sources):
        for one in ast.parse(source).body:
            if isinstance(one, ast.FunctionDef | ast.ClassDef | ast.Assign | ast.AnnAssign):
                for name in slices.bound(one):
                    defined.setdefault(name, number)
                    needs.setdefault(name, set()).update(taken(one))
            if isinstance(one, ast.FunctionDef) and any(
                CACHES.search(ast.unparse(decorator)) for decorator in one.decorator_list
            ):
                caches[one.name] = number
    found = dict[str, set[str]]()
    for name, number in caches.items():
        known, todo = set[str](), {name}
        while todo:
            known |= todo
            todo = {one for own in todo for one in needs[own] if one in defined} - known
        if below := {one for one in known if defined[one] > number}:
            found[name] = below
    return found


@pytest.mark.parametrize("stem", [*COMPUTING, *FURTHER])
def test_a_function_with_a_cache_stands_below_what_it_calls(stem: str):
    """Whoever edits a cell runs it and all below: what stands above would keep its old results."""
    assert not late([cell.source for cell in code_cells(stem)])


def test_a_cache_above_what_it_calls_is_found():
    cached = "@lru_cache(maxsize=1)\ndef maps():\n    return surfaces()"
    called, level = "def surfaces():\n    return [LEVEL for _ in range(3)]", "LEVEL = 20"
    assert late([cached, called, level]) == {"maps": {"surfaces", "LEVEL"}}
    assert late([called, level, cached.replace("lru_cache(maxsize=1)", "cache")]) == {}
    assert late([cached.split("\n", 1)[1], called, level]) == {}, "it has no cache"


@dataclass(frozen=True)
class Edit:
    """One change of a study cell, and a cell that shows another thing after it.

    Parameters
    ----------
    shown
        How the cell begins, or what it has.
    old, new
        A text that stands once in the study cells, and what is typed in its place.
    """

    shown: str
    old: str
    new: str


EDITS = {
    "anchored_slam": Edit(
        'now("turned-world"', "Anchor(0.0, 0.0), Anchor(5", "Anchor(0.9, 0.0), Anchor(5"
    ),
    "arm_likelihoods": Edit(
        'now(\n    "likelihoods-hero"',
        '("shape and motion", "colour", "texture"),',
        '("shape", "texture"),',
    ),
    "arm_tracking": Edit('now("arms-hero"', "PARTICLES = 400", "PARTICLES = 60"),
    "ceiling_navigation": Edit("draw.corrected(", "roll=np.deg2rad(6)", "roll=np.deg2rad(2)"),
    "colour_and_shape": Edit('now("shape-path"', "TRAINING = (9001,", "TRAINING = (9011,"),
    "companion_day": Edit("draw.views(", "np.array([6.0, 1.2, 0.0])", "np.array([8.0, 1.2, 0.0])"),
    "covariance_intersection": Edit("draw.heard(rumour)", "range_sigma, 20", "range_sigma, 12"),
    "exchanged_parts": Edit("SIZED = Exploration(", "3, 100, 15", "9, 100, 15"),
    "head_tracking": Edit(
        "describe_look(state)", '"opponent", (32, 32, 12)', '"opponent", (4, 4, 4)'
    ),
    "look_alikes": Edit('now("look-pulled",', "rng(5)", "rng(6)"),
    "loop_closing": Edit('now("loop-map"', "every=8, beams=6", "every=16, beams=6"),
    "many_guesses": Edit('now("guesses-weights", ', "-0.5 * ((z - to", "-2.0 * ((z - to"),
    "map_localisation": Edit("draw.slices(", "np.exp(-a / 2)", "np.exp(-a / 8)"),
    "monobot": Edit('now("monobot-run"', '"measurement_share": 0.05', '"measurement_share": 0.5'),
    "many_numbers": Edit('now("numbers-told"', "0.15**2 * np.eye(2)", "0.6**2 * np.eye(2)"),
    "one_belief": Edit('now("belief-story",', "(4.0, 7.0, 15.0)", "(4.0, 9.0, 15.0)"),
    "one_world": Edit('now("world-close"', "(26)", "(28)"),
    "pattern_tracking": Edit(
        'now("pattern-hero",', "ALIGNED = np.deg2rad(20)", "ALIGNED = np.deg2rad(5)"
    ),
    "people_fusion": Edit('now("people-together"', "threshold=0.3", "threshold=0.39"),
    "people_sensors": Edit('now("people-hero"', "NOW = 4.86", "NOW = 7.26"),
    "sift_association": Edit("draw.hero(rooms)", "FAR_AWAY = 5.0", "FAR_AWAY = 9.0"),
    "tutor_face": Edit('now("tutor-hero"', "GALLERY = CHOOSING[4]", "GALLERY = CHOOSING[3]"),
    "tutor_following": Edit("draw.patches(", "WALK = CHOOSING[3]", "WALK = CHOOSING[4]"),
    "visual_slam": Edit('now("slam-film"', "FRAMES = 507", "FRAMES = 487"),
    "walls": Edit("draw.opening(", "sigma=0.015", "sigma=0.1"),
}


def needed(stem: str, edit: Edit) -> list[str]:
    """Return the cells that the cell of an edit needs, which hold its text once."""
    cells = code_cells(stem)
    shown = [number for number, cell in enumerate(cells) if edit.shown in cell.source]
    assert len(shown) == 1, f"{len(shown)} cells have {edit.shown}"
    names = [slices.Names.of(cell.source) for cell in cells]
    texts = [cells[number].source for number in slices.slice_of(names, *shown)]
    assert sum(text.count(edit.old) for text in texts) == 1, f"{edit.old} does not stand once"
    return texts


def outputs(stem: str, edit: Edit, new: str) -> list[str]:
    """Run what a cell needs, with a text of the study cells exchanged; return what it shows."""
    texts = [text.replace(edit.old, new) for text in needed(stem, edit)]
    for name in NOW.findall(texts[-1]):
        texts[-1] = f'from explorables.later import later\nlater("{name}")\n{texts[-1]}'
    notebook = new_notebook(cells=[new_code_cell(text) for text in texts])
    client = NotebookClient(notebook, resources={"metadata": {"path": str(BOOK)}})
    client.execute(env=os.environ | {"STUDIES_WORKERS": "1"})
    shown = [one.data for one in notebook.cells[-1].outputs if "data" in one]
    return [MODEL.sub("", json.dumps(data, sort_keys=True)) for data in shown]


@pytest.mark.parametrize("stem", EDITS)
def test_each_edit_fits_its_notebook(stem: str):
    assert needed(stem, EDITS[stem])


@pytest.mark.slow
@pytest.mark.parametrize("stem", EDITS)
def test_one_changed_number_changes_what_is_shown(stem: str):
    edit = EDITS[stem]
    before, again, after = (outputs(stem, edit, new) for new in (edit.old, edit.old, edit.new))
    assert before
    assert again == before
    assert after != before


SPARED = """
def _spare():
    from dataclasses import replace
    from studies.trials import FEW, Trials

    recorded = Trials.rows

    def few(study):
        rows = recorded(study)
        kept = study.replicates[:FEW] if study.is_drawn else study.replicates
        table = rows.table[rows.table[study.replicate].isin(kept)]
        return replace(rows, table=table.reset_index(drop=True))

    Trials.rows = few

_spare()
"""
"""Gives of every study what is computed at once where a reader has changed it."""


TOO_FEW = {
    "people_sensors": ("asked = looked.rows()", "skin = coloured.rows()"),
}
"""What cells hold whose ratio three replicates leave without a value: they say so by an error."""


@pytest.mark.slow
@pytest.mark.parametrize("stem", [*COMPUTING, *FURTHER])
def test_a_page_runs_where_every_study_has_a_few_replicates(stem: str):
    """No sentence, table or drawing below an edit wants a trial that was not computed for it."""
    notebook = nbformat.read(BOOK / f"{stem}.ipynb", nbformat.NO_CONVERT)
    notebook.cells.insert(0, new_code_cell(SPARED))
    resources = {"metadata": {"path": str(BOOK)}}
    client = NotebookClient(notebook, allow_errors=True, timeout=900, resources=resources)
    client.execute(env=os.environ | {"STUDIES_WORKERS": "1"})
    wrong = [
        f"{cell.source[:200]}\n    {output.ename}: {output.evalue[:400]}"
        for cell in notebook.cells
        for output in cell.get("outputs", ())
        if output.output_type == "error"
        and not any(text in cell.source for text in TOO_FEW.get(stem, ()))
    ]
    assert not wrong, "\n".join(wrong)


@pytest.mark.slow
def test_every_chapter_has_an_edit():
    assert EDITS.keys() == {*COMPUTING}
