"""What is read of the notebooks' cells without running them is what their modules hold."""

import pytest

from explorables.bets import Bet
from explorables.explorations import Exploration
from robot_perception import chapters
from robot_perception.teaching.course.exercises import Sheet
from tests.book import registry
from tests.book.computing import COMPUTING, found
from tests.book.registry import every

TYPES = {registry.EXPLORER: Exploration, registry.BET: Bet, registry.SHEET: Sheet}


@pytest.mark.parametrize("kind", TYPES)
def test_what_cells_declare_is_what_their_modules_hold(kind: str):
    assert [id(one.value()) for one in every(kind)] == [id(v) for _, v in found(TYPES[kind])]


def test_names_are_those_of_studies_claims_explorers_and_stored_results():
    names = {f"{study.stem}.{study.name}" for study in chapters.trials(COMPUTING)}
    assert {one.id for one in every(registry.STUDY)} == names
    claims = [claim.id for claim in chapters.claims()]
    assert [one.name for one in every(registry.CLAIM)] == claims
    assert all(one.value().name == one.name for one in every(registry.EXPLORER))
    stored = {one.store for one in chapters.states()}
    assert {one.name for one in every(registry.STORED)} <= stored


@pytest.mark.parametrize(
    ("test", "words"),
    [
        ("monobot", {"monobot", "monobot."}),
        ("monobot.joseph", {"monobot", "monobot.joseph"}),
        (
            "monobot.joseph-scaled=False",
            {"monobot", "monobot.joseph", "monobot.joseph-scaled=False"},
        ),
        ("walls-walls-knob", {"walls", "walls.walls-knob", "walls.walls"}),
        ("people_fusion-x", {"people_fusion", "people_fusion.x"}),
        ("loop-grown", {"loop_closing", "loop-grown", "loop_closing.loop-grown"}),
        ("kalman", set()),
        ("wallsome", set()),
    ],
)
def test_a_test_is_chosen_by_its_stem_or_its_name(test: str, words: set[str]):
    assert registry.owners(test) == words
