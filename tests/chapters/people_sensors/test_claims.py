"""The claims of the chapter: the record, and what their findings must say."""

from tests.chapters.ledger import LedgerTests, quick, recorded


class TestLedger(LedgerTests):
    stem = "people_sensors"
    open_when_quick = frozenset({"legs"})


def test_verdicts():
    assert {e.id: e.verdict for e in recorded().chapter("people_sensors").entries} == {
        "legs": "reproduced",
        "sonar": "conditional",
        "fisheye": "reproduced",
    }


def test_the_laser_sees_the_legs_of_who_stands_sideways_less_often():
    evidence = quick("legs").evidence
    assert evidence["standing sideways, within 3 m"].high < quick("legs").value.low


def test_the_laser_loses_sight_with_the_distance():
    evidence = quick("legs").evidence
    assert evidence["found, 2.5 to 3 m"].high < evidence["found, 1 to 1.5 m"].low
