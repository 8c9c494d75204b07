"""The claims of the chapter: the record, and what their findings must say."""

from types import MappingProxyType

from tests.chapters.ledger import LedgerTests, recorded


class TestLedger(LedgerTests):
    stem = "colour_and_shape"
    open_when_quick = frozenset({"four-experiments", "shape-alone"})
    pictures = MappingProxyType(
        dict.fromkeys(
            (
                "affine-snake",
                "four-experiments",
                "colour-condensation",
                "colour-alone",
                "shape-alone",
            ),
            0.25,
        )
    )


def test_verdicts():
    assert {e.id: e.verdict for e in recorded().chapter("colour_and_shape").entries} == {
        "affine-snake": "conditional",
        "erratum-phi-area": "refuted",
        "four-experiments": "reproduced",
        "colour-condensation": "reproduced",
        "colour-alone": "conditional",
        "shape-alone": "conditional",
    }


def test_a_stiff_free_snake_holds_no_more_of_the_neck_than_the_best_affine_one():
    assert recorded()["affine-snake"].evidence["neck, each with its best rigidity"].high < 0


def test_adapted_colours_lose_every_animal():
    lost = recorded()["four-experiments"].tables["lost"]
    for world in ("beetle", "snail"):
        assert lost["colours adapted unchecked", world] == 1
        assert lost["both", world] < 0.1


def test_samples_that_are_not_weighed_lose_more_films():
    weighed = recorded()["colour-condensation"]
    assert weighed.evidence["films lost more often, unweighed"].low > 0


def test_on_circles_and_snails_edges_alone_do_as_well():
    by_kind = recorded()["shape-alone"].evidence
    for world in ("circles", "snail"):
        assert by_kind[world].low <= 0 <= by_kind[world].high


def test_colours_of_the_first_frame_lose_no_beetle():
    found = recorded()["colour-alone"].evidence
    assert found["colours of the first frame, beetle"].high == 0


def test_a_rigid_window_that_adapts_falls_behind_by_overlap():
    assert recorded()["colour-alone"].evidence["overlap, all kinds"].low > 0.05


def test_where_no_outline_is_given_up_the_printed_sign_holds_fewer_films():
    signs = recorded()["four-experiments"].tables["by sign"]
    printed, other = signs["the printed sign", "held"], signs["the other sign", "held"]
    assert printed.high < other.low
    assert signs["the printed sign", "overlap"].high < signs["the other sign", "overlap"].low


def test_fifty_samples_are_the_tracker_in_the_opponent_space():
    tables = recorded()["colour-condensation"].tables
    for world in ("rectangle", "beetle", "snail"):  # circles are followed in RGB
        assert tables["by samples"]["50", world] == tables["by space"]["opponent", world]


def test_camshift_loses_circles_and_some_snails_and_cards_and_no_beetle():
    lost = recorded()["four-experiments"].tables["lost"]
    assert lost["CamShift", "circles"] > 0.5 > 0.2 > lost["CamShift", "snail"] > 0.1
    assert lost["CamShift", "rectangle"] > 0 == lost["CamShift", "beetle"]


def test_judged_by_half_the_overlap_the_claim_holds_too():
    assert recorded()["four-experiments"].evidence["overlap of 0.5 or more"].low > 0.9


def test_one_sample_often_loses_the_beetle():
    by_samples = recorded()["colour-condensation"].tables["by samples"]
    assert by_samples["1", "beetle"].estimate < by_samples["50", "beetle"].low
