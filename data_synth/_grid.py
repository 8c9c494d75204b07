"""State that a step of a world hands to its next step, on a grid.

Processors and libraries disagree in the last bit of a sine, a root or an arctangent. People who
decide at every step are chaotic: of one bit their next forty seconds make metres. So whatever a
step leaves behind is rounded, far above that bit (1e-15) and far below anything that is simulated
(1e-3); then two processors part only where a value lies within one bit of the edge between two
points of the grid, which is one in a thousand million.
"""

import numpy as np

__all__: tuple[str, ...] = ()  # for the worlds alone

_DECIMALS = 6  # micrometres, micrometres in a second, microseconds
_TURN = 2**22  # directions: 1.5 microradians apart, and π and -π are one of them


def on_grid(values):
    """Return numbers rounded to a millionth; zero has no sign, which an arctangent would see."""
    return np.round(values, _DECIMALS) + 0.0


def direction(angles):
    """Return angles from -π to below π, rounded to parts of a turn, rad."""
    steps = np.rint(np.asarray(angles) * (_TURN / (2 * np.pi)))
    return ((steps + _TURN // 2) % _TURN - _TURN // 2) * (2 * np.pi / _TURN)
