"""Rows are asked by name, and answer as pandas, NumPy and `studies.intervals` would."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from studies import intervals
from studies.rows import Rows, framed

RNG = np.random.default_rng(5)
FILMS, RULES, LIGHTS = range(40, 52), ("old", "new"), (0.5, 1.0)


def made():
    index = pd.MultiIndex.from_product([FILMS, RULES, LIGHTS], names=["film", "rule", "light"])
    table = pd.DataFrame(index=index).reset_index()
    table["error"] = RNG.gamma(2.0, size=len(table)) * np.where(table.rule == "new", 0.5, 1.0)
    table["found"] = RNG.random(len(table)) < 0.7
    table["seen"] = RNG.integers(5, 50, len(table))
    table["right"] = (table.seen * RNG.random(len(table))).astype(int)
    return Rows(table, "film", {"gain": 2.0}, "Computed here.")


ROWS = made()
TABLE = ROWS.table
NEW = TABLE[TABLE.rule == "new"]


def test_rows_of_a_level_or_of_some_keep_everything_else():
    new = ROWS.where(rule="new")
    pd.testing.assert_frame_equal(new.table, NEW)
    assert (new.replicate, new.fixed, new.note) == ("film", {"gain": 2.0}, "Computed here.")
    some = ROWS.where(film=range(41, 43), light=0.5)
    pd.testing.assert_frame_equal(
        some.table, TABLE[TABLE.film.isin([41, 42]) & (TABLE.light == 0.5)]
    )
    assert len(ROWS.where(rule=("new", "old"))) == len(ROWS) == len(TABLE)
    assert len(ROWS.where(found=True)) == TABLE.found.sum()


def test_values_come_in_the_order_of_the_rows():
    np.testing.assert_array_equal(ROWS.of("error"), TABLE.error)
    np.testing.assert_array_equal(ROWS.of("error", rule="new"), NEW.error)
    assert ROWS.of("seen").dtype == TABLE.seen.dtype


def test_levels_come_in_their_order():
    shuffled = Rows(TABLE.iloc[::-1], "film", {})
    assert ROWS.levels("rule") == RULES
    assert shuffled.levels("rule") == RULES[::-1]
    assert ROWS.levels("film") == tuple(FILMS)


def test_means_of_each_replicate_or_of_each_combination():
    expected = TABLE.groupby("film")[["error", "found", "seen"]].mean()
    found = ROWS.per()
    np.testing.assert_allclose(found.of("error"), expected.error)
    np.testing.assert_allclose(found.of("found"), expected.found)
    assert found.levels("film") == tuple(FILMS)
    both = ROWS.per("rule", "light")
    assert len(both) == 4
    mean = TABLE[(TABLE.rule == "new") & (TABLE.light == 1.0)].seen.mean()
    assert both.of("seen", rule="new", light=1.0) == pytest.approx(mean)


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        (ROWS.mean("error", "m", rule="new"), intervals.bootstrap_mean(NEW.error.to_numpy(), "m")),
        (ROWS.mean("found"), intervals.bootstrap_mean(TABLE.found.to_numpy(float))),
        (ROWS.rate("found", rule="new"), intervals.proportion(int(NEW.found.sum()), len(NEW))),
        (ROWS.spread("error", "m"), intervals.spread(TABLE.error.to_numpy(), "m")),
        (
            ROWS.share("right", "seen", rule="new"),
            intervals.bootstrap_ratio(NEW.right.to_numpy(float), NEW.seen.to_numpy(float)),
        ),
        (
            ROWS.ratio("error", ("rule", "new", "old"), light=0.5),
            intervals.bootstrap_ratio(
                ROWS.of("error", rule="new", light=0.5), ROWS.of("error", rule="old", light=0.5)
            ),
        ),
        (
            ROWS.difference("error", ("rule", "new", "old"), "m", light=0.5),
            intervals.bootstrap_mean(
                ROWS.of("error", rule="new", light=0.5) - ROWS.of("error", rule="old", light=0.5),
                "m",
            ),
        ),
    ],
)
def test_each_kind_of_number_has_its_interval(found, expected):
    assert found == expected
    assert found.low < found.estimate < found.high


@pytest.mark.parametrize(("so", "low"), [(True, 0.757), (False, 0.0)])
def test_what_is_so_in_all_rows_or_in_none_has_the_interval_of_a_rate(so: bool, low: float):
    rows = Rows(TABLE[:12].assign(found=so, right=TABLE.seen * so), "film", {})
    wilson = intervals.proportion(12 * so, 12)
    assert wilson.low == pytest.approx(low, abs=0.001)
    assert wilson.high - wilson.low == pytest.approx(0.243, abs=0.001)
    assert rows.mean("found") == wilson
    assert rows.mean("right").low > 0 if so else rows.mean("right").high == 0  # counts, no rate


def test_medians_and_largest_values():
    assert ROWS.median("error", rule="new") == np.median(NEW.error)
    assert ROWS.largest("seen", rule="new") == NEW.seen.max()
    assert isinstance(ROWS.largest("seen"), float)


def test_pairs_are_of_the_same_replicates_in_the_same_order():
    less = Rows(TABLE.drop(TABLE.index[(TABLE.rule == "old") & (TABLE.film == 41)]), "film", {})
    shuffled = Rows(pd.concat([NEW, TABLE[TABLE.rule == "old"].iloc[::-1]]), "film", {})
    for rows in (less, shuffled):
        for compare in (rows.ratio, rows.difference):
            with pytest.raises(ValueError, match="error at 'new' and 'old' is not of the same"):
                compare("error", ("rule", "new", "old"), light=0.5)
    with pytest.raises(ValueError, match="no row has rule 'odd'; there are"):
        ROWS.ratio("error", ("rule", "new", "odd"))


def test_what_there_is_not_is_said_with_what_there_is():
    with pytest.raises(KeyError, match=r"no column 'weather'; there are film, rule, light, error"):
        ROWS.where(weather="dry")
    for ask in (ROWS.of, ROWS.mean, ROWS.levels, ROWS.rate):
        with pytest.raises(KeyError, match="no column 'speed'"):
            ask("speed")
    with pytest.raises(ValueError, match=r"no row has light 0\.7; there are \(0\.5, 1\.0\)"):
        ROWS.mean("error", light=0.7)
    with pytest.raises(ValueError, match=r"no row has rule \(\); there are"):
        ROWS.where(rule=())
    with pytest.raises(ValueError, match=r"no row has light 1\.0; there are"):
        ROWS.where(light=0.5).where(light=(0.5, 1.0))


@pytest.mark.parametrize("kind", [tuple, list])
@pytest.mark.parametrize("levels", [("new", "odd"), ("odd", "new"), ("odd", None)])
def test_a_level_that_no_row_has_is_named_beside_those_that_there_are(levels, kind):
    odd = ", ".join(repr(level) for level in levels if level != "new")
    with pytest.raises(ValueError, match=rf"no row has rule {odd}; there are \('old', 'new'\)"):
        ROWS.where(rule=kind(levels))
    with pytest.raises(ValueError, match="no row has film 52, 53; there are"):
        ROWS.where(film=range(50, 54))


def test_no_level_is_a_level():
    rule = pd.Series([None if one == "new" else one for one in TABLE.rule], dtype=object)
    rows = Rows(TABLE.assign(rule=rule), "film", {})
    assert rows.levels("rule") == ("old", None)
    np.testing.assert_array_equal(rows.of("error", rule=None), NEW.error)
    assert len(rows.where(rule=(None, "old"))) == len(TABLE)
    for some in (rows, replace(rows, table=rows.table[::-1])):
        means = some.per("rule")
        assert means.levels("rule") == some.levels("rule")
        assert means.of("error", rule=None).item() == pytest.approx(NEW.error.mean())
    assert rows.ratio("error", ("rule", None, "old")) == ROWS.ratio("error", ("rule", "new", "old"))
    assert tuple(rows.by("rule", {"rows": len}).rows) == ("old", "None")


def test_a_table_has_a_row_for_each_level():
    columns = {"mean": lambda rows: rows.mean("error", "m"), "found": ("rate", "found"),
               "share": ("share", "right", "seen"), "rows": len}  # fmt: skip
    table = ROWS.by("rule", columns, {"mean": "over films"}, "95 %")
    assert tuple(table.rows) == RULES
    assert table["new", "mean"] == ROWS.mean("error", "m", rule="new")
    assert table["new", "found"] == ROWS.rate("found", rule="new")
    assert table["old", "share"] == ROWS.share("right", "seen", rule="old")
    assert table["old", "rows"] == len(TABLE) / 2
    assert table.columns == {"mean": "over films", "found": "", "share": "", "rows": ""}
    assert (table.about, table.corner) == ("95 %", "rule")
    assert ROWS.by("rule", columns, corner="").corner == ""


def test_a_table_of_two_factors():
    table = ROWS.cross("rule", "light", ("largest", "error"), "m", "light {:g}".format)
    assert tuple(table.rows) == RULES
    assert tuple(table.columns) == ("light 0.5", "light 1")
    assert table["old", "light 1"] == ROWS.largest("error", rule="old", light=1.0)
    assert table["new", "light 0.5"] == ROWS.largest("error", rule="new", light=0.5)
    assert (table.about, table.corner) == ("m", "rule")


def test_trials_become_rows_arrays_of_one_length_as_many():
    trials = [
        {"film": k, "rule": np.array(["a", "b"]), "x": np.array([k, k + 0.5])} for k in (3, 1)
    ]
    table = framed(trials)
    expected = {"film": [3, 3, 1, 1], "rule": ["a", "b"] * 2, "x": [3, 3.5, 1, 1.5]}
    pd.testing.assert_frame_equal(table, pd.DataFrame(expected))
    assert framed([{"film": 1, "found": True}]).found.dtype == bool


@pytest.mark.parametrize(
    ("trials", "problem"),
    [
        ([{"k": 1, "x": np.nan}], "x must be finite in every row"),
        ([{"k": 1, "x": 1.0}, {"k": 2, "x": np.inf}], "x must be finite"),
        ([{"k": 1, "x": [1.0, -np.inf]}], "x must be finite"),
        ([{"k": 1, "x": [1, 2], "y": [1, 2, 3]}], r"of one length, got \[2, 3\]"),
        ([{"k": 1, "x": 1}, {"k": 2, "y": 1}], r"trials must give the same: \['k', 'x'\]"),
        ([{"k": 1, "x": 1, "y": 1}, {"k": 2, "y": 1, "x": 1}], "trials must give the same"),
    ],
)
def test_rows_that_would_be_no_table_are_refused(trials, problem):
    with pytest.raises(ValueError, match=problem):
        framed(trials)


def test_rows_are_shown_as_a_table_and_say_where_they_come_from():
    shown = ROWS
    assert repr(shown).endswith("\nComputed here.")
    assert all(name in repr(shown) for name in shown.table.columns)
    html = replace(shown, note="<b>")._repr_html_()
    assert html.endswith("<p>&lt;b&gt;</p>")
    assert "<table" in html
