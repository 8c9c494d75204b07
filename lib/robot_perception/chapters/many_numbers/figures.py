"""Drawings of what is known of several numbers at once.

What they draw is made in the notebook: a namespace with the names that a drawing reads.
"""

from types import SimpleNamespace

import numpy as np
from matplotlib.axes import Axes

from explorables.figures import band, drawn, label
from explorables.figures.style import MEANING, AxesRow, ellipses

REACH = 2.4477
"""Radius of an ellipse that holds a point of the plane with 95 %, in deviations."""
SIDE = 1.96
"""Half the width of a strip that holds a number with 95 %, in deviations."""
FLOOR = -1.5
"""Height at which the measurement of the robot's place is drawn, m."""
FINE = 72


def ellipse(ax: Axes, now: SimpleNamespace) -> Axes:
    """Draw points of a Gaussian, the ellipse of a share, and the box round it."""
    ax.clear()
    ax.plot(*now.points.T, ".", color=MEANING["particles"], markersize=4)
    ellipses(
        ax,
        np.zeros((1, 2)),
        now.P[None],
        MEANING["estimate"],
        deviations=now.reach,
        corners=FINE,
        fill=0.12,
    )
    x, y = now.reach * np.sqrt(np.diag(now.P))
    ax.plot([-x, x, x, -x, -x], [-y, -y, y, y, -y], "--", color=MEANING["expected"], linewidth=1.2)
    ax.set(xlim=(-6.5, 6.5), ylim=(-3.6, 3.6), aspect="equal")
    ax.set(xlabel="error to the right (m)", ylabel="error upwards (m)")
    ax.set_title(f"{now.inside} of {len(now.points)} points inside, ρ = {now.rho:g}")
    return ax


def carry(ax: Axes, now: SimpleNamespace) -> Axes:
    """Draw what is known of robot and post, before and after the robot is told its place."""
    ax.clear()
    (before, P), (after, Q) = now.beliefs
    ax.axvline(now.z, color=MEANING["position sensor"], linewidth=1.2)
    ax.plot(now.z, FLOOR, "^", color=MEANING["position sensor"], markersize=11)
    more = {"deviations": REACH, "corners": FINE}
    ellipses(ax, before[None], P[None], MEANING["expected"], **more)
    ellipses(ax, after[None], Q[None], MEANING["estimate"], fill=0.25, **more)
    ax.annotate(
        "",
        after,
        before,
        arrowprops={"arrowstyle": "->", "color": MEANING["estimate"], "linewidth": 1.6},
    )
    ax.set(xlim=(-6, 6), ylim=(-2.2, 10.2))
    ax.set(xlabel="robot's place (m)", ylabel="post's place (m)")
    ax.set_title(f"the post moves by {now.moved[1]:.2f} m, σ {now.deviations[1][1]:.2f} m")
    label(ax, 0.02, 0.94, f"ρ = {now.rho:.2f}", MEANING["expected"], transform=ax.transAxes)
    return ax


@drawn(
    name="numbers-told",
    alt="Two plans with a robot and a post, each with its ellipse. Before, both ellipses are large "
    "and of one shape. After the robot was told its place both are small, and both have moved by "
    "the same way.",
    caption="(a) A robot that hardly knows its place has seen a post. (b) Somebody has told the "
    "robot where it is (cross). Ellipses hold 95 %; grey: as they were before. Dotted: from robot "
    "to post, as estimated.",
    cols=2,
    height=3.4,
)
def told(axes: AxesRow, told: SimpleNamespace) -> AxesRow:
    """Draw robot and post before and after the robot is told its place."""
    seen, _ = told.beliefs
    for ax, (mean, cov), title in zip(axes, told.beliefs, ("Seen", "Told"), strict=True):
        for first, name, word in ((0, "robot", "robot"), (2, "landmark", "post")):
            part = slice(first, first + 2)
            if ax is axes[1]:
                ellipses(
                    ax,
                    seen[0][None, part],
                    seen[1][None, part, part],
                    MEANING["expected"],
                    deviations=REACH,
                    width=1.0,
                    corners=FINE,
                )
            ellipses(
                ax,
                mean[None, part],
                cov[None, part, part],
                MEANING[name],
                deviations=REACH,
                fill=0.15,
                corners=FINE,
            )
            ax.plot(*mean[part], "o", color=MEANING[name], markersize=4)
            label(ax, mean[first], -2.6, word, MEANING[name], ha="center")
        ax.plot(*mean.reshape(2, 2).T, ":", color=MEANING["readings"], linewidth=1.4)
        ax.set(xlim=(-3.2, 7.4), ylim=(-3.2, 4.0), aspect="equal", title=title, xlabel="x (m)")
    axes[0].set_ylabel("y (m)")
    axes[1].plot(*told.beliefs[1][0][:2], "x", color=MEANING["truth"], markersize=7)
    return axes


def mapped(axes: AxesRow, now: SimpleNamespace) -> AxesRow:
    """Draw errors and bars of robot and posts, and the correlations of the state."""
    errors, matrix = axes
    errors.clear()
    matrix.clear()
    errors.axhline(0, color=MEANING["truth"], linewidth=1.0)
    for places, name in ((now.places[1:], "landmark"), (now.places[:1], "robot")):
        part = slice(1, None) if name == "landmark" else slice(0, 1)
        middle, half = now.errors[part], 2 * now.deviations[part]
        errors.vlines(places, middle - half, middle + half, MEANING[name], linewidth=3)
        errors.plot(places, middle, "o", color=MEANING[name], markersize=5)
    errors.set(
        xlim=(-1, 25), ylim=(-1.05, 1.05), xlabel="place on the ring (m)", ylabel="error (m)"
    )
    errors.set_xticks(range(0, 25, 6))
    errors.set_title(f"step {now.step}: {now.outside} of {len(now.errors)} bars wrong")
    count = len(now.errors)
    across, down = np.meshgrid(np.arange(count), np.arange(count))
    sizes = np.abs(now.rho).ravel()
    squares = np.stack([across.ravel(), down.ravel()], axis=1)[sizes > 0.02]
    half = 0.46 * sizes[sizes > 0.02, None]
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1], [-1, -1]])
    rims = np.full((len(squares), 6, 2), np.nan)
    rims[:, :5] = squares[:, None] + half[:, None] * corners
    matrix.fill(*rims[:, :5].transpose(2, 1, 0), color=MEANING["information"], linewidth=0)
    matrix.set(xlim=(-0.7, 8.7), ylim=(8.7, -0.7), aspect="equal", title="Correlations")
    matrix.set_xticks([0, 8], ["robot", "last"])
    matrix.set_yticks([0, 1, 8], ["robot", "first", "last"])
    matrix.grid(visible=False)
    return axes


def swing(ax: Axes, now: SimpleNamespace) -> Axes:
    """Draw robots after a step, those that the filter's ellipse holds and the others."""
    ax.clear()
    for inside, name, word, height in (
        (True, "particles", "inside", 0.93),
        (False, "wrong", "outside", 0.86),
    ):
        ax.plot(*now.points[now.inside == inside].T, ".", color=MEANING[name], markersize=4)
        label(ax, 0.98, height, word, MEANING[name], ha="right", transform=ax.transAxes)
    ellipses(ax, now.mean[None], now.cov[None], MEANING["Kalman"], deviations=REACH, corners=FINE)
    ax.plot(0, 0, marker=(3, 0, -90), color=MEANING["truth"], markersize=11)
    ax.set(xlim=(-3, 14), ylim=(-6.8, 6.8), aspect="equal", xlabel="x (m)", ylabel="y (m)")
    ax.set_title(f"the 95 % ellipse holds {100 * now.share:.0f} %")
    return ax


def survey(ax: Axes, now: SimpleNamespace) -> Axes:
    """Draw lamps, the robot, and where it may be by what it measures."""
    ax.clear()
    ax.plot(*now.others.T, "*", color=MEANING["expected"], markersize=10)
    ax.plot(*now.lamps.T, "*", color=MEANING["anchor"], markersize=14)
    for lamp in now.lamps:
        ax.plot(*np.stack([now.place, lamp]).T, ":", color=MEANING["anchor"], linewidth=1.2)
    if now.rank == 2:
        cov = now.vectors * now.deviations**2 @ now.vectors.T
        ellipses(
            ax,
            now.place[None],
            cov[None],
            MEANING["estimate"],
            deviations=REACH,
            fill=0.2,
            corners=FINE,
        )
        title = f"rank 2: σ at most {now.deviations.max():.2f} m"
    else:
        unseen, seen = now.vectors.T
        sides = now.place + np.array([[-1], [1]]) * SIDE * now.deviations * seen
        ends = sides[:, None] + np.array([[-30], [30]]) * unseen
        for end in ends:
            ax.plot(*end.T, color=MEANING["unobservable"], linewidth=1.4)
        strip = np.concatenate([ends[0], ends[1][::-1]])
        ax.fill(*strip.T, color=MEANING["unobservable"], alpha=0.18, linewidth=0)
        title = "rank 1: a strip without an end"
    ax.plot(*now.place, "o", color=MEANING["robot"], markersize=8)
    ax.set(xlim=(0, 10), ylim=(-0.6, 5.0), xlabel="x (m)", ylabel="y (m)", title=title)
    return ax


def nees(ax: Axes, now: SimpleNamespace) -> Axes:
    """Draw the averaged NEES of a filter by step, with the bounds of chance."""
    ax.clear()
    steps = np.arange(1, len(now.nees) + 1)
    low, high = now.bounds
    band(ax, steps, np.full(len(steps), low), np.full(len(steps), high), MEANING["expected"])
    ax.axhline(2, color=MEANING["expected"], linewidth=1.0)
    ax.plot(steps, now.nees, color=MEANING["estimate"])
    label(ax, steps[-1] - 0.5, 0.05, "grey line: expected, 2", MEANING["expected"], ha="right")
    ax.set(xlim=(1, steps[-1]), ylim=(0.03, 60), yscale="log", xlabel="step", ylabel="NEES")
    drives = "one drive" if now.drives == 1 else f"{now.drives} drives"
    ax.set_title(f"{drives}: {now.within:.0%} of the steps inside")
    return ax
