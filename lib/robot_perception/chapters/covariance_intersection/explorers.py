"""The explorers of the chapter: a rumour, two Gaussians, sonar with camera."""

from functools import cache, partial

import numpy as np

from robot_perception.chapters.covariance_intersection import consistency, figures, rumour, weights
from robot_perception.teaching.controls import Drag, choice, slider
from robot_perception.teaching.explorations import Exploration
from robot_perception.teaching.figures import figure


@cache
def heard(share: float) -> rumour.Result:
    """Return what is heard of which a share is repeated."""
    return rumour.run(rumour.Config(share=share), rng=np.random.default_rng(4))


def describe_rumour(result: rumour.Result) -> str:
    """Return what the errors and the stated deviations are at the end, in words."""
    parts = [
        f"{rule}: off by {100 * result.true[rule][-1]:.0f} cm, states "
        f"{100 * result.stated[rule][-1]:.0f} cm"
        for rule in rumour.RULES
    ]
    share = result.config.share
    return f"After 20 readings, {share:.0%} of their variance repeated. " + "; ".join(parts) + "."


listen = Exploration(
    figures.rumours,
    heard,
    describe_rumour,
    name="ci-rumour",
    caption="True over stated variance after each reading, exact; the scale is logarithmic. Broad "
    "grey line: honest. Above it a rule is overconfident, below it too cautious. Orange: readings "
    "fused as if independent. Purple: covariance intersection. Dashed: a rule that is told the "
    "repeated share.",
    controls={
        "share": slider("Repeated share of the variance", (0.0, 0.1, 0.25, 0.5, 0.75, 1.0), 1.0)
    },
    presets={"a tenth repeated": {"share": 0.1}, "nothing repeated": {"share": 0.0}},
    axes=partial(figure, height=3.8),
    finding=lambda result: {rule: result.ratio(rule) for rule in rumour.RULES},
)


def describe_ellipses(state: consistency.Fused) -> str:
    """Return on which side of the stated covariance the true one is, in words."""
    name = (
        "the Kalman filter"
        if state.omega is None
        else f"covariance intersection with ω = {state.omega}"
    )
    where = "inside" if state.ratio <= 1 + consistency.ROUNDING else "outside"
    return (
        f"Two beliefs with correlation {state.rho:g} fused by {name}: the true covariance reaches "
        f"{where} the stated one; the largest ratio of variances is {state.ratio:.2f}."
    )


intersect = Exploration(
    figures.two_opinions,
    consistency.fused,
    describe_ellipses,
    name="ci-ellipses",
    caption="Two beliefs, the fused belief as its rule states it (thick), and the true covariance "
    "of its error (filled). Ellipses 1σ. Where the filled ellipse leaves the thick one, the rule "
    "is overconfident; above: the largest ratio over all directions.",
    controls={
        "rho": slider("Correlation", (-0.9, -0.5, 0.0, 0.5, 0.9, 1.0), 0.5),
        "omega": choice(
            "Fused by",
            {"Kalman": None} | {f"intersection, ω = {w}": w for w in (0.1, 0.3, 0.5, 0.7, 0.9)},
            None,
        ),
    },
    presets={
        "as the filter believes": {"rho": 0.0},
        "the same error twice": {"rho": 1.0},
        "intersection, the same error": {"rho": 1.0, "omega": 0.5},
    },
    axes=partial(figure, width=5.2, height=5.0),
    finding=lambda state: state.ratio,
)


def describe_pair(state: weights.Weighed) -> str:
    """Return the weights and the areas that they lead to, in words."""
    return (
        f"Ellipses of sonar and camera and of both fused; below, the area of the fused ellipse "
        f"against the weight of the camera. Eq. 4 takes "
        f"{state.printed:.2f}, the least area is at {state.least:.2f}; the areas are "
        f"{state.area(state.printed):.2f} and {state.area(state.least):.2f} of the sonar's."
    )


def on_ellipse(bearing: float, depth: float) -> tuple[float, float]:
    """Return the point half way round from the end in distance to that in direction, m and °."""
    return depth / np.sqrt(2), bearing / np.sqrt(2)


weigh = Exploration(
    figures.weighed,
    weights.weighed,
    describe_pair,
    name="ci-weight",
    caption="A sonar fused with a camera whose ellipse (1σ) you drag. Above: both, and thick what "
    "eq. 4 and the best weight make of them. Below: area of the fused ellipse over that of the "
    "sonar's, logarithmic, against the weight of the camera. Large dot: eq. 4; small: the least "
    "area.",
    controls={
        "bearing": slider(
            "Camera, direction", (1.0, 2.0, weights.BEARING, 4.0, 6.0, 10.0), weights.BEARING, "°"
        ),
        "depth": slider("Camera, distance", (0.2, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0), 2.0, "m"),
    },
    presets={
        "a sharp camera": {"bearing": 1.0},
        "a camera that knows no more": {"bearing": 10.0},
        "a camera with depth": {"depth": 0.2},
    },
    axes=partial(figure, 2, 1, height=6.2),
    drag=Drag(("depth", "bearing"), "the ellipse of the camera", on_ellipse),
    finding=lambda state: (state.area(state.printed), state.area(state.least), state.areas.min()),
)
