"""The chapters: studies and claims of their notebooks, drawings and films in a package each.

The study cells of a chapter's notebook are its module (:mod:`robot_perception.book`); claims are
found there in the order of their declarations. A chapter that is not in this form yet has a package
that names its modules in ``STUDIES``. Recordings are found in its module ``recordings``, in its
notebook, and in further notebooks that a package names in ``PAGES``. Before the chapters stand the
pages of the primer: notebooks of the same form, without a paper and without claims.
"""

from collections.abc import Iterable
from importlib import import_module
from importlib.util import find_spec
from pkgutil import iter_modules
from types import ModuleType

from robot_perception.teaching.cells import BOOK
from robot_perception.teaching.recorded import Recorded
from robot_perception.teaching.recordings import Recording
from robot_perception.teaching.studies import Claim, claims_in
from robot_perception.teaching.trials import Trials

PRIMER = ("one_belief", "many_guesses")
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
)
"""Stems of the chapters, in the order of the book."""


def studies(stem: str) -> tuple[ModuleType, ...]:
    """Return the modules of a chapter that declare claims, in the order of the chapter.

    Of a chapter whose notebook computes that is the module of its study cells.

    Raises
    ------
    ValueError
        If the book has no such chapter.
    """
    if stem not in (*PRIMER, *CHAPTERS):
        raise ValueError(f"no chapter {stem!r}; the book has {', '.join(CHAPTERS)}")
    package = import_module(f"{__name__}.{stem}")
    if not hasattr(package, "STUDIES"):
        return (import_module(f"{BOOK}{stem}"),)
    return tuple(import_module(f"{package.__name__}.{name}") for name in package.STUDIES)


def trials(stems: Iterable[str] = CHAPTERS) -> tuple[Trials, ...]:
    """Return the studies of rows of chapters, and their variants: those of claims' sabotages, too.

    Raises
    ------
    ValueError
        If the book has no such chapter.
    """
    found: dict[tuple[str, str, str], Trials] = {}
    for module in (module for stem in stems for module in studies(stem)):
        claims = claims_in(module)
        values = [*vars(module).values(), *(change.study for c in claims for change in c.sabotages
                  if isinstance(c.study, Trials))]  # fmt: skip
        for value in values:
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
    found = tuple(c for stem in stems for study in studies(stem) for c in claims_in(study))
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
        own = studies(stem)  # an unknown chapter is an error, not an empty answer
        name = f"{__name__}.{stem}.recordings"
        parts = [import_module(name)] if find_spec(name) is not None else []
        for values in (vars(module).values() for module in (*parts, *own, *pages(stem))):
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
        own = studies(stem)  # an unknown chapter is an error, not an empty answer
        package = import_module(f"{__name__}.{stem}")
        parts = iter_modules(package.__path__, f"{package.__name__}.")
        modules = (*(import_module(part.name) for part in parts), *own)
        for values in (vars(module).values() for module in modules):
            found |= {value.store: value for value in values if isinstance(value, Recorded)}
    return tuple(found.values())
