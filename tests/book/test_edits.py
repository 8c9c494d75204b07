"""What a student edits reaches what the page shows: pictures, films, explorers and sentences."""

import ast
import json
import os
import re
from dataclasses import dataclass

import pytest
from nbclient import NotebookClient
from nbformat.v4 import new_code_cell, new_notebook

from tests.book import slices
from tests.book.computing import COMPUTING, FURTHER, code_cells, is_study
from tests.book.pages import BOOK

DRAWN_ALONE = {
    "head_tracking": {"draw.step_aside()"},  # pixels of two ellipses
    "tutor_following": {"draw.features()"},  # rectangles of a sum
}
"""Drawings that show how something is done, and no result."""
FROM_A_RECORDING = {"monobot", "recordings_robots", "visual_slam", "walls"}
"""Chapters with cells on recordings, which `Recording` reads; its function lies in a module."""
MODEL = re.compile(r"\b[0-9a-f]{32}\b")
"""Name of a widget, another one in each kernel."""
OTHER = "robot_perception.book."
NOW = re.compile(r'now\(\s*"([^"]+)"')
RECORDED = (
    "recordings.",
    "origin at the start",
    "read().result",
    "freiburg",
    "anchored_slam.five",
    "car.",
)


def lent(source: str) -> set[str]:
    """Return the names that a cell takes from the study cells of another page."""
    found = [one for one in ast.parse(source).body if isinstance(one, ast.ImportFrom)]
    return {
        name for one in found if f"{one.module}.".startswith(OTHER) for name in slices.bound(one)
    }


def reached(stem: str) -> list[tuple[str, bool]]:
    """Return what each cell shows, and whether it takes something from a study cell."""
    cells = code_cells(stem)
    names = [slices.Names.of(cell.source) for cell in cells]
    made = {number for number, cell in enumerate(cells) if is_study(cell) and slices.defines(cell)}
    others = {name for cell in cells for name in lent(cell.source)}
    shown = []
    for number, cell in enumerate(cells):
        if not is_study(cell) and slices.shows(cell):
            needed = {*slices.slice_of(names, number)}
            borrows = any(names[k].read & others for k in needed)
            shown.append((cell.source, borrows or bool(made & needed)))
    return shown


@pytest.mark.parametrize("stem", [*COMPUTING, *FURTHER])
def test_what_a_page_shows_is_made_by_its_study_cells(stem: str):
    shown = reached(stem)
    alone = [source for source, from_study in shown if not from_study]
    alone = [source for source in alone if source not in DRAWN_ALONE.get(stem, ())]
    if stem in FROM_A_RECORDING:
        alone = [text for text in alone if not any(part in text for part in RECORDED)]
    assert not alone
    assert len(shown) >= 3


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
        "draw.hero({", '("shape and motion", "colour", "texture"),', '("shape", "texture"),'
    ),
    "arm_tracking": Edit('now("arms-hero"', "PARTICLES = 400", "PARTICLES = 60"),
    "ceiling_navigation": Edit("draw.corrected(", "roll=np.deg2rad(6)", "roll=np.deg2rad(2)"),
    "colour_and_shape": Edit('now("shape-path"', "TRAINING = (9001,", "TRAINING = (9011,"),
    "covariance_intersection": Edit("draw.heard(rumour)", "range_sigma, 20", "range_sigma, 12"),
    "exchanged_parts": Edit("VARIED = Exploration(", "7, 8, 20", "7, 8, 12"),
    "head_tracking": Edit(
        "describe_look(state)", '"opponent", (32, 32, 12)', '"opponent", (4, 4, 4)'
    ),
    "look_alikes": Edit('now("look-pulled",', "rng(5)", "rng(6)"),
    "loop_closing": Edit('now("loop-map"', "every=8, beams=6", "every=16, beams=6"),
    "many_guesses": Edit('now("guesses-weights", ', "-0.5 * ((z - to", "-2.0 * ((z - to"),
    "map_localisation": Edit("draw.slices(", "np.exp(-a / 2)", "np.exp(-a / 8)"),
    "monobot": Edit('now("monobot-run"', '"measurement_share": 0.05', '"measurement_share": 0.5'),
    "one_belief": Edit('now("belief-story",', "(4.0, 7.0, 15.0)", "(4.0, 9.0, 15.0)"),
    "one_world": Edit('now("world-close"', "(26)", "(28)"),
    "pattern_tracking": Edit('now("pattern-hero",', "np.deg2rad(20)", "np.deg2rad(5)"),
    "people_fusion": Edit('now("people-together"', "threshold=0.3", "threshold=0.39"),
    "people_sensors": Edit('now("people-hero"', "NOW = 4.86", "NOW = 7.26"),
    "sift_association": Edit("draw.hero(rooms)", "FAR_AWAY = 5.0", "FAR_AWAY = 9.0"),
    "tutor_face": Edit('now("tutor-hero"', "GALLERY = CHOOSING[4]", "GALLERY = CHOOSING[3]"),
    "tutor_following": Edit("draw.patches(", "WALK = CHOOSING[3]", "WALK = CHOOSING[4]"),
    "visual_slam": Edit('now("slam-film"', "FRAMES = 507", "FRAMES = 487"),
    "walls": Edit("draw.opening(", "sigma=0.015", "sigma=0.1"),
}


def outputs(stem: str, edit: Edit, new: str) -> list[str]:
    """Run what a cell needs, with a text of the study cells exchanged; return what it shows."""
    cells = code_cells(stem)
    shown = [number for number, cell in enumerate(cells) if edit.shown in cell.source]
    assert len(shown) == 1, f"{len(shown)} cells have {edit.shown}"
    names = [slices.Names.of(cell.source) for cell in cells]
    needed = [cells[number].source for number in slices.slice_of(names, *shown)]
    assert sum(text.count(edit.old) for text in needed) == 1, f"{edit.old} does not stand once"
    texts = [text.replace(edit.old, new) for text in needed]
    for name in NOW.findall(texts[-1]):
        texts[-1] = f'from explorables.later import later\nlater("{name}")\n{texts[-1]}'
    notebook = new_notebook(cells=[new_code_cell(text) for text in texts])
    client = NotebookClient(notebook, resources={"metadata": {"path": str(BOOK)}})
    client.execute(env=os.environ | {"STUDIES_WORKERS": "1"})
    shown = [one.data for one in notebook.cells[-1].outputs if "data" in one]
    return [MODEL.sub("", json.dumps(data, sort_keys=True)) for data in shown]


@pytest.mark.slow
@pytest.mark.parametrize("stem", EDITS)
def test_one_changed_number_changes_what_is_shown(stem: str):
    edit = EDITS[stem]
    before, again, after = (outputs(stem, edit, new) for new in (edit.old, edit.old, edit.new))
    assert before
    assert again == before
    assert after != before


@pytest.mark.slow
def test_every_chapter_has_an_edit():
    assert EDITS.keys() == {*COMPUTING}
