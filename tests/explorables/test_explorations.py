"""An explorer as one object, and drawings with their words."""

import json
from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest

from explorables import explore
from explorables.controls import slider, toggle
from explorables.explorations import Exploration
from explorables.figures import drawn, figure
from explorables.figures.output import PAGE_VARIABLE
from explorables.snapshots import STATES, snapshot

COMPUTED: list[dict] = []


@dataclass(frozen=True)
class State:
    height: float
    up: bool


def state(height: float, up: bool) -> State:
    COMPUTED.append({"height": height, "up": up})
    return State(height, up)


def draw(ax, shown: State) -> None:
    ax.clear()
    ax.plot([0, 1], [0, shown.height if shown.up else -shown.height])


def made(**changes) -> Exploration:
    COMPUTED.clear()
    fields = {
        "draw": draw,
        "state": state,
        "alt": lambda shown: f"A line that rises by {shown.height:g} over its length.",
        "controls": {"height": slider("Height", (1, 2, 3), 2), "up": toggle("Up", True)},
        "presets": {"high": {"height": 3}},
        "caption": "A line.",
        "finding": lambda shown: shown.height**2,
        "axes": partial(figure, height=2.0),
    }
    return Exploration(**(fields | changes))


def test_its_explorer_has_its_controls_words_and_presets():
    explorer = made().show()
    assert explorer.defaults == {"height": 2.0, "up": True} == made().default
    assert explorer.presets == {"high": {"height": 3.0, "up": True}}
    assert "rises by 3" in explorer.frame(height=3).alt


def test_drawing_and_words_share_a_state():
    explorer = made().show()
    COMPUTED.clear()
    explorer.frame(height=3)
    assert COMPUTED == [{"height": 3.0, "up": True}]


def test_the_finding_is_told_for_all_states_or_some():
    assert made().found() == [1.0, 1.0, 4.0, 4.0, 9.0, 9.0]
    assert made().found(up=True, height=3) == [9.0]
    assert list(made().parameters(height=1)) == [
        {"height": 1.0, "up": False},
        {"height": 1.0, "up": True},
    ]


def test_a_page_carries_what_its_states_say_and_computes_each_once(monkeypatch):
    monkeypatch.setenv(PAGE_VARIABLE, "1")
    asked = []
    some = made(name="rise", finds=lambda found: not asked.append(found))
    explorer = some.show()
    assert list(some.parameters()) == COMPUTED
    text = explorer.metadata_of_output[STATES]
    said = json.loads(text)
    assert said["name"] == "rise"
    assert said["findings"] == [1.0, 1.0, 4.0, 4.0, 9.0, 9.0] == asked[0]
    assert said["words"][-1] == "A line that rises by 3 over its length."
    assert said == snapshot("rise", some.said())
    shown = []
    monkeypatch.setattr(explore, "display", lambda *data, **options: shown.append(options))
    some._ipython_display_()
    assert [options["metadata"] for options in shown] == [{STATES: text}]


def test_a_page_whose_finding_is_not_there_is_not_built(monkeypatch):
    some = made(name="rise", finds=lambda found: max(found) < 9)
    assert not some.show().metadata_of_output
    monkeypatch.setenv(PAGE_VARIABLE, "1")
    with pytest.raises(AssertionError, match="rise: our finding does not hold"):
        some.show()


def test_a_state_is_drawn_and_described_without_a_widget():
    some = made()
    (line,) = some.drawn(height=3).lines
    assert line.get_ydata()[1] == 3
    assert some.described(up=False) == "A line that rises by 2 over its length."
    assert (
        made(alt="A line, and no more than that.").described() == "A line, and no more than that."
    )


def test_an_image_needs_no_axes():
    some = made(
        axes=None,
        draw=lambda shown: np.full((4, 6), int(shown.height), np.uint8),
        pixelated=True,
        lossless=True,
    )
    assert some.drawn(height=3)[0, 0] == 3
    assert some.show().frame(height=1).mime == "image/webp"


@drawn(
    alt=lambda gain: f"A line whose slope is {gain:g}, from the origin.",
    caption="A line.",
    name="slope",
    height=2.0,
)
def slope(ax, gain: float) -> None:
    """Draw a line."""
    ax.plot([0, 1], [0, gain])


def test_a_drawing_brings_its_axes_and_its_words():
    shown = slope(2.0)
    assert repr(shown) == "A line whose slope is 2, from the origin."
    html = shown.bundle["text/html"]
    assert 'id="fig-slope"' in html
    assert "<figcaption>A line.</figcaption>" in html
    assert slope.__doc__ == "Draw a line."


def test_a_drawing_can_be_put_on_other_axes():
    _, axes = figure(1, 2)
    slope.on(axes[1], gain=3.0)
    assert axes[1].lines[0].get_ydata()[1] == 3.0


def test_axes_can_depend_on_what_is_drawn():
    sized = drawn(
        alt="A line in axes of its size.", axes=lambda ax_height: figure(height=ax_height)
    )(lambda ax, ax_height: ax.plot([0, 1], [0, ax_height]))
    assert 'viewBox="0 0 403.2 288' in sized(4.0).bundle["text/html"]


def test_words_that_say_nothing_are_refused():
    with pytest.raises(ValueError, match="alt must say what the figure shows"):
        drawn(alt="line")(lambda ax: None)()
