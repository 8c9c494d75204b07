"""The scorecard in a real browser: chosen by keyboard, linked to, without scripts, on paper."""

import re
from functools import cache

from playwright.sync_api import Page, expect

from robot_perception.teaching.scores.badges import recorded
from robot_perception.teaching.scores.scorecard import grouped
from studies.ledger import Entry
from tests.site.accessibility import serious, violations
from tests.site.measures import WIDE_ELEMENTS
from tests.site.visits import Check, Stage, Standing

PAGES = ("scorecard",)
MOVED = """
() => [...document.querySelectorAll(".rp-claim *")].filter(
  (e) => !e.closest(".rp-table") && e.scrollWidth > e.clientWidth + 1
    && ["auto", "scroll"].includes(getComputedStyle(e).overflowX)).map((e) => e.outerHTML)
"""


@cache
def claims() -> tuple[Entry, ...]:
    """Return the claims that are recorded, in the order of the cards."""
    groups = (group for groups in grouped(recorded()).values() for group in groups.values())
    return tuple(entry for group in groups for entry in group)


def shown(page: Page) -> list[str]:
    """Return the claims whose cards are shown."""
    return page.eval_on_selector_all(".rp-claim", "c => c.filter(x => !x.hidden).map(x => x.id)")


def chosen_by_keyboard(at: Standing) -> list[str]:
    """Choose claims by verdict and paper, count what is shown, and choose all again."""
    page, everything = at.page, claims()
    assert shown(page) == [entry.id for entry in everything]
    reproduced = sum(entry.verdict == "reproduced" for entry in everything)
    counts = re.findall(rf"\b{reproduced}\s+reproduced", page.locator("main").inner_text())
    assert len(counts) == 1
    page.get_by_role("radio", name=re.compile("^all")).first.focus()
    for _ in range(2):
        page.keyboard.press("ArrowRight")
        name = page.evaluate("document.activeElement.value")
        wanted = [entry.id for entry in everything if entry.verdict == name]
        assert 0 < len(wanted) < len(everything)
        assert shown(page) == wanted
        told = f"{len(wanted)} of {len(everything)} claims"
        expect(page.get_by_role("status")).to_have_text(told)
    papers = {
        key
        for key, groups in grouped(recorded()).items()
        if any(entry.id in wanted for group in groups.values() for entry in group)
    }
    expect(page.locator(".rp-scorecard section:visible")).to_have_count(len(papers))
    paper = page.locator("input[name=paper]").last
    paper.focus()
    page.keyboard.press("Space")
    both = [e.id for e in everything if e.id in wanted and e.paper == paper.get_attribute("value")]
    assert shown(page) == both
    for radio in page.get_by_role("radio", name=re.compile("^all")).all():
        radio.focus()
        page.keyboard.press("Space")
    assert shown(page) == [entry.id for entry in everything]
    return []


def on_paper(at: Standing) -> list[str]:
    """Print cards, of which one is open, without controls."""
    page, first = at.page, at.page.locator(".rp-claim summary").first
    first.click()
    page.emulate_media(media="print")
    expect(page.locator(".rp-claim:visible")).to_have_count(len(claims()))
    expect(page.locator(".rp-claim > details:visible")).to_have_count(1)
    expect(page.locator(".rp-claim summary:visible")).to_have_count(0)
    expect(page.locator(".rp-filter")).to_be_hidden()
    page.emulate_media(media="screen")
    first.click()
    return []


def all_open(at: Standing) -> list[str]:
    """Open all cards and return what does not fit, has to be moved, or axe finds."""
    at.page.get_by_role("button", name="Open all").click()
    expect(at.page.locator(".rp-claim > details[open]")).to_have_count(len(claims()))
    moved = at.page.evaluate(WIDE_ELEMENTS) + at.page.evaluate(MOVED)
    return moved + serious(violations(at.page))


def linked(at: Standing) -> list[str]:
    """Follow a link to a claim, which shows and opens its card, though it was not chosen."""
    page, everything = at.page, claims()
    first, last = everything[0], everything[-1]
    card = page.locator(f"#{last.id}")
    expect(card).to_be_in_viewport()
    expect(card.locator("dl").last).to_be_visible()
    other = next(entry.verdict for entry in everything if entry.verdict != first.verdict)
    page.locator(f"input[name=verdict][value='{other}']").focus()
    page.keyboard.press("Space")
    expect(page.locator(f"#{first.id}")).to_be_hidden()
    page.evaluate("name => { location.hash = name; }", first.id)
    expect(page.locator(f"#{first.id}")).to_be_in_viewport()
    expect(page.locator(f"#{first.id} > details")).to_have_attribute("open", "")
    assert len(shown(page)) == len(everything)
    return []


def unscripted(at: Standing) -> list[str]:
    """See all cards, no control, and why."""
    expect(at.page.locator(".rp-claim:visible")).to_have_count(len(claims()))
    expect(at.page.locator(".rp-filter")).to_be_hidden()
    expect(at.page.get_by_text("Your browser runs no scripts.")).to_be_visible()
    return []


def served(window: Stage, telephone: Stage) -> tuple[Check, ...]:
    """Return what is checked where the page is served."""
    return (
        Check("cards on paper", (window,), on_paper, pages=PAGES),
        Check("claims chosen by keyboard", (window,), chosen_by_keyboard, pages=PAGES),
        Check("all cards open", (telephone,), all_open, pages=PAGES),
    )
