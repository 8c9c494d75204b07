"""Explorers: refusals, the stored grid, the live protocol, traits that can be linked."""

import base64
import gzip
import io
import json
import re

import numpy as np
import pytest
from IPython.core.interactiveshell import InteractiveShell
from IPython.utils.capture import capture_output
from ipywidgets import IntSlider, link
from PIL import Image
from traitlets import TraitError

from explorables.explore import (
    MOST_STATES,
    Drag,
    choice,
    explore,
    explorers_in,
    slider,
    timeline,
    toggle,
)
from explorables.figures import figure
from explorables.figures.output import PAGE_VARIABLE
from explorables.states import SVG, WEBP
from tests.unchecked import unchecked

ALT = "A line that rises with the gain, or falls."
FIG, AX = figure()


def line(gain, falling):
    """Draw a line of some slope."""
    AX.clear()
    AX.plot([0, 1], [0, -gain if falling else gain])
    AX.set(ylim=(-3, 3))
    return FIG


def controls():
    """Return the controls of the line."""
    return {"gain": slider("Gain", [0.5, 1, 2], 1, "m"), "falling": toggle("Falling")}


def made(**changes):
    """Return an explorer of the line."""
    return explore(line, **({"alt": ALT} | controls() | changes))


def square(size):
    """Return an image of a white square."""
    image = np.zeros((60, 80), np.uint8)
    image[10 : 10 + size, 10 : 10 + size] = 255
    return image


# ---- controls ----


def test_a_value_is_known_up_to_rounding_and_no_further():
    control = slider("Angle", [0.1, 0.3], 0.1)
    assert control.index_of(0.1 + 0.2) == 1
    with pytest.raises(ValueError, match=r"no value 0\.3001"):
        control.index_of(0.3001)


def test_sliders_show_values_with_their_unit():
    control = slider("Angle", np.linspace(-0.3, 0.3, 3), 0.3, "°")
    assert control.values == (-0.3, 0.0, 0.3)
    assert control.shown == ("−0.3°", "0°", "0.3°")
    assert control.default == 2
    assert slider("Length", [1, 2], 1, "m").shown == ("1\xa0m", "2\xa0m")


def test_integers_stay_integers():
    assert all(type(v) is int for v in slider("Looks", range(1, 4), 2).values)


def test_rounding_does_not_hide_a_default():
    values = np.arange(0, 1.05, 0.1)
    assert slider("Gain", values, 0.3).values[3] == 0.3


@pytest.mark.parametrize("unit", [1.0, 1e-9])
def test_values_that_lie_close_are_told_apart(unit):
    values = unit * np.array([1.0, 1.001, 1.002])
    for index, value in enumerate(values):
        assert slider("Gain", values, value).default == index


def test_a_toggle_is_off_and_on():
    control = toggle("Falling", True)
    assert (control.values, control.shown, control.default) == ((False, True), ("off", "on"), 1)


def test_states_share_their_identifiers():
    frames = [made().frame(gain=gain, falling=False).data.decode() for gain in (0.5, 2)]
    first, second = (set(re.findall(r' id="([^"]*)"', frame)) for frame in frames)
    assert first == second != set()


def test_choices_take_values_by_name():
    control = choice("Filter", {"Kalman": "kf", "particles": "pf"}, "pf")
    assert (control.values, control.shown, control.default) == (
        ("kf", "pf"),
        ("Kalman", "particles"),
        1,
    )


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: slider("Gain", [0, 1], 0.5), "'Gain' has no value 0.5; it has 0, 1"),
        (lambda: slider("Gain", [], 0), "needs two values or more"),
        (lambda: slider("Gain", [1], 1), "needs two values or more"),
        (lambda: slider("Gain", [1.00001, 1.00002], 1.00001), "look alike"),
        (lambda: slider(" ", [0, 1], 0), "needs a label"),
        (lambda: choice("Kind", ["a", "a"], "a"), "look alike"),
        (lambda: choice("Kind", ["a", "b"], "c"), "has no value 'c'"),
        (lambda: timeline("Time", [0, 1], 0, fps=0), "fps of 'Time' must be positive"),
    ],
)
def test_controls_that_cannot_work_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


# ---- making one ----


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"noise": slider("Noise", [0, 1], 0)}, "draw does not take gain, falling, noise"),
        ({"alt": "too short"}, "alt must say"),
        ({"alt": lambda **_: ""}, "alt must say"),
        ({"presets": {"Big": {"gain": 7}}}, "'Gain' has no value 7"),
        ({"presets": {"Big": {"grain": 2}}}, "'Big' sets grain, which is no control"),
        ({"falling": toggle("Gain")}, "labels must differ"),
        ({"layout": toggle("Layout")}, "'layout' is a name that widgets use"),
        ({"gain": slider("Gain", range(61), 1)}, "61 × 2 = 122 states of gain, falling"),
    ],
)
def test_explorers_that_cannot_work_are_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        made(**changes)


def test_a_missing_control_is_refused():
    with pytest.raises(ValueError, match="draw does not take gain: missing"):
        explore(line, alt=ALT, gain=controls()["gain"])
    with pytest.raises(ValueError, match="needs a control"):
        explore(lambda: FIG, alt=ALT)


def test_a_control_must_be_a_control():
    with unchecked(), pytest.raises(TypeError, match="gain must be a slider"):
        made(gain=[0, 1])


@pytest.mark.parametrize("drawing", [None, "svg", (FIG, AX)])
def test_a_drawing_must_be_a_picture(drawing):
    with pytest.raises(TypeError, match="draw must return a Figure or a uint8 array"):
        explore(lambda gain: drawing, alt=ALT, gain=controls()["gain"])


def test_draw_gets_the_values_of_the_controls_whatever_rounding_asks_for():
    asked = []

    def watched(gain):
        asked.append(gain)
        return line(gain, False)

    explorer = explore(
        watched, alt=ALT, gain=slider("Gain", [0.1, 0.3, 1], 1), presets={"P": {"gain": 0.1 + 0.2}}
    )
    explorer.frame(gain=0.1 + 0.2)
    explorer.gain = 0.1 + 0.2
    explorer.frame(**explorer.parameters)
    assert explorer.gain == 0.3
    assert asked[1:] == [0.3, 0.3]
    assert explorer.presets == {"P": {"gain": 0.3}}


def test_a_view_is_told_what_it_shows():
    explorer = explore(
        lambda size, time: square(size + time),
        alt=lambda size, time: f"A white square of {size} and {time} pixels.",
        presets={"Large": {"size": 20}, "Late": {"time": 3, "size": 5}},
        size=slider("Side", [5, 9, 20], 9),
        time=timeline("Time", range(4), 1, fps=7),
    )
    spec = explorer.spec
    assert [(c["kind"], c["default"], c["fps"]) for c in spec["controls"]] == [
        ("slider", 1, None),
        ("timeline", 1, 7.0),
    ]
    assert spec["presets"] == [
        {"label": "Large", "indices": {"size": 2, "time": 1}},
        {"label": "Late", "indices": {"size": 0, "time": 3}},
    ]
    assert spec["spoken"]
    assert not made().spec["spoken"]


def test_an_error_in_draw_is_not_swallowed():
    def broken(gain):
        return 1 / 0

    with pytest.raises(ZeroDivisionError):
        explore(broken, alt=ALT, gain=controls()["gain"])


def test_the_largest_grid_is_allowed():
    assert made(gain=slider("Gain", range(MOST_STATES // 2), 1)).gain == 1


def shown(explorer):
    """Return the outputs of a cell that ends with an explorer, and leave no shell behind."""
    shell = InteractiveShell.instance()  # before the capture, which takes its publisher
    try:
        with capture_output(stdout=False, stderr=False) as captured:
            shell.display_formatter.format(explorer)
    finally:
        InteractiveShell.clear_instance()
    return [output.data for output in captured.outputs]


# ---- on a page ----


def stored(explorer):
    """Return the frames that a page stores for an explorer."""
    html = explorer._repr_mimebundle_()["text/html"]
    found = re.search(r'class="rp-states">([^<]*)</script>', html)[1]
    states = json.loads(found)
    if isinstance(states, list):
        return states
    packed = json.loads(gzip.decompress(base64.b64decode(states)))
    return ["\n".join(packed["lines"][n] for n in state) for state in packed["states"]]


def test_the_stored_grid_equals_drawing(monkeypatch):
    monkeypatch.setenv(PAGE_VARIABLE, "1")
    explorer = made()
    frames = stored(explorer)
    grid = list(explorer.grid())
    assert len(frames) == len(grid) == 6
    assert grid[:3] == [
        {"gain": 0.5, "falling": False},
        {"gain": 0.5, "falling": True},
        {"gain": 1.0, "falling": False},
    ]
    for parameters, frame in zip(grid, frames, strict=True):
        assert frame == explorer.frame(**parameters).data.decode()
    assert len(set(frames)) == 6


def test_stored_images_are_webp_with_their_size(monkeypatch):
    monkeypatch.setenv(PAGE_VARIABLE, "1")
    explorer = explore(
        square,
        alt=lambda size: f"A white square of {size} pixels.",
        size=slider("Side", [5, 20], 5),
    )
    (small, large) = stored(explorer)
    assert small[1:] == ["A white square of 5 pixels.", 80, 60]
    pixels = np.asarray(Image.open(io.BytesIO(base64.b64decode(large[0]))).convert("L"))
    assert np.abs(pixels.astype(int) - square(20)).mean() < 2


def test_a_page_holds_the_default_state_and_no_widget(monkeypatch):
    monkeypatch.setenv(PAGE_VARIABLE, "1")
    bundle = made(caption="Slope $g$ of </script>")._repr_mimebundle_()
    assert set(bundle) == {"text/html", "text/plain"}
    html = bundle["text/html"]
    assert html.startswith('<div class="explorer" id="explorer-')
    assert f'aria-label="{ALT}"' in html
    assert html.count("</script>") == 2
    spec = json.loads(re.search(r'class="rp-spec">(.*?)</script>', html, re.S)[1])
    assert [c["name"] for c in spec["controls"]] == ["gain", "falling"]
    assert spec["controls"][0]["default"] == 1


@pytest.mark.parametrize("falling", [False, True])
@pytest.mark.parametrize("gain", [0.5, 1.0, 2.0])
def test_the_picture_on_a_page_is_that_of_the_defaults(monkeypatch, gain, falling):
    monkeypatch.setenv(PAGE_VARIABLE, "1")
    explorer = made(
        alt=lambda gain, falling: f"A line of slope {gain}, {'down' if falling else 'up'}.",
        gain=slider("Gain", [0.5, 1.0, 2.0], gain),
        falling=toggle("Falling", falling),
    )
    assert explorer._repr_mimebundle_()["text/plain"] == explorer.frame().alt


def test_the_same_explorer_gives_the_same_page(monkeypatch):
    monkeypatch.setenv(PAGE_VARIABLE, "1")
    pages = [made()._repr_mimebundle_()["text/html"] for _ in range(2)]
    assert pages[0] == pages[1]


def test_figures_and_images_may_not_alternate(monkeypatch):
    monkeypatch.setenv(PAGE_VARIABLE, "1")
    with pytest.raises(ValueError, match="figures always or images always"):
        explore(
            lambda size: FIG if size > 5 else square(size), alt=ALT, size=slider("Side", [5, 9], 5)
        )


# ---- alive ----


class Wire:
    """Stands for the comm: keeps what an explorer sends."""

    def __init__(self, explorer):
        self.sent = []
        self.explorer = explorer
        explorer.send = lambda content, buffers=None: self.sent.append((content, buffers))

    def ask(self, request, **indices):
        """Ask for a picture as a view does; return the answer."""
        content = {"type": "draw", "request": request, "indices": indices}
        self.explorer._handle_custom_msg(content, [])
        return self.sent[-1]


def test_a_live_explorer_draws_no_grid():
    calls = []

    def watched(gain):
        calls.append(gain)
        return line(gain, False)

    explorer = explore(watched, alt=ALT, gain=controls()["gain"])
    shown(explorer)
    assert calls == [1.0]


def test_a_live_explorer_holds_its_default_picture():
    explorer = explore(square, alt=ALT, size=slider("Side", [5, 20], 5))
    picture = explorer.get_state()["picture"]
    assert (picture["mime"], picture["alt"]) == (WEBP, ALT)
    assert Image.open(io.BytesIO(picture["data"])).size == (80, 60)
    explorer.size = 20
    assert explorer.get_state()["picture"] == picture


def test_a_live_explorer_shows_a_picture_that_lasts_and_a_view():
    explorer = made(caption="Slope")
    still, view = shown(explorer)
    assert set(still) == {"text/html", "text/plain"}
    data = base64.b64encode(explorer.frame().data).decode()
    assert f'src="data:image/svg+xml;base64,{data}"' in still["text/html"]
    assert f'id="{explorer.still}"' in still["text/html"]
    assert still["text/plain"] == ALT
    assert view["application/vnd.jupyter.widget-view+json"]["model_id"] == explorer.model_id
    assert view["text/plain"] == "", "no front end says everything twice"


def test_a_page_shows_one_output(monkeypatch):
    monkeypatch.setenv(PAGE_VARIABLE, "1")
    explorer = made()
    assert shown(explorer) == [explorer._repr_mimebundle_()]


def test_a_view_gets_the_picture_it_asked_for():
    explorer = made()
    content, buffers = Wire(explorer).ask(41, gain=2, falling=1)
    assert content == {
        "type": "frame",
        "mime": SVG,
        "alt": ALT,
        "request": 41,
        "indices": {"gain": 2, "falling": 1},
    }
    assert buffers == [explorer.frame(gain=2, falling=True).data]
    assert explorer.parameters == {"gain": 2.0, "falling": True}


def test_a_live_image_is_sent_as_bytes():
    explorer = explore(square, alt=ALT, size=slider("Side", [5, 20], 5))
    content, buffers = Wire(explorer).ask(1, size=1)
    assert content["mime"] == WEBP
    assert Image.open(io.BytesIO(buffers[0])).size == (80, 60)


def test_an_error_in_draw_is_shown_in_the_view():
    def fragile(gain):
        if gain > 1:
            raise ValueError("the gain is too large")
        return line(gain, False)

    wire = Wire(explore(fragile, alt=ALT, gain=controls()["gain"]))
    content, buffers = wire.ask(7, gain=2)
    assert (content["type"], content["request"], buffers) == ("error", 7, None)
    assert content["text"] == "ValueError: the gain is too large"
    assert wire.ask(8, gain=0)[0]["type"] == "frame"


def test_controls_are_traits_that_can_be_observed_and_linked():
    explorer = explore(
        lambda looks: line(looks, False), alt=ALT, looks=slider("Looks", range(4), 1)
    )
    seen = []
    explorer.observe(lambda change: seen.append(change["new"]), "parameters")
    other = IntSlider(value=1, max=3)
    link((explorer, "looks"), (other, "value"))
    other.value = 3
    assert explorer.looks == 3
    assert seen == [{"looks": 3}]
    Wire(explorer).ask(1, looks=0)
    assert other.value == 0
    assert explorer.indices == {"looks": 0}


def test_views_follow_a_change_made_in_python():
    explorer = made()
    wire = Wire(explorer)
    explorer.gain = 2
    assert not wire.sent, "nobody looks, nothing is drawn"
    wire.ask(1, gain=0, falling=0)
    explorer.parameters = {"gain": 2, "falling": True}
    content, _ = wire.sent[-1]
    assert len(wire.sent) == 2
    assert (content["request"], content["indices"]) == (None, {"gain": 2, "falling": 1})


def test_a_trait_takes_only_values_of_its_control():
    explorer = made()
    with pytest.raises(TraitError, match="'Gain' has no value 7"):
        explorer.gain = 7
    with pytest.raises(ValueError, match="grain"):
        explorer.parameters = {"grain": 1}
    assert explorer.parameters == {"gain": 1.0, "falling": False}


# ---- for tests ----


def test_end_points_are_both_ends_of_every_control_and_the_presets():
    explorer = made(presets={"Down": {"gain": 2, "falling": True}})
    assert list(explorer.end_points()) == [
        {"gain": 0.5, "falling": False},
        {"gain": 2.0, "falling": False},
        {"gain": 1.0, "falling": False},
        {"gain": 1.0, "falling": True},
        {"gain": 2.0, "falling": True},
    ]


def test_end_points_are_all_values_of_a_choice_and_the_ends_of_a_timeline():
    explorer = explore(
        lambda kind, time: line(time, kind == "c"),
        alt=ALT,
        kind=choice("Kind", "abc", "b"),
        time=timeline("Time", range(4), 2),
    )
    points = list(explorer.end_points())
    assert [point["kind"] for point in points] == ["a", "b", "c", "b", "b"]
    assert [point["time"] for point in points] == [2, 2, 2, 0, 3]


def test_explorers_are_found_in_a_namespace_and_among_outputs():
    named, displayed = made(), made()
    assert explorers_in({"a": named, "b": named, "n": 3, "Out": {1: displayed, 2: 5}}) == [
        named,
        displayed,
    ]


# ---- a hand on the picture ----


def dot(x, y):
    """Draw a dot at a place."""
    AX.clear()
    AX.plot([x], [y], "o")
    AX.set(xlim=(0, 10), ylim=(0, 10))
    return FIG


def dragged(**changes):
    """Return an explorer of a dot that can be dragged."""
    axes = {"x": slider("Ahead", [2, 5, 8], 2), "y": slider("Aside", [1, 9], 1)}
    return explore(
        dot, **({"alt": "A dot at the place that is chosen.", "drag": ("x", "y")} | axes | changes)
    )


def places(explorer, **parameters):
    """Return the places that a drawing holds, in its units, and the middle of its dot."""
    svg = explorer.frame(**parameters).data.decode()
    words = re.search(r'<metadata class="rp-places">(.*?)</metadata>', svg)[1].split()
    *_, dot = re.findall(r'<use [^>]*x="([\d.]+)" y="([\d.]+)"', svg)  # ticks stand before
    return [None if w == "-" else tuple(map(float, w.split(","))) for w in words], dot


@pytest.mark.parametrize(("place", "state"), list(enumerate(dragged().grid())))
def test_a_drawing_says_where_its_point_would_be_in_every_state(place, state):
    where, dot = places(dragged(), **state)
    assert len(where) == 6
    assert where[place] == pytest.approx(tuple(map(float, dot)), abs=0.1)


def test_a_point_may_be_anywhere_and_nowhere():
    def at(x, y):
        return None if x == 5 else (x / 2, y)

    elsewhere, _ = places(dragged(drag=Drag(("x", "y"), "the dot", at)))
    plain, _ = places(dragged())
    assert elsewhere[2:4] == [None, None]
    assert elsewhere[4][1] == plain[4][1]
    assert elsewhere[4][0] < plain[4][0]


def test_a_point_stands_in_the_panel_that_is_told():
    fig, (left, right) = figure(1, 2)

    def draw(x, y):
        for ax in (left, right):
            ax.clear()
            ax.plot([x], [y], "o")
            ax.set(xlim=(0, 10), ylim=(0, 10))
        return fig

    for panel in (0, 1):
        explorer = explore(
            draw,
            alt="Two dots at the same place.",
            drag=Drag(("x", "y"), panel=panel),
            x=slider("Ahead", [2, 5, 8], 2),
            y=slider("Aside", [1, 9], 1),
        )
        parts = explorer.frame().data.decode().split("</svg>")
        assert ["rp-places" in part for part in parts[:2]] == [panel == 0, panel == 1]


@pytest.mark.parametrize("drag", [("x",), ("x", "z"), ("x", "y", "x"), ()])
def test_what_cannot_be_dragged_is_refused(drag):
    with pytest.raises(ValueError, match="drag must name two of the controls x, y"):
        dragged(drag=drag)


def test_an_image_has_no_point_to_drag():
    explorer_of = {"alt": "A square of some size.", "size": slider("Size", [10, 20], 10)}
    with pytest.raises(TypeError, match="an image has no axes"):
        explore(square, drag=Drag(("size",), place=lambda size: (size, size)), **explorer_of)
