"""Recorded rows come back as they were, or not at all."""

import json
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pandas as pd
import pytest

from studies.files import DamagedFile
from studies.stored import recorded_rows, storage
from studies.stored.recorded_rows import (
    alike,
    content,
    drop,
    file_of,
    read,
    renew,
    seconds,
    variants,
    write,
)

TABLE = pd.DataFrame(
    {
        "film": np.arange(3),
        "rule": ["old", "new – ω", ""],
        "found": [True, False, True],
        "error": [0.1 + 0.2, 1e-300, -np.pi],
        "single": np.float32([0.1, 2, 3]),
        "byte": np.uint8([0, 255, 7]),
    }
)
OTHER = TABLE.assign(error=[1.0, 2.0, 3.0])
NAMES = "small", "study"


@pytest.fixture
def recorded(book):
    """Record two variants of a study."""
    write(*NAMES, "as declared", TABLE, "code", "levels")
    write(*NAMES, "gain=2", OTHER, "code", "other levels")
    return file_of(*NAMES)


def test_rows_that_are_recorded_at_the_same_time_are_all_there(book):
    names = [f"gain={k}" for k in range(8)]
    with ThreadPoolExecutor(8) as pool:
        list(pool.map(lambda name: write(*NAMES, name, TABLE, name, "levels"), names))
    assert sorted(variants(*NAMES)) == names
    assert [read(*NAMES, name).code for name in names] == names


def replaced(file, variant, name, values):
    """Put other numbers in the file, as somebody would who wants a better result."""
    stored = storage.load(file, recorded_rows._Stored)
    every = {key: dict(columns) for key, columns in stored.variants.items()}
    every[variant][name] = np.asarray(values)
    storage.save(file, recorded_rows._Stored(every))


def said(file, **changes):
    """Change what the summary says of the declared variant."""
    summary = file.with_suffix(".json")
    text = json.loads(summary.read_text("utf-8"))
    text["variants"]["as declared"] |= changes
    summary.write_text(json.dumps(text), "utf-8")
    recorded_rows._read.cache_clear()


def test_rows_come_back_exactly_with_their_types(recorded):
    found = read(*NAMES, "as declared")
    pd.testing.assert_frame_equal(found.table, TABLE, check_exact=True)
    assert found.table.dtypes.drop("rule").equals(TABLE.dtypes.drop("rule"))
    assert (found.code, found.declared) == ("code", "levels")
    assert found.processor == recorded_rows.processor()
    assert recorded == recorded_rows.folder() / "small.study.npz"


@pytest.mark.parametrize(
    "levels",
    [
        [None, "old", "None"],
        [None, None, None],
        [None, 0.1 + 0.2, 3],
        ["old", 3, True],
        ["\x10", "\x10null", "null"],
        [np.float64(0.5), None, "0.5"],
    ],
)
def test_levels_that_are_no_text_come_back_as_they_were(book, levels):
    table = TABLE.assign(rule=pd.Series(levels, dtype=object))
    file = write(*NAMES, "as declared", table, "code", "levels")
    found = read(*NAMES, "as declared").table.rule.tolist()
    assert found == levels
    assert [type(one) for one in found] == [type(np.asarray(one).tolist()) for one in levels]
    stored = storage.load(file, recorded_rows._Stored).variants["as declared"]["rule"]
    replaced(file, "as declared", "rule", [*stored[:2], "odd"])
    with pytest.raises(DamagedFile):
        read(*NAMES, "as declared")


def test_a_variant_that_is_recorded_leaves_the_others(recorded):
    pd.testing.assert_frame_equal(read(*NAMES, "gain=2").table, OTHER)
    write(*NAMES, "gain=2", TABLE[:1], "new code", "other levels")
    pd.testing.assert_frame_equal(read(*NAMES, "as declared").table, TABLE)
    assert len(read(*NAMES, "gain=2").table) == 1
    assert read(*NAMES, "gain=2").code == "new code"
    assert variants(*NAMES) == ("as declared", "gain=2")


def test_what_nobody_has_recorded_is_nothing(recorded):
    assert read(*NAMES, "gain=3") is None
    assert read("small", "other", "as declared") is None
    assert variants("small", "other") == ()


def test_a_variant_that_is_dropped_leaves_the_others(recorded):
    drop(*NAMES, {"gain=2"})
    assert variants(*NAMES) == ("as declared",)
    assert read(*NAMES, "gain=2") is None
    assert list(storage.load(recorded, recorded_rows._Stored).variants) == ["as declared"]
    pd.testing.assert_frame_equal(read(*NAMES, "as declared").table, TABLE)


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("error", [0.3, 1e-300, -np.pi]),  # 0.1 + 0.2 but for the last bit
        ("found", [True, True, True]),
        ("found", [1, 0, 1]),
        ("rule", ["old", "new", ""]),
        ("byte", [0, 255]),
        ("single", np.float64(np.float32([0.1, 2, 3]))),
        ("more", [0.0, 0.0, 0.0]),
    ],
)
def test_numbers_that_were_replaced_by_hand_are_refused(recorded, name, values):
    replaced(recorded, "as declared", name, values)
    with pytest.raises(DamagedFile, match=r"small\.study\.npz: holds no rows of 'as d"):
        read(*NAMES, "as declared")
    assert read(*NAMES, "gain=2") is not None


def test_rows_of_another_variant_are_not_taken_for_those(recorded):
    stored = storage.load(recorded, recorded_rows._Stored).variants
    swapped = dict(zip(stored, reversed(stored.values()), strict=True))
    storage.save(recorded, recorded_rows._Stored(swapped))
    with pytest.raises(DamagedFile, match="not those that were recorded"):
        read(*NAMES, "as declared")


def test_a_variant_that_is_only_described_is_damaged(recorded):
    stored = storage.load(recorded, recorded_rows._Stored).variants
    storage.save(recorded, recorded_rows._Stored({"gain=2": stored["gain=2"]}))
    with pytest.raises(DamagedFile, match="holds no rows of 'as declared'"):
        read(*NAMES, "as declared")


def test_columns_that_are_described_otherwise_are_damaged(recorded):
    columns = json.loads(recorded.with_suffix(".json").read_text("utf-8"))
    columns = columns["variants"]["as declared"]["columns"]
    said(recorded, columns=columns | {"more": "3 float64"})
    with pytest.raises(DamagedFile, match="holds no rows"):
        read(*NAMES, "as declared")


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"variants": {'])
def test_a_damaged_summary_is_named(recorded, text):
    recorded.with_suffix(".json").write_text(text)
    recorded_rows._read.cache_clear()
    with pytest.raises(DamagedFile, match=r"small\.study\.json: no summary of rows"):
        read(*NAMES, "as declared")


def test_a_damaged_file_is_named(recorded):
    recorded.write_bytes(recorded.read_bytes()[:200])
    with pytest.raises(DamagedFile, match=r"small\.study\.npz"):
        read(*NAMES, "as declared")


def test_rows_fit_the_code_and_the_levels_that_gave_them(recorded):
    found = read(*NAMES, "as declared")
    assert found.fits("code", "levels")
    assert not found.fits("other code", "levels")
    assert not found.fits("code", "other levels")
    assert not found.fits(None, "levels")
    said(recorded, code=None)
    assert not read(*NAMES, "as declared").fits(None, "levels")


def test_keys_are_renewed_and_the_rows_stay(recorded):
    before = recorded.read_bytes()
    renew(*NAMES, "as declared", "new code", "new levels")
    found = read(*NAMES, "as declared")
    assert found.fits("new code", "new levels")
    assert read(*NAMES, "gain=2").fits("code", "other levels")
    assert recorded.read_bytes() == before
    pd.testing.assert_frame_equal(found.table, TABLE)


def test_the_same_numbers_make_the_same_file(book):
    files = []
    for stem in ("one", "two"):
        for name, table in (("a", TABLE), ("b", OTHER)):
            write(stem, "study", name, table, "code", "levels")
        files.append(file_of(stem, "study"))
    assert files[0].read_bytes() == files[1].read_bytes()
    assert files[0].with_suffix(".json").read_text() == files[1].with_suffix(".json").read_text()


def test_the_hash_is_of_names_types_shapes_and_numbers():
    columns = {"a": np.array([1.0, 2.0]), "b": np.array([1, 2])}
    others = [
        {"a": np.array([1.0, 2.0]), "c": np.array([1, 2])},
        {"a": np.array([1.0, 2.5]), "b": np.array([1, 2])},
        {"a": np.array([2.0, 1.0]), "b": np.array([1, 2])},
        {"a": np.array([1.0, 2.0]), "b": np.array([1, 2], dtype=np.uint64)},
        {"a": np.array([[1.0, 2.0]]), "b": np.array([1, 2])},
        {"a": np.array([1.0, 2.0])},
    ]
    assert len({content(one) for one in (columns, *others)}) == 7
    assert content(dict(reversed(columns.items()))) == content(columns)
    assert content({"a": np.arange(4)[::2]}) == content({"a": np.array([0, 2])})


RANGE = pd.Series([0.0, 10.0, 20.0])


@pytest.mark.parametrize(
    ("again", "before", "elsewhere", "same"),
    [
        ([5.0], [5.0], False, True),
        ([5.0 + 1e-5], [5.0], False, True),  # of 20, the largest
        ([5.0 + 3e-5], [5.0], False, False),
        ([5.0 - 3e-5], [5.0], False, False),
        ([9.0], [5.0], False, False),
        ([9.0], [5.0], True, True),
        ([-19.9], [5.0], True, True),
        ([39.9], [5.0], True, True),
        ([-20.1], [5.0], True, False),
        ([40.1], [5.0], True, False),
        ([5.0, 5.0], [5.0, 5.1], False, False),
    ],
)
def test_a_number_is_alike_to_rounding_or_elsewhere_within_the_reach_of_the_others(
    again, before, elsewhere, same
):
    assert alike(pd.Series(again), pd.Series(before), RANGE, elsewhere=elsewhere) is same


def test_a_word_is_the_same_or_elsewhere_one_of_the_others():
    words = pd.Series(["old", "new"])
    old, new, other = words[:1], words[1:], pd.Series(["other"])
    assert alike(new, new, words)
    assert not alike(old, new, words)
    assert alike(old, new, words, elsewhere=True)
    assert not alike(other, new, words, elsewhere=True)


def test_zeros_must_be_zero_but_for_rounding():
    zero = pd.Series([0.0])
    assert alike(zero, zero, zero)
    assert alike(pd.Series([-9e-13]), zero, zero)
    assert not alike(pd.Series([1.1e-12]), zero, zero)
    assert alike(pd.Series([True]), pd.Series([True]), pd.Series([True, False]))
    assert not alike(pd.Series([False]), pd.Series([True]), pd.Series([True, False]))


def test_zero_is_a_share_of_what_numbers_are_compared_with():
    """A difference below 1e-7 of singular values near a hundred is rounding on any processor."""
    noise = pd.Series([3e-12, -2e-12])
    for elsewhere in (False, True):
        assert alike(pd.Series([9e-8, 0.0]), noise, noise, 100.0, elsewhere=elsewhere)
        assert not alike(pd.Series([1.1e-7, 0.0]), noise, noise, 100.0, elsewhere=elsewhere)
    assert not alike(pd.Series([9e-8, 0.0]), noise, noise)


def test_elsewhere_a_single_number_is_alike_to_rounding():
    alone = pd.Series([5.0])
    assert alike(pd.Series([5.0 + 4e-6]), alone, alone, elsewhere=True)
    assert not alike(pd.Series([5.0 + 6e-6]), alone, alone, elsewhere=True)
    assert not alike(pd.Series([5.0 - 6e-6]), alone, alone, elsewhere=True)


@pytest.fixture
def fresh():
    """Forget the kind of this processor before and after."""
    recorded_rows.processor.cache_clear()
    yield
    recorded_rows.processor.cache_clear()


@pytest.mark.parametrize(
    ("found", "kernels"),
    [
        ([{"user_api": "blas", "internal_api": "openblas", "architecture": "Zen"}], "Haswell"),
        (
            [{"user_api": "blas", "internal_api": "openblas", "architecture": "SkylakeX"}],
            "SkylakeX",
        ),
        ([{"user_api": "openmp", "internal_api": "openmp"}], "unknown"),
        ([{"user_api": "blas", "internal_api": "mkl"}], "mkl"),
    ],
)
def test_a_kind_of_processor_is_its_instructions_and_its_kernels(
    fresh, monkeypatch, found, kernels
):
    monkeypatch.setattr(recorded_rows, "threadpool_info", lambda: found)
    instructions, name = recorded_rows.processor().split()
    assert instructions in recorded_rows.FEATURES
    assert name == kernels


def test_rows_whose_summary_names_no_kernels_are_of_those_that_give_them_bit_for_bit(recorded):
    said(recorded, processor="AVX2")
    assert read(*NAMES, "as declared").processor == "AVX2 Haswell"


# What is interrupted


def test_seconds_are_recorded_beside_the_variants_and_stay(recorded):
    assert seconds(*NAMES) == seconds("small", "other") == {}
    write(*NAMES, "as declared", TABLE, "code", "levels", (0.5, 1.5))
    write(*NAMES, "gain=2", OTHER, "new code", "other levels")
    renew(*NAMES, "gain=2", "newer code", "other levels")
    assert seconds(*NAMES) == {"as declared": (0.5, 1.5)}
    write(*NAMES, "gain=2", OTHER, "new code", "other levels", (2.0, 3.0))
    assert seconds(*NAMES) == {"as declared": (0.5, 1.5), "gain=2": (2.0, 3.0)}
    drop(*NAMES, {"as declared"})
    assert seconds(*NAMES) == {"gain=2": (2.0, 3.0)}
    recorded.with_suffix(".json").write_text('{"seconds": [1]}')
    assert seconds(*NAMES) == {}


@pytest.mark.parametrize("half", [".npz", ".json"])
def test_half_of_what_was_recorded_is_nothing_and_is_recorded_again(recorded, half):
    recorded.with_suffix(half).unlink()
    assert read(*NAMES, "as declared") is None
    assert variants(*NAMES) == ()
    write(*NAMES, "gain=2", OTHER, "code", "levels")
    assert variants(*NAMES) == ("gain=2",)
    pd.testing.assert_frame_equal(read(*NAMES, "gain=2").table, OTHER)


@pytest.mark.parametrize("half", [".npz", ".json"])
def test_half_of_what_was_recorded_is_dropped_whole(recorded, half):
    recorded.with_suffix(half).unlink()
    drop(*NAMES, {"gain=3"})
    assert not recorded.exists()
    assert not recorded.with_suffix(".json").exists()


@pytest.fixture
def swapped(recorded):
    """The rows of one run beside the summary of another, in which one of two variants differs."""
    summary = recorded.with_suffix(".json").read_text("utf-8")
    write(*NAMES, "gain=2", TABLE[:2], "code", "other levels")
    recorded.with_suffix(".json").write_text(summary, "utf-8")
    recorded_rows._read.cache_clear()
    return recorded


def test_of_the_halves_of_two_runs_what_fits_is_taken_and_the_rest_refused(swapped):
    pd.testing.assert_frame_equal(read(*NAMES, "as declared").table, TABLE)
    with pytest.raises(DamagedFile, match=r"`robot-perception store --only small\.study` records"):
        read(*NAMES, "gain=2")


def test_what_fits_stays_where_the_rest_is_recorded_again(swapped):
    write(*NAMES, "gain=3", OTHER, "code", "levels")
    assert variants(*NAMES) == ("as declared", "gain=3")
    assert set(storage.load(swapped, recorded_rows._Stored).variants) == {"as declared", "gain=3"}
    pd.testing.assert_frame_equal(read(*NAMES, "as declared").table, TABLE)


def test_what_fits_stays_where_something_is_dropped(swapped):
    drop(*NAMES, {"gain=3"})
    assert variants(*NAMES) == ("as declared",)
    pd.testing.assert_frame_equal(read(*NAMES, "as declared").table, TABLE)


@pytest.mark.parametrize("text", ["", "{}", "[1]", '{"variants": [1]}', '{"variants": {"a": 1}}'])
def test_over_a_damaged_summary_rows_are_recorded_anew(recorded, text):
    recorded.with_suffix(".json").write_text(text)
    recorded_rows._read.cache_clear()
    write(*NAMES, "gain=2", OTHER, "code", "levels")
    assert variants(*NAMES) == ("gain=2",)
