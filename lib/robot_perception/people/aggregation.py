r"""People around the robot from what several sensors say, one reading after the other.

A hypothesis is a normal distribution of distance and direction :math:`(r, \varphi)` about the
robot, with a weight. A reading predicts all hypotheses to its time, is associated with them, merged
into those that it confirms, and lowers the weights of the others:

``Aggregator(rules).step(state, detections, motion) -> (Hypotheses, AggregationInfo)``

Which sensors there are is open: one more takes a detector that returns normal distributions, a name
and its :class:`SensorRules` under that name.

Equation numbers are those of Schaffernicht, Martin, Scheidig and Gross, section 3.2.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Literal

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception import checks
from robot_perception.beliefs import Gaussian
from robot_perception.fusion import (
    covariance_intersection,
    kalman_fusion,
    omega_determinants,
    omega_least_determinant,
    omega_least_trace,
)
from robot_perception.gating import gate, greedy
from robot_perception.geometry import wrap_angle
from robot_perception.people.detections import Detections, named

OMEGAS = {
    "determinants": omega_determinants,
    "least determinant": omega_least_determinant,
    "least trace": omega_least_trace,
}
NEAREST = 0.1  # m; nearer the frame of distance and direction has no meaning
ANGLES = (1,)


@dataclass(frozen=True, slots=True)
class SensorRules:
    r"""Rules for a sensor: how much it is trusted, and what it means that it reports nothing.

    Parameters
    ----------
    alpha
        Share of what is missing to 1 by which a match raises a weight, α of eq. (5), above 0.
    patience
        Seconds after which a weight of 1 has fallen to θ if nothing is seen, :math:`t_v` of
        eq. (6).
    alpha_behind
        α for people behind the robot, :math:`|\varphi| > \pi/2`; the same if left out.
    reach
        The sensor sees nobody who is further away, m.
    sector
        Directions from which to which it sees, counter-clockwise, rad. Its silence lowers no weight
        outside its sector and reach.
    silence
        Whether its silence lowers weights at all: somebody who is not seen may have gone, somebody
        who is not heard is silent.

    Raises
    ------
    ValueError
        If an α is not above 0 and at most 1, the patience or the reach not positive, or the sector
        not two directions that rise by a full turn at most.
    """

    alpha: float
    patience: float
    alpha_behind: float | None = None
    reach: float = np.inf
    sector: tuple[float, float] = (-np.pi, np.pi)
    silence: bool = True

    def __post_init__(self) -> None:
        for name in ("alpha", "alpha_behind"):
            value = getattr(self, name)
            if (name == "alpha" or value is not None) and checks.share(name, value) == 0:
                raise ValueError(f"{name} must be above 0, got {checks.shown(value)}")
        object.__setattr__(self, "patience", checks.positive("patience", self.patience))
        if not checks.number("reach", self.reach, finite=False) > 0:
            raise ValueError(f"reach must be positive, got {checks.shown(self.reach)}")
        begin, end = checks.vector("sector", self.sector, 2).tolist()
        if not 0 < end - begin <= 2 * np.pi:
            raise ValueError(f"sector must rise by a full turn at most, got {self.sector}")
        object.__setattr__(self, "sector", (begin, end))
        checks.flag("silence", self.silence)

    def sees(self, mean: Float[np.ndarray, "n 2"]) -> Bool[np.ndarray, " n"]:
        """Tell which positions (r, φ) are in reach and sector.

        Raises
        ------
        ValueError
            If they are not (n, 2) or not finite.
        """
        r, phi = checks.array("mean", mean, ("n", 2)).T
        begin, end = self.sector
        return (r <= self.reach) & ((phi - begin) % (2 * np.pi) <= end - begin)


@dataclass(frozen=True, slots=True)
class _Sensors(Mapping[str, SensorRules]):
    """Names and rules of sensors, in the order of the alphabet: a mapping that does not change."""

    rows: tuple[tuple[str, SensorRules], ...]

    @classmethod
    def of(cls, rules: Mapping[str, SensorRules]) -> "_Sensors":
        """Return the sensors of any mapping, or raise."""
        if not checks.entries("sensors", rules, SensorRules):
            raise ValueError("sensors must be one at least, got none")
        return cls(tuple(sorted((named("sensors", name), one) for name, one in rules.items())))

    def __getitem__(self, name: str) -> SensorRules:
        return dict(self.rows)[name]

    def __iter__(self) -> Iterator[str]:
        return iter(dict(self.rows))

    def __len__(self) -> int:
        return len(self.rows)


THREE = _Sensors.of(
    {
        "laser": SensorRules(alpha=0.3, patience=3.0),
        "sonar": SensorRules(alpha=0.1, patience=5.0),
        "camera": SensorRules(alpha=0.15, patience=4.0, alpha_behind=0.3),
    }
)
"""The sensors of the paper; the values are ours."""


@dataclass(frozen=True, slots=True)
class AggregationRules:
    r"""The rules of the aggregation. The paper names them and gives no values: these are ours.

    Parameters
    ----------
    threshold
        Weight θ below which a hypothesis is deleted. A new one starts at :math:`\theta +
        \alpha (1 - \theta)`.
    person
        Weight above which a hypothesis counts as a person; not below θ.
    level
        Probability that a right pair of reading and hypothesis passes the gate of eq. (2).
    alike
        Squared Mahalanobis distance below which two hypotheses are made one; 0: never.
    walk
        How far a person gets in a second, standard deviation on each axis, m: people move at
        random, so that the variance grows with the time.
    fusion
        How a reading is merged: ``"intersection"``, eq. (3), or ``"kalman"``, as if the errors were
        independent.
    omega
        Weight ω of the intersection: ``"determinants"``, eq. (4), ``"least determinant"`` or
        ``"least trace"``.
    sensors
        The sensors that there are, by name, and how much each is trusted. One more is
        ``sensors={**rules.sensors, "microphone": SensorRules(…)}``.

    Raises
    ------
    ValueError
        If a weight or the level is not between 0 and 1, ``person`` is below the threshold, a number
        is negative, a word is none of these, or there is no sensor or one without a name.
    """

    threshold: float = 0.2
    person: float = 0.5
    level: float = 0.99
    alike: float = 1.0
    walk: float = 0.5
    fusion: Literal["intersection", "kalman"] = "intersection"
    omega: Literal["determinants", "least determinant", "least trace"] = "determinants"
    sensors: Mapping[str, SensorRules] = THREE
    limit: float = field(init=False)

    def __post_init__(self) -> None:
        threshold = checks.level("threshold", self.threshold)
        if checks.level("person", self.person) < threshold:
            raise ValueError(
                f"person must not be below the threshold {threshold}, got {self.person}"
            )
        object.__setattr__(self, "alike", checks.not_negative("alike", self.alike))
        object.__setattr__(self, "walk", checks.not_negative("walk", self.walk))
        checks.one_of("fusion", self.fusion, ("intersection", "kalman"))
        checks.one_of("omega", self.omega, OMEGAS)
        object.__setattr__(self, "sensors", _Sensors.of(self.sensors))
        object.__setattr__(self, "limit", gate(checks.level("level", self.level), 2))


@dataclass(frozen=True, eq=False, slots=True)
class Hypotheses:
    r"""Hypotheses of people, n of them: the paper's local map :math:`M = \{\mu_i, C_i, w_i\}`.

    Parameters
    ----------
    mean : (n, 2)
        Distance and direction :math:`(r, \varphi)` about the robot, m and rad.
    cov : (n, 2, 2)
        Their covariances.
    weight : (n,)
        From 0 to 1.
    identity : (n,)
        A number that stays with a hypothesis; they rise, the oldest first.
    born : (n,)
        When it came up, s.
    last_seen : (n,)
        When it was last confirmed, s.
    charged : (n,)
        Until when eq. (6) has been counted, s: a sensor that says nothing of a hypothesis takes no
        time from it.
    heard
        When each sensor that has spoken last did, by name, s.
    following
        The next identity.

    Raises
    ------
    ValueError
        If shapes disagree, a number is not finite, a covariance none or singular, a weight not from
        0 to 1, a distance negative, or the identities do not rise to below the next.
    """

    mean: Float[np.ndarray, "n 2"]
    cov: Float[np.ndarray, "n 2 2"]
    weight: Float[np.ndarray, " n"]
    identity: Int[np.ndarray, " n"]
    born: Float[np.ndarray, " n"]
    last_seen: Float[np.ndarray, " n"]
    charged: Float[np.ndarray, " n"]
    heard: Mapping[str, float]
    following: int

    def __post_init__(self) -> None:
        mean = checks.array("mean", self.mean, ("n", 2))
        n, beside = len(mean), f"mean {mean.shape}"
        if (mean[:, 0] < 0).any():
            raise ValueError(f"mean must not have a negative distance, got {mean[:, 0].min()}")
        weight = checks.array("weight", self.weight, (n,), beside)
        if not ((weight >= 0) & (weight <= 1)).all():
            raise ValueError(f"weight must be from 0 to 1, got {checks.shown(self.weight)}")
        identity = checks.integers("identity", self.identity, (n,), 0, beside)
        following = checks.whole("following", self.following, 0)
        if not (np.diff(identity, append=following) > 0).all():
            raise ValueError(f"identity must rise to below {following}, got {identity.tolist()}")
        said = checks.instance("heard", self.heard, Mapping).items()
        heard = {named("heard", name): checks.number(f"heard of {name}", t) for name, t in said}
        cov = checks.covariance("cov", self.cov, (n, 2, 2), beside)
        if not (_determinants(cov) > 0).all():
            raise ValueError("cov must be positive definite, got a singular one")
        born = checks.array("born", self.born, (n,), beside)
        last_seen = checks.array("last_seen", self.last_seen, (n,), beside)
        charged = checks.array("charged", self.charged, (n,), beside)
        values = (mean, cov, weight, identity, born, last_seen, charged, heard, following)
        for name, value in zip((f.name for f in fields(self)), values, strict=True):
            object.__setattr__(self, name, value)

    @classmethod
    def none(cls) -> "Hypotheses":
        """Return what a robot knows that has not yet looked."""
        none = np.zeros(0)
        identity = np.zeros(0, dtype=np.int64)
        return cls(none.reshape(0, 2), np.zeros((0, 2, 2)), none, identity, *[none] * 3, {}, 0)

    def __len__(self) -> int:
        return len(self.mean)

    @property
    def time(self) -> float:
        """Time of the last report of a sensor, s; -inf if there is none."""
        return max(self.heard.values(), default=-np.inf)

    @property
    def points(self) -> Float[np.ndarray, "n 2"]:
        """The means as points (x, y) in the frame of the robot, m."""
        return _points(self.mean)

    def select(self, chosen: Bool[np.ndarray, " n"]) -> "Hypotheses":
        """Return some of the hypotheses.

        Parameters
        ----------
        chosen : (n,)
            Which ones.

        Raises
        ------
        ValueError
            If there is not one truth value for each.
        """
        mask = np.asarray(chosen)
        if mask.dtype != bool or mask.shape != (len(self),):
            raise ValueError(f"chosen must be {len(self)} truth values, got {checks.shown(chosen)}")
        parts = (getattr(self, entry.name) for entry in fields(self)[:-2])
        return Hypotheses(*(part[mask] for part in parts), self.heard, self.following)

    def persons(self, rules: AggregationRules) -> "Hypotheses":
        """Return those whose weight makes them persons."""
        checks.instance("rules", rules, AggregationRules)
        return self.select(self.weight > rules.person)


@dataclass(frozen=True, eq=False, slots=True)
class AggregationInfo:
    """Diagnostics of one reading.

    Parameters
    ----------
    identities : (m,)
        The hypothesis that each detection confirmed or brought up. One that was made one with
        another in the same step has that one's identity.
    matched : (m,)
        Whether it was there before.
    removed
        Identities of the hypotheses deleted.
    absorbed
        Pairs of identities (kept, gone) of those made one, in their order.
    compared
        Of how many pairs of distributions the distance, eq. (2), was computed: of detections and
        hypotheses, and of hypotheses among each other. It is what a reading costs.
    """

    identities: Int[np.ndarray, " m"]
    matched: Bool[np.ndarray, " m"]
    removed: tuple[int, ...]
    absorbed: tuple[tuple[int, int], ...]
    compared: int


@dataclass(frozen=True, slots=True)
class Aggregator:
    """Joins what several sensors say to people about the robot.

    Parameters
    ----------
    rules
        How readings are associated and merged, and when a hypothesis is forgotten.

    References
    ----------
    Schaffernicht et al., section 3.2.
    """

    rules: AggregationRules = field(default_factory=AggregationRules)

    def __post_init__(self) -> None:
        checks.instance("rules", self.rules, AggregationRules)

    def start(self) -> Hypotheses:
        """Return what is known before the first reading: nobody."""
        return Hypotheses.none()

    def step(
        self,
        state: Hypotheses,
        detections: Detections,
        motion: Float[np.ndarray, "3"],
    ) -> tuple[Hypotheses, AggregationInfo]:
        r"""Return the hypotheses after one reading of one sensor.

        They are predicted to its time, and pairs of reading i and hypothesis j associated, the
        nearest first, while

        .. math:: d_m = (\mu_i - \mu_j)^\top (C_i + C_j)^{-1} (\mu_i - \mu_j)

        is inside the gate. A pair is merged by covariance intersection, and the weight raised by
        :math:`w \leftarrow w + \alpha (1 - w)`; of a hypothesis without a match it is lowered,
        :math:`w \leftarrow w - (1 - \theta) (t - t_{old}) / t_v`, and it is deleted below θ. The
        :math:`t_v` is that of the sensor that did not see it; a sensor that could not have seen it,
        or whose silence says nothing, leaves its weight, and the time to the next one. A detection
        without a match is a new hypothesis. Hypotheses that have become alike are made one: the
        older identity and the larger weight stay.

        Parameters
        ----------
        state
            Before the reading.
        detections
            The reading. Readings of several sensors may have the same time, of one sensor not.
        motion : (3,)
            Pose (x, y, φ) of the robot at this reading as seen from its pose at the last one, m and
            rad.

        Raises
        ------
        ValueError
            If the rules have no such sensor, the reading is older than the last one, or as old as
            the last one of the same sensor, a covariance of it is singular, or the motion is not
            (3,) or not finite.

        References
        ----------
        Schaffernicht et al., eqs (2) to (6).
        """
        checks.instance("state", state, Hypotheses)
        checks.instance("detections", detections, Detections)
        rules = self.rules
        sensor = _sensor(detections, rules)
        elapsed = _elapsed(state, detections)
        readings = Gaussian(_clear(detections.positions.mean), detections.positions.cov)
        if not (_determinants(readings.cov) > 0).all():
            raise ValueError("detections must have regular covariances, got a singular one")
        before = predict(state, elapsed, motion, rules.walk)
        distances = _distances(readings.mean, readings.cov, before.mean, before.cov)  # eq. (2)
        assignment = greedy(distances, rules.limit)
        matched = assignment >= 0
        i, j = np.flatnonzero(matched), assignment[matched]

        mean, cov = before.mean.copy(), before.cov.copy()
        mean[j], cov[j] = _merged(
            Gaussian(readings.mean[i], readings.cov[i]), Gaussian(mean[j], cov[j]), rules
        )
        seen = np.zeros(len(before), dtype=bool)
        seen[j] = True
        missed = ~seen & sensor.silence & sensor.sees(before.mean)
        raised = before.weight + _alphas(sensor, mean[:, 1]) * (1 - before.weight)  # eq. (5)
        waited = detections.time - before.charged
        lowered = before.weight - (1 - rules.threshold) * waited / sensor.patience  # eq. (6)
        weight = np.where(seen, raised, np.where(missed, lowered, before.weight))
        kept = weight >= rules.threshold

        new, m = readings.mean[~matched], int((~matched).sum())
        start = rules.threshold + _alphas(sensor, new[:, 1]) * (1 - rules.threshold)
        now, fresh = np.full(m, detections.time), state.following + np.arange(m)
        identities = np.empty(len(matched), dtype=np.int64)
        identities[matched], identities[~matched] = before.identity[j], fresh
        after = Hypotheses(
            np.concatenate([mean[kept], new]),
            np.concatenate([cov[kept], readings.cov[~matched]]),
            np.concatenate([weight[kept], start]),
            np.concatenate([before.identity[kept], fresh]),
            np.concatenate([before.born[kept], now]),
            np.concatenate([np.where(seen, detections.time, before.last_seen)[kept], now]),
            np.concatenate([np.where(seen | missed, detections.time, before.charged)[kept], now]),
            {**state.heard, detections.sensor: detections.time},
            state.following + m,
        )
        after, absorbed, compared = _united(after, rules)
        for stays, goes in absorbed:
            identities[identities == goes] = stays
        removed = tuple(before.identity[~kept].tolist())
        info = AggregationInfo(identities, matched, removed, absorbed, distances.size + compared)
        return after, info


def predict(
    hypotheses: Hypotheses, duration: float, motion: Float[np.ndarray, "3"], walk: float
) -> Hypotheses:
    r"""Return the hypotheses as they are after a while, about the robot where it is then.

    With :math:`p = r (\cos\varphi, \sin\varphi)` the mean moves exactly, and so that distances and
    directions are those about the new pose (t, ψ); the covariance by the derivative:

    .. math::
        p' = R(\psi)^\top (p - t), \qquad
        C' = J C J^\top + \sigma^2 \Delta t \begin{bmatrix} 1 & 0 \\ 0 & r'^{-2} \end{bmatrix},
        \qquad
        J = \begin{bmatrix} \cos\beta & -r \sin\beta \\ \sin\beta / r' & r \cos\beta / r'
        \end{bmatrix}

    with :math:`\beta = \varphi - \psi - \varphi'`, the angle by which the line of sight turns.

    Parameters
    ----------
    hypotheses
        Before.
    duration
        Δt, s, not negative.
    motion : (3,)
        New pose (x, y, φ) of the robot as seen from the old one, m and rad. Its error is not
        counted: it is small beside what people may do meanwhile.
    walk
        σ: how far a person gets in a second, standard deviation on each axis, m.

    Raises
    ------
    ValueError
        If a number is negative, not finite or beyond 1e100, or the motion not (3,).
    """
    checks.instance("hypotheses", hypotheses, Hypotheses)
    duration = checks.not_negative("duration", duration)
    motion = checks.array("motion", motion, (3,))
    walk = checks.not_negative("walk", walk)
    r, phi = _clear(hypotheses.mean).T
    x, y = (_points(hypotheses.mean) - motion[:2]).T
    mean = _clear(np.stack([np.hypot(x, y), wrap_angle(np.arctan2(y, x) - motion[2])], axis=-1))
    beta = phi - motion[2] - mean[:, 1]
    cos, sin, near = np.cos(beta), np.sin(beta), mean[:, 0]
    J = np.stack([cos, -r * sin, sin / near, r * cos / near], axis=-1).reshape(-1, 2, 2)
    cov = J @ hypotheses.cov @ J.mT
    cov[:, 0, 0] += walk**2 * duration
    cov[:, 1, 1] += walk**2 * duration / near**2
    return replace(hypotheses, mean=mean, cov=(cov + cov.mT) / 2)


def _sensor(detections: Detections, rules: AggregationRules) -> SensorRules:
    """Return the rules of the sensor that speaks, or raise."""
    if detections.sensor not in rules.sensors:
        raise ValueError(
            f"rules must be given for the sensor {detections.sensor!r}, got some for "
            f"{', '.join(rules.sensors)}"
        )
    return rules.sensors[detections.sensor]


def _elapsed(hypotheses: Hypotheses, detections: Detections) -> float:
    """Return the time since the last reading, s, or refuse what comes too late."""
    last = hypotheses.heard.get(detections.sensor, -np.inf)
    if detections.time < hypotheses.time:
        raise ValueError(
            "detections must not be older than the last reading, of"
            f" {checks.shown(hypotheses.time)} s, got {checks.shown(detections.time)} s"
        )
    if detections.time == last:
        raise ValueError(
            f"detections of the {detections.sensor} at {checks.shown(last)} s were there already"
        )
    return 0.0 if hypotheses.time == -np.inf else detections.time - hypotheses.time


def _alphas(sensor: SensorRules, phi: np.ndarray) -> np.ndarray:
    """Return α for people in some directions."""
    behind = sensor.alpha if sensor.alpha_behind is None else sensor.alpha_behind
    return np.where(np.abs(phi) > np.pi / 2, behind, sensor.alpha)


def _merged(
    a: Gaussian, b: Gaussian, rules: AggregationRules
) -> tuple[Float[np.ndarray, "k 2"], Float[np.ndarray, "k 2 2"]]:
    """Return means and covariances of pairs made one, a reading first."""
    if rules.fusion == "kalman":
        fused = kalman_fusion(a, b, angles=ANGLES)
    else:
        fused = covariance_intersection(a, b, OMEGAS[rules.omega](a, b), angles=ANGLES)
    return _clear(fused.mean), fused.cov


def _united(
    found: Hypotheses, rules: AggregationRules
) -> tuple[Hypotheses, tuple[tuple[int, int], ...], int]:
    """Make hypotheses one that are nearer than the limit, the nearest first; say how many pairs
    were compared.
    """
    distances = _distances(found.mean, found.cov, found.mean, found.cov)
    compared = distances.size
    distances[np.tril_indices(len(found))] = np.inf
    if not (distances < rules.alike).any():
        return found, (), compared
    mean, cov, weight = found.mean.copy(), found.cov.copy(), found.weight.copy()
    last_seen, absorbed, left = found.last_seen.copy(), [], np.ones(len(found), dtype=bool)
    while (nearest := distances.min()) < rules.alike:
        i, j = (int(k[0]) for k in np.nonzero(distances == nearest))  # i is older
        one, other = (Gaussian(mean[[k]], cov[[k]]) for k in (j, i))
        (mean[i],), (cov[i],) = _merged(one, other, rules)
        weight[i], last_seen[i] = max(weight[[i, j]]), max(last_seen[[i, j]])
        left[j] = False
        distances[j] = distances[:, j] = np.inf
        to_i = np.where(left, _distances(mean[[i]], cov[[i]], mean, cov)[0], np.inf)
        distances[i, i + 1 :], distances[:i, i] = to_i[i + 1 :], to_i[:i]
        compared += len(to_i)
        absorbed.append((int(found.identity[i]), int(found.identity[j])))
    united = replace(found, mean=mean, cov=cov, weight=weight, last_seen=last_seen)
    return united.select(left), tuple(absorbed), compared


def _distances(
    means_a: np.ndarray, covs_a: np.ndarray, means_b: np.ndarray, covs_b: np.ndarray
) -> Float[np.ndarray, "m n"]:
    """Return the squared Mahalanobis distances of all pairs, eq. (2)."""
    along, across = np.moveaxis(means_a[:, None] - means_b, -1, 0)
    across = wrap_angle(across)
    S = covs_a[:, None] + covs_b
    squared = S[..., 1, 1] * along**2 - 2 * S[..., 0, 1] * along * across
    return (squared + S[..., 0, 0] * across**2) / _determinants(S)


def _determinants(covs: np.ndarray) -> np.ndarray:
    """Return determinants, 0 where a covariance is singular but for rounding."""
    straight, mixed = covs[..., 0, 0] * covs[..., 1, 1], covs[..., 0, 1] ** 2
    return np.where(straight - mixed > 1e-14 * straight, straight - mixed, 0.0)


def _clear(mean: np.ndarray) -> np.ndarray:
    """Return positions, none of them nearer to the robot than has a meaning."""
    return np.stack([np.maximum(mean[:, 0], NEAREST), mean[:, 1]], axis=-1)


def _points(mean: np.ndarray) -> np.ndarray:
    r, phi = mean.T
    return np.stack([r * np.cos(phi), r * np.sin(phi)], axis=-1)
