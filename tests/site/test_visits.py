"""What checks the pages is checked: planted errors are found, and all of them are told."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import pytest
from playwright.sync_api import Browser, Page

from tests.conftest import Scheduling
from tests.site import folder, served, unscripted
from tests.site.accessibility import DISTINCT, serious, violations
from tests.site.browser import TELEPHONE
from tests.site.conftest import Visit
from tests.site.contents import NOTEBOOKS
from tests.site.driver import faults
from tests.site.measures import ALIGNED, EQUATIONS, LETTERS, SETTLED, SMALLEST_PX
from tests.site.served import DARK, LIGHT, PHONE
from tests.site.visits import Broken, Check, findings, measured

MAIN = "document.querySelector('main')"


def letters(page: Page) -> list[str]:
    """Return what is wrong with the letters of a page."""
    return page.evaluate(f"(smallest) => ({LETTERS})([smallest, {MAIN}])", SMALLEST_PX)


def test_letters_that_are_too_small_are_found(visit: Callable[..., Visit], address: str) -> None:
    """The measure of letters measures: a picture made narrow has letters that are too small."""
    page = visit(viewport=TELEPHONE).open(f"{address}{NOTEBOOKS[0]}.html")
    page.evaluate(SETTLED)
    page.add_style_tag(content=".rp-svg { width: 120px !important; flex: none !important; }")
    assert any(found.endswith("px") for found in letters(page))
    page.add_style_tag(content=".rp-svg { width: 340px !important; --rp-text: 2.5 !important; }")
    found = letters(page)
    assert {words for line in found for words in ("overlap", "leaves") if words in line} == {
        "overlap",
        "leaves",
    }


def test_equations_and_words_out_of_place_are_found(
    visit: Callable[..., Visit], address: str
) -> None:
    """The measures measure: boxes that shrink and columns at the right are seen."""
    page = visit().open(f"{address}walls.html")
    page.add_style_tag(content="div.math > * { flex: none !important; }")
    page.add_style_tag(content=".rp-table td { text-align: right !important; }")
    assert page.evaluate(EQUATIONS)
    assert page.evaluate(ALIGNED)


COLOURS = """
<style>p { color: #767676 } .pale p { color: #999 } .over { position: absolute }</style>
<main><h1>A page</h1><p>Read.</p><p>Read.</p><p class="over">Read.</p><p class="over">Read.</p>
<div class="pale"><p>x</p><p>Pale.</p><p>Pale.</p></div></main>
"""


def test_of_texts_that_look_alike_one_is_judged(browser: Browser) -> None:
    """A text that is too pale is found, once; one that may lie over others is like none."""
    page = browser.new_page()
    page.set_content(COLOURS)
    assert len(page.evaluate(DISTINCT)) == len(["h1", "Read.", "over", "over", "x", "Pale."])
    for theme in ("light", "dark"):
        found = serious(violations(page, theme))
        assert [line.rpartition(">Pale")[1] for line in found if "contrast" in line] == [">Pale"]
    page.close()


DRIVEN = {"name": "fig-a", "controls": 1, "states": 3, "wrong": []}
STUCK = DRIVEN | {"wrong": ["nothing moves the picture"]}
STANDS = {"name": "fig-a", "visible": True, "alt": "A line through the origin.", "inputs": 0}
NODE = {"target": ["p"], "html": "<p>"}


def violation(impact: str) -> list[dict[str, Any]]:
    """Return what axe finds."""
    return [{"impact": impact, "id": "contrast", "help": "See", "nodes": [NODE]}]


@pytest.mark.parametrize(
    ("judge", "sound", "planted"),
    [
        (served.other_theme, ["dark", "dark"], [["dark", "light"], ["dark", None]]),
        (served.serious, violation("minor"), [violation("serious"), violation("critical")]),
        (served.of_another_theme,
         [{"drawn": True, "dark": True}, {"drawn": False, "dark": False}],
         [[{"drawn": True, "dark": False}], [{"drawn": False, "dark": True}]]),
        (served.too_long, [served.MOST_ROWS], [[served.MOST_ROWS, served.MOST_ROWS + 1]]),
        (served.not_in_a_line, [[5, 5]], [[[5, 5], [5, 6]]]),
        (served.not_one_under_the_other, [[5, 9]], [[[5, 5]], [[9, 5]]]),
        (served.too_high, [{"name": "a", "height": 800}], [[{"name": "a", "height": 801}]]),
        (served.badly_moved, [DRIVEN], [[DRIVEN, STUCK]]),
        (served.badly_driven, {"expected": 1, "driven": [DRIVEN]},
         [{"expected": 2, "driven": [DRIVEN]}, {"expected": 1, "driven": [STUCK]}]),
        (served.unlike_paper, {"buttons of the header": 0, "controls": 0, "titles": 1},
         [{"buttons of the header": 1, "controls": 0, "titles": 1},
          {"buttons of the header": 0, "controls": 2, "titles": 1},
          {"buttons of the header": 0, "controls": 0, "titles": 0}]),
        (served.not_the_notebook, [True, True], [[False, True], [True, False]]),
        (folder.unmoved, [{"name": "a", "complaint": "", "still": False}],
         [[{"name": "a", "complaint": "No.", "still": False}],
          [{"name": "a", "complaint": "", "still": True}]]),
        (unscripted.not_the_default, {"expected": 1, "found": [STANDS]},
         [{"expected": 2, "found": [STANDS]},
          {"expected": 1, "found": [STANDS | {"visible": False}]},
          {"expected": 1, "found": [STANDS | {"alt": "A line."}]},
          {"expected": 1, "found": [STANDS | {"inputs": 1}]}]),
        (faults, {"complaint": "", "area": 1001, "marks": 1, "alt": 20 * "a", "finite": True},
         [{"complaint": "No.", "area": 1001, "marks": 1, "alt": 20 * "a", "finite": True},
          {"complaint": "", "area": 1000, "marks": 1, "alt": 20 * "a", "finite": True},
          {"complaint": "", "area": 1001, "marks": 0, "alt": 20 * "a", "finite": True},
          {"complaint": "", "area": 1001, "marks": 1, "alt": None, "finite": True},
          {"complaint": "", "area": 1001, "marks": 1, "alt": 19 * "a", "finite": True},
          {"complaint": "", "area": 1001, "marks": 1, "alt": 20 * "a", "finite": False}]),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)  # fmt: skip
def test_a_planted_fact_is_one_finding(
    judge: Callable[[Any], Any], sound: Any, planted: list[Any]
) -> None:
    """What is sound is no finding; what is not is one."""
    assert list(judge(sound)) == []
    assert [len(list(judge(fact))) for fact in planted] == [1] * len(planted)


def test_every_judgement_is_tried() -> None:
    """A check that judges has a planted fact above."""
    tried = test_a_planted_fact_is_one_finding.pytestmark[0].args[1]
    checks = (*served.CHECKS, *folder.CHECKS, *unscripted.CHECKS)
    assert {check.wrong for check in checks} - {list} <= {case[0] for case in tried}


class Still:
    """A page that is not in a browser."""

    name = "walls"
    stage = DARK

    def enter(self, stage: object) -> None:
        """Stand as asked."""
        self.stage = stage


def fails(at: Still) -> list[str]:
    """Break off."""
    raise LookupError(f"no figure in the {at.stage.name}")


def test_all_is_told_though_a_check_breaks_off() -> None:
    """Findings name their stage and check, in their order; a check is made where it belongs."""
    asked = Check("asked", (LIGHT,), lambda at: [at.stage.name, "light"], served.other_theme)
    checks = [
        Check("broken", (DARK, PHONE), fails),
        replace(asked, pages=("monobot",), name="elsewhere"),
        asked,
        Check("fine", (LIGHT,), lambda at: []),
    ]
    facts = measured(Still(), (DARK, LIGHT, PHONE), checks)
    assert facts["dark", "broken"] == Broken("LookupError: no figure in the dark")
    assert list(findings(facts, checks)) == [
        "dark, broken: broke off: LookupError: no figure in the dark",
        "window, asked: light in place of window",
        "telephone, broken: broke off: LookupError: no figure in the telephone",
    ]


def test_any_worker_takes_the_next_page() -> None:
    """A file is one worker's, but for visits of pages."""
    scheduling = object.__new__(Scheduling)
    files = ("tests/site/test_pages.py::test_page[walls]", "tests/test_kalman.py::test_predict[2]")
    assert list(map(scheduling._split_scope, files)) == [files[0], "tests/test_kalman.py"]
