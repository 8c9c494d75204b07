"""Numbers at the ends of floating point and beyond all memory: errors of ours that name them."""

import numpy as np
import pytest

from data_synth import building, office
from robot_perception import checks, kalman, particles
from robot_perception.appearance.colour_distribution import learn
from robot_perception.evaluation import spatial, trajectories
from robot_perception.geometry import se3
from robot_perception.people.scores import gospa
from robot_perception.slam import monobot
from robot_perception.slam.observability import Position, numeric, symbolic
from robot_perception.walls import fit_pole
from tests.hostile.calls import kalman as kalman_calls
from tests.hostile.calls import people as people_calls
from tests.unchecked import unchecked

RNG = np.random.default_rng
PLANE, SPACE = RNG(0).normal(size=(6, 2)), RNG(0).normal(size=(6, 3))
ARC = np.array([[2.0, -0.05], [1.95, 0.0], [2.0, 0.05]])
SEEN = [Position()]
MANY = 10**12


def predicted(**wrong):
    from robot_perception.people.aggregation import predict

    args, named = people_calls.CALLS[predict]()
    known = dict(zip(("hypotheses", "duration", "motion", "walk"), args, strict=False))
    return predict(**(known | named | wrong))


def informed(start):
    args, named = kalman_calls.CALLS[kalman.state_information]()
    return kalman.state_information(*args[:2], **(named | {"start": start}))


CALLS = {
    "twist": (lambda: se3.exp(np.full(6, 1e200)), "twist must be within 1e+100, got 1e+200"),
    "learn": (lambda: learn(np.full((9, 8), 1e308)), "states must be within 1e+100, got 1e+308"),
    "align": (lambda: trajectories.align(PLANE * 1e308, PLANE), "estimate must be within 1e+100"),
    "align in space": (lambda: spatial.align(SPACE, 1e307 * SPACE, False), "truth must be within"),
    "predict": (lambda: predicted(walk=1e200), "walk must be within 1e+100, got 1e+200"),
    "predict, motion": (lambda: predicted(motion=np.full(3, 1e308)), "motion must be within"),
    "gospa": (lambda: gospa(PLANE, PLANE, 1e200), "cutoff must be within 1e+100, got 1e+200"),
    "pole": (lambda: fit_pole(ARC, 0.05, 1e200), "sigma must be within 1e+100, got 1e+200"),
    "landmarks": (lambda: symbolic.state(MANY), "landmarks must be from 0 to 100, got 1000000"),
    "minors": (lambda: symbolic.fixed_point_minors(SEEN, MANY), "landmarks must be from 0 to 100"),
    "monobot": (lambda: monobot.sensor_matrix(MANY), "landmarks must be from 1 to 10000, got"),
    "start": (lambda: informed(np.full((2, 2), 1e200)), "start must be within 1e+100, got 1e+200"),
    "information": (lambda: informed(np.full((2, 2), 1e99)), "start, motions and sensors must"),
    **{
        scheme.__name__: (
            lambda scheme=scheme: scheme(np.ones(3), MANY, rng=RNG(0)),
            "count must be from 1 to 100000000, got 1000000000000",
        )
        for scheme in (
            *(particles.systematic, particles.stratified),
            *(particles.multinomial, particles.residual),
        )
    },
    "drive": (
        lambda: building.drive(building.make_building(rng=RNG(0)), step=1e-320),
        "step must make at most 10000000",
    ),
    "drive in an office": (
        lambda: office.drive(office.make_office(rng=RNG(0), rooms=2), step=1e-200),
        "step must be finite and from 1e-09",
    ),
}


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_the_error_is_ours_and_names_the_value(name):
    call, said = CALLS[name]
    with unchecked(), pytest.raises(ValueError) as caught:
        call()
    assert type(caught.value) is ValueError
    assert str(caught.value).startswith(said)


def test_arrays_that_are_not_to_be_written_to_are_read():
    twist = RNG(0).normal(size=(4, 6))
    fixed = twist.copy()
    fixed.flags.writeable = False
    assert np.array_equal(se3.exp(fixed), se3.exp(twist))
    assert np.abs(se3.log(se3.exp(fixed)) - twist).max() < 1e-12


def test_within_the_bound_products_of_three_numbers_are_finite():
    assert np.isfinite(checks.LARGEST**3)
    assert checks.moderate("x", 1e100) == 1e100
    assert np.isfinite(numeric.MOST_STEPS)


@pytest.mark.parametrize("error", [np.linalg.LinAlgError, OverflowError, ZeroDivisionError])
def test_what_arithmetic_gives_up_on_is_a_value_error(error):
    said = r"^x must not have numbers too large.*\(gave up\)$"
    with pytest.raises(ValueError, match=said) as caught, checks.computable("x"):
        raise error("gave up")
    assert type(caught.value) is ValueError


@pytest.mark.parametrize(
    "compute",
    [
        lambda x: np.exp(800 + x),
        lambda x: 1 / x,
        lambda x: x / x,
    ],
    ids=["overflow", "division by zero", "not a number"],
)
def test_what_numpy_would_warn_of_is_a_value_error(compute):
    with pytest.raises(ValueError, match=r"^x must not have numbers"), checks.computable("x"):
        compute(np.zeros(1))
    with checks.computable("x"):
        assert np.exp(np.array(-800.0)) == 0, "what is too small to matter is no matter"
