"""A step of the planar filter against filterpy's and roboticstoolbox's, and its growth.

Beyond a few hundred landmarks one leaves the covariance aside and smooths the whole drive: gtsam's
incremental smoother (iSAM2) is what one uses then. Here the filter is the subject.
"""

import time
from types import SimpleNamespace

import numpy as np
from scipy.linalg.blas import dsyrk

from robot_perception.slam.planar import (
    CartesianSensor,
    MapBelief,
    Observations,
    Odometry,
    Settings,
    Step,
    run_filter,
    textbook,
)
from tests.tools.benchmarks.harness import Row, Timing

SEEN = 10
Q, R = np.diag([0.02**2, 0.02**2, 0.01**2]), np.diag([0.05**2, 0.05**2])
CART = CartesianSensor(R)


def world(landmarks: int) -> tuple[MapBelief, Step]:
    """Return a map of so many landmarks with all correlations, and a step that sees ten of them."""
    rng = np.random.default_rng(landmarks)
    size = 3 + 2 * landmarks
    root = rng.standard_normal((size, 40))
    cov = 1e-3 * root @ root.T / 40 + 1e-4 * np.eye(size)
    mean = np.concatenate([[0.0, 0.0, 0.3], rng.uniform(-20, 20, 2 * landmarks)])
    belief = MapBelief(mean, cov, np.arange(landmarks))
    ids = rng.permutation(landmarks)[:SEEN]
    motion = Odometry(np.array([0.1, 0.0, 0.02]), Q)
    values = CART.expect(motion.move(belief.pose), belief.landmarks[ids])[0]
    return belief, Step(motion, Observations(ids, values + 0.05 * rng.standard_normal((SEEN, 2))))


def matrices(belief: MapBelief, step: Step) -> tuple[np.ndarray, ...]:
    """Return F, the noise of the motion in the world, H, the expected values and the moved mean."""
    moved = textbook.predict(belief, step.motion)
    F = textbook.motion_matrix(belief.mean, moved.mean)
    _, G = step.motion.jacobians(belief.pose)
    noise = np.zeros_like(F)
    noise[:3, :3] = G @ Q @ G.T
    slots = [belief.slot(name) for name in step.observations.ids]
    places = belief.landmarks[step.observations.ids]
    H = textbook.measurement_matrix(moved.mean, slots, places, CART)
    return F, noise, H, CART.expect(moved.pose, places)[0].ravel(), moved.mean


class Filterpy:
    """filterpy's extended filter, given the Jacobians."""

    def __init__(self, belief: MapBelief, step: Step) -> None:
        from filterpy.kalman import ExtendedKalmanFilter

        self.belief, self.step = belief, step
        self.F, noise, self.H, self.expected, self.moved = matrices(belief, step)
        self.filter = ExtendedKalmanFilter(belief.mean.size, 2 * SEEN)
        self.filter.F, self.filter.Q = self.F, noise
        self.filter.R = np.kron(np.eye(SEEN), R)
        self.filter.predict_x = self._move
        self.values = step.observations.values.reshape(-1, 1)

    def _move(self, u: object = 0) -> None:
        self.filter.x = self.moved[:, None].copy()

    def start(self) -> None:
        """Put the filter back to the belief it starts from."""
        self.filter.x, self.filter.P = self.belief.mean[:, None].copy(), self.belief.cov

    def __call__(self) -> None:
        """Take the step."""
        self.filter.predict()
        self.filter.update(self.values, lambda _: self.H, lambda _: self.expected[:, None])

    def result(self) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and covariance."""
        return self.filter.x[:, 0], self.filter.P


class Toolbox:
    """roboticstoolbox's filter on a given step.

    Its filter drives its own simulated vehicle and takes one observation a step, so stubs of the
    vehicle and the sensor hand it ours: the first of ten steps moves, the others stand still. The
    stub sensor is linear about one state; then ten updates one after the other are the same as one
    of all. It has two forms of the covariance: P - K S Kᵀ, which is measured, and Joseph's, its
    default, which takes about ten times as long.
    """

    def __init__(self, belief: MapBelief, step: Step) -> None:
        from roboticstoolbox.mobile import EKF

        self.belief, self.step, self.turn = belief, step, 0
        F, _, H, expected, self.moved = matrices(belief, step)
        _, G = step.motion.jacobians(belief.pose)
        ids, values = step.observations.ids.tolist(), step.observations.values
        slots = [belief.slot(name) for name in ids]
        expected, H = expected.reshape(-1, 2), H.reshape(SEEN, 2, -1)
        by_point = [H[i, :, slot : slot + 2] for i, slot in enumerate(slots)]

        def seen(pose: np.ndarray, point: np.ndarray | int) -> np.ndarray:
            i = self.turn
            if isinstance(point, int):  # its guess by the number of the landmark, not used
                return expected[i]
            known = self.moved[slots[i] : slots[i] + 2]
            return (
                expected[i] + H[i, :, :3] @ (pose - self.moved[:3]) + by_point[i] @ (point - known)
            )

        vehicle = SimpleNamespace(
            step=lambda pause: step.motion.increment,
            f=lambda pose, _: self.moved[:3] if self.turn == 0 else pose,
            Fx=lambda *_: F[:3, :3] if self.turn == 0 else np.eye(3),
            Fv=lambda *_: G if self.turn == 0 else np.zeros((3, 3)),
        )
        sensor = SimpleNamespace(
            reading=lambda: (values[self.turn], ids[self.turn]),
            h=seen,
            Hx=lambda *_: H[self.turn, :, :3],
            Hp=lambda *_: by_point[self.turn],
            Hw=lambda *_: np.eye(2),
        )
        self.filter = object.__new__(EKF)
        self.filter.__dict__.update(
            _robot=vehicle,
            _sensor=sensor,
            _V_est=Q,
            _W_est=R,
            _est_vehicle=True,
            _est_ekf_map=True,
            _joseph=False,
            _verbose=False,
            _keep_history=False,
            _landmarks={name: [name, 1] for name in range(belief.ids.size)},
        )

    def start(self) -> None:
        """Put the filter back to the belief it starts from."""
        self.filter._x_est, self.filter._P_est = self.belief.mean, self.belief.cov

    def __call__(self) -> None:
        """Take the step: ten of the toolbox's."""
        for self.turn in range(SEEN):
            self.filter.step()

    def result(self) -> tuple[np.ndarray, np.ndarray]:
        """Return mean and covariance."""
        return self.filter._x_est, self.filter._P_est


def _ours(belief: MapBelief, step: Step, steps: int) -> MapBelief:
    return run_filter(belief, [step] * steps, Settings(CART)).belief


def _row(landmarks: int, name: str, peer_of: type, ratio: float, steps: int) -> Row:
    belief, step = world(landmarks)
    peer = peer_of(belief, step)

    def agree() -> None:
        ours = run_filter(belief, [step], Settings(CART)).belief
        peer.start()
        peer()
        mean, cov = peer.result()
        np.testing.assert_allclose(ours.mean, mean, rtol=0, atol=1e-9)
        np.testing.assert_allclose(ours.cov, cov, rtol=0, atol=1e-9)

    def theirs() -> None:
        peer.start()
        for _ in range(steps):
            peer()

    return Row(
        work=f"planar EKF-SLAM, {steps} steps, {SEEN} landmarks seen of {landmarks}",
        ours=lambda: _ours(belief, step, steps),
        peer=theirs,
        peer_name=name,
        ratio=ratio,
        agree=agree,
        repeats=9 if landmarks < 500 else 3,
    )


def _floor(landmarks: int) -> Row:
    """Return our steps beside as many bare symmetric updates of rank 2 × 10 by BLAS."""
    steps, (belief, step) = 100, world(landmarks)
    cov = np.asfortranarray(belief.cov)
    strip = np.asfortranarray(1e-9 * np.random.default_rng(0).standard_normal((len(cov), 2 * SEEN)))

    def floor() -> None:
        for _ in range(steps):
            dsyrk(-1.0, strip, 1.0, cov, overwrite_c=1)

    return Row(
        work=f"planar EKF-SLAM, {steps} steps, {SEEN} landmarks seen of {landmarks}",
        ours=lambda: _ours(belief, step, steps),
        peer=floor,
        peer_name="rank-20 update of BLAS (the floor)",
        ratio=1 / 1.6,
    )


def growth(sizes: tuple[int, ...] = (125, 250, 500, 1000)) -> Timing:
    """Return the exponent of the time of a step against the size of the map, fitted over sizes.

    The work is quadratic. The limit lies 0.2 above, as a large covariance leaves the processor's
    caches: half as much again for each entry over three doublings is log2(1.5) / 3 = 0.2.
    """
    worlds, samples = [world(landmarks) for landmarks in sizes], []
    for _ in range(7):
        for belief, step in worlds:  # in turn, so that a busy spell hits all sizes
            times = []
            for steps in (1, 11):
                begin = time.perf_counter()
                _ours(belief, step, steps)
                times.append(time.perf_counter() - begin)
            samples.append((times[1] - times[0]) / 10)
    seconds = np.median(np.reshape(samples, (-1, len(sizes))), axis=0)
    exponent = float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])
    return Timing(
        work=f"planar EKF-SLAM step, {sizes[0]} to {sizes[-1]} landmarks: exponent {exponent:.2f} "
        "(beyond a few hundred one uses an incremental smoother such as gtsam's iSAM2)",
        ours_s=float(seconds[-1]),
        peer_s=None,
        peer_name="",
        target="exponent ≤ 2.2",
        reached=exponent <= 2.2,
    )


def rows() -> list[Row | Timing]:
    """Return the rows of the benchmark table that concern the planar filter."""
    return [
        _row(100, "filterpy ExtendedKalmanFilter", Filterpy, 9, 20),
        _row(500, "filterpy ExtendedKalmanFilter", Filterpy, 75, 20),
        _row(100, "roboticstoolbox EKF", Toolbox, 15, 20),
        _row(500, "roboticstoolbox EKF", Toolbox, 45, 20),
        _floor(500),
        growth(),
    ]
