"""Pages that changed are visited, and no others but those that are drawn."""

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from tests.site import choice
from tests.site.choice import VISITS, Sound, chosen, page_of

PAGES = tuple(f"page{k}" for k in range(30))
KINDS = ("", "_from_a_folder")
ALL = tuple(f"{VISITS}{kind}[{page}]" for page in PAGES for kind in KINDS)


@pytest.fixture
def sound(tmp_path: Path) -> Sound:
    """Nothing is kept yet of a site with thirty pages and one script."""
    (tmp_path / "_static").mkdir()
    (tmp_path / "_static" / "book.js").write_text("move()")
    for page in PAGES:
        (tmp_path / f"{page}.html").write_text(page)
    choice._shared.cache_clear()
    return at(tmp_path)


def at(site: Path, run: str = "first") -> Sound:
    """Return what is kept beside a site, as a run of tests meets it."""
    return Sound(site, site / "visited", run)


def visited(sound: Sound, word: str) -> set[str]:
    """Return the pages that are visited."""
    return {page_of(visit) for visit in chosen(ALL, sound, PAGES, ["page0"], word)}


def test_a_new_clone_visits_what_is_drawn_and_what_is_always_visited(sound: Sound) -> None:
    """Each commit draws others; what is visited always comes on top."""
    first, again, other = (visited(sound, word) for word in ("a", "a", "b"))
    assert first == again != other
    assert "page0" in first & other
    assert len(first) in (choice.DRAWN, choice.DRAWN + 1)
    everything = set().union(*(visited(sound, f"{k}") for k in range(60)))
    assert everything == set(PAGES)


def test_a_page_that_changed_is_visited_until_it_is_found_sound(
    sound: Sound, tmp_path: Path
) -> None:
    """A visit that failed is made again, of an unchanged page, too."""
    drawn = visited(sound, "a")
    sound = at(tmp_path, "second")
    changed = next(page for page in PAGES if page not in drawn)
    visits = [visit for visit in ALL if page_of(visit) == changed]
    (tmp_path / f"{changed}.html").write_text("other words")
    assert visited(sound, "a") == drawn | {changed}
    sound.note(visits[0])
    made = chosen(ALL, sound, PAGES, [], "a")
    assert [visit for visit in made if page_of(visit) == changed] == visits[1:]
    sound.note(visits[1])
    assert visited(sound, "a") == drawn
    sound.forget(visits[0])
    assert visited(sound, "a") == drawn | {changed}


def test_a_script_of_all_pages_changes_all(sound: Sound, tmp_path: Path) -> None:
    """What all pages share is part of each."""
    assert visited(sound, "a") != set(PAGES)
    sound = at(tmp_path, "second")
    (tmp_path / "_static" / "book.js").write_text("stand()")
    choice._shared.cache_clear()
    assert visited(sound, "a") == set(PAGES)


def test_workers_of_a_run_choose_the_same_visits(tmp_path: Path, sound: Sound) -> None:
    """However far apart they come: a second worker asks while the first still notes, or later."""
    with ThreadPoolExecutor(8) as workers:
        made = set(workers.map(lambda _: frozenset(visited(at(tmp_path), "a")), range(24)))
    assert made == {frozenset(visited(sound, "a"))}
    assert len(*made) <= choice.DRAWN + 1


def test_a_second_run_is_not_new(tmp_path: Path, sound: Sound) -> None:
    """What was not seen sound since is visited by the next run, whose workers agree, too."""
    drawn = visited(sound, "a")
    changed = next(page for page in PAGES if page not in drawn)
    (tmp_path / f"{changed}.html").write_text("other words")
    for _ in range(2):
        assert visited(at(tmp_path, "second"), "a") == drawn | {changed}
