"""The scorecard in a real browser: chosen by keyboard, linked to, without scripts, on paper."""

import re
from collections.abc import Callable
from pathlib import Path

from playwright.sync_api import Page, expect

from robot_perception.teaching.badges import recorded
from tests.site.conftest import Visit
from tests.site.test_pages import WIDE_ELEMENTS, violations

CLAIMS = recorded().entries


def shown(page: Page) -> list[str]:
    """Return the claims whose cards are shown."""
    return page.eval_on_selector_all(".rp-claim", "c => c.filter(x => !x.hidden).map(x => x.id)")


def test_claims_are_chosen_by_keyboard_and_counted(
    visit: Callable[..., Visit], address: str
) -> None:
    page = visit().open(f"{address}scorecard.html")
    assert shown(page) == [entry.id for entry in CLAIMS]
    reproduced = sum(entry.verdict == "reproduced" for entry in CLAIMS)
    counts = re.findall(rf"\b{reproduced}\s+reproduced", page.locator("main").inner_text())
    assert len(counts) == 1
    page.get_by_role("radio", name=re.compile("^all")).first.focus()
    for _ in range(2):
        page.keyboard.press("ArrowRight")
        name = page.evaluate("document.activeElement.value")
        wanted = [entry.id for entry in CLAIMS if entry.verdict == name]
        assert 0 < len(wanted) < len(CLAIMS)
        assert shown(page) == wanted
        expect(page.get_by_role("status")).to_have_text(f"{len(wanted)} of {len(CLAIMS)} claims")
    chapters = {entry.chapter for entry in CLAIMS if entry.id in wanted}
    expect(page.locator(".rp-scorecard section:visible")).to_have_count(len(chapters))
    paper = page.locator("input[name=paper]").last
    paper.focus()
    page.keyboard.press("Space")
    both = [e.id for e in CLAIMS if e.id in wanted and e.paper == paper.get_attribute("value")]
    assert shown(page) == both


def test_a_link_to_a_claim_shows_and_opens_its_card(
    visit: Callable[..., Visit], site: Path
) -> None:
    last, first = CLAIMS[-1], CLAIMS[0]
    page = visit().open(f"{(site / 'scorecard.html').as_uri()}#{last.id}")
    card = page.locator(f"#{last.id}")
    expect(card).to_be_in_viewport()
    expect(card.locator("dl").last).to_be_visible()
    other = next(entry.verdict for entry in CLAIMS if entry.verdict != first.verdict)
    page.locator(f"input[name=verdict][value='{other}']").focus()
    page.keyboard.press("Space")
    expect(page.locator(f"#{first.id}")).to_be_hidden()
    page.evaluate("name => { location.hash = name; }", first.id)
    expect(page.locator(f"#{first.id}")).to_be_in_viewport()
    expect(page.locator(f"#{first.id} > details")).to_have_attribute("open", "")
    assert len(shown(page)) == len(CLAIMS)


def test_all_cards_open_on_a_telephone_fit_it_and_satisfy_axe(
    visit: Callable[..., Visit], address: str
) -> None:
    page = visit(viewport={"width": 390, "height": 844}).open(f"{address}scorecard.html")
    page.get_by_role("button", name="Open all").click()
    expect(page.locator(".rp-claim > details[open]")).to_have_count(len(CLAIMS))
    wide = page.evaluate(WIDE_ELEMENTS)
    assert not wide, "\n".join(wide)
    moved = """() => [...document.querySelectorAll(".rp-claim *")].filter(
      (e) => !e.closest(".rp-table") && e.scrollWidth > e.clientWidth + 1
        && ["auto", "scroll"].includes(getComputedStyle(e).overflowX)).map((e) => e.outerHTML)"""
    assert page.evaluate(moved) == []
    assert violations(page) == []


def test_without_scripts_all_cards_are_there_and_the_page_says_what_is_missing(
    visit: Callable[..., Visit], address: str
) -> None:
    page = visit(java_script_enabled=False).page
    page.goto(f"{address}scorecard.html")
    expect(page.locator(".rp-claim:visible")).to_have_count(len(CLAIMS))
    expect(page.locator(".rp-filter")).to_be_hidden()
    expect(page.get_by_text("Your browser runs no scripts.")).to_be_visible()


def test_on_paper_there_are_cards_without_controls(
    visit: Callable[..., Visit], address: str
) -> None:
    page = visit().open(f"{address}scorecard.html")
    page.locator(".rp-claim summary").first.click()
    page.emulate_media(media="print")
    expect(page.locator(".rp-claim:visible")).to_have_count(len(CLAIMS))
    expect(page.locator(".rp-claim > details:visible")).to_have_count(1)
    expect(page.locator(".rp-claim summary:visible")).to_have_count(0)
    expect(page.locator(".rp-filter")).to_be_hidden()
