"""The claims of the chapter: the record, and what their findings must say."""

from types import MappingProxyType

from tests.chapters.ledger import LedgerTests, recorded


class TestLedger(LedgerTests):
    stem = "arm_likelihoods"
    pictures = MappingProxyType(
        {
            "likelihood-shapes": 0.3,
            "moving-edges": 0.5,
            "dt-smooth": 0.1,
            "erratum-eq2": 0.02,
            "hidden-parts": 0.3,
            "bhattacharyya": 0.2,
            "patch-confidence": 0.5,
            "stabiliser": 0.3,
        }
    )
    rounding = MappingProxyType(
        {
            "likelihood-shapes": 0.2,
            "moving-edges": 0.2,
            "hidden-parts": 0.2,
            "patch-confidence": 0.1,
            "stabiliser": 3.0,
            "erratum-eq2": 0.02,
        }
    )
    few_films = frozenset({"likelihood-shapes", "moving-edges"})
    open_when_quick = frozenset({"likelihood-shapes", "moving-edges", "bhattacharyya"})


def test_colour_takes_peaks_away_and_a_bare_wall_needs_no_help():
    found = recorded()["likelihood-shapes"]
    assert found.evidence["peaks, all"].high < 0.5 * found.evidence["peaks, shape"].low
    assert abs(found.evidence["bare wall"].estimate) < 0.12


def test_a_factor_does_nothing_and_a_toll_does_what_the_text_says():
    found = recorded()["moving-edges"].evidence
    assert found["a toll in place of K"].low > 0.1
    assert found["arms that stand still"].estimate == 0
    assert found["K of 1, largest difference to shape alone"].estimate == 0
    assert found["people walk behind"].high < 0


def test_exponents_of_the_three_sums_are_two_one_and_none():
    table = recorded()["erratum-eq2"].tables["forms"]
    for name, wanted in (("square of the sum", 2), ("sum of the squares", 1),
                         ("mean of the squares", 0)):  # fmt: skip
        assert abs(table[name, "exponent"].estimate - wanted) < 0.02


def test_a_hidden_arm_is_preferred_less_and_less():
    table = recorded()["hidden-parts"].tables["forms"]
    shares = [table[name, "hidden preferred"].estimate for name in table.rows]
    assert shares == sorted(shares, reverse=True)
    assert shares[-1] < 0.2


def test_the_hands_colours_find_skin():
    found = recorded()["bhattacharyya"]
    assert found.evidence["on a hand, the head or a forearm"].low > 0.85
    assert found.value.high < 0.8


def test_contrast_foretells_and_the_papers_weight_does_not():
    found = recorded()["patch-confidence"]
    assert found.value.low > -0.1
    assert found.evidence["how unlike its surroundings"].high < -0.1


def test_the_pull_holds_a_straight_arm_a_little():
    found = recorded()["stabiliser"].evidence
    assert found["straight arm, spread of γ, pulled over free"].high < 1
