"""Bets and the words between figures: keys, speech, paper, phone, themes, without scripts."""

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, Page

from explorables.bets import bet
from tests.site import extra
from tests.site.accessibility import serious, violations
from tests.site.conftest import Visit
from tests.site.measures import WIDE_ELEMENTS

COLOUR = "(node, name) => getComputedStyle(node).getPropertyValue(name)"
PLAIN = {"one": "It is too small.", "two": "So it is.", "three": "It is too large."}


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page of words."""
    return extra.build("words", tmp_path_factory.mktemp("words"))


@pytest.fixture
def enter(browser: Browser, built: Path) -> Iterator[Callable[..., Visit]]:
    """Open the page from disk; keyword arguments go to the browser context."""
    with extra.visits(browser, built) as make:
        yield make


def asked(page: Page) -> list[Locator]:
    """Return the bets of a page."""
    found = page.locator(".rp-bet").all()
    assert len(found) == 2
    return found


def told(root: Locator) -> list[str]:
    """Return the replies of a bet that can be seen."""
    replies = root.locator(".rp-reply").all()
    return [reply.inner_text() for reply in replies if reply.is_visible()]


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_the_page_is_sound(enter: Callable[..., Visit], theme: str) -> None:
    """No error, no other host, nothing that axe finds, and it fits a telephone."""
    visitor = enter(color_scheme=theme)
    page = visitor.page
    page.evaluate("async () => { await MathJax.startup.promise; }")
    for root in asked(page):
        root.locator("input").nth(1).check()
    found = serious(violations(page))
    page.set_viewport_size({"width": 390, "height": 844})
    wide = page.evaluate(WIDE_ELEMENTS)
    assert not visitor.errors
    assert not visitor.strangers
    assert not found, "\n".join(found)
    assert not wide, "\n".join(wide)


def test_a_bet_is_answered_by_keys(enter: Callable[..., Visit]) -> None:
    """Nothing is told before; space and arrows choose; one reply stands at a time."""
    page = enter().page
    coin, _ = asked(page)
    assert told(coin) == []
    coin.locator("input").first.focus()
    assert told(coin) == []
    page.keyboard.press("Space")
    assert [reply.split(".")[0] for reply in told(coin)] == ["A is wrong"]
    page.keyboard.press("ArrowDown")
    assert [reply.split(".")[0] for reply in told(coin)] == ["B is right"]
    page.keyboard.press("ArrowDown")
    assert [reply.split(".")[0] for reply in told(coin)] == ["C is wrong"]
    page.keyboard.press("ArrowUp")
    assert [reply.split(".")[0] for reply in told(coin)] == ["B is right"]


def test_a_bet_is_answered_by_its_words_and_alone(enter: Callable[..., Visit]) -> None:
    """A click on the words of an answer chooses it; the other bet stays as it is."""
    coin, other = asked(enter().page)
    other.locator("label").nth(2).click()
    assert [reply.split(".")[0] for reply in told(other)] == ["C is right"]
    assert told(coin) == []


def test_right_and_wrong_differ_in_colour(enter: Callable[..., Visit]) -> None:
    """The edge of a reply has the colour of its verdict, in each theme another one."""
    seen = set()
    for theme in ("light", "dark"):
        coin, _ = asked(enter(color_scheme=theme).page)
        for answer in range(3):
            coin.locator("input").nth(answer).check()
            reply = coin.locator(".rp-reply").nth(answer)
            seen.add((theme, answer == 1, reply.evaluate(COLOUR, "border-left-color")))
    assert len(seen) == len({colour for _, _, colour in seen}) == 4


def test_a_screen_reader_hears_the_question_and_then_one_reply(enter: Callable[..., Visit]) -> None:
    """The group is named by its question; the region that is announced holds the reply alone."""
    page = enter().page
    _, other = asked(page)
    before = other.aria_snapshot()
    assert re.search(r'group "A bet. Does a prediction make a belief surer\?"', before)
    assert before.count("- radio ") == 3
    assert '- radio "A yes, it is one step more"' in before
    assert "is wrong" not in before
    assert "is right" not in before
    other.locator("input").nth(1).check()
    status = other.aria_snapshot().partition("- status")[2]
    assert "B is wrong." in status
    assert "A is" not in status
    assert "C is" not in status


def test_mathematics_is_set(enter: Callable[..., Visit]) -> None:
    """Formulas of question, answers and replies are set, those in hidden ones too."""
    page = enter().page
    page.evaluate("async () => { await MathJax.startup.promise; }")
    coin, _ = asked(page)
    for place in ("legend mjx-container", "label mjx-container"):
        assert coin.locator(place).first.is_visible()
    assert page.locator(".rp-reply mjx-container").count() > 0
    assert not [text for text in page.locator(".rp-bet").all_inner_texts() if "\\(" in text]


def test_paper_has_the_answer_at_the_end_of_the_section(enter: Callable[..., Visit]) -> None:
    """In place stand question and answers, whatever was chosen; the answer stands last."""
    page = enter().page
    for root in asked(page):
        root.locator("input").nth(1).check()
    answers = page.locator(".rp-bet-answer")
    assert not answers.first.is_visible()
    page.emulate_media(media="print")
    for root in asked(page):
        assert told(root) == []
        assert not root.locator("input").first.is_visible()
        labels = root.locator("label").all()
        assert [label.is_visible() for label in labels] == [True] * 3
        assert len({label.bounding_box()["y"] for label in labels}) == 3, "two answers in a line"
    shown = page.locator("main").inner_text()
    assert not re.search(r"\b[A-F] is (right|wrong)\.", shown)
    for name, reply in (("a-coin", "Each throw halves it"), ("a-filter", "It does:")):
        section = page.locator(f"section#{name}")
        last = section.locator("> :last-child")
        assert "rp-bet-answer" in last.get_attribute("class")
        assert last.is_visible()
        assert shown.count(reply) == 1
        assert reply in last.inner_text()
    assert shown.index("The result stands below") < shown.index("Each throw halves it")


def test_a_bet_needs_no_script(enter: Callable[..., Visit]) -> None:
    """Without scripts an answer has its reply, too."""
    coin, _ = asked(enter(java_script_enabled=False).page)
    assert told(coin) == []
    coin.locator("input").nth(2).check()
    assert [reply.split(".")[0] for reply in told(coin)] == ["C is wrong"]


def test_a_listing_says_what_is_left_out(enter: Callable[..., Visit]) -> None:
    """The heading leads to the whole source; the code has no check."""
    listing = enter().page.locator(".rp-source")
    place = listing.locator(".rp-source-place")
    assert place.inner_text().endswith("; validation left out")
    assert "kalman.html#" in place.locator("a").get_attribute("href")
    code = listing.locator("pre").inner_text()
    assert code.startswith("def predict(prior, motion):")
    assert "check" not in code


def as_in_a_notebook() -> str:
    """Return a bet as a notebook shows it."""
    return bet("Which is even?", PLAIN, "two").bundle["text/html"]


def test_a_notebook_needs_nothing_but_the_output(browser: Browser) -> None:
    """Alone on a page an output hides its replies and shows the one that is asked for."""
    page = browser.new_page()
    page.set_content(f"<body>{as_in_a_notebook()}</body>")
    root = page.locator(".rp-bet")
    assert told(root) == []
    root.locator("input").nth(1).check()
    assert told(root) == ["B is right. So it is."]
    suppressed = root.locator("input").first.get_attribute("data-lm-suppress-shortcuts")
    assert suppressed == "true"
    page.close()


def test_a_sanitised_bet_can_be_read_in_order(browser: Browser) -> None:
    """Without style and inputs there are the question, the answers and the replies, a line each."""
    page = browser.new_page()
    safe = re.sub(r"<style\b.*?</style>|<input[^>]*>", "", as_in_a_notebook(), flags=re.S)
    page.set_content(f"<body>{safe}</body>")
    lines = [line.strip() for line in page.locator("body").inner_text().splitlines()]
    assert [line for line in lines if line] == [
        "A bet. Which is even?",
        "A one",
        "B two",
        "C three",
        "A is wrong. It is too small.",
        "B is right. So it is.",
        "C is wrong. It is too large.",
    ]
    page.close()
