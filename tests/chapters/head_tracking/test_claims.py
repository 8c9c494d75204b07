"""The claims of the chapter: the record, and what their findings must say."""

from types import MappingProxyType

from tests.chapters.ledger import LedgerTests, recorded


class TestLedger(LedgerTests):
    stem = "head_tracking"
    pictures = MappingProxyType({})
    open_when_quick = frozenset({"histogram-head", "histogram-threshold", "histogram-space"})


def test_verdicts():
    assert {e.id: e.verdict for e in recorded().chapter("head_tracking").entries} == {
        "incremental-histogram": "reproduced",
        "incremental-saving": "reproduced",
        "histogram-head": "conditional",
        "histogram-threshold": "reproduced",
        "histogram-bimodal": "conditional",
        "histogram-space": "reproduced",
    }


def test_adaptation_harms_where_others_pass():
    assert recorded()["histogram-head"].evidence["missed less often, and others pass"].high < 0


def test_an_adapted_model_gains_nothing_from_the_second_view():
    found = recorded()["histogram-bimodal"]
    assert found.evidence["overlap, both adapted"].high < found.value.low


def test_once_adapted_the_space_gains_about_as_much_but_less_certainly():
    found = recorded()["histogram-space"]
    adapted = found.evidence["overlap, both adapted"]
    assert found.value.overlaps(adapted)
    assert adapted.low < found.value.low


def test_the_highest_score_loses_the_head():
    assert recorded()["histogram-head"].evidence["missed, size by highest score"].low > 0.5
