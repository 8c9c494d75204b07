"""Figures of the chapter "Tracking a pattern".

What they draw is made in the notebook: a namespace with the names that a drawing reads.
"""

from collections.abc import Mapping, Sequence
from types import SimpleNamespace

import numpy as np
from jaxtyping import Float
from matplotlib.axes import Axes

from explorables.figures import drawn
from explorables.figures.charts import curve
from explorables.figures.style import MEANING, band
from robot_perception.ceiling.patterns import Pattern
from robot_perception.chapters.pattern_tracking.recordings import Real
from robot_perception.chapters.pattern_tracking.scene import COORDINATES, START, WINDOW
from studies.intervals import Interval

_PHOTOS = {"left": 0.01, "right": 0.99, "bottom": 0.02, "top": 0.86, "wspace": 0.06}


def picture(ax: Axes, image: np.ndarray) -> None:
    """Show a grey picture on axes without scales."""
    ax.imshow(image, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
    ax.set(xlim=(-0.5, image.shape[1] - 0.5), ylim=(image.shape[0] - 0.5, -0.5))
    ax.set_xticks([])
    ax.set_yticks([])
    ax.grid(visible=False)


def frame(ax: Axes, pose: Float[np.ndarray, " 4"], colour: str, **kwargs: object) -> None:
    """Draw the outline of the window at a place, and its upward direction."""
    half = np.array(WINDOW) / 2
    corners = half * [[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]]
    for points in (corners, half[1] * np.array([[0.0, -1.0], [0.0, -0.6]])):
        cos, sin = pose[3] * np.cos(pose[2]), pose[3] * np.sin(pose[2])
        u, v = points.T
        ax.plot(pose[0] + cos * u - sin * v, pose[1] + sin * u + cos * v, color=colour, **kwargs)


def card(ax: Axes, film: SimpleNamespace, at: int) -> Axes:
    """Draw particles, truth and estimate on the axes of a picture of the film."""
    ax.scatter(*film.particles[at].T, s=14, color=MEANING["particles"], linewidths=0)
    frame(ax, film.truth[at], MEANING["truth"], linewidth=4.0, linestyle=":")
    frame(ax, film.poses[at], MEANING["estimate"], linewidth=3.0)
    return ax


@drawn(
    name="pattern-hero",
    alt="Four pictures. A sign in the middle of a picture crowded with stripes, lamps and boxes. "
    "The same place as three maps: by edges many bright spots, by edges of the same "
    "direction few, by grey vectors few.",
    caption="(a) What the camera sees; framed, the pattern. (b) to (d) How well the pattern fits "
    "at each place within 60 px: by the distance of its outlines from edges, from edges of the "
    "same direction, and by its grey vectors. Bright spots fit well.",
    cols=4,
    width=8.2,
    height=2.3,
    gridspec_kw=_PHOTOS,
)
def hero(axes: np.ndarray, image: np.ndarray, maps: Mapping[str, np.ndarray]) -> None:
    """Draw a picture and likelihoods of the pattern over the places round it, 0 to 1."""
    reach = 60
    corner = (START[:2] - 92).astype(int)
    picture(axes[0], image[corner[1] : corner[1] + 185, corner[0] : corner[0] + 185])
    frame(axes[0], START - [*corner, 0, 0], MEANING["grey vectors"], linewidth=2.0)
    axes[0].set_title("the pattern")
    for ax, (name, surface) in zip(axes[1:], maps.items(), strict=True):
        ax.imshow(surface, cmap="gray", vmin=-0.2, vmax=1, extent=(-reach, reach, reach, -reach),
                  interpolation="nearest")  # fmt: skip
        ax.set_xticks([])
        ax.set_yticks([])
        ax.grid(visible=False)
        ax.set_title(name)


@drawn(
    name="pattern-model",
    alt="The sign, enlarged, with some hundred short strokes across its outlines.",
    caption="The pattern as the tracker knows it. Lines: its contours, segments and arcs. Strokes: "
    "eleven grey values each, taken along the gradient, across a contour.",
    width=4.4,
    height=4.4,
    gridspec_kw={"left": 0.01, "right": 0.99, "bottom": 0.01, "top": 0.99},
)
def model(ax: Axes, pattern: Pattern, state: SimpleNamespace) -> Axes:
    """Draw a pattern: picture, contours, and where vectors are taken."""
    reach = 46
    picture(ax, state.image)
    for piece in pattern.contours:
        ax.plot(*(piece.points(2.0) + reach).T, color=MEANING["contours"], linewidth=2.0)
    way = np.stack([np.cos(pattern.places[:, 2]), np.sin(pattern.places[:, 2])], -1)
    half = pattern.step * (pattern.vectors.shape[1] // 2) * way
    ends = np.stack([state.points - half, state.points + half], axis=1)
    for a, b in ends:
        ax.plot(*np.transpose([a, b]), color=MEANING["grey vectors"], linewidth=0.8)
    return ax


def falling(axes: np.ndarray, state: SimpleNamespace) -> None:
    """Draw one vector in the picture, its greys, and its correlation; axes cleared first."""
    left, middle, right = axes
    for ax in axes:
        ax.clear()
    picture(left, state.image)
    left.scatter(*state.points.T, s=5, color=MEANING["particles"], linewidths=0)
    left.plot(*state.line.T, color=MEANING["grey vectors"], linewidth=2.4)
    half = len(state.greys) // 2
    middle.plot(np.arange(-half, half + 1), state.greys, "-o", color=MEANING["grey vectors"],
                markersize=3.5)  # fmt: skip
    middle.set(xlim=(-half, half), ylim=(0, 260), xlabel="sample", ylabel="grey value")
    lags = np.arange(len(state.fall))
    right.plot(lags, state.fall, "-o", color=MEANING["grey vectors"], markersize=3.5)
    right.plot(lags, 1 - state.rate * lags, "--", color=MEANING["paper"], linewidth=1.6)
    right.set(xlim=(0, lags[-1]), ylim=(-1, 1.05), xlabel="deviation λ (samples)")
    right.set_ylabel("correlation C")
    right.set_title(f"slope {state.rate:.2f}")


def moving(ax: Axes, state: SimpleNamespace) -> Axes:
    """Draw the picture, the particles as they were drawn, truth and estimate; axes cleared."""
    ax.clear()
    picture(ax, state.image)
    ax.scatter(*state.drawn.T, s=7, color=MEANING["particles"], linewidths=0, alpha=0.9)
    frame(ax, state.truth, MEANING["truth"], linewidth=3.0, linestyle=":")
    frame(ax, state.pose, MEANING["estimate"], linewidth=2.2)
    ax.set_title(f"moved {state.away:.1f}σ, estimate {state.error:.0f} px off")
    return ax


def covering(ax: Axes, state: SimpleNamespace) -> Axes:
    """Draw a covered pattern, its good and bad points, truth and estimate; axes cleared."""
    ax.clear()
    picture(ax, state.image)
    for which, name, size in ((state.good, "right", 9), (~state.good, "wrong", 13)):
        ax.scatter(*state.points[which].T, s=size, color=MEANING[name], linewidths=0)
    frame(ax, state.truth, MEANING["truth"], linewidth=3.0, linestyle=":")
    frame(ax, state.pose, MEANING["estimate"], linewidth=2.0)
    ax.set(xlim=(90, 235), ylim=(175, 65))
    lost = ", reported lost" if state.lost else ""
    ax.set_title(f"{(~state.good).mean():.0%} bad, {state.error:.2f}σ off{lost}")
    return ax


@drawn(
    name="pattern-fig8",
    alt="Four drawings, one a coordinate: the estimate follows the true displacement up to some "
    "two standard deviations; beyond three the line bends back to where the pattern was.",
    caption="Estimated against true displacement after one picture. Line: median over patches; "
    "band: the middle half of them. Dashed: the right answer. Shaded: ±3σ of the random walk.",
    cols=4,
    width=8.2,
    height=2.7,
)
def fig8(axes: np.ndarray, moved: Sequence[float], errors: np.ndarray) -> None:
    """Draw what one picture makes of displacements along each coordinate.

    Errors are by coordinate, displacement and patch, σ.
    """
    true = np.array(moved)
    for c, ax in enumerate(axes):
        low, middle, high = np.percentile(errors[c] + true[:, None], (25, 50, 75), axis=1)
        ax.axvspan(-3, 3, color=MEANING["expected"], alpha=0.12, linewidth=0)
        ax.plot(true, true, "--", color=MEANING["truth"], linewidth=1.2)
        band(ax, true, low, high, MEANING["estimate"])
        ax.plot(true, middle, color=MEANING["estimate"])
        ax.set(xlim=(-4, 4), ylim=(-4, 4), xlabel=f"true d{COORDINATES[c]} (σ)")
        ax.set_ylabel(f"estimated d{COORDINATES[c]} (σ)")
        ax.set_xticks([-3, 0, 3])
        ax.set_yticks([-3, 0, 3])


@drawn(
    name="pattern-occlusion",
    alt="Error against the share of the window that is covered. Leaving out vectors beyond three "
    "samples starts highest; beyond four it is below no tolerance wherever something is covered.",
    caption="Error by the share of the window that is covered, mean over patches, and by what is "
    "done with bad vectors: nothing; left out, as printed, beyond four samples or (dashed) beyond "
    "three; or counted as much as the threshold. Bands: 95 %.",
    height=3.0,
)
def occlusion(ax: Axes, shares: Sequence[float], errors: Mapping[str, list[Interval]]) -> Axes:
    """Draw the error against what is covered, by the rule of bad vectors."""
    at = 100 * np.array(shares)
    words = {"none": "no tolerance", "at worst": "counted as the threshold"}
    for name, row in errors.items():
        dashed = name.endswith("beyond 3")
        colour = MEANING[{"none": "no tolerance"}.get(name, name.removesuffix(" beyond 3"))]
        curve(ax, at, row, colour, "--s" if dashed else "-o", label=words.get(name, name))
    ax.set(xlabel="covered (%)", ylabel="error (σ)", xlim=(0, at[-1]), ylim=(0, None))
    ax.legend(loc="upper left")
    return ax


@drawn(
    name="pattern-scale",
    alt="Difference of grey vectors from their model against the scale: smoothing by σ = s lies "
    "above no smoothing; with a model smoothed as well it lies far below.",
    caption="How much vectors differ from those of the model, 1 − C at the true place, while the "
    "pattern grows; mean over patches, bands 95 %. Smoothed: the picture, by σ = s px.",
    height=3.0,
)
def scale(ax: Axes, scales: Sequence[float], unlike: Mapping[str, list[Interval]]) -> Axes:
    """Draw how unlike vectors are at their true places, by smoothing."""
    at = np.array(scales)
    for meaning, row in unlike.items():
        curve(ax, at, row, MEANING[meaning], label=meaning)
    ax.set_yscale("log")
    ax.set_yticks([1e-3, 1e-2, 1e-1, 1], ["0.001", "0.01", "0.1", "1"])
    ax.set(xlabel="scale s", ylabel="difference 1 − C", xlim=(1, at[-1]), ylim=(2e-4, 5))
    ax.legend(loc="upper left")
    return ax


@drawn(
    name="pattern-real",
    alt="Two photographs of a wall of graffiti, the second from the side. Frames of patterns in "
    "the first stand at the same details in the second.",
    caption="Patterns chosen in the first photograph of a wall (a), and where the tracker has "
    "them in the second (b): solid where they are within 5 px of the truth, dashed where not. "
    "Dotted: the truth, of which only the turn and the area can be followed.",
    cols=2,
    width=7.6,
    height=3.2,
    gridspec_kw=_PHOTOS,
)
def real(axes: np.ndarray, seen: Real) -> None:
    """Draw both photographs with the patterns."""
    left, right = axes
    picture(left, seen.first)
    picture(right, seen.last)
    for k, held in enumerate(seen.held):
        frame(left, np.array([*seen.places[k], 0.0, 1.0]), MEANING["grey vectors"], linewidth=1.6)
        frame(right, seen.truth[k], MEANING["truth"], linewidth=2.4, linestyle=":")
        line = "-" if held else "--"
        frame(right, seen.found[k], MEANING["grey vectors"], linewidth=1.6, linestyle=line)
    left.set_title("the first picture")
    right.set_title("the second")
