"""A study is a function of one trial: run, recorded, resumed, changed and compared."""

import pickle
from itertools import product

import numpy as np
import pandas as pd
import pytest
from joblib import parallel_config

from robot_perception.book import covariance_intersection
from robot_perception.datasets.store import CACHE_VARIABLE
from studies import trials
from studies.claims import Claim
from studies.keys import versions
from studies.keys.cells import code_of
from studies.stored import recorded_rows
from studies.sweep import sweep
from studies.trials import Chapter, Trials

CELLS = (
    """import numpy as np
from studies.intervals import exact
from studies.claims import Finding
from studies.trials import Chapter
from studies.verdicts import Accepted

chapter = Chapter("small")
SCALE, CALLS = 2.0, []
""",
    """@chapter.study(seed=7, film=range(5), rule=("old", "new"))
def drawn(film, rule, *, gain=1.0, rng):
    CALLS.append((film, rule))
    return {"error": SCALE * gain * rng.random() + (rule == "new"), "found": rng.random() < 0.5}
""",
    """@chapter.study(film=(3, 1))
def plain(film, *, gain=1.0):
    return {"rule": ["a", "b"], "error": np.float32([gain * film, gain * film / 3])}
""",
)
CLAIM = """@drawn.claim("some", paper="perception-issues", place="§1", basis="mathematics",
    statement="Something holds.", says="it is {value}", form="number",
    method="counted", accepted=Accepted(0, 9, "theory"),
    sabotage={"a gain of a hundred": drawn.but(gain=100.0)}, stopping="five films")
def some(rows):
    return Finding(exact(float(rows.of("error").max())))
"""


def where(study):
    return list(study.trials())


@pytest.fixture
def small(book):
    return book.made(*CELLS)


def computed(module):
    """Return which trials were computed since it was asked last."""
    calls = list(module.CALLS)
    module.CALLS.clear()
    return calls


def again(book):
    """Import the notebook anew, as another process does."""
    return book.module("small")


# What is run


def test_replicates_are_in_the_outer_loop_and_factors_in_their_order(small):
    expected = [{"film": k, "rule": rule} for k, rule in product(range(5), ("old", "new"))]
    assert where(small.drawn) == expected
    rows = small.drawn.run()
    assert rows.table[["film", "rule"]].to_dict("records") == expected
    assert list(rows.table.columns) == ["film", "rule", "error", "found"]
    assert (rows.replicate, rows.note) == ("film", "Computed just now: 5 films.")


def test_arrays_of_a_trial_are_rows(small):
    rows = small.plain.run()
    assert rows.table.film.tolist() == [3, 3, 1, 1]
    assert rows.table.rule.tolist() == ["a", "b", "a", "b"]
    np.testing.assert_allclose(rows.of("error"), [3, 1, 1, 1 / 3], rtol=1e-6)


def test_a_trial_draws_what_sweep_gives_its_replicate_whatever_the_factors(small):
    """As the studies did that ran a sweep over films."""
    old = sweep(lambda film, rng: rng.random(), range(5), rng=np.random.default_rng(7))
    rows = small.drawn.run()
    np.testing.assert_array_equal(rows.of("error", rule="old"), 2 * np.array(old))
    np.testing.assert_allclose(rows.of("error", rule="new"), 2 * np.array(old) + 1, rtol=1e-15)


def test_fewer_replicates_draw_as_in_the_whole_study(small):
    whole, some = small.drawn.run(), small.drawn.run(film=(3, 1), rule="new")
    assert some.of("error").tolist() == [
        *whole.of("error", film=3, rule="new"),
        *whole.of("error", film=1, rule="new"),
    ]


def test_replicates_that_are_not_declared_draw_something_else(small):
    draws = [small.drawn.generator(k).random() for k in (*range(5), 5, 6, 99, "a name", -1)]
    assert len(set(draws)) == len(draws)
    assert small.drawn.but(film=99).generator(99).random() == draws[7]


# What is changed


def test_a_study_but_for_one_thing(small):
    changed = small.drawn.but(gain=3.0).but(film=range(2, 5), rule="new")
    assert changed.axes == {"film": (2, 3, 4), "rule": ("new",)}
    assert changed.fixed == {"gain": 3.0}
    assert changed.changed == "gain=3.0, film=2 to 4, rule=new"
    assert (changed.name, changed.seed, changed.stem) == ("drawn", 7, "small")
    assert small.drawn.axes["rule"] == ("old", "new")
    base = small.drawn.run(film=range(2, 5), rule="new").of("error") - 1
    np.testing.assert_allclose(changed.run().of("error") - 1, 3 * base)
    assert changed.run().fixed == {"gain": 3.0}


def test_what_a_trial_does_not_take_is_refused(small):
    with pytest.raises(TypeError, match="drawn has no 'speed'; it has film, rule, gain, rng"):
        small.drawn.but(speed=1)
    with pytest.raises(TypeError, match="has no 'speed'"):
        small.drawn.run(speed=1)


@pytest.mark.parametrize("levels", [(), [], (1, 2, 1)])
def test_a_study_needs_levels_each_once(small, levels):
    for ask in (Chapter("small").study, small.drawn.but, small.drawn.run):
        with pytest.raises(ValueError, match="film needs levels, each once, got"):
            ask(film=levels)
    with pytest.raises(ValueError, match="a study needs replicates"):
        Chapter("small").study()


# What is kept


def test_trials_are_resumed_where_a_run_was_interrupted(book, small):
    small.drawn.run(film=range(2))
    assert computed(small) == [(0, "old"), (0, "new"), (1, "old"), (1, "new")]
    other = again(book)
    rows = other.drawn.run()
    assert {film for film, _ in computed(other)} == {2, 3, 4}
    assert rows.table.equals(again(book).drawn.run().table)
    assert computed(other) == []


def test_rows_are_the_same_whether_they_were_kept_or_not(book, small):
    first, second = small.plain.run().table, again(book).plain.run().table
    pd.testing.assert_frame_equal(first, second, check_exact=True)


def test_a_kept_trial_is_of_its_code_keywords_and_draws(book, small):
    small.drawn.run(film=0, rule="old")
    for texts in (
        [text.replace("SCALE, CALLS = 2.0", "SCALE, CALLS = 3.0") for text in CELLS],
        [text.replace("seed=7", "seed=8") for text in CELLS],
        [text.replace("film=range(5)", "film=(4, 3, 2, 1, 0)") for text in CELLS],
    ):
        module = book.made(*texts)
        module.drawn.run(film=0, rule="old")
        assert computed(module) == [(0, "old")], texts
    module = book.made(*CELLS)
    module.drawn.run(film=0, rule="old", gain=2.0)
    assert computed(module) == [(0, "old")]
    module.drawn.run(film=0, rule="old")
    assert computed(module) == []


def test_a_damaged_kept_trial_is_computed_anew(book, small, tmp_path):
    before = small.drawn.run().table
    for file in (tmp_path / "cache" / "trials").iterdir():
        file.write_text("{")
    module = again(book)
    assert module.drawn.run().table.equals(before)
    assert len(computed(module)) == 10


def test_a_trial_of_unknown_code_is_not_kept(book):
    namespace = {"__name__": "__main__"}
    exec("\n".join(CELLS[:2]), namespace)
    for _ in range(2):
        namespace["drawn"].run(film=0, rule="old")
    assert namespace["CALLS"] == [(0, "old")] * 2


# Other processes


def test_a_study_of_a_notebook_is_pickled_by_its_name(small):
    study = small.drawn.but(gain=2.0, film=(9, 1))
    text = pickle.dumps(study)
    found = pickle.loads(text)
    assert found.one is small.drawn.one
    for name in ("axes", "fixed", "changed", "seed", "stem", "declared", "scales"):
        assert getattr(found, name) == getattr(study, name)
    assert b"CALLS" not in text


def test_two_processes_compute_what_one_does(tmp_path, monkeypatch):
    """Of a notebook of the book, which a worker imports as any module."""
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path))
    study = covariance_intersection.itself.but(sample=range(4), beliefs=17)
    one = [study.trial(**at) for at in where(study)]
    with parallel_config("loky", n_jobs=2):
        two = study.run().table
    pd.testing.assert_frame_equal(trials.framed(one), two, check_exact=True)


# What is recorded


def test_recorded_rows_are_given_while_the_code_is_theirs(book, small):
    with pytest.raises(FileNotFoundError, match=r"no rows of drawn .* are recorded"):
        small.drawn.rows()
    assert not small.drawn.is_current()
    small.drawn.record()
    computed(small)
    assert small.drawn.is_current()
    rows = small.drawn.rows()
    assert rows.note.startswith("Computed on ")
    assert rows.note.endswith("by this code: 5 films.")
    assert rows.table.equals(small.drawn.run().table)
    assert (rows.replicate, rows.fixed) == ("film", {})
    assert computed(small) == []


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("SCALE * gain", "SCALE + gain"),
        ("SCALE, CALLS = 2.0", "SCALE, CALLS = 3.0"),
        ("seed=7", "seed=8"),
        ("range(5)", "range(6)"),
        ('("old", "new")', '("new", "old")'),
    ],
)
def test_rows_of_other_code_seed_or_levels_never_say_by_this_code(book, small, old, new):
    small.drawn.record()
    changed = book.made(*(text.replace(old, new) for text in CELLS)).drawn
    assert not changed.is_current()
    assert "by earlier code" in changed.rows().note


def other_seed(self, replicate):
    return np.random.default_rng(self.seed + self.key(replicate)[0])


def other_place(self, replicate):
    return (self.replicates.index(replicate),)


@pytest.mark.parametrize(("name", "other"), [("generator", other_seed), ("key", other_place)])
def test_rows_of_generators_that_are_made_otherwise_are_not_current(
    small, monkeypatch, name, other
):
    for study in (small.drawn, small.plain):
        study.record()
    before = small.drawn.run().of("error")
    computed(small)
    monkeypatch.setattr(Trials, name, other)
    for study in (small.drawn, small.plain):
        assert not study.is_current()
        assert "by earlier code" in study.rows().note
    again = small.drawn.run().of("error")
    assert len(computed(small)) == 10  # none of those that this computer has kept
    assert np.array_equal(before, again) == (name == "key")  # the same for what is declared


def test_rows_of_other_packages_are_read_and_say_so(small, monkeypatch):
    small.drawn.record()
    assert small.drawn.other_packages() == ""
    monkeypatch.setattr(versions, "installed", lambda: {"numpy": "9.9"})
    numpy = f"numpy {np.__version__} (here 9.9)"
    assert small.drawn.other_packages() == numpy
    assert small.drawn.is_current()
    assert small.drawn.rows().note.endswith(f"by this code with {numpy}: 5 films.")
    assert small.drawn.renew(where(small.drawn)[:1]) == []
    assert small.drawn.other_packages() == ""


def test_a_variant_is_recorded_beside_the_study(small):
    small.drawn.record()
    changed = small.drawn.but(gain=2.0)
    assert not changed.is_current()
    changed.record()
    assert changed.is_current()
    assert small.drawn.is_current()
    assert recorded_rows.variants("small", "drawn") == ("as declared", "gain=2.0")
    assert not np.array_equal(changed.rows().of("error"), small.drawn.rows().of("error"))


def test_a_claim_reads_the_rows_and_its_sabotage_the_changed_ones(book):
    module = book.made(*CELLS, CLAIM)
    claim = module.some
    module.drawn.record()
    claim.sabotages[0].study.record()
    assert isinstance(claim, Claim)
    assert (claim.id, claim.chapter, claim.stopping) == ("some", "small", "five films")
    assert claim.seed == 7
    largest = module.drawn.rows().largest("error")
    assert claim.find().value.estimate == largest
    assert claim.verdict(claim.find()) == "reproduced"
    change = claim.sabotages[0]
    assert change.text == "a gain of a hundred"
    assert claim.sabotaged(change).value.estimate == change.study.rows().largest("error") > 9


# What is compared


def test_a_trial_that_gives_what_is_recorded_differs_in_nothing(small):
    small.drawn.record()
    small.plain.record()
    for study in (small.drawn, small.plain):
        assert [study.differs(**at) for at in where(study)] == [[]] * len(where(study))


def test_a_study_without_rows_differs_and_says_so(small):
    assert small.drawn.differs(film=2, rule="new") == ["drawn: no rows are recorded"]


def forged(study, **columns):
    """Record other numbers, with the right hashes."""
    table = study.run().table.assign(**columns)
    name = study.changed or trials.AS_DECLARED
    recorded_rows.write("small", study.name, name, table, study.code(), study._declared())


def test_a_number_that_was_made_up_is_found(small):
    forged(small.drawn, error=small.drawn.run().of("error") + 1e-4)
    (line,) = small.drawn.differs(film=2, rule="new")
    assert line.startswith("drawn {'film': 2, 'rule': 'new'}: error is [")
    assert ", recorded [" in line
    forged(small.drawn, error=small.drawn.run().of("error") + 1e-8)
    assert not small.drawn.differs(film=2, rule="new")
    forged(small.drawn, found=True)
    assert any(small.drawn.differs(**at) for at in where(small.drawn))


def test_other_columns_or_rows_are_found(small):
    forged(small.drawn, more=1.0)
    (line,) = small.drawn.differs(film=2, rule="new")
    assert "other columns" in line
    table = small.plain.run().table
    key = small.plain.code(), small.plain._declared()
    recorded_rows.write("small", "plain", "as declared", table[::2], *key)
    (line,) = small.plain.differs(film=3)
    assert "another number of rows" in line


def elsewhere(monkeypatch):
    """Let this processor be of another kind than the one that has recorded."""
    monkeypatch.setattr(recorded_rows, "processor", lambda: "another kind")


def test_rows_of_another_kind_of_processor_are_compared_with_their_combination(small, monkeypatch):
    study = small.drawn
    forged(study, error=study.run().of("error") + 0.01)  # other pixels
    assert study.differs(film=2, rule="old")
    elsewhere(monkeypatch)
    assert not study.differs(film=2, rule="old")


def test_elsewhere_a_number_may_not_leave_the_reach_of_its_combination(small, monkeypatch):
    rows = small.drawn.run()
    forged(small.drawn, error=rows.of("error") + np.where(rows.of("rule") == "old", 20.0, 0.0))
    with monkeypatch.context() as other:
        elsewhere(other)
        assert small.drawn.differs(film=2, rule="old")
        assert not small.drawn.differs(film=2, rule="new")


COUNTED = """@chapter.study(film=range(4), scales={"left": 100.0})
def counted(film, *, more=0):
    size = film + 1 + more
    return {"seen": np.ones(size), "left": np.full(size, 1e-9 * film)}
"""


def test_elsewhere_a_trial_may_have_another_number_of_rows_as_others_have(book, monkeypatch):
    module = book.made(CELLS[0], COUNTED)
    module.counted.record()
    other = {
        more: book.made(CELLS[0], COUNTED.replace("more=0", f"more={more}")).counted
        for more in (3, 4)
    }
    assert other[3].differs(film=3)
    elsewhere(monkeypatch)
    assert not other[3].differs(film=3)  # 7 rows; there are 1 to 4
    assert other[4].differs(film=3)


def test_numbers_are_zero_below_what_they_are_compared_with(book):
    study = book.made(CELLS[0], COUNTED).counted
    study.record()
    before = study.rows().table
    study = book.made(CELLS[0], COUNTED.replace("1e-9 * film", "-1e-8 * film")).counted
    assert not study.differs(film=2)
    assert study.same(before.assign(left=9e-8), before)
    assert not study.same(before.assign(left=2e-7), before)
    assert not study.same(before.assign(seen=1 + 1e-5), before)


def test_rows_are_the_same_by_the_scale_of_their_combination(small):
    """What rounds in the large numbers of one rule would change the small ones of another."""
    before = small.drawn.run().table
    before["error"] *= np.where(before.rule == "new", 1e6, 1.0)
    moved = {rule: before.error + 0.1 * (before.rule == rule) for rule in ("old", "new")}
    assert small.drawn.same(before.assign(error=moved["new"]), before)
    assert not small.drawn.same(before.assign(error=moved["old"]), before)
    assert small.plain.same(small.plain.run().table, small.plain.run().table)
    assert not small.drawn.same(before[:-1], before)
    assert not small.drawn.same(before.drop(columns="found"), before)


def test_of_levels_that_are_none_each_combination_is_compared(book):
    levels = [text.replace('"old", "new"', 'None, "new"') for text in CELLS]
    study = book.made(*levels).drawn
    before = study.run().table
    wrong = before.error.where(before.rule.notna(), before.error + 1)
    assert study.same(before, before)
    assert not study.same(before.assign(error=wrong), before)


# What is interrupted


def halves(study):
    return [recorded_rows.file_of("small", study.name).with_suffix(s) for s in (".npz", ".json")]


@pytest.mark.parametrize("half", [0, 1])
def test_half_of_what_was_recorded_is_not_current_and_is_recorded_again(small, half):
    small.drawn.record()
    before = small.drawn.rows().table
    halves(small.drawn)[half].unlink()
    assert not small.drawn.is_current()
    assert small.drawn.differs(film=2, rule="new") == ["drawn: no rows are recorded"]
    with pytest.raises(FileNotFoundError, match="robot-perception store"):
        small.drawn.rows()
    small.drawn.record()
    assert small.drawn.is_current()
    assert small.drawn.rows().table.equals(before)


def test_halves_of_two_runs_are_not_current_and_say_what_to_do(book, small):
    small.drawn.record()
    summary = halves(small.drawn)[1].read_text("utf-8")
    study = book.made(*(text.replace("SCALE * gain", "SCALE + gain") for text in CELLS)).drawn
    study.record()
    halves(study)[1].write_text(summary, "utf-8")
    for one in (study, book.made(*CELLS).drawn):
        recorded_rows._read.cache_clear()
        assert not one.is_current()
        (line,) = one.differs(film=2, rule="new")
        assert "`robot-perception store --only small.drawn` records the rows anew" in line
        assert one.renew(where(one)[:1]) == [line]
    study.record()
    assert study.is_current()


# What a trial takes


def test_seconds_of_the_first_combination_and_of_the_longest_are_recorded(book, monkeypatch):
    """The first one computes what the others find, so what these take alone is more."""
    clock = iter(np.cumsum([0, 4, 0, 2, 0, 5, 0, 1]).tolist())
    monkeypatch.setattr(trials.time, "process_time", lambda: next(clock))
    study = book.made(*CELLS).drawn.but(film=(0, 1))
    study.record()
    assert recorded_rows.seconds("small", "drawn") == {study.changed: (5.0, 7.0)}
    assert next(clock, None) is None
    study.record()  # of trials that were kept
    assert recorded_rows.seconds("small", "drawn") == {study.changed: (5.0, 7.0)}


def test_keys_are_renewed_only_if_drawn_trials_give_the_same(book, small):
    small.drawn.record()
    same = book.made(*(text.replace("SCALE * gain", "gain * SCALE") for text in CELLS)).drawn
    drawn = where(same)[2:4]
    assert not same.is_current()
    assert same.renew(drawn) == []
    assert same.is_current()
    other = book.made(*(text.replace("SCALE * gain", "SCALE + gain") for text in CELLS)).drawn
    assert len(other.renew(drawn)) == 2
    assert not other.is_current()


# In a notebook


def test_the_books_own_study_gives_the_recorded_rows_in_a_notebook(small, live, capsys):
    small.drawn.record()
    study = live(*CELLS).drawn
    assert study.rows().table.equals(small.drawn.rows().table)
    assert study.is_current()
    assert capsys.readouterr().out == ""


def test_an_edited_study_computes_a_few_replicates_and_says_so_once(small, live, capsys):
    small.drawn.record()
    live(*CELLS)
    study = live("SCALE = 5.0").drawn
    rows = study.rows()
    assert rows.levels("film") == (0, 1, 2)
    np.testing.assert_allclose(
        rows.of("error", rule="old"), 2.5 * small.drawn.rows().of("error", rule="old")[:3]
    )
    said = capsys.readouterr().out
    assert said == ("drawn was changed: 3 films computed here of 5; drawn.run() computes all.\n")
    study.rows()
    assert capsys.readouterr().out == ""
    assert live("SCALE, CALLS = 2.0, []").drawn.rows().levels("film") == tuple(range(5))


@pytest.mark.parametrize(
    "levels", ['"at rest", "slow", "fast", "askew"', "0.1, 0.2, 0.3, 0.4", "1, 2, 10, 50"]
)
def test_an_edited_study_of_settings_computes_all_of_them(book, live, capsys, levels):
    """What a page says of a setting by its name, it says after an edit, too."""
    cells = (
        CELLS[0],
        f"@chapter.study(setting=({levels}))\n"
        "def known(setting):\n    return {'error': SCALE * len(str(setting))}",
    )
    recorded = book.made(*cells).known
    recorded.record()
    live(*cells)
    rows = live("SCALE = 5.0").known.rows()
    assert rows.levels("setting") == recorded.rows().levels("setting")
    np.testing.assert_allclose(rows.of("error"), 2.5 * recorded.rows().of("error"))
    assert capsys.readouterr().out == "known was changed: 4 settings computed here.\n"


def test_an_edited_study_that_takes_long_shows_the_recorded_rows_and_says_so(
    small, live, capsys, monkeypatch
):
    """An edit does not stop the notebook for half an hour; other levels are computed still."""
    small.drawn.record()
    live(*CELLS)
    monkeypatch.setattr("studies.stored.recorded_rows.seconds", lambda *_: {"as declared": (1, 59)})
    study = live("SCALE = 6.0").drawn
    assert study.rows().table.equals(small.drawn.rows().table)
    assert "by other code" in study.rows().note
    said = capsys.readouterr().out
    assert said.startswith("drawn was changed: 3 films computed here would take some 3 minutes, so")
    assert study.but(gain=3.0).rows().levels("film") == (0, 1, 2)


@pytest.mark.parametrize("films", ["range(5)", "(7301, 7305, 7306, 7320)", "range(900, 940)"])
def test_an_edited_study_of_draws_computes_a_few(live, films):
    cell = f"@chapter.study(film={films})\ndef of_films(film):\n    return {{'error': 1.0}}"
    assert len(live(CELLS[0], cell).of_films.rows()) == 3


@pytest.mark.parametrize("changes", [{"gain": 2.0}, {"film": (4, 3)}])
def test_levels_that_are_not_recorded_are_computed_in_a_notebook(small, live, capsys, changes):
    small.drawn.record()
    rows = live(*CELLS).drawn.but(**changes).rows()
    assert rows.note.startswith("Computed just now")
    assert "was changed" in capsys.readouterr().out
    assert set(rows.levels("film")) <= {0, 1, 2, 3, 4}


def test_recorded_rows_of_earlier_code_are_given_where_the_reader_changed_nothing(
    book, small, live, capsys
):
    small.drawn.record()
    texts = [text.replace("SCALE * gain", "gain * SCALE") for text in CELLS]
    book.made(*texts)
    rows = live(*texts).drawn.rows()
    assert "by earlier code" in rows.note
    assert len(rows) == 10
    assert capsys.readouterr().out == ""


def test_code_is_that_of_the_function(small):
    assert small.drawn.code() == small.drawn.but(gain=2.0).code() == code_of(small.drawn.one)
    assert small.drawn.code() != small.plain.code()
