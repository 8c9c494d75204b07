"""The chapters: studies and claims of their notebooks, drawings and films in a package each.

The study cells of a chapter's notebook are its module (:mod:`robot_perception.book`); claims are
found there in the order of their declarations. Recordings are found in the module ``recordings`` of
its package, in its notebook, and in further notebooks that a package names in ``PAGES``. Before the
chapters stand the pages of the primer: notebooks of the same form, without a paper and without
claims.
"""

from collections.abc import Iterable
from importlib import import_module
from importlib.util import find_spec
from pkgutil import iter_modules
from types import ModuleType

from robot_perception.project import BOOK
from studies.claims import Claim, claims_in
from studies.stored.recorded import Recorded
from studies.stored.recordings import Recording
from studies.trials import Trials

PRIMER = ("one_belief", "many_numbers", "many_guesses")
"""Stems of the pages before the chapters, which teach what several of them need."""

CHAPTERS = (
    "walls",
    "monobot",
    "anchored_slam",
    "loop_closing",
    "sift_association",
    "visual_slam",
    "map_localisation",
    "look_alikes",
    "covariance_intersection",
    "people_sensors",
    "people_fusion",
    "head_tracking",
    "colour_and_shape",
    "pattern_tracking",
    "ceiling_navigation",
    "tutor_face",
    "tutor_following",
    "arm_likelihoods",
    "arm_tracking",
    "one_world",
    "exchanged_parts",
    "companion_day",
)
"""Stems of the chapters, in the order of the book."""


def module(stem: str) -> ModuleType:
    """Return the module of the study cells of a chapter.

    Raises
    ------
    ValueError
        If the book has no such chapter.
    """
    if stem not in (*PRIMER, *CHAPTERS):
        raise ValueError(f"no chapter {stem!r}; the book has {', '.join(CHAPTERS)}")
    return import_module(f"{BOOK}{stem}")


def trials(stems: Iterable[str] = CHAPTERS) -> tuple[Trials, ...]:
    """Return the studies of rows of chapters, and their variants: those of claims' sabotages, too.

    Raises
    ------
    ValueError
        If the book has no such chapter.
    """
    found: dict[tuple[str, str, str], Trials] = {}
    for own in map(module, stems):
        changed = (change.study for claim in claims_in(own) for change in claim.sabotages)
        for value in (*vars(own).values(), *changed):
            if isinstance(value, Trials):
                found.setdefault((value.stem, value.name, value.changed), value)
    return tuple(found.values())


def titles() -> dict[str, str]:
    """Return the titles of the chapters by stem, in the order of the book.

    A title is what stands before the colon in the first line of the chapter's package.
    """
    packages = {stem: import_module(f"{__name__}.{stem}") for stem in CHAPTERS}
    return {stem: package.__doc__.partition(":")[0] for stem, package in packages.items()}


def claims(stems: Iterable[str] = CHAPTERS) -> tuple[Claim, ...]:
    """Return the claims of chapters in the order of the book.

    Raises
    ------
    ValueError
        If two claims share an identifier, or the book has no such chapter.
    """
    found = tuple(claim for stem in stems for claim in claims_in(module(stem)))
    ids = [claim.id for claim in found]
    twice = sorted({i for i in ids if ids.count(i) > 1})
    if twice:
        raise ValueError(f"claims declared twice: {', '.join(twice)}")
    return found


def recordings(stems: Iterable[str] = CHAPTERS) -> tuple[Recording, ...]:
    """Return the real recordings of chapters, those of their further pages too.

    Raises
    ------
    ValueError
        If the book has no such chapter.
    """
    found: dict[int, Recording] = {}  # one that several modules hold, once
    for stem in stems:
        own = module(stem)  # an unknown chapter is an error, not an empty answer
        name = f"{__name__}.{stem}.recordings"
        parts = [import_module(name)] if find_spec(name) is not None else []
        for values in (vars(part).values() for part in (*parts, own, *pages(stem))):
            found |= {id(value): value for value in values if isinstance(value, Recording)}
    return tuple(found.values())


def pages(stem: str) -> tuple[ModuleType, ...]:
    """Return the study cells of a chapter's further pages, which its package names in ``PAGES``."""
    package = import_module(f"{__name__}.{stem}")
    return tuple(import_module(f"{BOOK}{page}") for page in getattr(package, "PAGES", ()))


def states(stems: Iterable[str] = CHAPTERS) -> tuple[Recorded, ...]:
    """Return the functions of chapters of which some results are stored with the book.

    Raises
    ------
    ValueError
        If the book has no such chapter.
    """
    found: dict[str, Recorded] = {}
    for stem in stems:
        own = module(stem)  # an unknown chapter is an error, not an empty answer
        package = import_module(f"{__name__}.{stem}")
        parts = iter_modules(package.__path__, f"{package.__name__}.")
        modules = (*(import_module(part.name) for part in parts), own)
        for values in (vars(one).values() for one in modules):
            found |= {value.store: value for value in values if isinstance(value, Recorded)}
    return tuple(found.values())
