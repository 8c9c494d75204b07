"""Does one sensor more help? The committee with microphones beside the paper's three sensors."""

import ast
import inspect
import io
import textwrap
import tokenize
from collections.abc import Callable, Mapping
from types import ModuleType

from robot_perception.chapters.people_fusion import committee
from robot_perception.chapters.people_fusion.committee import ALL, Comparison, Rates, System
from robot_perception.chapters.people_sensors import hearing, sessions
from robot_perception.chapters.people_sensors.hearing import PAIR, Ears, with_microphones
from robot_perception.chapters.people_sensors.sessions import PAPER
from robot_perception.evaluation.intervals import Interval, bootstrap_ratio, exact
from robot_perception.people import sound
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.verdicts import Accepted

SILENT = {
    getattr(tokenize, name)
    for name in ("COMMENT", "NL", "NEWLINE", "INDENT", "DEDENT", "ENDMARKER")
}
"""Tokens that make a line no line of code."""
JOINING = with_microphones, hearing.heard.__wrapped__, hearing.joined
WITHOUT, FOUR, TWO = "three sensors", "and four microphones", "and a pair of them"


def rows(elsewhere: bool = False) -> tuple[committee.Row, ...]:
    """Return the committee without and with microphones."""
    hears = with_microphones(committee.RULES)
    systems = {
        WITHOUT: System(),
        FOUR: System(hears, ears=Ears(elsewhere=elsewhere)),
        TWO: System(hears, ears=Ears(PAIR)),
    }
    return tuple((name, system, ALL) for name, system in systems.items())


def lines(*parts: Callable | ModuleType) -> int:
    """Return how many lines of some functions or modules hold code: no comments, no docstrings."""
    return sum(len(_code(textwrap.dedent(inspect.getsource(part)))) for part in parts)


def _code(source: str) -> set[int]:
    texts = [
        range(node.lineno, node.end_lineno + 1)
        for node in ast.walk(ast.parse(source))
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
    ]
    tokens = tokenize.generate_tokens(io.StringIO(source).readline)
    code = {
        n for one in tokens if one.type not in SILENT for n in range(one.start[0], one.end[0] + 1)
    }
    return code.difference(*texts)


def gained(found: Mapping[str, Rates], name: str = FOUR) -> Interval:
    """Return how right the committee is with microphones, over that without, by session."""
    return bootstrap_ratio(found[name].worth(), found[WITHOUT].worth(), "F₂ with over without")


JOINED = Study(
    committee.compare,
    Comparison(sessions.FULL, rows()),
    Comparison(sessions.QUICK[:4], rows()),
    seed=71,
)


@JOINED.claim(
    "another-sensor",
    paper=PAPER,
    place="§1, §4, §5",
    basis="substitute",
    statement="A further sensor, microphones, that joins by its detections and its rules alone "
    "improves the tracking.",
    paper_value="“simple expandability … like sound sources”, which “will further improve the "
    "performance”; no number",
    method="Rendered voices and echoes at four microphones, a direction of whoever speaks four "
    "times a second, joined to laser, sonars and camera by one more entry in the rules: F₂ with "
    "them over F₂ without, over the same sessions.",
    accepted=Accepted(1.0, float("inf"), "better with them than without", "theory"),
    sabotage=Change("microphones that hear people of another office", rows=rows(elsewhere=True)),
    value=gained,
)
def another_sensor(found: Mapping[str, Rates], value: Interval) -> Finding:
    """Compare the committee with and without microphones, and count what they took."""
    with_, without = found[FOUR], found[WITHOUT]
    return Finding(
        value,
        {
            "with a pair": gained(found, TWO),
            "people tracked, with over without": bootstrap_ratio(with_.matched, without.matched),
            "false hypotheses, with over without": bootstrap_ratio(
                with_.hypotheses - with_.matched, without.hypotheses - without.matched
            ),
            "lines of code to join": exact(lines(*JOINING)),
            "lines of code of their detector": exact(lines(sound)),
        },
        {"members": committee.table(found, "mean and 95 % bootstrap interval", "sensors")},
    )
