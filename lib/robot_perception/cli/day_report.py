"""Report of a day of the robot: a table of its acts, a log, and a film."""

import json
import time
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from tqdm import tqdm

from robot_perception.book.companion_day import day_of
from robot_perception.chapters.companion_day.acts import ACTS, TICK, Day, Moment, Outcome
from robot_perception.day.robot import DayRobot, Reading
from robot_perception.geometry import se2
from studies.sweep import sweep

_SCALE = 48  # of the plan, px a metre
_PLAN = (0.0, -1.6, 20.0, 4.2)  # that is shown: low x, low y, high x and high y, m
_WIDE, _HIGH = 960, 640  # of the film, px
_EVERY = 3  # steps from one picture of the film to the next
_INK, _TRUE, _BELIEVED, _PEOPLE = (70, 70, 70), (30, 120, 30), (200, 90, 20), (60, 60, 200)  # BGR


class Clocked:
    """A robot that counts its readings by sensor, and the seconds of this process they take."""

    def __init__(self, robot: DayRobot) -> None:
        self.robot = robot
        self.readings: Counter[str] = Counter()
        self.seconds: Counter[str] = Counter()

    def __getattr__(self, name: str) -> Any:
        return getattr(self.robot, name)

    def step(self, state: Any, reading: Reading, *, rng: np.random.Generator) -> tuple[Any, Any]:
        """Return what the robot makes of a reading."""
        start = time.process_time()
        found = self.robot.step(state, reading, rng=rng)
        self.readings[reading.sensor] += 1
        self.seconds[reading.sensor] += time.process_time() - start
        return found

    def told(self, lasted: float) -> Iterator[str]:
        """Yield a line for each sensor, and how long the computing took beside the day."""
        for sensor, seconds in self.seconds.most_common():
            each = 1000 * seconds / self.readings[sensor]
            yield f"{sensor:9s} {self.readings[sensor]:5d} readings, {each:7.2f} ms each"
        whole = sum(self.seconds.values())
        share = f"{whole / lasted:.2f} of real time"
        yield f"computes {whole:.1f} s of a day of {lasted:.1f} s: {share}"


def one(
    seed: int, without: frozenset[str], film: Path | None, log: Path | None
) -> tuple[list[Outcome], list[str]]:
    """Run one day with a bar, and write its film and log; return its ends, and its times."""
    today = day_of(seed, without=without)
    today.robot = Clocked(today.robot)
    with ExitStack() as stack:
        lines = None if log is None else stack.enter_context(log.open("w", encoding="utf-8"))
        shown = None if film is None else stack.enter_context(Film(film, today))
        bar = stack.enter_context(tqdm(unit=" s", desc="day", unit_scale=TICK))
        for step, moment in enumerate(today.run()):
            bar.set_description(f"{moment.act}: {moment.state.task}")
            bar.update()
            if lines is not None:
                lines.write(json.dumps(noted(today, moment)) + "\n")
            if shown is not None and step % _EVERY == 0:
                shown.add(moment)
    return today.outcomes, [*today.robot.told(today.time)]


def many(seeds: Sequence[int], without: frozenset[str]) -> dict[int, list[Outcome]]:
    """Run a day of each seed, several at a time, and return how the acts of each ended."""
    rng = np.random.default_rng(0)  # each day has generators of its own seed
    found = sweep(partial(_ended, without=without), seeds, rng=rng, desc="days")
    return dict(zip(seeds, found, strict=True))


def _ended(seed: int, *, without: frozenset[str], rng: np.random.Generator) -> list[Outcome]:
    """Return how the acts of the day of a seed ended."""
    today = day_of(seed, without=without)
    for _ in today.run():
        pass
    return today.outcomes


def table(found: Mapping[int, Sequence[Outcome]]) -> Iterator[str]:
    """Yield how the acts of a day ended, a line each; of several days how many reached each."""
    if len(found) == 1:
        for end in next(iter(found.values())):
            yield f"{'reached' if end.right else 'failed':8s} {end.act:7s} {end.why}"
        return
    reached = Counter(end.act for ends in found.values() for end in ends if end.right)
    tried = Counter(end.act for ends in found.values() for end in ends)
    for act in ACTS:
        yield f"{act:7s} {reached[act]:3d} of {tried[act]:3d}"
    whole = sum(len(ends) == len(ACTS) and ends[-1].right for ends in found.values())
    yield f"{'whole':7s} {whole:3d} of {len(found):3d}"


def noted(today: Day, moment: Moment) -> dict[str, Any]:
    """Return a line of the log: time, act, task, belief beside truth, and what is said."""
    return {
        "time": round(moment.time, 3),
        "act": moment.act,
        "module": moment.state.task,
        "belief": se2.compose(today.onto, moment.state.pose.mean).round(4).tolist(),
        "truth": moment.robot.round(4).tolist(),
        "people": moment.people.round(3).tolist(),
        "command": [round(float(one), 3) for one in moment.info.command],
        "say": moment.info.say,
    }


class Film:
    """A film of a day: what the robot sees above, and the corridor from above below."""

    def __init__(self, file: Path, today: Day) -> None:
        self.file, self.today = file, today
        self.plan = _floor(today)
        code = cv2.VideoWriter.fourcc(*"mp4v")
        self.writer = cv2.VideoWriter(str(file), code, 1 / (TICK * _EVERY) * 2, (_WIDE, _HIGH))
        if not self.writer.isOpened():
            raise OSError(f"no film can be written to {file}")

    def __enter__(self) -> "Film":
        return self

    def __exit__(self, *_: object) -> None:
        self.writer.release()

    def add(self, moment: Moment) -> None:
        """Add what is at a moment."""
        canvas = np.full((_HIGH, _WIDE, 3), 255, np.uint8)
        canvas[-len(self.plan) :] = self.plan
        if moment.image is not None:
            seen = moment.image()
            seen = cv2.cvtColor(seen, cv2.COLOR_GRAY2BGR) if seen.ndim == 2 else seen[..., ::-1]
            canvas[:320, :427] = cv2.resize(seen, (427, 320), interpolation=cv2.INTER_AREA)
        below = _HIGH - len(self.plan)
        for at, colour in ((moment.people, _PEOPLE),):
            for place in at:
                cv2.circle(canvas, _pixel(place, below), 8, colour, -1, cv2.LINE_AA)
        believed = se2.compose(self.today.onto, moment.state.pose.mean)
        for pose, colour in ((believed, _BELIEVED), (moment.robot, _TRUE)):
            tip = pose[:2] + 0.45 * np.array([np.cos(pose[2]), np.sin(pose[2])])
            cv2.circle(canvas, _pixel(pose[:2], below), 12, colour, 2, cv2.LINE_AA)
            cv2.line(canvas, _pixel(pose[:2], below), _pixel(tip, below), colour, 2, cv2.LINE_AA)
        words = [
            f"{moment.time:.0f} s",
            f"act: {moment.act}",
            f"task: {moment.state.task}",
            f"says: {moment.info.say}" if moment.info.say else "",
        ]
        if moment.state.companion is not None and moment.state.task == "attend":
            words.append(f"state: {moment.state.companion.name}")
        for k, word in enumerate(words):
            _write(canvas, word, (450, 40 + 34 * k), _INK)
        _write(canvas, "where it is", (450, 270), _TRUE)
        _write(canvas, "where it takes itself to be", (450, 304), _BELIEVED)
        _write(canvas, "people", (700, 270), _PEOPLE)
        self.writer.write(canvas)


def _floor(today: Day) -> np.ndarray:
    """Return a drawing of the corridor from above."""
    x0, y0, x1, y1 = _PLAN
    size = round((y1 - y0) * _SCALE), round((x1 - x0) * _SCALE)
    drawn = np.full((*size, 3), 255, np.uint8)
    faces, _ = today.building.office.section(0.3)
    for a, b in faces:
        cv2.line(drawn, _pixel(a), _pixel(b), _INK, 2, cv2.LINE_AA)
    return drawn


def _pixel(place: Iterable[float], below: int = 0) -> tuple[int, int]:
    """Return the column and row of a place, y upwards."""
    x, y = place
    return round((x - _PLAN[0]) * _SCALE), below + round((_PLAN[3] - y) * _SCALE)


def _write(canvas: np.ndarray, word: str, at: tuple[int, int], colour: tuple) -> None:
    cv2.putText(canvas, word, at, cv2.FONT_HERSHEY_SIMPLEX, 0.8, colour, 2, cv2.LINE_AA)
