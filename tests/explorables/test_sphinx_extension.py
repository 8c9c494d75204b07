"""What the Sphinx extension of explorers does to a page: states, answers of bets, a note."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from explorables import sphinx_extension
from explorables.explore import explore, slider
from explorables.figures import figure
from explorables.figures.output import PAGE_VARIABLE
from explorables.pages import NO_SCRIPTS
from tests.unchecked import unchecked

ALT = "A line whose slope is the gain that was chosen."


def finished(body: str, folder: Path) -> dict[str, object]:
    """Return the context of a page after the extension has finished it."""
    context = {"body": body, "pathto": lambda target, _: f"../{target}"}
    app = SimpleNamespace(outdir=folder)  # all of Sphinx that is asked
    with unchecked():
        sphinx_extension._finish_page(app, "page", "page.html", context, None)
    return context


def page_of(explorer: object) -> str:
    """Return the HTML that an explorer puts on a page."""
    return explorer._repr_mimebundle_()["text/html"]


@pytest.fixture
def on_page(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let outputs be those of a built page."""
    monkeypatch.setenv(PAGE_VARIABLE, "1")


@pytest.mark.usefixtures("on_page")
def test_states_move_into_a_script_beside_the_page(tmp_path: Path):
    fig, ax = figure()

    def draw(gain):
        ax.clear()
        ax.plot([0, gain])
        return fig

    html = page_of(explore(draw, alt=ALT, gain=slider("Gain", [1, 2], 1)))
    body = finished(f"<p>before</p>{html}<p>after</p>", tmp_path)["body"]
    assert "rp-states" not in body
    assert "rp-spec" in body
    (script,) = (tmp_path / "_static" / "explorers").glob("*.js")
    assert f'data-states="../_static/explorers/{script.name}"' in body
    assert f'id="explorer-{script.stem}"' in body
    assert script.read_text().startswith(f'explorables.register("explorer-{script.stem}", "')


@pytest.mark.usefixtures("on_page")
def test_pictures_become_files(tmp_path: Path):
    def draw(grey):
        return np.full((4, 6), grey, np.uint8)

    explorer = explore(draw, alt=ALT, grey=slider("Grey", [0, 200], 0))
    finished(page_of(explorer), tmp_path)
    folder = tmp_path / "_static" / "explorers"
    (script,) = folder.glob("*.js")
    states = json.loads(script.read_text().split(", ", 1)[1].removesuffix(");\n"))
    assert [state[1:] for state in states] == [[ALT, 6, 4], [ALT, 6, 4]]
    for state, grey in zip(states, (0, 200), strict=True):
        assert (folder / state[0]).read_bytes() == explorer.frame(grey=grey).data


@pytest.mark.usefixtures("on_page")
def test_two_explorers_on_a_page_keep_their_own_states(tmp_path: Path):
    pages = [
        page_of(
            explore(
                lambda grey, low=low: np.full((4, 6), grey + low, np.uint8),
                alt=ALT,
                grey=slider("Grey", [0, 99], 0),
            )
        )
        for low in (0, 100)
    ]
    body = finished("<hr>".join(pages), tmp_path)["body"]
    assert body.count("data-states=") == 2
    assert len(list((tmp_path / "_static" / "explorers").glob("*.js"))) == 2


def test_states_that_no_page_shows_are_removed(tmp_path: Path):
    stored = tmp_path / sphinx_extension.STORED
    stored.mkdir(parents=True)
    for name in ("kept.js", "kept-0.webp", "gone.js", "gone-0.webp"):
        (stored / name).touch()
    (tmp_path / "page.html").write_text('<div data-states="_static/explorers/kept.js">')
    with unchecked():
        sphinx_extension._drop_orphans(SimpleNamespace(outdir=tmp_path), None)
    assert sorted(path.name for path in stored.iterdir()) == ["kept-0.webp", "kept.js"]


def waiting(answer: str) -> str:
    """Return a bet as a notebook puts it on a page."""
    return f'<div class="rp-bet">?</div><p class="rp-bet-answer" data-waiting>{answer}</p>'


def test_answers_of_bets_move_to_the_ends_of_their_sections(tmp_path: Path):
    inner = f"<section id='b'>{waiting('2')}<p>two</p></section>"
    outer = f"<section id='a'>{waiting('1')}<p>one</p>{waiting('3')}{inner}<p>last</p></section>"
    body = finished(f"<section>{outer}<p>end</p></section>", tmp_path)["body"]
    bet, answer = '<div class="rp-bet">?</div>', '<p class="rp-bet-answer">{}</p>'.format
    inner = f"<section id='b'>{bet}<p>two</p>{answer(2)}</section>"
    outer = f"{bet}<p>one</p>{bet}{inner}<p>last</p>{answer(1)}{answer(3)}"
    assert body == f"<section><section id='a'>{outer}</section><p>end</p></section>"


def test_an_answer_outside_of_all_sections_stays(tmp_path: Path):
    body = finished(f"{waiting('1')}<section>one</section>", tmp_path)["body"]
    assert body.startswith('<div class="rp-bet">?</div><p class="rp-bet-answer">1</p><section>')


def test_pages_with_controls_say_what_needs_scripts(tmp_path: Path):
    plain = finished("<p>words</p>", tmp_path)["body"]
    assert plain == "<p>words</p>"
    film = '<div class="rp-film">'
    assert finished(film, tmp_path)["body"] == NO_SCRIPTS + film
