"""Choose the pages that are visited: those changed since they were found sound, and a few drawn.

What was found sound is kept beside the build: for each visit a digest of the page, of the scripts
and style sheets that every page has, and of what the visit checks. A new clone keeps nothing: there
the front page, the scorecard and a few pages that the commit draws are visited, and the others
count as sound as they were first built. ``make test-all`` visits all.
"""

import fcntl
import hashlib
import os
import re
import subprocess
from collections.abc import Collection, Iterable
from functools import cache
from pathlib import Path
from random import Random

ROOT = Path(__file__).parents[2]
VISITS = "tests/site/test_pages.py::test_page"
DRAWN = 6
"""Pages that the commit draws, whatever has changed."""
RUN = os.environ.get("PYTEST_XDIST_TESTRUNUID", f"process {os.getpid()}")
"""The run of tests, one word for all its workers: they must choose the same visits."""
_NAMED = re.compile(r"\[(?P<page>.+)\]$")


class Sound:
    """Visits that found a page sound, kept in a folder, a file each.

    Parameters
    ----------
    site
        The built site.
    folder
        Where they are kept.
    run
        The run of tests that asks; its workers ask at the same time.
    """

    def __init__(self, site: Path, folder: Path, run: str = RUN) -> None:
        self._site, self._folder, self._run = site, folder, run

    def begin(self, visits: Iterable[str]) -> bool:
        """Tell whether nothing was kept before this run; then count all visits as sound.

        Nothing is kept where the clone is new, or the build was removed. The worker that comes
        first begins, under a lock; another one of its run is told the same.
        """
        self._folder.parent.mkdir(parents=True, exist_ok=True)
        begun = self._folder / "begun"
        with self._folder.with_name(f"{self._folder.name}.lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not self._folder.is_dir():
                self._folder.mkdir()
                for visit in visits:
                    self.note(visit)
                begun.write_text(self._run, encoding="utf-8")
            return begun.exists() and begun.read_text("utf-8") == self._run

    def note(self, visit: str) -> None:
        """Keep that a visit found its page sound."""
        self._folder.mkdir(parents=True, exist_ok=True)
        self._file(visit).write_text(self._digest(visit), encoding="utf-8")

    def forget(self, visit: str) -> None:
        """Keep no longer that a visit found its page sound."""
        self._file(visit).unlink(missing_ok=True)

    def knows(self, visit: str) -> bool:
        """Tell whether a visit found this page sound, by these checks."""
        file = self._file(visit)
        return file.exists() and file.read_text("utf-8") == self._digest(visit)

    def _file(self, visit: str) -> Path:
        return self._folder / hashlib.sha256(visit.encode()).hexdigest()[:20]

    def _digest(self, visit: str) -> str:
        page = self._site / f"{page_of(visit)}.html"
        content = page.read_bytes() if page.exists() else b""
        return hashlib.sha256(content + _shared(self._site).encode()).hexdigest()


@cache
def _shared(site: Path) -> str:
    """Hash what all pages share, and what the visits check."""
    digest = hashlib.sha256()
    scripts = (p for p in (site / "_static").rglob("*") if p.suffix in (".css", ".js"))
    own = (p for p in scripts if "explorers" not in p.parts)  # a page's own, named by content
    for file in sorted((*own, *Path(__file__).parent.glob("*.py"))):
        digest.update(file.read_bytes())
    return digest.hexdigest()


def page_of(visit: str) -> str:
    """Return the page of a visit, the value of its test; of a test without one its own name."""
    named = _NAMED.search(visit)
    return named["page"] if named else visit


def chosen(
    visits: Iterable[str], sound: Sound, pages: Collection[str], always: Collection[str], word: str
) -> list[str]:
    """Return which visits are made.

    Parameters
    ----------
    visits
        Identifiers of all tests that visit a page.
    sound
        What is kept of earlier visits.
    pages
        All pages, of which some are drawn.
    always
        Pages that are visited whatever has changed.
    word
        By which pages are drawn.
    """
    visits = list(visits)
    drawn = {*always, *Random(word).sample(sorted(pages), min(DRAWN, len(pages)))}
    is_new = sound.begin(visits)
    return [v for v in visits if page_of(v) in drawn or not (is_new or sound.knows(v))]


def commit() -> str:
    """Return the commit that is tested; without git a word that stays."""
    said = subprocess.run(["git", "rev-parse", "HEAD"], cwd=ROOT, capture_output=True, text=True)
    return said.stdout.strip() or "no commit"
