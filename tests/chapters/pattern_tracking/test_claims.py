"""The claims of the chapter: the record, and what their findings must say."""

from types import MappingProxyType

from tests.chapters.ledger import LedgerTests, quick, recorded


class TestLedger(LedgerTests):
    stem = "pattern_tracking"
    pictures = MappingProxyType(
        {
            "pattern-model": 0.05,
            "contours-ambiguous": 0.5,
            "autocorrelation-slope": 0.05,
            "normalised-light": 1e-4,
            "tracker-fig8": 0.2,
            "occlusion": 0.2,
            "scale-smoothing": 0.5,
        }
    )
    rounding = MappingProxyType({"normalised-light": 2e-6})
    open_when_quick = frozenset({"occlusion", "pattern-model"})


def test_verdicts():
    assert {e.id: e.verdict for e in recorded().chapter("pattern_tracking").entries} == {
        "pattern-model": "conditional",
        "contours-ambiguous": "reproduced",
        "autocorrelation-slope": "not reproduced",
        "normalised-light": "conditional",
        "erratum-eq6": "refuted",
        "tracker-fig8": "conditional",
        "occlusion": "conditional",
        "scale-smoothing": "conditional",
    }


def test_means_removed_an_offset_changes_nothing():
    found = quick("normalised-light").evidence
    assert found["change under an offset of 40, means removed"].estimate < 1e-5
    assert found["change under an offset of 40, as printed"].estimate > 1e-3


def test_grey_vectors_have_fewer_peaks_and_lose_no_pattern():
    found = recorded()["contours-ambiguous"]
    assert found.evidence["peaks, grey vectors"].high < found.value.low / 2
    assert found.evidence["pictures with the pattern lost, grey vectors"].high < 0.01
    assert found.evidence["pictures with the pattern lost, contours"].low > 0.3


def test_a_power_is_no_better_than_a_line():
    assert recorded()["autocorrelation-slope"].evidence["ratio, own power"].low > 1


def test_vectors_find_more_than_contours_alone_and_keep_silent_more_often():
    table = recorded()["pattern-model"].tables["found"]
    contours, vectors = table.rows
    assert table[vectors, "found"].estimate > table[contours, "found"].estimate
    assert table[vectors, "right"].low > table[contours, "right"].high
