"""The claims of the chapter: the record, and what their findings must say."""

from types import MappingProxyType

from matplotlib.figure import Figure

from robot_perception.chapters.tutor_following import figures
from tests.chapters.ledger import LedgerTests, recorded


class TestLedger(LedgerTests):
    stem = "tutor_following"
    pictures = MappingProxyType(
        {
            "hand-detector": 0.3,
            "multi-patch": 1.0,
            "patch-occlusion": 1.0,
            "drift-dilemma": 1.0,
            "interaction-states": 1.0,
        }
    )
    few_films = frozenset({"multi-patch", "patch-occlusion", "drift-dilemma"})
    open_when_quick = frozenset(
        {
            "hand-detector",
            "multi-patch",
            "patch-occlusion",
            "drift-dilemma",
            "interaction-states",
        }
    )


def test_hands_are_found_as_often_as_the_faces_beside_them():
    found = recorded()["hand-detector"]
    assert found.value.overlaps(found.evidence["faces in the same pictures"])


def test_the_darkest_faces_are_missed_and_the_darkest_hands_are_not():
    table = recorded()["hand-detector"].tables["tones"]
    assert table["6", "face"].high < 0.5 < 0.75 < table["6", "hand"].low


def test_two_fingers_are_often_an_open_hand_and_fists_seldom():
    table = recorded()["hand-detector"].tables["gestures"]
    assert table["two", "taken"].low > 0.4
    assert table["fist", "taken"].high < 0.25


def test_patches_that_all_learn_are_no_better_than_one_and_one_that_never_does_is():
    found = recorded()["multi-patch"]
    assert found.value.high < 0.2
    assert found.evidence["one patch that never learns, less one that adapts"].low > 0.3
    assert found.evidence["several gated patches, less one that adapts"].low > 0.3


def test_a_passer_who_goes_on_loses_nobody():
    table = recorded()["multi-patch"].tables["held"]
    assert all(table[way, "short, whole"].estimate > 0.9 for way in table.rows)


def test_fixed_models_lose_nearly_all_in_the_dark_and_gated_ones_most():
    table = recorded()["drift-dilemma"].tables["light"]
    assert table["one patch, fixed", "darker"].estimate == 0
    assert table["several, gated", "darker"].high < table["several, adapting", "darker"].estimate


def test_a_share_of_strangers_who_are_not_obeyed_is_not_called_obeyed():
    found = recorded()["interaction-states"]
    table, row = found.tables["orders"], "a stranger's hand"
    refused = found.evidence["strangers who are not obeyed"].estimate
    named = [c for c in table.columns if getattr(table[row, c], "estimate", None) == refused]
    assert named == ["right"]
    ax = figures.orders.on(Figure().add_subplot(), table)
    labels = [tick.get_text() for tick in ax.get_yticklabels()]
    assert labels == [f"{name} → {table[name, 'state']}" for name in table.rows]
    page = figures.orders(table).bundle["text/html"]
    assert "obey" not in " ".join((ax.get_xlabel(), page, *table.columns.values()))


def test_more_orders_are_obeyed_than_visits_go_through():
    found = recorded()["interaction-states"]
    assert found.value.low > found.evidence["visits without a fault"].high
