"""A stranger's script uses `explorables` alone: the one of its README, and the page it writes."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from bs4 import BeautifulSoup
from playwright.sync_api import Browser

from explorables.pages import page
from tests.site.browser import WINDOW

LIB = Path(__file__).parents[2] / "lib"
ALONE = """
import sys
for name in ("robot_perception", "data_synth", "studies"):
    sys.modules[name] = None  # importing it raises
exec(compile(sys.stdin.read(), "script.py", "exec"))
"""


def script() -> str:
    """Return the first script of the README."""
    text = (LIB / "explorables" / "README.md").read_text("utf-8")
    return re.search(r"```python\n(.*?)```", text, re.S)[1]


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page that the script writes."""
    folder = tmp_path_factory.mktemp("stranger")
    run = subprocess.run(
        [sys.executable, "-c", ALONE],
        input=script(),
        cwd=folder,
        env={"PYTHONPATH": str(LIB), "HOME": str(folder), "PATH": ""},
        capture_output=True,
        text=True,
    )
    assert run.returncode == 0, run.stderr
    (file,) = folder.glob("*.html")
    return file


def test_a_script_of_ten_lines_draws_an_explorer_with_two_sliders():
    lines = [line for line in script().splitlines() if line and "import" not in line]
    assert len(lines) <= 10
    assert script().count("slider(") == 2


def test_the_page_holds_all_that_it_needs(written: Path):
    text = written.read_text("utf-8")
    made = BeautifulSoup(text, "html.parser")
    assert made.title.text == "A wave"
    assert made.h1.text == "A wave"
    assert len(made.select("div.explorer")) == 1
    assert made.select_one(".rp-canvas svg")["aria-label"].startswith("A sine wave that reaches 2")
    assert made.select_one("script.rp-states")
    assert not [
        tag
        for tag in made.select("[src], link[href]")
        if not tag.get("src", "").startswith("data:")
    ]
    assert not re.search("robot.?perception", text, re.I)


def test_the_page_is_alive_from_the_disk(written: Path, browser: Browser):
    asked: list[str] = []
    wrong: list[str] = []
    with browser.new_context(viewport=WINDOW) as context:
        opened = context.new_page()
        opened.on("request", lambda request: asked.append(request.url))
        opened.on("pageerror", lambda error: wrong.append(f"{error}"))
        opened.goto(written.as_uri())
        sliders = opened.locator("input[type=range]")
        assert sliders.count() == 2
        drawing = opened.locator(".rp-canvas svg")
        before = drawing.inner_html()
        assert drawing.get_attribute("aria-label").endswith("2.0 at its highest.")
        sliders.first.press("ArrowRight")
        opened.wait_for_function(
            "document.querySelector('.rp-canvas svg').ariaLabel.includes('3.0')"
        )
        assert drawing.inner_html() != before
    assert not wrong
    assert asked == [written.as_uri()]


def test_a_part_without_html_is_refused():
    with pytest.raises(TypeError, match=r"a part must be a text or have HTML, got 3"):
        page("<p>words</p>", 3, title="A page")
