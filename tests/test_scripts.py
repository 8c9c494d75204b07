"""The scripts' frame: no result takes the place of what is read, nor of a file without leave."""

import ast
import hashlib
import inspect
import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner

import robot_perception.datasets
from robot_perception.datasets import Commands, ReadReport, limits
from robot_perception.scripts import (
    TIME_UNITS,
    Clocks,
    Form,
    Kinds,
    Numbers,
    Places,
    Recording,
    Results,
    check_results,
    for_each,
    installed,
    of_the_book,
    script,
    tell,
    within,
    worded,
)

ROOT = Path(__file__).parents[1]
SCRIPTS = ROOT / "book" / "own_data"
COMMANDS = {  # words of each; what it reads may be one of its own results
    "arms.py": ["{input}", "0.3,0.25,0.2", "rest", "{out}"],
    "ceiling.py": ["{input}", "{out}"],
    "ekf_slam.py": ["polar", "{input}", "{input}", "{out}"],
    "faces.py": ["people", "{input}", "{out}"],
    "following.py": ["{input}", "{out}"],
    "judge.py": None,  # these two write nothing
    "rank.py": None,
    "people.py": ["detections", "{input}", "{out}"],
    "stereo_slam.py": ["people", "{out}", "{input}"],
    "track.py": ["camshift", "{input}", "1,1,9,9", "{out}"],
    "walls.py": ["carmen", "{input}", "{out}"],
}
WRITING = [name for name, words in COMMANDS.items() if words]


def command(name: str) -> click.Command:
    return runpy.run_path(str(SCRIPTS / name))["main"]


def endings(main: click.Command) -> tuple[str, ...]:
    (found,) = (tuple(one.type.files) for one in main.params if isinstance(one.type, Results))
    return found


def test_every_script_is_in_the_table():
    assert set(COMMANDS) == {path.name for path in SCRIPTS.glob("*.py")}
    for name in COMMANDS:
        kinds = [type(one.type) for one in command(name).params]
        assert (Results in kinds) == (name in WRITING)


@pytest.mark.parametrize("name", WRITING)
def test_a_script_refuses_to_write_over_what_it_reads(name, tmp_path, monkeypatch):
    """Under its own name, by a link of either kind, and with --force as well."""
    monkeypatch.chdir(tmp_path)
    Path("people").mkdir()
    main = command(name)
    for ending in endings(main):
        for link in (None, os.symlink, os.link):
            mine, result = Path("mine.bin"), Path(f"out{ending}")
            mine.write_bytes(b"recorded once")
            link(mine, result) if link else mine.rename(result)
            words = [w.format(input=mine if link else result, out="out") for w in COMMANDS[name]]
            for force in ([], ["--force"]):
                done = CliRunner().invoke(main, [*words, *force])
                assert done.exit_code == 1
                assert f"{result} would be written over, and it is read" in done.output
            assert result.read_bytes() == b"recorded once"
            result.unlink()


def test_an_outline_is_read_as_well(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("film.mp4", "out_outlines.csv"):
        Path(name).write_bytes(b"mine")
    words = ["shape", "film.mp4", "out_outlines.csv", "out", "--force"]
    done = CliRunner().invoke(command("track.py"), words)
    assert "out_outlines.csv would be written over" in done.output


@pytest.mark.parametrize("name", WRITING)
def test_a_script_asks_before_a_file_is_written_over(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    main = command(name)
    Path("people").mkdir()
    Path("in").mkdir()
    Path("in/mine.bin").write_bytes(b"no recording at all")
    words = [w.format(input="in/mine.bin", out="out") for w in COMMANDS[name]]
    for ending in endings(main):
        result = Path(f"out{ending}")
        result.write_bytes(b"of last week")
        done = CliRunner().invoke(main, words)
        assert done.exit_code == 1
        assert f"{result}: there already; --force writes over" in done.output
        forced = CliRunner().invoke(main, [*words, "--force"])
        assert forced.exit_code == 1  # now it is the recording that is wrong
        assert "there already" not in forced.output
        assert result.read_bytes() == b"of last week"
        result.unlink()


def test_a_picture_in_a_folder_that_is_read_is_not_written_over(tmp_path):
    folder = tmp_path / "pictures"
    folder.mkdir()
    (folder / "1.png").write_bytes(b"mine")
    with pytest.raises(ValueError, match=r"1\.png would be written over"):
        check_results([folder / "1.png"], [folder], overwrite=True)
    check_results([folder / "2.png"], [folder], overwrite=False)
    (folder / "run.tum").write_bytes(b"of last week")  # a result of a run in that folder
    check_results([folder / "run.tum"], [folder], overwrite=True)
    (tmp_path / "also").symlink_to(folder)
    with pytest.raises(ValueError, match=r"1\.png would be written over"):
        check_results([folder / "1.png"], [tmp_path / "also"], overwrite=True)


def test_results_need_a_folder_and_recordings_must_be_there(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    @script
    @click.argument("seen", type=Recording("What is copied."))
    @click.argument("out", type=Results({".csv": "The copy.", ".txt": "Nothing yet."}))
    def main(seen, out, force):
        """Copy."""
        assert isinstance(out, Places)
        out[".csv"].write_bytes(Path(seen).read_bytes() if seen.exists() else b"")

    Path("a.txt.gz").write_bytes(b"packed")
    run = CliRunner().invoke
    done = run(main, ["a.txt", "out"])  # the readers find it
    assert (done.exit_code, done.output) == (0, "written: out.csv\n")
    assert run(main, ["a.txt", "run.csv"]).output == "written: run.csv\n"
    assert run(main, ["a.txt", "run.tum"]).output == "written: run.tum.csv\n"
    assert run(main, ["a.txt", "run", "--force"]).output == "written: run.csv\n"
    assert "a.csv: no such file or folder" in run(main, ["a.csv", "b"]).output
    assert "no is no folder: cannot write no/b.csv there" in run(main, ["a.txt", "no/b"]).output
    Path("b.csv").mkdir()
    assert "b.csv is a folder" in run(main, ["a.txt", "b"]).output
    before = hashlib.sha256(Path("out.csv").read_bytes()).digest()
    assert run(main, ["out.csv", "out", "--force"]).exit_code == 1
    assert hashlib.sha256(Path("out.csv").read_bytes()).digest() == before


def test_an_error_is_one_line_and_a_number_below_zero_is_no_option():
    @script
    @click.argument("box")
    def main(box):
        """Fail."""
        raise ValueError(f"got {box!r}")

    done = CliRunner().invoke(main, ["-5,3,20,20"])
    assert (done.exit_code, done.output) == (1, "Error: got '-5,3,20,20'\n")


def test_a_script_that_takes_topics_gets_an_option_for_them():
    @script
    @click.argument("bag")
    def main(bag, topic):
        """Say."""
        print(bag, topic)

    said = CliRunner().invoke(main, ["a", "--topic", "/b", "--topic", "c"]).output
    assert said == "a ('/b', 'c')\n"
    assert CliRunner().invoke(main, ["a"]).output == "a ()\n"


def test_a_script_that_takes_units_of_time_gets_an_option_for_them():
    @script
    @click.argument("log")
    def main(log, time_unit):
        """Say."""
        print(log, time_unit)

    run = CliRunner().invoke
    assert run(main, ["a", "--time-unit", "ms", "--time-unit", "s"]).output == "a ('ms', 's')\n"
    assert run(main, ["a"]).output == "a ()\n"
    assert "'h' is not one of" in run(main, ["a", "--time-unit", "h"]).output


def test_an_option_holds_for_all_files_or_for_each_in_their_order():
    assert for_each("--topic", [], 2) == [None, None]
    assert for_each("--topic", ["a"], 2) == ["a", "a"]
    assert for_each("--topic", ["a", "b"], 2) == ["a", "b"]
    with pytest.raises(ValueError, match="--topic may be given once, or 2 times in the order of"):
        for_each("--topic", ["a", "b", "c"], 2)
    with pytest.raises(ValueError, match="--time-unit may be given once, got s ms"):
        for_each("--time-unit", ["s", "ms"], 1)


class OtherUnitError(ValueError):
    """An error of a reader that found times in another unit."""

    unit = "ms"


def recording(numbers):
    """Return a reader of times that cannot be farther apart than a minute."""

    def read(path, *, time_unit):
        times = np.array(numbers) / 1000.0 ** TIME_UNITS.index(time_unit)
        if np.diff(times).max() > 60:
            raise OtherUnitError(f"{path}: too far apart")
        return Commands(times, np.zeros((len(times), 2)))

    return read


def test_a_unit_is_taken_as_given_or_as_the_numbers_tell(capsys):
    mine, theirs = Path("mine.csv"), Path("theirs.csv")
    seconds, milliseconds = recording([0.0, 1, 2]), recording([0.0, 1000, 2000])
    for given in ([], ["s", "ms"]):
        clocks = Clocks(given, mine, theirs)
        both = clocks.read(seconds, mine), clocks.read(milliseconds, theirs)
        np.testing.assert_array_equal(both[0].times, both[1].times)
        clocks.check(*zip((mine, theirs), (one.times for one in both), strict=True))
        told = "theirs.csv: its times are read in ms, as their size tells\n"
        assert capsys.readouterr().out == ("" if given else told)
    with pytest.raises(ValueError, match=r"too far apart; --time-unit s --time-unit ms would help"):
        Clocks(["s"], mine, theirs).read(milliseconds, theirs)
    with pytest.raises(ValueError, match=r"too far apart; --time-unit ms would help"):
        Clocks(["s"], theirs).read(milliseconds, theirs)
    with pytest.raises(ValueError, match="--time-unit may be given once, got s ms"):
        Clocks(["s", "ms"], mine)


@pytest.mark.parametrize(
    ("first", "second", "given", "units"),
    [
        ([0.0, 1, 2], [1000.0, 1040], ["s"], ["s", "ms"]),
        ([0.0, 1, 2], [1000.0, 2000], ["ms"], ["s", "ms"]),
        ([5000.0, 6000], [5.0, 6, 7], ["ms"], ["ms", "s"]),
        ([1.7e9, 1.7e9 + 1], [1.7e12, 1.7e12 + 50], ["s"], ["s", "ms"]),
        ([0.0, 1, 2], [0.0, 1000, 2000], ["ms"], ["s", "ms"]),
        ([0.0, 1, 2], [0.0, *range(25, 2000, 25)], [], ["s", "ms"]),
    ],
)
def test_what_is_advised_where_no_time_is_in_common_works(first, second, given, units):
    files = Path("a.csv"), Path("b.csv")
    readers = recording(first), recording(second)

    def both(given):
        clocks = Clocks(given, *files)
        read = [clocks.read(*one).times for one in zip(readers, files, strict=True)]
        clocks.check(*zip(files, read, strict=True))

    with pytest.raises(
        ValueError, match=r"(no|hardly a) time in common: a\.csv from .* and b\.csv from"
    ) as no:
        both(given)
    advice = " ".join(f"--time-unit {unit}" for unit in units)
    assert str(no.value).endswith(f" s; {advice} would help")
    both(units)


def test_a_minute_of_a_day_is_enough_in_common():
    files, day = (Path("a.csv"), Path("b.csv")), np.arange(0.0, 86400.0).tolist()
    for given in ([], ["s"], ["s", "s"]):
        clocks = Clocks(given, *files)
        minute = clocks.read(recording(np.arange(0, 60, 0.1).tolist()), files[0])
        whole = clocks.read(recording(day), files[1])
        clocks.check((files[0], minute.times), (files[1], whole.times))


def test_of_two_clocks_that_no_unit_joins_it_is_told_which_counts_from_1970():
    files = Path("a.csv"), Path("b.bag")
    clocks = Clocks([], files[0])
    clocks.read(recording([0.0, 1.0]), files[0])
    with pytest.raises(ValueError, match="; one clock counts from 1970, the other does not"):
        clocks.check((files[0], [0.0, 1.0]), (files[1], [1.7e9, 1.7e9 + 1]))
    with pytest.raises(ValueError, match=r"from 7\.000 to 8\.000 s$"):
        clocks.check((files[0], [0.0, 1.0]), (files[1], [7.0, 8.0]))


def test_remarks_of_a_recording_are_told(capsys):
    report = ReadReport(Path("a.bag"), {}, {}, "messages", ("two are late", "one is lost"))
    recording = Commands(np.zeros(1), np.zeros((1, 2)), report)
    assert tell(recording) is recording
    tell(Commands(np.zeros(1), np.zeros((1, 2))))
    assert capsys.readouterr().out == "two are late\none is lost\n"


def test_a_constant_of_the_wrong_type_is_an_error_of_one_line():
    @script
    @click.argument("value", type=click.Choice(["12", "0", "text", "none"]))
    def main(value):
        """Check."""
        known = {"12": 12, "0": 0, "text": "12", "none": None}
        print(within("RATE", known[value], 0.5, 20, "Hz"))

    run = CliRunner().invoke
    assert run(main, ["12"]).output == "12.0\n"
    assert run(main, ["0"]).output == "Error: RATE must be from 0.5 to 20 Hz, got 0\n"
    for value, said in (("text", "'12'"), ("none", "None")):
        done = run(main, [value])
        assert (done.exit_code, done.output) == (1, f"Error: RATE must be a number, got {said}\n")


def test_units_of_time_are_those_of_the_readers():
    assert tuple(limits.UNITS) == TIME_UNITS


# Help ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", COMMANDS)
def test_help_tells_the_form_of_each_argument_and_each_file_that_is_written(name):
    main = command(name)
    told = "".join(CliRunner().invoke(main, ["--help"]).output.split())  # lines are broken anywhere
    arguments = [one for one in main.params if isinstance(one, click.Argument)]
    for one in arguments:
        assert isinstance(one.type, Form)
        for label, what in one.type.rows(one.human_readable_name):
            assert "".join((label + what).split()) in told
    if name in WRITING:
        files = told.partition("Filesthatarewritten:")[2]
        for one in arguments:
            for ending, what in getattr(one.type, "files", {}).items():
                assert "".join(f"OUT{ending}{what}".split()) in files


@pytest.mark.parametrize(
    ("name", "forms"),
    [
        ("track.py", ["BOX u,v,width,height"]),
        (
            "arms.py",
            [
                "LENGTHS upper,fore,hand",
                "POSE sideways,ahead,about,elbow,sideways,ahead,about,elbow, or rest",
                "--face SQUARE u,v,width,height",
            ],
        ),
    ],
)
def test_help_tells_how_numbers_are_given(name, forms):
    told = " ".join(CliRunner().invoke(command(name), ["--help"]).output.split())
    for form in forms:
        assert f"{form}: " in told


def test_numbers_are_of_their_form_or_the_word_or_a_file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("1,2").write_text("a file of that name")

    @script
    @click.argument("pair", type=Numbers("u,v", "px", word="rest", or_file=True))
    @click.argument("kind", type=Kinds({"one": "The first.", "two": "The second."}))
    def main(pair, kind):
        """Say."""
        print(repr(pair), kind)

    run = CliRunner().invoke
    assert run(main, ["-1.5,2e1", "one"]).output == "(-1.5, 20.0) one\n"
    assert run(main, ["rest", "two"]).output == "'rest' two\n"
    assert "Path('1,2') one" in run(main, ["1,2", "one"]).output
    for wrong in ("1", "1,2,3", "1,a", "nan,1", "1,inf", "none.csv", ""):
        done = run(main, [wrong, "one"])
        assert done.exit_code == 2
        assert done.output.splitlines()[-1] == (
            f"Error: Invalid value for 'PAIR': must be u,v or rest or a file, got {wrong!r}"
        )


# Words -----------------------------------------------------------------------------------------


PUBLIC = {
    name: getattr(robot_perception.datasets, name) for name in robot_perception.datasets.__all__
}
FUNCTIONS = {name for name, value in PUBLIC.items() if inspect.isfunction(value)}
PARAMETERS = {name for key in FUNCTIONS for name in inspect.signature(PUBLIC[key]).parameters}
NAMED = re.compile(r"\b(\w+)=(?!=)|\b(\w+_\w+|[A-Z][a-z]+[A-Z]\w+)\b")


def named(text: str) -> set[str]:
    """Return the parameters, functions and classes of the library that a sentence names."""
    found = {name or word for name, word in NAMED.findall(text)}
    return found & (PUBLIC.keys() | PARAMETERS)


def sentences() -> list[str]:
    """Return what the readers and writers may say: texts of several words, and names of readers."""
    found = []
    for file in sorted((ROOT / "lib" / "robot_perception" / "datasets").glob("[!_]*.py")):
        nodes = list(ast.walk(ast.parse(file.read_text("utf-8"))))
        silent = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
        types = [getattr(node, name, None) for node in nodes for name in ("returns", "annotation")]
        silent |= {id(part) for kind in types if kind for part in ast.walk(kind)}
        joined = [node for node in nodes if isinstance(node, ast.JoinedStr)]
        silent |= {id(part) for node in joined for part in node.values}
        found += ["".join(map(said, node.values)) for node in joined]
        found += [said(n) for n in nodes if isinstance(n, ast.Constant) and id(n) not in silent]
    return [text for text in found if (" " in text and text[0] != "<") or text in FUNCTIONS]


def said(part: ast.expr) -> str:
    """Return what a part of a text says, with an x for what is put in."""
    if isinstance(part, ast.FormattedValue):
        return "'x'" if part.conversion == ord("r") else "x"
    return part.value if isinstance(part, ast.Constant) and isinstance(part.value, str) else ""


SENTENCES = sorted({text for text in sentences() if named(text)})
SOURCES = {path.name: path.read_text("utf-8") for path in SCRIPTS.glob("*.py")}
OPTIONS = {word for name in COMMANDS for one in command(name).params for word in one.opts}


@pytest.mark.parametrize("sentence", SENTENCES)
def test_what_the_library_says_names_in_a_script_what_a_script_has(sentence):
    """No parameter, function or class; but options, constants and scripts that there are."""
    assert len(SENTENCES) > 5
    told = worded(sentence)
    assert not named(told)
    assert set(re.findall(r"--[\w-]+", told)) <= OPTIONS
    assert set(re.findall(r"\b\w+\.py\b", told)) <= SOURCES.keys()
    for constant in set(re.findall(r"\b[A-Z_]{3,}\b", told)) - set(re.findall(r"\w+", sentence)):
        assert any(re.search(rf"^{constant} = ", text, re.MULTILINE) for text in SOURCES.values())


def test_an_error_and_a_remark_of_a_script_have_its_words(capsys):
    @script
    @click.argument("file")
    def main(file):
        """Fail."""
        raise ValueError(f"{file}: missing (allow_gaps=True reads\nthe others)")

    done = CliRunner().invoke(main, ["a"])
    assert done.output == "Error: a: missing (GAPS = True in the script reads the others)\n"
    report = ReadReport(
        Path("a.bag"), {}, {}, "messages", ("two would do (topic=…, in a script --topic)",)
    )
    tell(Commands(np.zeros(1), np.zeros((1, 2)), report))
    assert capsys.readouterr().out == "two would do (--topic)\n"


# Packages that are missing ---------------------------------------------------------------------

WITHOUT = """
import runpy, sys
from importlib.machinery import PathFinder

class Installed(PathFinder):
    @classmethod
    def find_spec(cls, name, path=None, target=None):
        there = name.partition(".")[0] not in absent
        return super().find_spec(name, path, target) if there else None

absent, files = sys.argv[1].split(","), sys.argv[2:]
sys.meta_path[:] = [one for one in sys.meta_path if one is not PathFinder] + [Installed]
for file in files:
    runpy.run_path(file)["main"]
"""
BOOK = "matplotlib,anywidget,ipywidgets,pandas,joblib,jupyter_book,filelock,grimp,latex2mathml"


def without(packages: str, *names: str) -> subprocess.CompletedProcess:
    """Import scripts where packages are missing."""
    files = [str(SCRIPTS / name) for name in names]
    words = [sys.executable, "-c", WITHOUT, packages, *files]
    return subprocess.run(words, capture_output=True, text=True)


def test_no_script_needs_what_only_the_book_needs():
    done = without(BOOK, *COMMANDS)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("name", COMMANDS)
def test_a_script_says_in_one_line_what_is_missing(name):
    package, index, extra = "click", "click", "data"
    if "import cv2" in SOURCES[name]:
        package, index, extra = "cv2", "opencv-python-headless", "vision"
    done = without(package, name)
    assert done.returncode == 1
    assert done.stderr == (
        f"Error: this needs {package}: pip install {index}"
        f" (or, in the folder of the book, pip install '.[{extra}]')\n"
    )


def test_a_package_that_is_asked_for_later_is_named_in_one_line():
    @script
    def main():
        """Read."""
        raise ModuleNotFoundError("No module named 'cv2.face'", name="cv2.face")

    done = CliRunner().invoke(main, [])
    assert done.output.startswith("Error: this needs cv2: pip install opencv-python-headless (or")
    with pytest.raises(ModuleNotFoundError), installed():
        raise ModuleNotFoundError("ours", name="robot_perception.none")


def test_files_of_the_book_are_found():
    assert of_the_book("claims.json").is_file()
    with pytest.raises(FileNotFoundError, match=r"none\.json is not beside the library"):
        of_the_book("none.json")
