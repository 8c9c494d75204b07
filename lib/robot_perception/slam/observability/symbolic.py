r"""The three analyses in symbols.

The rank that each returns is exact for almost all states: it is counted in rational numbers at one
state, which bounds it from below, and directions along which the matrix vanishes identically bound
it from above. Where the two bounds meet (:attr:`Reading.proven`) the rank is proven.

Distances enter as half their squares, which are as good to know and keep everything rational.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any, Protocol, runtime_checkable

from robot_perception import checks
from robot_perception.extras import needing
from robot_perception.slam.observability.gauge import SHIFT_X, SHIFT_Y
from robot_perception.slam.observability.sensors import (
    Anchor,
    Heading,
    Landmarks,
    Position,
    StateSensor,
)
from robot_perception.slam.planar.sensors import RangeBearing

with needing():
    import sympy
    from sympy.polys.matrices import DomainMatrix
    from sympy.polys.polyerrors import ExactQuotientFailed

J = sympy.Matrix([[0, -1], [1, 0]])
DISPLACEMENT = sympy.symbols("d_x d_y", real=True)
SPEED, TURN_RATE = sympy.symbols("v omega", real=True)
ANCHORS = tuple(Anchor(*sympy.symbols(f"a_{i}x a_{i}y", real=True)) for i in (1, 2))
"""Two anchors at unnamed places."""


@runtime_checkable
class Formula(Protocol):
    """A sensor of one's own: what it measures, in symbols."""

    def formula(self, x: sympy.MatrixBase) -> sympy.MatrixBase:
        """Return the measurement (m, 1) of a state (3 + 2n, 1), robot first.

        A distance must enter as half its square, so that its derivatives are rational in the
        coordinates and in the cosine and sine of the heading.
        """


@dataclass(frozen=True, slots=True)
class Reading:
    """Result of the analysis of one set of sensors.

    Parameters
    ----------
    dimension, rank
        Size of the state, and how much of it is seen.
    unseen
        Motions of the whole world that no measurement shows.
    """

    dimension: int
    rank: int
    unseen: tuple[str, ...]

    @property
    def full(self) -> bool:
        """True if the whole state is observable."""
        return self.rank == self.dimension

    @property
    def proven(self) -> bool:
        """True if the unseen motions account for all that the rank lacks."""
        return self.rank + len(self.unseen) == self.dimension


MOST_LANDMARKS = 100

Pose = tuple[sympy.Expr, sympy.Expr, sympy.Expr]


def pose(step: int = 0) -> Pose:
    """Return the symbols of a pose (x, y, heading) at a step, counted from 0."""
    checks.whole("step", step, 0)
    x, y, heading = sympy.symbols(f"t_{step}x t_{step}y varphi_{step}", real=True)
    return x, y, heading


def state(landmarks: int, at: Pose | None = None) -> sympy.MatrixBase:
    """Return the state (3 + 2n,) in symbols, robot first.

    Raises
    ------
    ValueError
        If the number of landmarks is negative or above a hundred, which no algebra of symbols
        would end with, or the pose has no three entries.
    """
    checks.whole("landmarks", checks.whole("landmarks", landmarks, 0), 0, MOST_LANDMARKS)
    at = pose() if at is None else _expressions("at", at, 3)
    names = " ".join(f"p_{i}x p_{i}y" for i in range(1, landmarks + 1))
    points = sympy.symbols(names, real=True) if landmarks else ()
    return sympy.Matrix([*at, *points])


def measurement(sensors: Sequence[StateSensor | Formula], x: sympy.MatrixBase) -> sympy.MatrixBase:
    r"""Return what the sensors measure of a state, noise-free.

    .. math:: h^{(0)} = R^\top (a - t), \qquad h^{(i)} = R^\top (p_i - t)

    Raises
    ------
    ValueError
        If there is no sensor, or one of a kind that has no formula here.

    References
    ----------
    Andrade-Cetto, eqs (24) and (26).
    """
    sensors = tuple(checks.iterable("sensors", sensors))
    if not sensors:
        raise ValueError("sensors are empty: there is no sensor")
    _column("x", x)
    return sympy.Matrix.vstack(*(_measured(sensor, x) for sensor in sensors))


def _measured(sensor: StateSensor | Formula, x: sympy.MatrixBase) -> sympy.MatrixBase:
    match sensor:
        case Position():
            return x[:2, :]
        case Heading():
            return x[2:3, :]
        case Anchor():
            points = [sympy.Matrix([sensor.x, sensor.y])]
        case Landmarks():
            points = [x[i : i + 2, :] for i in range(3, len(x), 2)]
        case Formula():
            return sensor.formula(x)
        case _:
            raise ValueError(f"sensors: no formula for {sensor!r}")
    offsets = [point - x[:2, :] for point in points]
    if isinstance(sensor.sensor, RangeBearing):
        seen = [[d.dot(d) / 2, sympy.atan2(d[1], d[0]) - x[2]] for d in offsets]
        return sympy.Matrix([row for rows in seen for row in rows])
    return sympy.Matrix([row for d in offsets for row in _rotation(x[2]).T * d])


def fixed_point_matrix(
    sensors: Sequence[StateSensor | Formula],
    landmarks: int = 1,
    displacement: Sequence[sympy.Expr | int] = DISPLACEMENT,
) -> sympy.MatrixBase:
    r"""Return the observability matrix at one point, as the paper's algebra package had it.

    .. math::
        \begin{bmatrix} H \\ HF - H \end{bmatrix}, \qquad
        HF^k - H = k\,(HF - H), \text{ as } (F - I)^2 = 0

    Further powers of F therefore add nothing, for any number of states.

    Parameters
    ----------
    sensors
        What is measured.
    landmarks
        Number n.
    displacement
        :math:`d`, motion of the robot in its own frame between two measurements. How much it turns
        appears nowhere in F.
    """
    x = state(landmarks)
    H = measurement(sensors, x).jacobian(x)
    moved = J * _rotation(x[2]) * sympy.Matrix(_expressions("displacement", displacement, 2))
    growth = sympy.zeros(len(x))
    growth[:2, 2] = moved
    return sympy.Matrix.vstack(H, H * growth)


def fixed_point_minors(
    sensors: Sequence[StateSensor | Formula], landmarks: int = 1
) -> tuple[sympy.Expr, ...]:
    """Return what must not all vanish for full rank at one point, up to signs.

    Each is the determinant of all rows of H with one row of HF − H, for sensors whose H lacks one
    row of being square.

    Raises
    ------
    ValueError
        If the number of measurements is another.
    """
    matrix = fixed_point_matrix(sensors, landmarks)
    rows, size = matrix.shape[0] // 2, matrix.shape[1]
    if rows != size - 1:
        raise ValueError(f"need {size - 1} measurements of {size} states, got {rows}")
    minors = []
    for row in range(rows, 2 * rows):
        square = sympy.Matrix.vstack(matrix[:rows, :], matrix[row, :])
        with checks.computable("sensors", ExactQuotientFailed):
            minor = _determinant(square, state(landmarks)[2])
        if minor != 0 and minor not in minors and sympy.expand(-minor) not in minors:
            minors.append(minor)
    return tuple(minors)


def trajectory_matrix(
    sensors: Sequence[StateSensor | Formula],
    landmarks: int = 1,
    poses: Sequence[Pose] | None = None,
) -> sympy.MatrixBase:
    r"""Return the local observability matrix along a trajectory.

    .. math:: H_k F_{k-1} \cdots F_0 = H_k \begin{bmatrix} I & J (t_k - t_0) \\ 0 & 1 \end{bmatrix}

    Parameters
    ----------
    sensors
        What is measured.
    landmarks
        Number n.
    poses
        The true poses; three free ones if left out.

    Raises
    ------
    ValueError
        If there is no pose.
    """
    poses = [pose(step) for step in range(3)] if poses is None else poses
    poses = [_expressions("poses", at, 3) for at in checks.iterable("poses", poses)]
    if not poses:
        raise ValueError("poses are empty: there is no pose")
    blocks = []
    for at in poses:
        x = state(landmarks, at)
        H = _jacobian(measurement(sensors, state(landmarks)), state(landmarks), x)
        passage = sympy.eye(len(x))
        passage[:2, 2] = J * sympy.Matrix([at[i] - poses[0][i] for i in (0, 1)])
        blocks.append(H * passage)
    return sympy.Matrix.vstack(*blocks)


def lie_matrix(
    sensors: Sequence[StateSensor | Formula],
    landmarks: int = 1,
    *,
    speed: sympy.Expr | int = SPEED,
    turn_rate: sympy.Expr | int = TURN_RATE,
) -> sympy.MatrixBase:
    r"""Return the gradients of the measurements and their Lie derivatives along the motion.

    .. math::
        \dot t = R(\varphi) (v, 0)^\top, \quad \dot\varphi = \omega, \quad \dot p_i = 0, \qquad
        L^0 = h, \quad L^{k+1} = \frac{\partial L^k}{\partial x} \dot x

    Derivatives are added until they add no rank; then none ever will (Hermann and Krener).

    Parameters
    ----------
    sensors
        What is measured.
    landmarks
        Number n.
    speed, turn_rate
        :math:`v` and :math:`\omega`; symbols stand for any values but exceptions.
    """
    x = state(landmarks)
    field = sympy.zeros(len(x), 1)
    (speed,) = _expressions("speed", [speed], 1)
    field[0], field[1] = speed * sympy.cos(x[2]), speed * sympy.sin(x[2])
    (field[2],) = _expressions("turn_rate", [turn_rate], 1)
    values = measurement(sensors, x)
    gradients = values.jacobian(x)
    while True:
        values = values.jacobian(x) * field
        longer = sympy.Matrix.vstack(gradients, values.jacobian(x))
        if _rank_at_a_point(longer) == _rank_at_a_point(gradients):
            return gradients
        gradients = longer


def read(
    matrix: sympy.MatrixBase, sensors: Sequence[StateSensor | Formula], at: Pose | None = None
) -> Reading:
    """Return rank and unseen motions of an observability matrix.

    Parameters
    ----------
    matrix
        From one of the functions of this module.
    sensors
        The same that the matrix was made with; the world is turned about the first anchor among
        them, or about the robot if there is none.
    at
        The pose to which the matrix refers, the first of a trajectory.
    """
    checks.instance("matrix", matrix, sympy.MatrixBase)
    if matrix.shape[1] < 3 or matrix.shape[1] % 2 == 0:
        raise ValueError(f"matrix must be (rows, 3 + 2n), got {matrix.shape}")
    x = state((matrix.shape[1] - 3) // 2, at)
    sensors = checks.instances("sensors", sensors, StateSensor, Formula)
    anchor = next((s for s in sensors if isinstance(s, Anchor)), None)
    about, centre = ("anchor", (anchor.x, anchor.y)) if anchor else ("robot", x[:2])
    motions = {
        SHIFT_X: gauge_direction(x, (1, 0)),
        SHIFT_Y: gauge_direction(x, (0, 1)),
        f"turn about the {about}": gauge_direction(x, (0, 0), 1, about=centre),
    }
    unseen = tuple(name for name, N in motions.items() if _vanishes(matrix * N))
    return Reading(matrix.shape[1], _rank_at_a_point(matrix), unseen)


def gauge_direction(
    x: sympy.MatrixBase,
    shift: Sequence[sympy.Expr | int],
    turn: sympy.Expr | int = 0,
    *,
    about: Sequence[sympy.Expr] = (0, 0),
) -> sympy.MatrixBase:
    r"""Return how a state moves when the whole world is shifted and turned about a point.

    .. math:: \delta t = s + \alpha J (t - c), \quad \delta\varphi = \alpha, \quad
        \delta p_i = s + \alpha J (p_i - c)
    """
    _column("x", x)
    (turn,) = _expressions("turn", [turn], 1)
    centre = sympy.Matrix(_expressions("about", about, 2))
    shift = sympy.Matrix(_expressions("shift", shift, 2))
    points = [shift + turn * J * (x[i : i + 2, :] - centre) for i in (0, *range(3, len(x), 2))]
    return sympy.Matrix([*points[0], turn, *(entry for p in points[1:] for entry in p)])


def _expressions(name: str, values: Any, size: int) -> tuple[sympy.Expr, ...]:
    """Return so many numbers or symbols, or raise an error that names them."""
    values = tuple(checks.iterable(name, values))
    for value in values:
        number = isinstance(value, Real) and not isinstance(value, bool)
        if not number and not isinstance(value, sympy.Expr):
            raise TypeError(f"{name} must be numbers or symbols, got {checks.shown(value)}")
        if number:
            checks.number(name, value)
    if len(values) != size:
        raise ValueError(f"{name} must have {size} entries, got {len(values)}")
    return tuple(map(sympy.sympify, values))


def _column(name: str, x: sympy.MatrixBase) -> None:
    shape = checks.instance(name, x, sympy.MatrixBase).shape
    if shape[1] != 1 or shape[0] < 3 or shape[0] % 2 == 0:
        raise ValueError(f"{name} must be (3 + 2n, 1), got {shape}")


def _rotation(angle: sympy.Expr) -> sympy.MatrixBase:
    cos, sin = sympy.cos(angle), sympy.sin(angle)
    return sympy.Matrix([[cos, -sin], [sin, cos]])


def _jacobian(h: sympy.MatrixBase, x: sympy.MatrixBase, at: sympy.MatrixBase) -> sympy.MatrixBase:
    """Return the Jacobian of h by x, taken at another state."""
    return h.jacobian(x).subs(dict(zip(x, at, strict=True)), simultaneous=True)


def _determinant(matrix: sympy.MatrixBase, angle: sympy.Symbol) -> sympy.Expr:
    """Return the determinant of polynomials in the cosine and sine of one angle."""
    cos, sin = sympy.symbols("cos sin")
    there = {sympy.cos(angle): cos, sympy.sin(angle): sin}
    total = DomainMatrix.from_Matrix(matrix.xreplace(there)).det()
    reduced = sympy.rem(total.as_expr(), cos**2 + sin**2 - 1, sin)
    return sympy.factor(reduced.subs({name: function for function, name in there.items()}))


def _half_angles(matrix: sympy.MatrixBase) -> sympy.MatrixBase:
    r"""Return a matrix in which cosine and sine are rational, by :math:`\tan(\varphi / 2)`."""
    swaps = {}
    for function in matrix.atoms(sympy.cos, sympy.sin):
        angle = function.args[0]
        half = sympy.Symbol(f"tan_{angle}", real=True)
        swaps[sympy.cos(angle)] = (1 - half**2) / (1 + half**2)
        swaps[sympy.sin(angle)] = 2 * half / (1 + half**2)
    return matrix.xreplace(swaps)


def _vanishes(vector: sympy.MatrixBase) -> bool:
    """Decide whether all entries are zero identically; they are rational in half angles."""
    return all(sympy.cancel(entry) == 0 for entry in _half_angles(vector))


def _rank_at_a_point(matrix: sympy.MatrixBase) -> int:
    """Return the exact rank where every symbol has some rational value, no two alike."""
    matrix = _half_angles(matrix)
    symbols = sorted(matrix.free_symbols, key=str)
    values = {s: sympy.Rational(sympy.prime(i + 4), i + 2) for i, s in enumerate(symbols)}
    return matrix.xreplace(values).rank()
