"""Measures of a study's rows are said once; claims, tables and sentences are made of them."""

import pandas as pd
import pytest

from robot_perception.teaching.words.prose import tell
from studies.intervals import exact
from studies.rows import Rows
from studies.says import Says, When
from studies.verdicts import Accepted
from tests.studies.entries import study

TABLE = pd.DataFrame(
    {
        "film": [0, 1, 2, 0, 1, 2],
        "rule": ["new"] * 3 + ["old"] * 3,
        "found": [True, True, False, False, True, False],
        "off by": [1.0, 2.0, 3.0, 4.0, 5.0, 9.0],
    }
)
ROWS = Rows(TABLE, "film", {})
OTHERS = Rows(TABLE.assign(found=False), "film", {})


def largest(rows):
    """Return the largest error."""
    return exact(rows.largest("off by"), "m")


@pytest.fixture
def says() -> Says:
    return study(ROWS).says(
        "{film} films; {rule} rules",
        found=("rate", "found", "share of the films"),
        off_by=(largest, "at most"),
        more=("difference", "off by", ("rule", "old", "new"), "old less new"),
    )


def test_a_measure_is_a_function_of_rows_and_of_those_of_the_study(says):
    measure = says("found", rule="new")
    assert measure() == ROWS.rate("found", rule="new")
    assert measure(OTHERS).estimate == 0
    assert says("off_by")() == exact(9.0, "m")
    assert says("more")() == ROWS.difference("off by", ("rule", "old", "new"))


def test_a_measure_that_is_not_said_is_an_error(says):
    with pytest.raises(KeyError, match="no measure 'lost'; there are found, off_by, more"):
        says("lost")
    with pytest.raises(ValueError, match="no row has rule 'none'"):
        says("found", rule="none")()


def test_a_table_has_a_column_for_each_measure_in_its_words(says):
    table = says.by("rule", "found", "off_by", corner="by")()
    assert list(table.rows) == ["new", "old"]
    assert table.columns == {"found": "share of the films", "off by (m)": "at most"}
    assert (table.about, table.corner) == ("3 films; 2 rules", "by")
    assert table["old", "found"] == ROWS.rate("found", rule="old")
    assert table["new", "off by (m)"] == exact(3.0, "m")
    assert says.by("rule", "found")(OTHERS)["new", "found"].estimate == 0
    one = says.by("film", "found", about="a rule", rule="old")()
    assert (len(one.rows), one.about, one.corner) == (3, "a rule", "film")
    assert [cell.estimate for (cell,) in one.rows.values()] == [0, 1, 0]


def test_levels_are_columns_too(says):
    table = says.by("film", "found", across="rule")()
    assert table.columns == {"new": "share of the films", "old": "share of the films"}
    assert [cell.estimate for cell in table.rows["1"]] == [1, 1]
    assert [cell.estimate for cell in table.rows["0"]] == [1, 0]
    both = says.by("film", "found", "off_by", across="rule", film={"third": 2})()
    assert list(both.columns) == ["found, new", "found, old", "off by, new", "off by, old"]
    assert [cell.estimate for cell in both.rows["third"]] == [0, 0, 3, 9]


def test_levels_have_the_names_that_they_are_given(says):
    table = says.by("rule", "off_by", rule={"the old one": "old", "any": ("new", "old")}, film=1)()
    assert {name: cell.estimate for name, (cell,) in table.rows.items()} == {
        "the old one": 5,
        "any": 5,
    }
    assert (table.about, table.corner) == ("1 films; 2 rules", "rule")
    columns = says.by("rule", "off_by", across="film", film={"last": 2, "first": 0})().columns
    assert [*columns] == ["last", "first"]
    assert [*says.by("rule", "found", rule=("old", "new"))().rows] == ["old", "new"]
    assert [*says.by("rule", "found", rule="old")().rows] == ["old"]


def test_rows_of_several_factors_are_their_pairs(says):
    table = says.by(("film", "rule"), "off_by", film={"one": 0, "two": 1})()
    assert {name: cell.estimate for name, (cell,) in table.rows.items()} == {
        "one, new": 1,
        "one, old": 4,
        "two, new": 2,
        "two, old": 5,
    }
    assert table.corner == ""


def test_rows_are_taken_where_a_table_says(says):
    places = {"a": {"rule": "old", "film": (0, 1)}, "b": lambda rows: OTHERS.where(film=0)}
    table = says.by(places, "found", "off_by", corner="of")()
    assert (table["a", "found"].estimate, table["a", "off by (m)"].estimate) == (0.5, 5)
    assert (table["b", "found"].estimate, table["b", "off by (m)"].estimate) == (0, 4)
    assert table.corner == "of"


def test_other_rows_stand_below(says):
    best = {"best": {"found": lambda rows: len(rows)}}
    table = says.by("rule", "found", "off_by", below=best)(ROWS.where(film=(1, 2)))
    assert [*table.rows] == ["new", "old", "best"]
    assert table.rows["best"] == (4, None)
    across = says.by("rule", "found", across="film", below={"best": {"found": len}})()
    assert across.rows["best"] == (2, 2, 2)


def test_a_name_is_followed_by_the_unit_of_its_numbers():
    """Where all have the same, and levels do not stand in its place."""
    says = study(ROWS).says(
        way_off=(lambda rows: rows.mean("off by", "m"), ""),
        more=(lambda rows: exact(1.0, rows.levels("rule")[0]), ""),
    )
    assert [*says.by("rule")().columns] == ["way off (m)", "more"]
    assert [*says.by({"all": {}}, "way_off", across="rule")().columns] == ["new", "old"]


def test_a_sentence_takes_numbers_by_name(says):
    told = tell(
        "{new.found:.0%} and {old.found:.0%}, at most {old.off_by:.1f} m, {more:.0f} m more "
        "(from {more.low:.1f}).",
        new=says.at(rule="new"),
        old=says.at(rule="old"),
        more=says("more")(),
    )
    assert repr(told) == "67\xa0% and 33\xa0%, at most 9.0 m, 4 m more (from 3.0)."
    assert repr(tell("{x:.0%}", x=says("found"))) == "50\xa0%"
    assert repr(tell("{x:.1p} points", x=exact(-0.1234))) == "−12.3 points"
    assert repr(tell("{x:.0p} points", x=-0.001)) == "0 points"


def test_conditions_are_judged_by_the_range_of_the_claim(says):
    accepted = Accepted(0.0, 5.0, "a range")
    inside, outside = says("off_by", rule="new"), says("off_by", rule="old")
    both = When("rules are new", inside=inside, outside=outside).judged(ROWS, accepted)
    assert (both.text, both.needed, both.holds) == ("rules are new", True, True)
    other = When("rules are old", inside=outside, outside=inside).judged(ROWS, accepted)
    assert (other.needed, other.holds) == (False, False)
    alone = When("rules are new", outside=outside).judged(ROWS, accepted)
    assert (alone.needed, alone.holds) == (True, False)


def test_measures_are_read_when_they_are_asked_for():
    asked = []

    def count(rows):
        asked.append(len(rows))
        return exact(len(rows))

    says = study(ROWS).says(count=(count, ""))
    some, measure, table = says.at(rule="new"), says("count"), says.by("rule")
    assert asked == []
    assert (some.count.estimate, measure().estimate) == (3, 6)
    table()
    assert asked == [3, 6, 3, 3]
    assert says.by("rule", rule="old")().rows == {"old": (exact(3),)}
