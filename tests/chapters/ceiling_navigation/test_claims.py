"""The claims of the chapter: the record, and what their findings must say."""

from tests.chapters.ledger import LedgerTests, recorded


class TestLedger(LedgerTests):
    stem = "ceiling_navigation"
    open_when_quick = frozenset({"key-image-conditions", "visual-memory"})


def test_verdicts():
    assert {e.id: e.verdict for e in recorded().chapter("ceiling_navigation").entries} == {
        "camera-correction": "conditional",
        "pose-from-pattern": "reproduced",
        "erratum-mosaic": "refuted",
        "pose-up-to-scale": "conditional",
        "mosaic-fig9": "reproduced",
        "key-image-conditions": "reproduced",
        "visual-memory": "reproduced",
    }
