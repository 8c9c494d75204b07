"""A visit: how a page stands, what is measured there, and what of that is wrong.

A visit opens a page once and takes it through stages: sizes of the window, themes, paper. In each
it makes the checks that are of this stage and of this page. A check reads a fact off the page; a
pure function says what of it is wrong, so that all that is wrong with a page is said together.
"""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from playwright.sync_api import Page

from tests.site.conftest import Visit
from tests.site.measures import REST, SETTLED

Facts = dict[tuple[str, str], Any]
"""What was read, by stage and check."""


@dataclass(frozen=True)
class Stage:
    """How a page is looked at.

    Parameters
    ----------
    name
        What findings call it.
    window
        Its size.
    theme
        What the reader's system prefers.
    medium
        Screen or paper.
    """

    name: str
    window: Mapping[str, int]
    theme: str = "light"
    medium: str = "screen"

    @property
    def shown(self) -> str:
        """The theme that a page should have: paper is light."""
        return "light" if self.medium == "print" else self.theme


class Standing:
    """A page of the site that is open, and how it stands.

    Parameters
    ----------
    name
        The page.
    visit
        Where it is open.
    stage
        How it was opened.
    site
        The folder of the built site.
    """

    def __init__(self, name: str, visit: Visit, stage: Stage, site: Path) -> None:
        self.name = name
        self.visit = visit
        self.stage = stage
        self.html = (site / f"{name}.html").read_text("utf-8")

    @property
    def page(self) -> Page:
        """The page in the browser."""
        return self.visit.page

    def enter(self, stage: Stage) -> None:
        """Take the page to a stage and wait until it has settled."""
        if stage == self.stage:
            return
        self.stage = stage
        self.page.emulate_media(media=stage.medium, color_scheme=stage.theme)
        self.page.set_viewport_size(stage.window)
        self.page.evaluate(SETTLED)


@dataclass(frozen=True)
class Check:
    """Something that holds on pages.

    Parameters
    ----------
    name
        What findings call it.
    stages
        Where it is made.
    read
        Returns a fact.
    wrong
        Returns what of a fact is wrong; by default a fact is a list of that.
    pages
        Where it is made, by name; by default on every page that is visited.
    moves
        Whether explorers have to be reset afterwards.
    """

    name: str
    stages: Collection[Stage]
    read: Callable[[Standing], Any]
    wrong: Callable[[Any], Iterable[str]] = list
    pages: Collection[str] | None = None
    moves: bool = False

    def is_made(self, page: str, stage: Stage) -> bool:
        """Tell whether it is made on a page in a stage."""
        return stage in self.stages and (self.pages is None or page in self.pages)


@dataclass(frozen=True)
class Broken:
    """What is known of a fact that could not be read."""

    words: str


def measured(standing: Standing, stages: Iterable[Stage], checks: Iterable[Check]) -> Facts:
    """Take a page through stages and return the facts; none is judged."""
    facts: Facts = {}
    for stage in stages:
        here = [check for check in checks if check.is_made(standing.name, stage)]
        if here:
            standing.enter(stage)
        for check in here:
            facts[stage.name, check.name] = _read(check, standing)
            if check.moves:
                standing.page.evaluate(REST)
    return facts


def _read(check: Check, standing: Standing) -> Any:
    try:
        return check.read(standing)
    except Exception as error:  # whatever it is, the other checks are made
        return Broken(f"{type(error).__name__}: {error}")


def findings(facts: Facts, checks: Iterable[Check]) -> Iterator[str]:
    """Yield what is wrong, a line each: stage, check, and where."""
    wrong = {check.name: check.wrong for check in checks}
    for (stage, name), fact in facts.items():
        broken = isinstance(fact, Broken)
        for words in [f"broke off: {fact.words}"] if broken else wrong[name](fact):
            yield f"{stage}, {name}: {words}"


def unless(holds: bool, words: str) -> list[str]:
    """Return what is wrong unless something holds."""
    return [] if holds else [words]


def script(source: str, *arguments: Any) -> Callable[[Standing], Any]:
    """Return what reads a fact by a script that runs in the page."""
    return lambda at: at.page.evaluate(source, *arguments)
