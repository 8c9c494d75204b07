"""The claims of the chapter: the record, and what their findings must say."""

from types import MappingProxyType

from tests.chapters.ledger import LedgerTests, quick, recorded


class TestLedger(LedgerTests):
    stem = "tutor_face"
    pictures = MappingProxyType(
        {
            "face-detect": 0.05,
            "eigenfaces": 0.05,
            "kalman-roi": 0.1,
            "icondensation-face": 0.3,
            "identity-keeps-link": 0.5,
        }
    )


def test_strangers_pass_and_more_eigenimages_show_more_of_a_face():
    table = recorded()["eigenfaces"].tables["counts"]
    assert table["20", "strangers"].low > 0.3
    left = [table[count, "left"].estimate for count in table.rows]
    assert left == sorted(left, reverse=True)


def test_few_people_are_told_apart_better_than_many():
    found = quick("eigenfaces")
    assert found.evidence["ten people"].high < found.value.low


def test_the_detector_looks_at_less_than_the_picture():
    assert recorded()["kalman-roi"].evidence["searched share of a picture"].high < 1 / 3


def test_who_began_the_link_has_it_more_often_verified_than_with_the_nearest_face():
    found = recorded()["identity-keeps-link"].evidence
    verified, near, told = (
        found[f"who began has it, {rule}"] for rule in ("verified", "nearest face", "told")
    )
    assert near.estimate < verified.low
    assert verified.high < told.low
    assert found["never another, nearest face"].high < 0.5
