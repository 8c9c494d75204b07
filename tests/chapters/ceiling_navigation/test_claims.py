"""The claims of the chapter: the record, and what their findings must say."""

from types import MappingProxyType

from tests.chapters.ledger import LedgerTests, recorded


class TestLedger(LedgerTests):
    stem = "ceiling_navigation"
    pictures = MappingProxyType({"mosaic-fig9": 0.01, "visual-memory": 0.01})
    rounding = MappingProxyType(
        # where the servo stops hangs on single pixels: two tenths of a millimetre
        {"erratum-mosaic": 1e-13, "pose-from-pattern": 1e-13, "pose-up-to-scale": 2e-4}
    )
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
