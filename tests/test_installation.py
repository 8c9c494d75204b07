"""Each module imports with the packages of its extra alone; the base is enough for algorithms."""

import json
import os
import re
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from robot_perception import extras

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
EXTRAS = {
    "robot_perception.cameras": "vision",
    "robot_perception.landmarks": "vision",
    "robot_perception.people.skin": "vision",
    "robot_perception.appearance": "vision",
    "robot_perception.ceiling": "vision",
    "robot_perception.arms": "vision",
    "robot_perception.companion": "vision",
    "robot_perception.day": "vision",
    "robot_perception.cli.day_report": "book",
    "data_synth.ceiling": "vision",
    "data_synth.coloured": "vision",
    "data_synth.arms": "vision",
    "data_synth.companion": "vision",
    "data_synth.day": "vision",
    "data_synth.people": "vision",
    "robot_perception.book": "book",
    "robot_perception.chapters": "book",
    "explorables": "book",
    "studies.claims": "book",
    "studies.keys": "book",
    "studies.ledger": "book",
    "studies.notebooks": "book",
    "studies.pages": "book",
    "studies.registration": "book",
    "studies.rows": "book",
    "studies.says": "book",
    "studies.stored": "book",
    "studies.sweep": "book",
    "studies.tables": "book",
    "studies.trials": "book",
    "robot_perception.scripts": "data",
    "robot_perception.teaching": "book",
    "robot_perception.cli": "data",
    "robot_perception.datasets": "data",
    "robot_perception.slam.observability.symbolic": "symbolic",
}
"""What needs more than the base, with all below it."""

IMPORT = """
import importlib, json, sys
from importlib.machinery import BuiltinImporter, FrozenImporter, PathFinder

class Installed(PathFinder):
    @classmethod
    def find_spec(cls, name, path=None, target=None):
        return None if name in absent else super().find_spec(name, path, target)

names, absent = json.load(sys.stdin)
sys.meta_path[:] = [BuiltinImporter, FrozenImporter, Installed]
for name in names:
    importlib.import_module(name)
"""


def modules(extra: str | None) -> list[str]:
    """Return the modules that an extra is for, or those of the base."""
    found = []
    for folder in (ROOT / "lib", ROOT):
        for package in ("robot_perception", "explorables", "studies", "data_synth"):
            for file in sorted((folder / package).rglob("*.py")):
                parts = file.relative_to(folder).with_suffix("").parts
                name = ".".join(part for part in parts if part != "__init__")
                rooms = [room for room in EXTRAS if f"{name}.".startswith(f"{room}.")]
                needs = EXTRAS[max(rooms, key=len)] if rooms else None
                found += [name] if needs == extra else []
    return found


def packages(extra: str | None) -> set[str]:
    """Return the packages that the base and an extra install."""
    todo = [Requirement(line) for line in PROJECT["dependencies"]]
    todo += [Requirement(f"robot-perception[{extra}]")] if extra else []
    seen: set[str] = set()
    while todo:
        wanted = todo.pop()
        if str(wanted) in seen:
            continue
        seen.add(str(wanted))
        if wanted.name == "robot-perception":
            for name in wanted.extras:
                todo += map(Requirement, PROJECT["optional-dependencies"][name])
            continue
        for line in metadata.requires(wanted.name) or ():
            needed = Requirement(line)
            environments = [{"extra": name} for name in (*wanted.extras, "")]
            if needed.marker is None or any(map(needed.marker.evaluate, environments)):
                todo.append(needed)
    return {"robot-perception", *(_normal(Requirement(line).name) for line in seen)}


def absent(extra: str | None) -> list[str]:
    """Return what cannot be imported where only the base and an extra are installed."""
    here = packages(extra)
    imports = metadata.packages_distributions().items()
    return [name for name, owners in imports if here.isdisjoint(map(_normal, owners))]


def _normal(name: str) -> str:
    return name.lower().replace("_", "-").replace(".", "-")


def python(code: str, names: list[str], extra: str | None) -> subprocess.CompletedProcess:
    """Run code where only the base and an extra are installed."""
    words, command = json.dumps([names, absent(extra)]), [sys.executable, "-c", code]
    return subprocess.run(command, input=words, capture_output=True, text=True)


@pytest.mark.parametrize("extra", [None, "data", "symbolic", "vision", "book"])
def test_modules_import_with_their_extra_alone(extra: str | None):
    names = modules(extra)
    assert names
    run = python(IMPORT, names, extra)
    assert run.returncode == 0, run.stderr


def test_command_line_says_what_to_install(monkeypatch: pytest.MonkeyPatch):
    run = python(IMPORT + "from robot_perception.__main__ import main\nmain()", [], None)
    assert run.returncode == 1
    assert re.fullmatch(r"This needs \w+: pip install 'robot-perception\[\w+\]'\n", run.stderr)


def test_extras_are_read_from_what_the_project_says(monkeypatch: pytest.MonkeyPatch):
    lines = [f"click>=8; extra == '{extra}'" for extra in ("book", "data")]
    lines += ["clickable", "opencv-python-headless<5,>=4; extra == 'vision'"]
    monkeypatch.setattr(extras, "requires", lambda name: lines)
    names = "click", "cv2", "PIL"
    assert [extras.extra_of(name) for name in names] == ["data", "vision", "book"]

    def absent(name: str) -> None:
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(extras, "requires", absent)  # not installed, run from its folder
    assert extras.extra_of("click") == "book"


NEEDY = {
    "robot_perception.landmarks": ("cv2", "vision"),
    "robot_perception.landmarks.ego_motion": ("cv2", "vision"),
    "robot_perception.cameras": ("cv2", "vision"),
    "robot_perception.appearance.segmentation": ("cv2", "vision"),
    "robot_perception.appearance.affine_snake": ("cv2", "vision"),
    "robot_perception.appearance.single_cues": ("cv2", "vision"),
    "robot_perception.appearance.colour_shape": ("cv2", "vision"),
    "robot_perception.ceiling.correction": ("cv2", "vision"),
    "robot_perception.people.skin": ("cv2", "vision"),
    "studies.sweep": ("matplotlib", "book"),
    "robot_perception.slam.observability.symbolic": ("sympy", "symbolic"),
    "explorables.figures": ("matplotlib", "book"),
    "robot_perception.chapters.walls": ("matplotlib", "book"),
}
CALLS = {
    "datasets.read_image('a.png')": ("PIL", "vision"),
    "datasets.read_video('a.avi')": ("cv2", "vision"),
    "datasets.write_video('a.avi', [], rate=1.0)": ("cv2", "vision"),
    "datasets.dataset('kitti_stereo_turn')": ("pooch", "data"),
    "datasets.read_track('a.bag')": ("rosbags", "ros"),
}
MISSING = """
for name in names:
    try:
        importlib.import_module(name) if not name.startswith("datasets.") else eval(
            name, {"datasets": importlib.import_module("robot_perception.datasets")}
        )
    except ModuleNotFoundError as error:
        print(error.name, error)
"""


def test_modules_say_what_to_install():
    """Where the base alone is installed, in one sentence for each module and function."""
    code = IMPORT[: IMPORT.rindex("for name in names")] + MISSING
    run = python(code, [*NEEDY, *CALLS], None)
    assert run.returncode == 0, run.stderr
    assert run.stdout.splitlines() == [
        f"{package} This needs {package}: pip install 'robot-perception[{extra}]'"
        for package, extra in (NEEDY | CALLS).values()
    ]


def test_an_error_of_our_own_is_none_of_a_missing_package():
    ours = r"No module named 'robot_perception\.none'"
    with pytest.raises(ModuleNotFoundError, match=ours), extras.needing():
        import robot_perception.none  # noqa: F401
    with pytest.raises(ImportError, match="cannot import name 'nothing'"), extras.needing():
        from numpy import nothing  # noqa: F401


def test_every_module_of_an_extra_names_it():
    """No module of the library, chapters and teaching apart, imports such a package bare."""
    optional = {"cv2", "PIL", "pooch", "tqdm", "sympy", "joblib", "requests", "rosbags", "urllib3"}
    bare = re.compile(rf"^(?:import|from) ({'|'.join(optional)})\b", re.MULTILINE)
    outside = {"chapters", "teaching", "cli"}
    for file in (ROOT / "lib" / "robot_perception").rglob("*.py"):
        if not outside & set(file.relative_to(ROOT / "lib").parts):
            assert not bare.findall(file.read_text("utf-8")), file.name


# Real environments -------------------------------------------------------------------------------

OWN = ROOT / "book" / "own_data"
FILM = """
import numpy as np
from robot_perception import datasets
card, film = np.zeros((60, 80, 3), np.uint8), []
card[:] = np.random.default_rng(1).integers(60, 90, (60, 80, 1))
for k in range(12):
    frame = card.copy()
    frame[20:40, 20 + k : 36 + k] = 200, 60, 40
    film.append(frame)
datasets.write_video("film.avi", film, rate=10.0)
"""
RUNS = {
    "": [],
    "data": [
        [str(OWN / "judge.py")],
        ["-m", "robot_perception", "datasets", "list"],
    ],
    "symbolic": [],
    "vision": [],
    "data,symbolic": [[str(OWN / "rank.py"), "landmarks", "anchor"]],
    "data,vision": [
        ["-c", FILM],
        [str(OWN / "track.py"), "camshift", "film.avi", "20,20,16,20", "run"],
    ],
    "book": [
        ["-m", "robot_perception", "--help"],
        ["-m", "robot_perception", "claims", "--json"],
        ["-m", "robot_perception", "register", "--help"],
        ["-m", "robot_perception", "store", "--prune"],
    ],
}
"""What is run where the base and these extras are installed; a word of usage counts as a run."""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The library as it is installed."""
    folder = tmp_path_factory.mktemp("wheel")
    command = [
        sys.executable,
        "-m",
        "pip",
        "wheel",
        "-q",
        "--no-deps",
        "-w",
        str(folder),
        str(ROOT),
    ]
    subprocess.run(command, check=True, capture_output=True)
    return next(folder.glob("*.whl"))


@pytest.mark.slow
@pytest.mark.parametrize("extra", RUNS)
def test_an_environment_of_its_own_has_all_that_its_extra_promises(
    extra: str, wheel: Path, tmp_path: Path
):
    """The modules import, and the scripts for own data run, from a wheel in a bare environment."""
    subprocess.run([sys.executable, "-m", "venv", str(tmp_path / "env")], check=True)
    here = str(tmp_path / "env" / ("Scripts" if sys.platform == "win32" else "bin") / "python")
    clean = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "PYTEST"))}

    def run(*words: str, text: str | None = None) -> subprocess.CompletedProcess:
        command, options = [here, *words], {"capture_output": True, "text": True}
        return subprocess.run(command, cwd=tmp_path, env=clean, input=text, **options)

    what = f"{wheel}[{extra}]" if extra else str(wheel)
    installed = run("-m", "pip", "install", "-q", "-c", str(ROOT / "constraints.txt"), what)
    if "connection" in installed.stderr.lower():
        pytest.skip("no package index can be reached")
    assert installed.returncode == 0, installed.stderr
    assert run("-m", "pip", "check").returncode == 0
    names = [name for one in (None, *extra.split(",")) if one != "" for name in modules(one)]
    found = run("-c", IMPORT, text=json.dumps([names, []]))
    assert found.returncode == 0, found.stderr
    for words in RUNS[extra]:
        done = run(*words)
        assert "Traceback" not in done.stderr, done.stderr
        assert done.returncode == 0 or len(words) == 1, done.stderr


def test_the_base_is_small():
    assert len(PROJECT["dependencies"]) == 4
    assert not {"matplotlib", "anywidget", "sympy", "pooch", "click"} & packages(None)
