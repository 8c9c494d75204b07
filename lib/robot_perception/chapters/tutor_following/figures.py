"""Figures of the chapter "Follow me".

What they draw is made in the notebook: a namespace with the names that a drawing reads.
"""

from types import SimpleNamespace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.patches import Polygon, Rectangle

from data_synth.companion.hands import hand_window, make_hand
from explorables.figures import charts, drawn
from explorables.figures.charts import Arrow, bars, curve
from explorables.figures.maps import picture, square
from explorables.figures.style import MEANING, label
from robot_perception.chapters.tutor_following.training import stored
from robot_perception.companion.hands.features import SIZE
from robot_perception.companion.interaction import StateTable
from studies.tables import Table

_PHOTO = {"left": 0.01, "right": 0.99, "bottom": 0.01, "top": 0.99}
PLACES = {
    "wait": (0.45, 2.2),
    "identify": (1.45, 3.05),
    "idle": (2.3, 2.2),
    "follow": (4.3, 3.5),
    "halt": (4.3, 2.2),
    "gesture": (4.3, 0.6),
}
"""Places of the states in the drawing of the table, inches."""
TEXTS = {
    ("wait", "identify"): (0.5, "face"),
    ("identify", "wait"): (0.3, "nobody"),
    ("identify", "idle"): (-0.25, "tutor"),
    ("idle", "follow"): (-0.12, "hand above"),
    ("follow", "halt"): (0.0, "open hand"),
    ("halt", "idle"): (0.12, "hand down"),
    ("idle", "gesture"): (0.3, "hand beside"),
    ("gesture", "idle"): (0.3, "hand down"),
}
"""Bends of the arrows that have a text, and the event that leads there."""


def seen(ax: Axes, moment: SimpleNamespace) -> Axes:
    """Draw what the robot finds in a picture."""
    for k, face in enumerate(moment.faces):
        known = k == moment.held
        square(ax, face, MEANING["right" if known else "wrong"], linewidth=2.4,
               linestyle="-" if known else "--")  # fmt: skip
    for hand in moment.hands:
        square(ax, hand, MEANING["readings"], linewidth=2.4)
    if np.isfinite(moment.box).all():
        square(ax, moment.body, MEANING["truth"], linewidth=2.4, linestyle=":")
        square(ax, moment.box, MEANING["estimate"], linewidth=2.4)
    return ax


def card(ax: Axes, met: SimpleNamespace) -> Axes:
    """Draw the found face and hand on the axes of the picture of a greeting."""
    for boxes, meaning in ((met.faces, "right"), (met.hands, "readings")):
        for box in boxes:
            square(ax, box, MEANING[meaning], linewidth=3.0)
    return ax


@drawn(
    name="following-hero",
    alt="A person in a hall raises an open hand. A square marks the face, another one the hand.",
    caption="Squares: a face that the robot knows, and an open hand above it. A moment later the "
    "robot follows.",
    width=5.2,
    height=3.9,
    gridspec_kw=_PHOTO,
)
def hero(ax: Axes, moment: SimpleNamespace) -> Axes:
    """Draw the picture in which the order is given."""
    picture(ax, moment.image())
    return seen(ax, moment)


@drawn(
    name="following-features",
    alt="Four times the same open hand, each with a large and a smaller rectangle on it.",
    caption="An open hand, and the first feature of each of the first four stages: how the mean "
    "within the solid lines differs from that within the dashed ones.",
    cols=4,
    width=7.6,
    height=2.1,
    gridspec_kw={"left": 0.01, "right": 0.99, "bottom": 0.02, "top": 0.86, "wspace": 0.06},
)
def features(axes: np.ndarray) -> None:
    """Draw the feature that boosting picks first in each of four stages."""
    cascade, rng = stored().cascade, np.random.default_rng(100)
    image = hand_window(rng, make_hand(rng, tone=1), size=3 * SIZE, jitter=0.0)
    fine = len(image) / SIZE
    for k, ax in enumerate(axes):
        picture(ax, image)
        ax.set_title(f"stage {k + 1}")
        first = cascade.features[cascade.stages[k].stumps.features[0]]
        for x, y, wide, high, weight in first[first[:, 2] > 0]:
            colour = MEANING["added" if weight > 0 else "taken off"]
            corner, size = (fine * x - 0.5, fine * y - 0.5), (fine * wide, fine * high)
            ax.add_patch(Rectangle(
                corner, *size, linewidth=2.0, linestyle="-" if weight > 0 else "--",
                facecolor=(*to_rgb(colour), 0.3), edgecolor=colour,
            ))  # fmt: skip


@drawn(
    name="following-tilts",
    alt="Share of hands found against their tilt: nine in ten upright and at 15 degrees, half at "
    "30, none at 45. The faces beside them are found as often at any tilt of the hand.",
    caption="Share of the open hands that the cascade finds, by their tilt, and of the faces in "
    "the same pictures. Bands: 95 %.",
    height=2.9,
)
def tilts(ax: Axes, table: Table) -> Axes:
    """Draw the rates by the tilt of the hand."""
    degrees = np.array([int(name.rstrip("°")) for name in table.columns])
    for name, meaning in (("open hand", "camera"), ("face beside", "expected")):
        row = list(table.rows[name])
        curve(ax, degrees, row, MEANING[meaning])
        label(ax, degrees[-1] - 0.5, row[-1].estimate + 0.1, name, MEANING[meaning], ha="right")
    ax.set(xlabel="tilt of the hand (°)", ylabel="share found")
    ax.set(xlim=(0, degrees[-1]), ylim=(0, 1.05))
    return ax


@drawn(
    name="following-states",
    alt="Six states as words and arrows between them: from wait by a face to identify, by the "
    "tutor to idle, by a hand above to follow, by an open hand to halt, and back to idle; by a "
    "hand beside from idle to gesture and back. Dashed arrows lead from everywhere to wait.",
    caption="The table of states. At each arrow stands the event that leads there. Dashed: the "
    "tutor is gone, or lost.",
    width=4.8,
    height=4.0,
    gridspec_kw={"left": 0.0, "right": 1.0, "bottom": 0.0, "top": 1.0},
)
def states(ax: Axes, table: StateTable) -> Axes:
    """Draw the states and the arrows between them; dashed are those without a text."""
    pairs = [(arrow.source, arrow.target) for arrow in table.transitions]
    bends = {"follow": 0.55, "gesture": -0.32, "halt": -0.3}
    charts.states(ax, PLACES, [
        Arrow(*pair, *TEXTS[pair]) if pair in TEXTS
        else Arrow(*pair, bends.get(pair[0], -0.15), dashed=True)
        for pair in pairs
    ])  # fmt: skip
    ax.set(xlim=(0.0, 4.8), ylim=(0.2, 4.2))
    return ax


@drawn(
    name="following-orders",
    alt="A bar for each thing that happens in a visit: after most strangers' hands the robot waits "
    "as it should, and most tutors are recognised; from then on it is mostly in the state that was "
    "ordered, least often while the tutor walks.",
    caption="Row: what happens → the state in which the robot should be then. Bar: share of the "
    "visits that came to it in which the robot is in this state; how many came stands behind the "
    "bar. Lines: 95 %.",
    height=3.6,
    gridspec_kw={"left": 0.42, "right": 0.9, "bottom": 0.16, "top": 0.97},
)
def orders(ax: Axes, table: Table) -> Axes:
    """Draw how often the robot is in the state in which it should be after each order."""
    named = {f"{name} → {table[name, 'state']}": table[name, "right"] for name in table.rows}
    bars(ax, named, MEANING["right"], "share in the right state")
    for k, name in enumerate(table.rows):
        ax.text(1.03, k, f"{table[name, 'came']:.0f}", va="center", fontsize=10)
    return ax


@drawn(
    name="following-patches",
    alt="A person from behind. Four rectangles lie on head, both halves of the back and waist; a "
    "line runs round head and shoulders.",
    caption="What the follower looks at, where the first picture tells it that the person is. "
    "Rectangles: four patches of colour. Dashed: the outline of head and shoulders.",
    width=4.4,
    height=3.3,
    gridspec_kw=_PHOTO,
)
def patches(ax: Axes, shown: SimpleNamespace, rectangles: np.ndarray, outline: np.ndarray) -> Axes:
    """Draw the patches and the silhouette on the person of a film."""
    picture(ax, shown.frames[0])
    left, top, wide, high = shown.boxes[0]
    middle = np.array([left + wide / 2, top + high / 2])
    for rectangle in rectangles:
        box = high * rectangle
        box[:2] += middle
        square(ax, box, MEANING["estimate"], linewidth=2.4)
    half = len(outline) // 2
    line = middle + high * np.concatenate([outline[:half][::-1], outline[half:]])
    ax.add_patch(Polygon(line, closed=False, fill=False, edgecolor=MEANING["camera"],
                         linewidth=2.0, linestyle="--"))  # fmt: skip
    return ax


def tracking(axes: np.ndarray, state: SimpleNamespace) -> None:
    """Draw a picture of the walk, and on whose trunk the box is over time; axes cleared first."""
    top, below = axes
    for ax in axes:
        ax.clear()
    picture(top, state.image)
    square(top, state.truth, MEANING["truth"], linewidth=2.6, linestyle=":")
    square(top, state.box, MEANING["estimate"], linewidth=2.4)
    u, v = state.box[:2] + state.box[2:] / 2
    top.plot([u], [v], "+", color=MEANING["estimate"], markersize=12, markeredgewidth=2.4)
    pictures = np.arange(len(state.right))
    for level, on, meaning in ((1, state.right, "right"), (0, state.wrong & ~state.right, "wrong")):
        below.plot(
            pictures[on], np.full(on.sum(), level), "s", color=MEANING[meaning], markersize=5
        )
    nobody = ~state.right & ~state.wrong
    below.plot(pictures[nobody], np.full(nobody.sum(), -1), "s", color=MEANING["expected"],
               markersize=5)  # fmt: skip
    below.axvline(state.time, color=MEANING["truth"], linewidth=1.2)
    below.set_yticks((1, 0, -1), ("person", "other", "nobody"))
    below.set(xlim=(-1, len(state.right)), ylim=(-1.6, 1.6), xlabel="picture")
    below.set_title("held at the end" if state.held else "lost at the end", fontsize=10)


def judging(axes: np.ndarray, state: SimpleNamespace) -> None:
    """Draw the window in the picture, as the cascade sees it, and its stages; axes cleared."""
    left, middle, right = axes
    for ax in axes:
        ax.clear()
    picture(left, state.part)
    hit = state.passed == len(state.margins)
    square(left, np.array([state.x, state.y, state.side, state.side]) - [0.5, 0.5, 0, 0],
           MEANING["right" if hit else "wrong"], linewidth=2.6)  # fmt: skip
    picture(middle, state.window)
    stages = np.arange(1, len(state.margins) + 1)
    colours = [
        MEANING["expected" if k > state.passed + 1 else "right" if k <= state.passed else "wrong"]
        for k in stages
    ]
    right.barh(stages, state.margins, color=colours, height=0.7)
    right.axvline(0, color=MEANING["mean"], linewidth=1.0)
    right.set(xlim=(-0.6, 0.6), ylim=(len(stages) + 0.6, 0.4), xlabel="votes above the threshold",
              ylabel="stage")  # fmt: skip
    right.set_title(f"{state.passed} of {len(stages)} passed")
