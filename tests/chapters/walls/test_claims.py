"""The claims of the chapter "Walls from laser scans"."""

from tests.chapters.ledger import LedgerTests, quick


class TestLedger(LedgerTests):
    stem = "walls"


def test_printed_measure_has_no_unit_and_is_no_distance():
    finding = quick("erratum-table2")
    assert finding.value.estimate == 0.0
    assert all(v.estimate < 0.05 for name, v in finding.evidence.items() if "triples" in name)


def test_times_of_other_packages_are_left_to_the_full_size():
    assert not quick("dp-quadratic").evidence
