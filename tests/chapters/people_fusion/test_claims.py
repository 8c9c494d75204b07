"""The claims of the chapter: the record, and what their findings must say."""

from tests.chapters.ledger import LedgerTests, quick, recorded


class TestLedger(LedgerTests):
    stem = "people_fusion"
    open_when_quick = frozenset({"legs", "sonar-keeps-alive", "false-25", "guide-asks-back"})


def test_verdicts():
    assert {e.id: e.verdict for e in recorded().chapter("people_fusion").entries} == {
        "legs": "reproduced",
        "sonar": "conditional",
        "fisheye": "reproduced",
        "no-single-sensor": "reproduced",
        "front-outperforms": "inconclusive",
        "behind-slightly": "conditional",
        "sonar-keeps-alive": "conditional",
        "concurrent-not-sequential": "reproduced",
        "aggregation-scales": "conditional",
        "lost-after-tv": "conditional",
        "rate-93": "inconclusive",
        "false-25": "not reproduced",
        "trajectories": "inconclusive",
        "guide-asks-back": "not reproduced",
        "follow-turned-back": "reproduced",
        "survey-breaks-off": "reproduced",
    }


def test_the_laser_sees_the_legs_of_who_stands_sideways_less_often():
    evidence = quick("legs").evidence
    assert evidence["standing sideways, within 3 m"].high < quick("legs").value.low


def test_the_laser_loses_sight_with_the_distance():
    evidence = quick("legs").evidence
    assert evidence["found, 2.5 to 3 m"].high < evidence["found, 1 to 1.5 m"].low


def test_most_misses_are_behind_the_robot():
    evidence = quick("rate-93").evidence
    assert evidence["missed behind over ahead"].low > 1


def test_each_sensor_alone_finds_fewer_than_all_together():
    table = quick("no-single-sensor").tables["by place"]
    together = table["together", "tracked"].low
    assert all(table[f"{name} alone", "tracked"].high < together for name in ("laser", "sonar"))
