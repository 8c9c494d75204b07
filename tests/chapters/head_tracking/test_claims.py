"""The claims of the chapter: the record, and what their findings must say."""

from types import MappingProxyType

from robot_perception.chapters.head_tracking import heads
from tests.chapters.ledger import LedgerTests, recorded


class TestLedger(LedgerTests):
    stem = "head_tracking"
    pictures = MappingProxyType(
        dict.fromkeys(
            ("histogram-head", "histogram-threshold", "histogram-bimodal", "histogram-space"), 0.01
        )
    )
    open_when_quick = frozenset({"histogram-head"})


def test_verdicts():
    assert {e.id: e.verdict for e in recorded().chapter("head_tracking").entries} == {
        "incremental-histogram": "reproduced",
        "incremental-saving": "conditional",
        "histogram-head": "conditional",
        "histogram-threshold": "inconclusive",
        "histogram-bimodal": "reproduced",
        "histogram-space": "not reproduced",
    }


def test_adaptation_harms_where_others_pass():
    found = recorded()["histogram-head"].evidence
    assert found["missed less often, and others pass, a = 0.1"].high < 0


def test_the_table_has_every_a_and_threshold():
    table = recorded()["histogram-head"].tables["grid"]
    assert set(table.rows) == {"fixed", "fixed, gives up", *heads.GRID}


def test_eq_28_costs_more_than_the_pixels_if_its_cells_are_summed():
    found = recorded()["incremental-saving"].evidence
    assert found["saving of a step at 20 px"].estimate > 15
    assert 2.4 < found["saving of a step at 20 px, eq. 28 summed"].estimate < 2.6


def test_the_highest_score_loses_the_head():
    assert recorded()["histogram-head"].evidence["missed, size by highest score"].low > 0.5
