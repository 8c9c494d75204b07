"""The claims of the chapter: the record, and what their findings must say."""

from types import MappingProxyType

from tests.chapters.ledger import LedgerTests, quick, recorded


class TestLedger(LedgerTests):
    stem = "head_tracking"
    pictures = MappingProxyType({})
    open_when_quick = frozenset({"histogram-space"})


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
    assert quick("histogram-head").evidence["missed less often, and others pass"].high < 0


def test_an_adapted_model_gains_nothing_from_the_second_view():
    found = quick("histogram-bimodal")
    assert found.evidence["overlap, both adapted"].high < found.value.low


def test_once_adapted_the_space_gains_about_as_much_but_less_certainly():
    found, adapted = quick("histogram-space").value, recorded()["histogram-space"].evidence
    assert found.overlaps(adapted["overlap, both adapted"])
    assert adapted["overlap, both adapted"].low < recorded()["histogram-space"].value.low


def test_the_highest_score_loses_the_head():
    assert quick("histogram-head").evidence["missed, size by highest score"].low > 0.5
