"""A face's Kalman filter against the house's own, its window, and when it gives up."""

from dataclasses import dataclass, field, replace

import numpy as np
import pytest

from robot_perception import kalman
from robot_perception.beliefs import Gaussian
from robot_perception.companion.boxes import overlap
from robot_perception.companion.faces.region import FaceTracker, RegionRules, RegionState

SIZE = (240, 320)
IMAGE = np.zeros(SIZE, dtype=np.uint8)
RULES = RegionRules()


@dataclass
class Told:
    """A detector that is told what is there, and finds of it what lies in the window."""

    boxes: np.ndarray = field(default_factory=lambda: np.zeros((0, 4)))
    windows: list = field(default_factory=list)
    sides: list = field(default_factory=list)

    def find(self, image, window=None, sides=None):
        self.windows.append(window)
        self.sides.append(sides)
        if window is None or not len(self.boxes):
            return self.boxes
        low, high = window[:2], window[:2] + window[2:]
        inside = (self.boxes[:, :2] >= low).all(1)
        inside &= (self.boxes[:, :2] + self.boxes[:, 2:] <= high).all(1)
        return self.boxes[inside]


def square(u, v, side):
    return np.array([u - side / 2, v - side / 2, side, side])


def run(boxes, rules=RULES):
    """Follow boxes (None where none is found); return states and what was seen."""
    detector = Told()
    tracker, found = FaceTracker(detector, rules), []
    state = tracker.start()
    for box in boxes:
        detector.boxes = np.zeros((0, 4)) if box is None else np.atleast_2d(box)
        state, info = tracker.step(state, IMAGE)
        found.append((state, info))
    return found


def test_prediction_and_update_are_those_of_the_house():
    tracker = FaceTracker(Told(), RULES)
    state = tracker.start(square(100, 80, 50))
    F = np.eye(6) + np.eye(6, k=3)
    half, whole = np.eye(3) * 0.25, np.eye(3)
    scale = np.diag([2.0**2, 2.0**2, 0.5**2])
    Q = np.block([[half @ scale, scale / 2], [scale / 2, whole @ scale]])
    expected = kalman.predict(state.belief, kalman.Motion(F, Q))
    ours = tracker.predict(state).belief
    np.testing.assert_allclose(ours.mean, expected.mean)
    np.testing.assert_allclose(ours.cov, expected.cov)
    box = square(104, 83, 48)
    tracker.detector.boxes = box[None]
    after, _ = tracker.step(state, IMAGE)
    H = np.eye(3, 6)
    R = np.diag((48 * np.array([0.05, 0.05, 0.08])) ** 2)
    theirs, _ = kalman.update(expected, np.array([104.0, 83.0, 48.0]), kalman.Sensor(H, R))
    np.testing.assert_allclose(after.belief.mean, theirs.mean)
    np.testing.assert_allclose(after.belief.cov, theirs.cov, atol=1e-9)


def test_its_errors_are_as_large_as_it_says():
    """Squared errors in units of the covariance: mean 6, over faces drawn from the model itself."""
    rng, rules = np.random.default_rng(0), replace(RULES, level=0.999999)
    F = np.eye(6) + np.eye(6, k=3)
    squares = []
    for _ in range(200):
        first = square(160, 120, 60.0)
        tracker = FaceTracker(Told(), rules)
        belief = tracker.start(first).belief
        truth = rng.multivariate_normal(belief.mean, belief.cov)
        state = RegionState(belief)
        for _ in range(8):
            push = np.concatenate([rng.normal(0, 2.0, 2), rng.normal(0, 0.5, 1)])
            truth = F @ truth + np.concatenate([push / 2, push])
            side = truth[2]
            seen = truth[:3] + side * rng.normal(0, [0.05, 0.05, 0.08])
            tracker.detector.boxes = square(*seen)[None]
            state, _ = tracker.step(state, IMAGE)
            if state.belief is None:
                break
        else:
            error = state.belief.mean - truth
            squares.append(error @ np.linalg.solve(state.belief.cov, error))
    assert len(squares) > 190
    # noise is taken from the measured side in place of the true one, hence the width of the range
    assert 5.3 < np.mean(squares) < 7.4


def test_misses_are_bridged_along_a_constant_velocity():
    way = [square(60 + 5 * k, 120, 50) for k in range(20)]
    found = run([*way[:10], *[None] * 6, *way[16:]])
    for k in range(10, 16):
        state, info = found[k]
        assert info.taken is None
        assert state.missed == k - 9
        assert overlap(state.box[None], way[k][None])[0, 0] > 0.75
    assert found[16][1].taken == 0
    assert found[16][0].missed == 0


def test_the_window_holds_the_face_grows_with_misses_and_becomes_the_picture():
    found = run([square(160, 120, 40)] * 6 + [None] * 20)
    areas = [info.searched for _, info in found]
    assert areas[0] == SIZE[0] * SIZE[1]
    assert found[0][1].whole
    assert areas[5] < 0.25 * areas[0]
    assert (np.diff(areas[6:]) >= 0).all()
    assert found[-1][1].whole
    state, _ = found[5]
    tracker = FaceTracker(Told(), RULES)
    left, top, wide, high = tracker.window(tracker.predict(state))
    x, y, side, _ = tracker.predict(state).box
    assert left < x
    assert top < y
    assert left + wide > x + side
    assert top + high > y + side


def test_more_standard_deviations_or_margin_make_the_window_wider_by_so_much():
    state = FaceTracker(Told(), RULES).start(square(160, 120, 40))
    usual = FaceTracker(Told(), RULES).window(state)
    spread = np.sqrt(state.belief.cov[0, 0] + state.belief.cov[2, 2] / 4)
    wider = FaceTracker(Told(), replace(RULES, sigmas=4.0)).window(state)
    assert wider[2] - usual[2] == pytest.approx(2 * spread)
    looser = FaceTracker(Told(), replace(RULES, margin=0.5)).window(state)
    assert looser[2] - usual[2] == pytest.approx(2 * 0.2 * 40)


def test_sides_are_looked_for_within_what_the_filter_expects():
    tracker = FaceTracker(Told(), RULES)
    state = tracker.start(square(160, 120, 40))
    spread = 3 * np.sqrt(state.belief.cov[2, 2])
    low, high = tracker.sides(state)
    assert low == pytest.approx((40 - spread) / 1.3)
    assert high == pytest.approx((40 + spread) * 1.3)


def test_another_face_in_the_window_is_not_taken():
    far = square(160 + 60, 120, 40)
    rules = replace(RULES, margin=3.0)
    found = run([square(160, 120, 40)] * 6 + [far], rules)
    assert found[-1][1].taken is None
    assert len(found[-1][1].boxes) == 1
    both = run([square(160, 120, 40)] * 6 + [np.array([far, square(161, 121, 40)])], rules)
    assert both[-1][1].taken == 1


def test_a_face_is_given_up_after_its_patience():
    rules = replace(RULES, patience=3)
    found = run([square(160, 120, 40), *[None] * 5], rules)
    assert [state.belief is None for state, _ in found] == [False, False, False, False, True, True]
    assert found[-1][1].whole
    assert found[-1][0].box is None
    assert found[-1][0].missed == 0


def test_who_is_followed_first_may_be_chosen():
    two = np.array([square(80, 100, 60), square(220, 100, 40)])
    tracker = FaceTracker(Told(two), RULES)
    nobody = tracker.start()
    assert tracker.step(nobody, IMAGE)[0].belief.mean[0] == 80
    last, none = (replace(tracker, choose=lambda boxes, one=one: one) for one in (1, None))
    assert last.step(nobody, IMAGE)[0].belief.mean[0] == 220
    state, info = none.step(nobody, IMAGE)
    assert state.belief is None
    assert info.taken is None


@pytest.mark.parametrize("ask", [FaceTracker.predict, FaceTracker.window, FaceTracker.sides])
def test_nothing_is_expected_of_nobody(ask):
    tracker = FaceTracker(Told(), RULES)
    with pytest.raises(ValueError, match="state must be of a face that is followed, got none"):
        ask(tracker, tracker.start())


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (lambda: RegionRules(acceleration=0.0), "acceleration must be"),
        (lambda: RegionRules(margin=-0.1), "margin must"),
        (lambda: RegionRules(level=1.0), "level must be"),
        (lambda: RegionRules(patience=-1), "patience must be"),
        (lambda: RegionState(Gaussian(np.zeros(4), np.eye(4))), "belief.mean must be"),
        (lambda: FaceTracker(Told()).start(np.zeros(4)), "box must have"),
        (
            lambda: FaceTracker(Told(square(9, 9, 5)[None]), choose=lambda boxes: 4).step(
                RegionState(), IMAGE
            ),
            "choose",
        ),
    ],
)
def test_what_is_wrong_is_named(wrong, text):
    with pytest.raises(ValueError, match=text):
        wrong()


def test_a_detector_has_a_method_find():
    with pytest.raises(TypeError, match="detector"):
        FaceTracker(object())


def test_the_gate_knows_that_the_prediction_is_uncertain_too():
    """Three deviations of prediction and detection together are more than three of either."""
    states = run([square(100, 100, 40)])
    expected = FaceTracker(Told(), RULES).predict(states[0][0])
    predicted, measured = np.sqrt(expected.belief.cov[0, 0]), RULES.place_sigma * 40
    away = 3 * np.hypot(predicted, measured)
    assert away > 1.3 * 4.03 * measured  # outside of the gate of a detection alone
    ((_, first), (_, info)) = run([square(100, 100, 40), square(100 + away, 100, 40)])
    assert first.taken == info.taken == 0


def test_of_a_face_that_was_told_once_nothing_is_known_of_its_motion():
    """Two deviations of an acceleration to either side, and what the detection is worth."""
    rules = RegionRules(acceleration=3.0, growth=0.7)
    belief = FaceTracker(Told(), rules).start(square(100, 80, 50)).belief
    np.testing.assert_array_equal(belief.mean, [100, 80, 50, 0, 0, 0])
    spread = [50 * rules.place_sigma, 50 * rules.place_sigma, 50 * rules.side_sigma, 6, 6, 1.4]
    np.testing.assert_allclose(belief.cov, np.diag(np.square(spread)))


def test_in_a_window_only_faces_of_the_expected_sizes_are_asked_for():
    detector = Told(square(100, 80, 50)[None])
    tracker = FaceTracker(detector, RULES)
    state = tracker.start(square(100, 80, 50))
    tracker.step(state, IMAGE)
    tracker.step(tracker.start(), IMAGE)
    assert detector.sides == [tracker.sides(tracker.predict(state)), None]


def test_a_prediction_remembers_for_how_long_the_face_was_missed():
    tracker = FaceTracker(Told(), RULES)
    state = replace(tracker.start(square(100, 80, 50)), missed=3)
    assert tracker.predict(state).missed == 3
    assert tracker.step(state, IMAGE)[0].missed == 4


def test_a_face_that_has_left_the_picture_is_given_up_at_once():
    tracker = FaceTracker(Told(), RULES)
    assert tracker.step(tracker.start(square(160, 120, 40)), IMAGE)[0].belief is not None
    assert tracker.step(tracker.start(square(-400, 120, 40)), IMAGE)[0].belief is None
