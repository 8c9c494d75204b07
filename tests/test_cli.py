"""The command line prints the ledger, records claims one by one, and names what was wrong."""

import importlib
import json
import subprocess
import sys
from collections import Counter
from functools import partial
from math import comb, prod, sqrt
from random import Random
from types import SimpleNamespace

import click
import cv2
import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from joblib.parallel import get_active_backend

from data_synth.day.building import make_building
from robot_perception import chapters
from robot_perception.cli import main
from robot_perception.cli.store import _renew_rows, drawn
from robot_perception.cli.workers import working
from robot_perception.datasets import DatasetMissing
from robot_perception.datasets.entries import registry
from robot_perception.teaching.scores.badges import recorded
from studies import registration
from studies.claims import Finding
from studies.intervals import exact
from studies.ledger import Ledger, record
from studies.records import records
from studies.rows import Rows
from studies.trials import Sabotage
from tests.studies.entries import Given, claim, study


@pytest.fixture
def run():
    return lambda *words: CliRunner().invoke(main, [str(w) for w in words])


@pytest.fixture
def three(monkeypatch):
    """A book of three registered claims; the second fails as long as its switch is on.

    What is called "meanwhile" happens once while the first is computed.
    """
    switch = {"broken": True}

    def first(rows):
        switch.pop("meanwhile", lambda: None)()
        return Finding(exact(1.0))

    def second(rows):
        if switch["broken"]:
            raise RuntimeError("the second is broken")
        return Finding(exact(2.0))

    claims = (
        claim("first", compute=first),
        claim("second", compute=second),
        claim("third", compute=lambda rows: Finding(exact(3.0))),
    )
    declare(monkeypatch, *claims)
    return switch


def declare(monkeypatch, *claims):
    """Let these be the claims of the book, registered as they are declared."""
    lines = tuple(registration.anew(one, (), "new") for one in claims)
    monkeypatch.setattr(chapters, "claims", lambda stems=(): claims)
    monkeypatch.setattr(registration, "read", lambda path=None: lines)


def test_table_has_a_line_per_claim(run):
    result = run("claims")
    assert result.exit_code == 0, result.output
    for known in chapters.claims():
        assert any(line.startswith(f"{known.id} ") for line in result.output.splitlines())


@pytest.mark.parametrize("encoding", ["cp1252", "latin-1", "cp437"])
@pytest.mark.parametrize("words", [("claims",), ("claims", "--json"), ("datasets", "list")])
def test_a_file_of_another_encoding_takes_what_is_printed(encoding, words):
    """Python encodes so what Windows sends to a file."""
    printed = CliRunner(charset=encoding).invoke(main, list(words))
    assert printed.exit_code == 0, printed.output
    if "--json" in words:
        assert Ledger.from_json(printed.stdout_bytes.decode("utf-8")) == recorded()
    else:
        lines = printed.stdout_bytes.decode(encoding).splitlines()
        assert len(lines) > len(registry() if "datasets" in words else chapters.CHAPTERS)
        assert not any("?" * 3 in line for line in lines)


def test_only_what_was_asked_for_is_printed(run):
    printed = Ledger.from_json(run("claims", "--json", "--claim", "dp-quadratic").output)
    assert [e.id for e in printed.entries] == ["dp-quadratic"]


def test_claims_that_are_asked_for_are_computed(run, three):
    words = ("claims", "--run", "--claim", "first", "--claim", "third", "--json")
    computed = Ledger.from_json(run(*words).stdout)
    assert [e.value.estimate for e in computed.entries] == [1.0, 3.0]


@pytest.mark.parametrize("workers", [2, -1])
def test_work_is_done_by_as_many_processes_as_asked_for(workers):
    with working(workers, None, None):
        assert get_active_backend()[1] == workers


def test_json_is_a_ledger(run):
    output = run("claims", "--json").output
    json.loads(output, parse_constant=pytest.fail)
    assert [e.id for e in Ledger.from_json(output).entries] == [c.id for c in chapters.claims()]


def test_one_claim_is_recorded_alone(run, three, tmp_path):
    file = tmp_path / "claims.json"
    three["broken"] = False
    assert run("claims", "--run", "--write", file).exit_code == 0
    before = file.read_text().splitlines()
    again = run("claims", "--run", "--claim", "second", "--write", file)
    assert again.exit_code == 0, again.output
    assert file.read_text().splitlines() == before
    assert [e.id for e in Ledger.read(file).entries] == ["first", "second", "third"]
    assert Ledger.read(file)["second"].value.estimate == 2.0


def test_what_others_write_meanwhile_stays(run, three, tmp_path):
    file, three["broken"] = tmp_path / "claims.json", False
    other = "claims", "--run", "--claim", "third", "--write", file
    three["meanwhile"] = lambda: run(*other)
    result = run("claims", "--run", "--claim", "first", "--claim", "second", "--write", file)
    assert result.exit_code == 0, result.output
    assert "meanwhile" not in three
    assert [e.id for e in Ledger.read(file).entries] == ["first", "second", "third"]


def test_rows_that_are_not_current_are_recorded_before_their_claim(run, monkeypatch, tmp_path):
    done = []

    def found(rows):
        assert len(done) == 2, "rows are recorded first"
        return Finding(exact(rows))

    changes = (Sabotage("twice", study(2.0, changed="gain=2.0")), Sabotage("none", study(0.0)))
    declare(monkeypatch, claim("first", compute=found, study=study(1.0), sabotages=changes))
    monkeypatch.setattr(Given, "is_current", lambda self: self.found == 0)
    monkeypatch.setattr(Given, "record", lambda self: done.append(self.changed))
    result = run("claims", "--run", "--write", tmp_path / "new.json")
    assert result.exit_code == 0, result.output
    assert done == ["", "gain=2.0"]
    made = Ledger.read(tmp_path / "new.json")["first"]
    assert [made.value.estimate, *(s.value.estimate for s in made.sabotages)] == [1.0, 2.0, 0.0]


def test_a_claim_that_fails_does_not_lose_the_others(run, three, tmp_path):
    file = tmp_path / "claims.json"
    result = run("claims", "--run", "--write", file)
    assert result.exit_code != 0
    assert "1 claims could not be computed: second" in result.output
    assert "the second is broken" in result.output
    assert [e.id for e in Ledger.read(file).entries] == ["first", "third"]
    three["broken"] = False
    run("claims", "--run", "--claim", "second", "--write", file)
    assert [e.id for e in Ledger.read(file).entries] == ["first", "second", "third"]


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("claims", "--chapter", "kitchen"), "no chapter 'kitchen'"),
        (("claims", "--claim", "dp-cubic"), "no claim 'dp-cubic'; there are erratum-table2"),
        (("claims", "--run", "full"), "unexpected extra argument (full)"),
        (("claims", "--write", "x.json"), "say --run"),
        (("claims", "--run", "--write", "no/where.json"), "there is no folder no"),
        (("claims", "--run", "--workers", "0"), "--workers must not be 0"),
        (("claims", "--run", "--dask", "tcp://a", "--ray", "b"), "exclude each other"),
        (("store", "--chapter", "kitchen"), "no chapter 'kitchen'"),
        (("store", "--only", "kitchen"), "no stored result 'kitchen'; there are"),
    ],
)
def test_wrong_words_are_named(run, words, says):
    result = run(*words)
    assert result.exit_code != 0
    assert says in result.output
    assert "Traceback" not in result.output


def test_an_import_that_the_work_misses_is_not_blamed_on_the_cluster():
    with pytest.raises(ModuleNotFoundError, match="no_such_peer"), working(1, None, None):
        importlib.import_module("no_such_peer")


def test_a_missing_cluster_package_names_its_extra(monkeypatch):
    monkeypatch.setitem(sys.modules, "dask.distributed", None)
    with pytest.raises(click.UsageError, match=r"\[cluster\]"), working(None, "tcp://a:1", None):
        pass


def test_store_keeps_results_whose_recording_is_not_here(run, tmp_path, monkeypatch):
    monkeypatch.setenv("ROBOT_PERCEPTION_DATA", str(tmp_path))
    monkeypatch.setenv("ROBOT_PERCEPTION_CACHE", str(tmp_path))
    before = (records() / "monobot-corridor.npz").read_bytes()
    result = run("store", "--chapter", "monobot")
    assert result.exit_code == 0, result.output
    assert "monobot-corridor: kept as it is" in result.output
    assert (records() / "monobot-corridor.npz").read_bytes() == before


def test_one_stored_result_is_computed_alone(run, monkeypatch):
    class Recorded:
        """Stands for a recording that is not on this computer."""

        def __init__(self, store):
            self.store, self.dataset = store, "carmen_intel"

        def write(self):
            raise DatasetMissing

    monkeypatch.setattr(chapters, "recordings", lambda stems: [Recorded("one"), Recorded("two")])
    assert run("store", "--only", "two").stdout.splitlines() == [
        "two: kept as it is, carmen_intel is not on this computer"
    ]


def test_rows_are_recorded_where_they_are_not_current_and_renewed_where_trials_agree(
    run, monkeypatch
):
    class Trials:
        """Stands for a study of rows; what it is asked to do is noted."""

        stem, replicate, replicates = "walls", "film", (1, 2)

        def __init__(self, name, current, differs=()):
            self.name, self.changed, self.current, self.differing = name, "", current, differs
            self.done = []

        def is_current(self):
            return self.current

        def other_packages(self):
            return ""

        def record(self, *, anew):
            self.done.append("anew" if anew else "recorded")

        def rows(self):
            return Rows(pd.DataFrame({"film": [1, 2, 3]}), "film", {})

        def same(self, again, before):
            return again.equals(before)

        def code(self):
            return "code"

        def trials(self):
            return [{"film": k} for k in self.replicates]

        def renew(self, drawn):
            self.done.append(len(drawn))
            return list(self.differing)

    studies = [Trials("a", True), Trials("b", False), Trials("c", False, ["c: 1, recorded 2"])]
    monkeypatch.setattr(chapters, "trials", lambda stems: studies)
    monkeypatch.setattr(chapters, "recordings", lambda stems: [])
    monkeypatch.setattr(chapters, "states", lambda stems: [])
    assert run("store").stdout.splitlines() == [
        "walls.a (as declared): current",
        "walls.b (as declared): recorded, 3 rows",
        "walls.c (as declared): recorded, 3 rows",
    ]
    *_, same, other, line = run("store", "--keys").stdout.splitlines()
    assert same == (
        "walls.b (as declared): the same in 2 of 2 trials drawn for this code, keys renewed"
    )
    assert other.startswith("walls.c (as declared): NOT the same; `robot-perception store --only")
    assert line == "c: 1, recorded 2"
    assert [study.done for study in studies] == [[], ["recorded", 2], ["recorded", 2]]
    first, *_ = run("store", "--anew", "--only", "walls.a").stdout.splitlines()
    assert first == "walls.a (as declared): recorded, 3 rows, the same"
    assert studies[0].done == ["anew"]


class Drawn:
    """Stands for a study of films and rules; some of its trials give something else."""

    stem, name, changed, replicate = "walls", "drawn", "", "film"

    def __init__(self, code, rules, films=40, changed=()):
        self.hash, self.rules, self.films, self.moved = code, rules, films, changed

    def code(self):
        return self.hash

    def is_current(self):
        return False

    def trials(self):
        return [{"film": k, "rule": rule} for k in range(self.films) for rule in range(self.rules)]

    def renew(self, drawn):
        return [f"{where}" for where in drawn if where in self.moved]


@pytest.mark.parametrize(("rules", "each"), [(1, 3), (10, 3), (11, 2), (15, 2), (16, 1), (48, 1)])
def test_of_each_combination_three_trials_are_drawn_and_thirty_in_all(rules, each):
    chosen = drawn(Drawn("code", rules))
    assert Counter(where["rule"] for where in chosen) == dict.fromkeys(range(rules), each)
    assert len({repr(where) for where in chosen}) == len(chosen)
    assert len(drawn(Drawn("code", 4, films=2))) == 8


def test_keys_of_other_code_are_tried_on_other_trials():
    chosen = [repr(drawn(Drawn(code, 2))) for code in ("one", "two", "one")]
    assert chosen[0] == chosen[2] != chosen[1]


def test_a_tenth_of_the_trials_that_gives_something_else_is_caught_as_often_as_chance_says():
    """8 of 80 trials, of which 6 are drawn: 1 - C(72, 6) / C(80, 6) = 0.48 of the codes."""
    rules, films, changed, codes = 2, 40, 8, 600
    every = Drawn("", rules, films).trials()
    moved = Random(5).sample(every, changed)
    missed = prod(
        comb(films - sum(where["rule"] == rule for where in moved), 3) / comb(films, 3)
        for rule in range(rules)
    )
    found = [
        "NOT the same" in _renew_rows(Drawn(f"{k}", rules, films, moved)) for k in range(codes)
    ]
    assert missed == pytest.approx(comb(72, 6) / comb(80, 6), abs=0.03)
    assert np.mean(found) == pytest.approx(1 - missed, abs=3 * sqrt(0.25 / codes))


def test_what_cannot_be_stored_is_named_and_the_others_are_stored(run, monkeypatch):
    class Recording:
        """Stands for a recording that is stored, or cannot be."""

        def __init__(self, store, broken=None):
            self.store, self.broken = store, broken

        def is_current(self):
            return False

        def renew(self):
            if self.broken is not None:
                raise self.broken
            return True

    found = [
        Recording("a", ValueError("a.npz: half")),
        Recording("b", OSError("b")),
        Recording("c"),
    ]
    monkeypatch.setattr(chapters, "trials", lambda stems: [])
    monkeypatch.setattr(chapters, "recordings", lambda stems: found)
    monkeypatch.setattr(chapters, "states", lambda stems: [])
    said = run("store", "--keys")
    assert said.exit_code == 1
    assert said.stdout.splitlines()[:3] == ["a: a.npz: half", "b: b", "c: the same, keys renewed"]
    assert "not stored: a, b" in said.output


def test_a_claim_of_rows_that_is_not_registered_as_declared_is_not_recorded(
    run, monkeypatch, tmp_path
):
    monkeypatch.setattr(registration, "read", lambda path=None: ())
    words = ("claims", "--run", "--claim", "erratum-eq3", "--write", tmp_path / "new.json")
    found = run(*words)
    assert found.exit_code == 1
    assert "erratum-eq3 is not registered as it is declared" in found.output
    assert not (tmp_path / "new.json").exists()


def scored(run, monkeypatch, file):
    """Score two claims and take the second out of the book."""
    both = (
        claim("first", compute=found_of, study=study(1.0)),
        claim("second", compute=found_of, study=study(2.0)),
    )
    declare(monkeypatch, *both)
    assert run("claims", "--run", "--write", file).exit_code == 0
    declare(monkeypatch, both[0])


def found_of(rows):
    return Finding(exact(rows))


def test_a_scored_claim_leaves_the_ledger_by_no_way_but_withdrawal(run, monkeypatch, tmp_path):
    file = tmp_path / "claims.json"
    scored(run, monkeypatch, file)
    before = file.read_text("utf-8")
    dropped = run("claims", "--run", "--write", file)
    assert dropped.exit_code == 1
    assert "claims --withdraw second --why" in dropped.output
    assert file.read_text("utf-8") == before
    words = ("claims", "--withdraw", "second", "--write", file, "--instead", "first")
    assert "must say why" in run(*words).output
    done = run(*words, "--why", "nobody asks")
    assert done.exit_code == 0, done.output
    assert run("claims", "--run", "--write", file).exit_code == 0
    ledger = Ledger.read(file)
    assert [e.id for e in ledger.entries] == ["first"]
    (gone,) = ledger.withdrawn
    assert (gone.id, gone.value.estimate, gone.why, gone.instead) == (
        "second",
        2.0,
        "nobody asks",
        "first",
    )


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("second", "--instead", "third"), "instead must be"),
        (("third",), "no scored claim 'third'; there are first, second"),
        (("first",), "first is still declared"),
    ],
)
def test_only_what_was_scored_and_is_declared_no_more_is_withdrawn(
    run, monkeypatch, tmp_path, words, says
):
    file = tmp_path / "claims.json"
    scored(run, monkeypatch, file)
    before = file.read_text("utf-8")
    refused = run("claims", "--withdraw", *words, "--why", "so", "--write", file)
    assert refused.exit_code == 1
    assert says in refused.output
    assert "Traceback" not in refused.output
    assert file.read_text("utf-8") == before
    assert "name its file" in run("claims", "--withdraw", "second", "--why", "so").output


@pytest.fixture
def listed(monkeypatch, tmp_path):
    """A registered and scored claim with a sabotage, and the file in which it is registered."""
    own, other = study(1.0), study(0.0, changed="gain=2.0")
    one = claim("first", compute=found_of, study=own, sabotages=(Sabotage("twice", other),))
    monkeypatch.setattr(chapters, "claims", lambda stems=(): (one,))
    monkeypatch.setattr(registration, "records", lambda: tmp_path)
    registration.write([registration.anew(one, (), "new")])
    ledger = Ledger((record(one, versions=""),))
    monkeypatch.setattr("robot_perception.teaching.scores.badges.recorded", lambda: ledger)
    return one


SAME = ("register", "--claim", "first", "--remark", "by another world", "--same")


def test_another_world_is_the_same_claim_where_rows_of_it_give_the_same(run, listed, monkeypatch):
    monkeypatch.setattr(registration, "tried_on", lambda function: "another world")
    (before,) = registration.read()
    assert registration.changed(before, listed) == "trial or world"
    refused = run("register", "--claim", "first", "--remark", "by another world")
    assert "draw new replicates" in refused.output
    assert run(*SAME).exit_code == 0
    _, after = registration.read()
    assert (after.number, after.words) == (1, before.words)
    assert not registration.changed(after, listed)


@pytest.mark.parametrize("of", ["the study", "its sabotage"])
@pytest.mark.parametrize("what", ["other code", "other rows"])
def test_nothing_is_the_same_claim_by_rows_of_other_code_or_with_other_values(
    run, listed, monkeypatch, of, what
):
    own = listed.study if of == "the study" else listed.sabotages[0].study
    if what == "other code":
        monkeypatch.setattr(Given, "is_current", lambda self: self is not own)
        says = f"rows of walls.compute ({own.changed or 'as declared'}) are of other code"
    else:
        monkeypatch.setattr(Given, "rows", lambda self: self.found + 0.5 * (self is own))
        says = "first is not the same"
    refused = run(*SAME)
    assert refused.exit_code == 1
    assert says in refused.output
    assert len(registration.read()) == 1


def test_keys_are_tried_again_where_other_packages_gave_what_is_stored(run, monkeypatch):
    class Recorded:
        """Stands for states that are of this code, and of other packages."""

        store, tried = "a", 0

        def is_current(self):
            return True

        def other_packages(self):
            return "" if self.tried else "numpy 1.0 (here 2.0)"

        def renew(self):
            self.tried += 1
            return True

    one = Recorded()
    monkeypatch.setattr(chapters, "recordings", lambda stems: [])
    monkeypatch.setattr(chapters, "trials", lambda stems: [])
    monkeypatch.setattr(chapters, "states", lambda stems: [one])
    for said in ("a: the same, keys renewed", "a: current"):
        assert run("store", "--keys").stdout.splitlines() == [said]
    assert one.tried == 1


def test_keys_are_renewed_without_touching_what_is_stored(run, monkeypatch):
    class Recorded:
        """Stands for a recording; only the first is what its code computes."""

        def __init__(self, store, current=False, same=None):
            self.store, self.dataset, self.current, self.same = store, "attic", current, same

        def is_current(self):
            return self.current

        def other_packages(self):
            return ""

        def renew(self):
            if self.same is None:
                raise DatasetMissing
            return self.same

        def write(self):
            pytest.fail("stored anew")

    found = [Recorded("a", current=True), Recorded("b", same=True), Recorded("c", same=False)]
    monkeypatch.setattr(chapters, "recordings", lambda stems: [*found, Recorded("d")])
    monkeypatch.setattr(chapters, "trials", lambda stems: [])
    monkeypatch.setattr(chapters, "states", lambda stems: [])
    assert run("store", "--keys").stdout.splitlines() == [
        "a: current",
        "b: the same, keys renewed",
        "c: NOT the same; `robot-perception store --only c` stores what it is now",
        "d: kept as it is, attic is not on this computer",
    ]


@pytest.fixture
def short_day(monkeypatch):
    """A day of two moments, in which the second act fails."""
    from robot_perception.chapters.companion_day import acts as day_acts
    from robot_perception.cli import day_report
    from robot_perception.day.robot import DayInfo, DayState, Reading

    class Short:
        def __init__(self, seed, without=frozenset()):
            self.outcomes, self.onto, self.without = [], np.zeros(3), without
            self.building = make_building(rng=np.random.default_rng(seed))
            self.time, self.robot = 0.6, SimpleNamespace(step=lambda *rest, rng: rest)

        def run(self):
            if hasattr(self.robot, "told"):  # it is clocked
                assert self.robot.step(1, Reading(0.0, "laser", np.ones(3)), rng=None)[0] == 1
            for k, act in enumerate(day_acts.ACTS[:2]):
                seen = partial(np.full, (24, 32, 3)[: 3 - k], 80, dtype=np.uint8)
                yield day_acts.Moment(
                    k * 0.3, act, np.array([2.0 + k, 1.0, 0.1]), DayState(), DayInfo(say="here"),
                    people=np.array([[4.0, 1.0]]), image=seen,
                )  # fmt: skip
                self.outcomes.append(day_acts.Outcome(act, k == 0, f"as {len(self.without)}"))

    monkeypatch.setattr(day_report, "day_of", Short)
    return Short


def test_a_day_is_told_act_by_act_and_written_down(run, short_day, tmp_path):
    film, log = tmp_path / "day.mp4", tmp_path / "day.jsonl"
    done = run("day", "--seed", "5", "--without", "arms", "--film", film, "--log", log)
    assert done.exit_code == 0, done.output
    learnt, found, laser, whole = done.stdout.splitlines()[-4:]
    assert [learnt, found] == ["reached  learn   as 1", "failed   find    as 1"]
    assert laser.split()[:3] == ["laser", "1", "readings,"]
    assert whole.startswith("computes 0.0 s of a day of 0.6 s: 0.0")
    lines = [json.loads(line) for line in log.read_text("utf-8").splitlines()]
    assert [line["act"] for line in lines] == ["learn", "find"]
    assert lines[1]["truth"] == [3.0, 1.0, 0.1]
    assert lines[0]["belief"] == [0.0, 0.0, 0.0]
    pictures = cv2.VideoCapture(str(film))
    there, picture = pictures.read()
    assert there
    assert picture.shape == (640, 960, 3)
    assert abs(int(picture[100, 100].mean()) - 80) < 12  # what the robot sees


def test_of_several_days_it_is_counted_how_many_reached_each_act(run, short_day):
    done = run("day", "--days", "3")
    assert done.exit_code == 0, done.output
    *acts, whole = done.stdout.splitlines()[-10:]
    assert acts[0].split() == ["learn", "3", "of", "3"]
    assert acts[1].split() == ["find", "0", "of", "3"]
    assert acts[2].split() == ["hall", "0", "of", "0"]
    assert whole.split() == ["whole", "0", "of", "3"]


def test_a_system_that_there_is_not_and_a_film_of_many_days_are_refused(run, tmp_path):
    none = run("day", "--without", "smell")
    assert none.exit_code == 2
    assert "'smell' is none of stereo, ceiling, laser" in none.output
    many = run("day", "--days", "2", "--film", tmp_path / "day.mp4")
    assert many.exit_code == 2
    assert "a film or a log is of one day" in many.output


def test_a_detector_is_trained_and_stored(run, tmp_path):
    from robot_perception.chapters.tutor_following.training import read

    file = tmp_path / "hand.json"
    done = run("hands", "--brief", "--write", file)
    assert done.exit_code == 0, done.output
    *stages, last = done.output.splitlines()
    assert len(stages) == len(read(file).stages) == 2
    assert last == f"2 stages are stored in {file}"
    assert stages[0].endswith(f"of {read(file).stages[0].others} others "
                              f"{read(file).stages[0].false_alarms:.1%}")  # fmt: skip


def test_photographs_of_a_folder_are_told_from_hands_too(run, tmp_path):
    from robot_perception.chapters.tutor_following.training import TALL, photographs

    folder = tmp_path / "room"
    (folder / "later").mkdir(parents=True)
    rng = np.random.default_rng(0)
    for name, size in (("a.png", (240, 320)), ("later/b.jpg", (60, 80)), ("notes.txt", None)):
        if size is None:
            (folder / name).write_text("no picture")
        else:
            cv2.imwrite(str(folder / name), rng.integers(0, 256, size, dtype=np.uint8))
    images, skipped = photographs(folder)
    shapes = [image.shape for image in images]
    assert skipped == 1
    assert shapes == [(240, 320), (60, 80), (TALL * 3 // 4, TALL)]
    done = run("hands", "--brief", "--others", folder)
    assert done.exit_code == 0, done.output
    assert len(done.output.splitlines()) == 3
    assert done.output.startswith(f"{folder}: files that are no pictures and no films: 1")
    (tmp_path / "empty").mkdir()
    none = run("hands", "--brief", "--others", tmp_path / "empty")
    assert none.exit_code == 1
    assert none.output.splitlines() == [f"Error: {tmp_path / 'empty'} has no pictures and no films"]


def test_help_loads_nothing_that_computes():
    program = (
        "import sys; from robot_perception.cli import main\n"
        "try: main(['--help'])\n"
        "except SystemExit: print(sorted({m.split('.')[0] for m in sys.modules}))"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    loaded = ended.stdout.splitlines()[-1]
    for name in ("numba", "scipy", "matplotlib", "joblib", "sympy"):
        assert f"'{name}'" not in loaded
