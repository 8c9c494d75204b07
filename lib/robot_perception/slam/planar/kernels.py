"""Compiled inner loops of the planar filter; :mod:`.textbook` is the version to read.

A covariance is symmetric: during a run only its lower triangle is kept, as copying each update to
the other one would cost a third of a step. Whoever reads it goes through :func:`rows` or takes the
larger index first. Inner loops run along contiguous rows.
"""

from typing import no_type_check

import numpy as np

from robot_perception.kernels import kernel

STRIP = 64  # so many rows at a time: of these one column after the other stays in the cache


@kernel()
@no_type_check
def wrapped(angle):  # pragma: no cover - compiled
    """Return the angle in [-π, π); one already there is returned as it is, to the last bit."""
    if -np.pi <= angle < np.pi:
        return angle
    turned = (angle + np.pi) % (2 * np.pi) - np.pi
    return turned if turned < np.pi else -np.pi  # just below -π rounding gives π


@kernel()
@no_type_check
def is_covariance(blocks, tolerance):  # pragma: no cover - compiled
    """Tell whether each (d, d) block is finite, symmetric and positive semi-definite.

    Positive semi-definite up to ``tolerance`` times the largest entry: the block with that much
    added to its diagonal has a Cholesky factor.
    """
    d = blocks.shape[1]
    L = np.empty((d, d))
    for block in blocks:
        scale = 0.0
        for i in range(d):
            for j in range(d):
                if not np.isfinite(block[i, j]):
                    return False
                scale = max(scale, abs(block[i, j]))
        if scale == 0.0:
            continue
        for i in range(d):
            for j in range(i + 1):
                if abs(block[i, j] - block[j, i]) > tolerance * scale:
                    return False
                total = block[i, j]
                for q in range(j):
                    total -= L[i, q] * L[j, q]
                if i > j:
                    L[i, j] = total / L[j, j]
                else:
                    total += tolerance * scale
                    if total <= 0.0:
                        return False
                    L[i, i] = np.sqrt(total)
    return True


@kernel()
@no_type_check
def fill_lower(copy, cov, tolerance):  # pragma: no cover - compiled
    """Fill in the lower triangle of a copy and return how many pairs of entries differ.

    They may differ by a share of the largest variance.
    """
    n = cov.shape[0]
    limit = 0.0
    for i in range(n):
        limit = max(limit, tolerance * abs(cov[i, i]))
    count = 0
    for i0 in range(0, n, STRIP):
        i1 = min(i0 + STRIP, n)
        for j in range(i1):
            below, above = cov[max(i0, j) : i1, j], cov[j, max(i0, j) : i1]
            out = copy[max(i0, j) : i1, j]
            for i in range(below.size):  # written so that NaN counts
                count += not abs(below[i] - above[i]) <= limit
                out[i] = below[i]
    return count


@kernel()
@no_type_check
def mirror(cov):  # pragma: no cover - compiled
    """Copy the triangle below the diagonal to the one above, in place."""
    n = cov.shape[0]
    for i0 in range(0, n, STRIP):
        i1 = min(i0 + STRIP, n)
        for j in range(i1):
            below, above = cov[max(i0, j) : i1, j], cov[j, max(i0, j) : i1]
            for i in range(below.size):
                above[i] = below[i]


@kernel()
@no_type_check
def rows(cov, first, count):  # pragma: no cover - compiled
    """Return neighbouring rows, (count, n), of a covariance of which the lower triangle is kept."""
    n, last = cov.shape[0], first + count
    out = np.empty((count, n))
    for q in range(count):
        out[q, :last] = cov[first + q, :last]
        for p in range(q):
            out[p, first + q] = out[q, first + p]
    for j in range(last, n):
        for q in range(count):
            out[q, j] = cov[j, first + q]
    return out


@kernel()
@no_type_check
def move(pose, increment):  # pragma: no cover - compiled
    """Move a pose in place by an increment in its own frame, eq. (3)."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    pose[0] += c * increment[0] - s * increment[1]
    pose[1] += s * increment[0] + c * increment[1]
    pose[2] = wrapped(pose[2] + increment[2])


@kernel()
@no_type_check
def predict_cov(cov, noise, at, after):  # pragma: no cover - compiled
    """Spread the covariance in place: only the robot's rows and columns change, eq. (5).

    ``at`` and ``after`` are the poses before and after the motion at which it is linearised.
    """
    fx, fy = at[1] - after[1], after[0] - at[0]  # J (t' - t), third column of F
    for j in range(3, cov.shape[0]):
        cov[j, 0] += fx * cov[j, 2]
        cov[j, 1] += fy * cov[j, 2]
    c, s = np.cos(at[2]), np.sin(at[2])
    F = np.array([[1.0, 0.0, fx], [0.0, 1.0, fy], [0.0, 0.0, 1.0]])
    G = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    old = np.empty((3, 3))
    for i in range(3):
        for j in range(i + 1):
            old[i, j] = old[j, i] = cov[i, j]
    for i in range(3):
        for j in range(i + 1):
            total = 0.0
            for p in range(3):
                for q in range(3):
                    total += F[i, p] * old[p, q] * F[j, q] + G[i, p] * noise[p, q] * G[j, q]
            cov[i, j] = total


@kernel()
@no_type_check
def cartesian(pose, points):  # pragma: no cover - compiled
    """Return h = Rᵀ(p - t) and its Jacobians by pose and by landmark, eqs (24) and (25)."""
    k = points.shape[0]
    h, Hr, Hp = np.empty((k, 2)), np.empty((k, 2, 3)), np.empty((k, 2, 2))
    c, s = np.cos(pose[2]), np.sin(pose[2])
    for i in range(k):
        dx, dy = points[i, 0] - pose[0], points[i, 1] - pose[1]
        h[i, 0], h[i, 1] = c * dx + s * dy, c * dy - s * dx
        Hp[i, 0, 0], Hp[i, 0, 1], Hp[i, 1, 0], Hp[i, 1, 1] = c, s, -s, c
        for row in range(2):
            Hr[i, row, 0], Hr[i, row, 1] = -Hp[i, row, 0], -Hp[i, row, 1]
        Hr[i, 0, 2], Hr[i, 1, 2] = h[i, 1], -h[i, 0]
    return h, Hr, Hp


@kernel()
@no_type_check
def range_bearing(pose, points, bias):  # pragma: no cover - compiled
    """Return h = (|p - t| + bias, bearing), its Jacobians, and whether they all exist."""
    k = points.shape[0]
    h, Hr, Hp = np.empty((k, 2)), np.empty((k, 2, 3)), np.empty((k, 2, 2))
    regular = True
    for i in range(k):
        dx, dy = points[i, 0] - pose[0], points[i, 1] - pose[1]
        r = np.hypot(dx, dy)
        h[i, 0], h[i, 1] = r + bias, wrapped(np.arctan2(dy, dx) - pose[2])
        if r**2 == 0.0:  # the bearing of a landmark under the robot has no derivative
            regular = False
            continue
        Hp[i, 0, 0], Hp[i, 0, 1] = dx / r, dy / r
        Hp[i, 1, 0], Hp[i, 1, 1] = -dy / r**2, dx / r**2
        for row in range(2):
            Hr[i, row, 0], Hr[i, row, 1] = -Hp[i, row, 0], -Hp[i, row, 1]
        Hr[i, 0, 2], Hr[i, 1, 2] = 0.0, -1.0
    return h, Hr, Hp, regular


@kernel()
@no_type_check
def bearing_residual(values, expected):  # pragma: no cover - compiled
    """Return measured minus expected ranges and bearings, the latter in [-π, π)."""
    residual = np.empty_like(values)
    for i in range(values.shape[0]):
        residual[i, 0] = values[i, 0] - expected[i, 0]
        residual[i, 1] = wrapped(values[i, 1] - expected[i, 1])
    return residual


@kernel()
@no_type_check
def gather(mean, slots, points):  # pragma: no cover - compiled
    """Fill in the points that stand in the state; those with slot -1 are known already."""
    for i in range(slots.size):
        if slots[i] >= 0:
            points[i, 0], points[i, 1] = mean[slots[i]], mean[slots[i] + 1]


@kernel()
@no_type_check
def cross_rows(cov, Hr, Hp, slots):  # pragma: no cover - compiled
    """Return (P Hᵀ)ᵀ: each row of H touches the pose and at most one landmark."""
    k, d, n = Hr.shape[0], Hr.shape[1], cov.shape[0]
    B, pose = np.empty((k * d, n)), rows(cov, 0, 3)
    x, y, heading = pose[0], pose[1], pose[2]
    for i in range(k):
        for row in range(d):
            out = B[i * d + row]
            a, b, c = Hr[i, row, 0], Hr[i, row, 1], Hr[i, row, 2]
            for j in range(n):
                out[j] = a * x[j] + b * y[j] + c * heading[j]
        if slots[i] >= 0:
            point = rows(cov, slots[i], 2)
            u, v = point[0], point[1]
            for row in range(d):
                out = B[i * d + row]
                e, f = Hp[i, row, 0], Hp[i, row, 1]
                for j in range(n):
                    out[j] += e * u[j] + f * v[j]
    return B


@kernel()
@no_type_check
def innovation_cov(B, Hr, Hp, slots, noises):  # pragma: no cover - compiled
    """Return S = H P Hᵀ + R from B = (P Hᵀ)ᵀ; one noise for all or one for each, eq. (8)."""
    k, d = Hr.shape[0], Hr.shape[1]
    S = np.empty((k * d, k * d))
    for i in range(k):
        slot = slots[i]
        R = noises[min(i, noises.shape[0] - 1)]
        for row in range(d):
            p = i * d + row
            for q in range(p + 1):
                total = Hr[i, row, 0] * B[q, 0] + Hr[i, row, 1] * B[q, 1] + Hr[i, row, 2] * B[q, 2]
                if slot >= 0:
                    total += Hp[i, row, 0] * B[q, slot] + Hp[i, row, 1] * B[q, slot + 1]
                if q >= i * d:
                    total += R[row, q - i * d]
                S[p, q] = total
                S[q, p] = total
    return S


@kernel()
@no_type_check
def cholesky(S):  # pragma: no cover - compiled
    """Return the lower factor of S, and whether S is regular."""
    m = S.shape[0]
    L = np.zeros((m, m))
    for i in range(m):
        for j in range(i + 1):
            total = S[i, j]
            for q in range(j):
                total -= L[i, q] * L[j, q]
            if i > j:
                L[i, j] = total / L[j, j]
            elif total > 1e-14 * S[i, i]:
                L[i, i] = np.sqrt(total)
            else:
                return L, False
    return L, True


@kernel()
@no_type_check
def inverse_factor(L):  # pragma: no cover - compiled
    """Return the inverse of a lower triangular matrix."""
    m = L.shape[0]
    inverse = np.eye(m)
    for i in range(m):
        for q in range(i):
            for j in range(q + 1):
                inverse[i, j] -= L[i, q] * inverse[q, j]
        for j in range(i + 1):
            inverse[i, j] /= L[i, i]
    return inverse


@kernel()
@no_type_check
def whiten(cov, Hr, Hp, slots, innovation, noises):  # pragma: no cover - compiled
    """Return W = L⁻¹ (P Hᵀ)ᵀ, L⁻¹ z̃, S = L Lᵀ, and whether S is regular; eq. (8).

    The factor of S is inverted, as it is small and its product with the wide (P Hᵀ)ᵀ is then
    BLAS's; the inverse of the factor is as exact as substitution, that of S would not be.
    """
    B = cross_rows(cov, Hr, Hp, slots)
    S = innovation_cov(B, Hr, Hp, slots, noises)
    L, regular = cholesky(S)
    seen = innovation.copy().reshape(S.shape[0])
    if not regular:
        return B, seen, S, False
    whitener = inverse_factor(L)
    return np.dot(whitener, B), np.dot(whitener, seen), S, True


@kernel()
@no_type_check
def append(cov, n, Gr, Gz, noises):  # pragma: no cover - compiled
    """Fill in the covariance of landmarks behind the first n states, with all before them."""
    for i in range(Gr.shape[0]):
        R = noises[min(i, noises.shape[0] - 1)]
        a = n + 2 * i
        for row in range(2):
            for j in range(a):
                total = 0.0
                for q in range(3):
                    total += Gr[i, row, q] * cov[max(q, j), min(q, j)]
                cov[a + row, j] = total
        for row in range(2):
            for other in range(row + 1):
                total = 0.0
                for q in range(3):
                    total += Gr[i, other, q] * cov[a + row, q]
                for p in range(2):
                    for q in range(2):
                        total += Gz[i, row, p] * R[p, q] * Gz[i, other, q]
                cov[a + row, a + other] = total


@kernel()
@no_type_check
def arc(speed, rate, duration):  # pragma: no cover - compiled
    """Return the increment of an arc and its derivatives by speed and turn rate."""
    a, length = rate * duration, speed * duration
    if abs(a) > 1e-3:
        along, across = np.sin(a) / a, (1 - np.cos(a)) / a
        along_a, across_a = (np.cos(a) - along) / a, (np.sin(a) - across) / a
    else:  # series; what is left out is below the rounding of the quotients
        along, across = 1 - a**2 / 6, a / 2 - a**3 / 24
        along_a, across_a = -a / 3 + a**3 / 30, 0.5 - a**2 / 8
    increment = np.array([length * along, length * across, a])
    by_command = np.array(
        [
            [duration * along, length * duration * along_a],
            [duration * across, length * duration * across_a],
            [0.0, duration],
        ]
    )
    return increment, by_command


@kernel()
@no_type_check
def own_covs(cov, Hr, Hp, slots):  # pragma: no cover - compiled
    """Return H P Hᵀ of each observation by itself, (k, d, d): five states at most take part."""
    k, d = Hr.shape[0], Hr.shape[1]
    covs, h, states = np.empty((k, d, d)), np.empty((d, 5)), np.array([0, 1, 2, 0, 0])
    for i in range(k):
        h[:, :3] = Hr[i]
        involved = 3
        if slots[i] >= 0:
            states[3], states[4] = slots[i], slots[i] + 1
            h[:, 3:] = Hp[i]
            involved = 5
        for row in range(d):
            for col in range(row + 1):
                total = 0.0
                for p in range(involved):
                    for q in range(involved):
                        total += h[row, p] * cov[states[max(p, q)], states[min(p, q)]] * h[col, q]
                covs[i, row, col] = total
                covs[i, col, row] = total
    return covs


@kernel()
@no_type_check
def pair_distances(innovations, own, noises):  # pragma: no cover - compiled
    """Return the squared Mahalanobis distance of each of m observations to each of n targets.

    innovations (m, n, 2); covariances of the expected values (n, 2, 2); noises (m or 1, 2, 2). A
    singular covariance gives NaN.
    """
    m, n = innovations.shape[:2]
    distances = np.empty((m, n))
    for i in range(m):
        R = noises[min(i, noises.shape[0] - 1)]
        for j in range(n):
            a, b, c = own[j, 0, 0] + R[0, 0], own[j, 1, 0] + R[1, 0], own[j, 1, 1] + R[1, 1]
            x, y = innovations[i, j, 0], innovations[i, j, 1]
            determinant = a * c - b * b
            if determinant <= 1e-14 * a * c:
                distances[i, j] = np.nan
            else:
                distances[i, j] = (c * x * x - 2 * b * x * y + a * y * y) / determinant
    return distances
