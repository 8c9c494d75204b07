"""The claims of the chapter: the record, and what their findings must say."""

from tests.chapters.ledger import LedgerTests, quick, recorded


class TestLedger(LedgerTests):
    stem = "people_fusion"
    open_when_quick = frozenset({"sonar-keeps-alive", "false-25", "guide-asks-back"})


def test_verdicts():
    assert {e.id: e.verdict for e in recorded().chapter("people_fusion").entries} == {
        "no-single-sensor": "reproduced",
        "front-outperforms": "inconclusive",
        "behind-slightly": "conditional",
        "sonar-keeps-alive": "conditional",
        "concurrent-not-sequential": "reproduced",
        "another-sensor": "reproduced",
        "aggregation-scales": "conditional",
        "lost-after-tv": "conditional",
        "rate-93": "inconclusive",
        "false-25": "not reproduced",
        "trajectories": "inconclusive",
        "guide-asks-back": "not reproduced",
        "follow-turned-back": "reproduced",
        "survey-breaks-off": "reproduced",
    }


def test_most_misses_are_behind_the_robot():
    evidence = quick("rate-93").evidence
    assert evidence["missed behind over ahead"].low > 1


def test_each_sensor_alone_finds_fewer_than_all_together():
    table = quick("no-single-sensor").tables["by place"]
    together = table["together", "tracked"].low
    assert all(table[f"{name} alone", "tracked"].high < together for name in ("laser", "sonar"))
