"""The scripts' frame: no result takes the place of what is read, nor of a file without leave."""

import hashlib
import os
import runpy
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner

from robot_perception.datasets import Commands, ReadReport, limits
from robot_perception.scripts import (
    TIME_UNITS,
    Places,
    Recording,
    Results,
    check_results,
    script,
    tell,
    within,
)

SCRIPTS = Path(__file__).parents[1] / "book" / "own_data"
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
    (found,) = (one.type.endings for one in main.params if isinstance(one.type, Results))
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
    @click.argument("seen", type=Recording())
    @click.argument("out", type=Results(".csv"))
    def main(seen, out, force):
        """Copy."""
        assert isinstance(out, Places)
        out[".csv"].write_bytes(Path(seen).read_bytes() if seen.exists() else b"")

    Path("a.txt.gz").write_bytes(b"packed")
    run = CliRunner().invoke
    assert run(main, ["a.txt", "out"]).exit_code == 0  # the readers find it
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
