"""The claims of the chapter: the record, and what their findings must say."""

from types import MappingProxyType

from tests.chapters.ledger import LedgerTests, recorded


class TestLedger(LedgerTests):
    stem = "arm_tracking"
    pictures = MappingProxyType(
        {"apf-400": 1.0, "pointing": 1.0, "clutter": 1.0, "collisions": 1.0}
    )
    rounding = MappingProxyType({"apf-400": 0.3, "pointing": 0.5, "clutter": 0.5,
                                 "collisions": 0.2})  # fmt: skip
    few_films = frozenset({"apf-400", "pointing", "clutter", "collisions"})
    open_when_quick = frozenset({"pointing", "clutter"})


def test_patches_hold_the_arms_in_clutter_and_contours_add_little():
    found = recorded()["clutter"]
    table = found.tables["held"]
    whole = table["all cues", "gesturing, clutter"]
    for way in ("contours only", "no patches"):
        assert table[way, "gesturing, clutter"].high < whole.low
    assert table["no contours", "gesturing, clutter"].overlaps(whole)
    losses = {name: value.estimate for name, value in found.evidence.items() if "less no" in name}
    assert max(losses, key=losses.get) == "all cues less no patches"


def test_contours_lose_arms_before_a_bare_wall_where_patches_hold_them():
    found = recorded()["pointing"].evidence
    assert found["no contours"].low > 0.6
    assert found["contours five times as strong"].high < found["no contours"].estimate


def test_the_turn_about_the_axis_is_known_least():
    table = recorded()["pointing"].tables["joints"]
    for scene in table.columns:
        each = [table[name, scene].estimate for name in table.rows]
        assert each[0] == min(each)
        if scene.startswith("pointing"):
            assert each[2] == max(each)


def test_no_filter_is_much_better_than_another():
    found = recorded()["apf-400"].evidence
    for name in ("condensation", "importance"):
        ratio = found[f"auxiliary over {name}, 400 particles"]
        assert 0.8 < ratio.estimate < 1.25


def test_a_picture_takes_less_than_a_fortieth_of_the_papers_second():
    assert recorded()["one-second"].value.estimate < 1 / 40
