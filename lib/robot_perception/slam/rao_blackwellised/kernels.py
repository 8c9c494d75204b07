"""Compiled inner loops of the Rao-Blackwellised filter; :mod:`.textbook` is the version to read.

A landmark of a particle is a row of nine numbers: its mean, and the upper triangle of its
covariance row by row. So is an observed point in the frame of the world.
"""

from typing import no_type_check

import numpy as np

from robot_perception.gating import greedy
from robot_perception.kernels import kernel
from robot_perception.slam.planar.kernels import move

ROW = 9
LOG_2PI = float(np.log(2 * np.pi))


@kernel()
@no_type_check
def is_rigid(matrix, tolerance):  # pragma: no cover - compiled
    """Tell whether a (4, 4) matrix is a rotation with a translation."""
    R = matrix[:3, :3]
    largest = 0.0
    for i in range(3):
        for j in range(3):
            total = -1.0 if i == j else 0.0
            for q in range(3):
                total += R[i, q] * R[j, q]
            largest = max(largest, abs(total))
        largest = max(largest, abs(matrix[3, i]))
    determinant = (
        R[0, 0] * (R[1, 1] * R[2, 2] - R[1, 2] * R[2, 1])
        - R[0, 1] * (R[1, 0] * R[2, 2] - R[1, 2] * R[2, 0])
        + R[0, 2] * (R[1, 0] * R[2, 1] - R[1, 1] * R[2, 0])
    )
    return largest <= tolerance and abs(matrix[3, 3] - 1.0) <= tolerance and determinant > 0.0


@kernel()
@no_type_check
def root(cov):  # pragma: no cover - compiled
    """Return the lower triangular root of a covariance, which may be singular."""
    L = np.zeros_like(cov)
    for i in range(cov.shape[0]):
        for j in range(i + 1):
            total = cov[i, j]
            for q in range(j):
                total -= L[i, q] * L[j, q]
            if i == j:
                L[i, i] = np.sqrt(total) if total > 1e-14 * cov[i, i] else 0.0
            elif L[j, j] > 0.0:
                L[i, j] = total / L[j, j]
    return L


@kernel()
@no_type_check
def moved(poses, increment, cov, draws):  # pragma: no cover - compiled
    """Return the poses moved by the increment, with noises of a covariance from standard draws."""
    out, noisy, L = poses.copy(), np.empty(3), root(cov)
    for m in range(poses.shape[0]):
        for i in range(3):
            noisy[i] = increment[i]
            for j in range(3):
                noisy[i] += L[i, j] * draws[m, j]
        move(out[m], noisy)
    return out


@kernel()
@no_type_check
def in_robot_frame(values, covs, mount):  # pragma: no cover - compiled
    """Return points seen by the camera, as rows of nine numbers, in the frame of the robot."""
    seen = np.empty((values.shape[0], ROW))
    R, half = mount[:3, :3], np.empty((3, 3))
    for k in range(values.shape[0]):
        for i in range(3):
            seen[k, i] = mount[i, 3]
            for j in range(3):
                seen[k, i] += R[i, j] * values[k, j]
                half[i, j] = 0.0
                for q in range(3):
                    half[i, j] += R[i, q] * covs[k, q, j]
        at = 3
        for i in range(3):
            for j in range(i, 3):
                seen[k, at] = 0.0
                for q in range(3):
                    seen[k, at] += half[i, q] * R[j, q]
                at += 1
    return seen


@kernel()
@no_type_check
def to_world(x, y, c, s, seen, out):  # pragma: no cover - compiled
    """Take an observed point from the frame of the robot to that of the world."""
    out[0] = x + c * seen[0] - s * seen[1]
    out[1] = y + s * seen[0] + c * seen[1]
    out[2] = seen[2]
    xx, xy, xz, yy, yz = seen[3], seen[4], seen[5], seen[6], seen[7]
    out[3] = c * c * xx - 2 * c * s * xy + s * s * yy
    out[4] = c * s * (xx - yy) + (c * c - s * s) * xy
    out[5] = c * xz - s * yz
    out[6] = s * s * xx + 2 * c * s * xy + c * c * yy
    out[7] = s * xz + c * yz
    out[8] = seen[8]


@kernel()
@no_type_check
def factor(row, point):  # pragma: no cover - compiled
    """Return the Cholesky factor of S, the sum of two covariances; zeros if it is singular."""
    xx, yy, zz = row[3] + point[3], row[6] + point[6], row[8] + point[8]
    if not xx > 0.0:  # written so that NaN is singular
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    l00 = np.sqrt(xx)
    l10, l20 = (row[4] + point[4]) / l00, (row[5] + point[5]) / l00
    pivot = yy - l10 * l10
    if not pivot > 1e-12 * yy:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    l11 = np.sqrt(pivot)
    l21 = (row[7] + point[7] - l20 * l10) / l11
    pivot = zz - l20 * l20 - l21 * l21
    if not pivot > 1e-12 * zz:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    return l00, l10, l11, l20, l21, np.sqrt(pivot)


@kernel()
@no_type_check
def revise(rows, poses, seen, columns, unmatched):  # pragma: no cover - compiled
    """Update landmarks in place; return the log likelihood of each particle, and whether S exist.

    ``rows`` (k, M, 9) has the observed landmarks of all particles, ``columns`` (M or 1, m) which of
    them each observation is of; -1 for none, which counts as ``unmatched``.
    """
    M, last = poses.shape[0], columns.shape[0] - 1
    total, point = np.zeros(M), np.empty(ROW)
    for m in range(M):
        x, y, c, s = poses[m, 0], poses[m, 1], np.cos(poses[m, 2]), np.sin(poses[m, 2])
        for i in range(seen.shape[0]):
            column = columns[min(m, last), i]
            if column < 0:
                total[m] += unmatched
                continue
            row = rows[column, m]
            to_world(x, y, c, s, seen[i], point)
            l00, l10, l11, l20, l21, l22 = factor(row, point)
            if l22 == 0.0:
                return total, False
            # L⁻¹ applied to the innovation, and to each column of the prior covariance
            a0 = (point[0] - row[0]) / l00
            a1 = (point[1] - row[1] - l10 * a0) / l11
            a2 = (point[2] - row[2] - l20 * a0 - l21 * a1) / l22
            x0, y0, z0 = row[3] / l00, row[4] / l00, row[5] / l00
            x1, y1 = (row[4] - l10 * x0) / l11, (row[6] - l10 * y0) / l11
            z1 = (row[7] - l10 * z0) / l11
            x2 = (row[5] - l20 * x0 - l21 * x1) / l22
            y2 = (row[7] - l20 * y0 - l21 * y1) / l22
            z2 = (row[8] - l20 * z0 - l21 * z1) / l22
            row[0] += x0 * a0 + x1 * a1 + x2 * a2
            row[1] += y0 * a0 + y1 * a1 + y2 * a2
            row[2] += z0 * a0 + z1 * a1 + z2 * a2
            row[3] -= x0 * x0 + x1 * x1 + x2 * x2
            row[4] -= x0 * y0 + x1 * y1 + x2 * y2
            row[5] -= x0 * z0 + x1 * z1 + x2 * z2
            row[6] -= y0 * y0 + y1 * y1 + y2 * y2
            row[7] -= y0 * z0 + y1 * z1 + y2 * z2
            row[8] -= z0 * z0 + z1 * z1 + z2 * z2
            squared = a0 * a0 + a1 * a1 + a2 * a2  # eq. (5)
            total[m] -= 0.5 * (3 * LOG_2PI + squared) + np.log(l00 * l11 * l22)  # eqs (4), (6)
    return total, True


@kernel()
@no_type_check
def located(poses, seen):  # pragma: no cover - compiled
    """Return observed points in the world as each particle sees them, (m, M, 9)."""
    rows = np.empty((seen.shape[0], poses.shape[0], ROW))
    for m in range(poses.shape[0]):
        c, s = np.cos(poses[m, 2]), np.sin(poses[m, 2])
        for i in range(seen.shape[0]):
            to_world(poses[m, 0], poses[m, 1], c, s, seen[i], rows[i, m])
    return rows


@kernel()
@no_type_check
def squared_distance(row, point):  # pragma: no cover - compiled
    """Return the squared Mahalanobis distance of two points; NaN where S is singular."""
    l00, l10, l11, l20, l21, l22 = factor(row, point)
    if l22 == 0.0:
        return np.nan
    a0 = (point[0] - row[0]) / l00
    a1 = (point[1] - row[1] - l10 * a0) / l11
    a2 = (point[2] - row[2] - l20 * a0 - l21 * a1) / l22
    return a0 * a0 + a1 * a1 + a2 * a2


@kernel()
@no_type_check
def squared_distances(points, rows, known, measured, target, limit):  # pragma: no cover - compiled
    """Return the squared Mahalanobis distance of pairs in each particle, (pairs, M).

    Infinite where it is beyond the limit or the particle does not have the landmark. No direction
    has more variance than the trace of S, which spares most factors.
    """
    distances = np.full((measured.size, points.shape[1]), np.inf)
    for q in range(measured.size):
        for m in range(points.shape[1]):
            if not known[target[q], m]:
                continue
            point, row = points[measured[q], m], rows[target[q], m]
            dx, dy, dz = point[0] - row[0], point[1] - row[1], point[2] - row[2]
            trace = row[3] + row[6] + row[8] + point[3] + point[6] + point[8]
            if trace > 0.0 and dx * dx + dy * dy + dz * dz > limit * trace:
                continue
            squared = squared_distance(row, point)
            if not squared > limit:
                distances[q, m] = squared
    return distances


@kernel()
@no_type_check
def mixture_distances(
    points, rows, known, weights, measured, target, limit
):  # pragma: no cover - compiled
    """Return the squared Mahalanobis distance of pairs in the mixture of all particles, (pairs, 1).

    Infinite where it is beyond the limit or no particle of any weight has the landmark.
    """
    distances, zero = np.full((measured.size, 1), np.inf), np.zeros(ROW)
    for q in range(measured.size):
        mixed, share = np.zeros(ROW), 0.0
        for m in range(weights.size):
            if known[target[q], m]:
                share += weights[m]
                for i in range(3):
                    mixed[i] += weights[m] * (points[measured[q], m, i] - rows[target[q], m, i])
        if share == 0.0:
            continue
        for i in range(3):
            mixed[i] /= share
        for m in range(weights.size):
            if not known[target[q], m]:
                continue
            point, row, at = points[measured[q], m], rows[target[q], m], 3
            for i in range(3):
                for j in range(i, 3):
                    spread = (point[i] - row[i] - mixed[i]) * (point[j] - row[j] - mixed[j])
                    mixed[at] += weights[m] / share * (point[at] + row[at] + spread)
                    at += 1
        squared = squared_distance(zero, mixed)
        if not squared > limit:
            distances[q, 0] = squared
    return distances


@kernel()
@no_type_check
def assigned(distances, costs, measured, target, sizes, limit):  # pragma: no cover - compiled
    """Return for each particle and measurement the target with the least cost, each given once.

    ``costs`` (pairs,), or empty: then the distances are the costs.
    """
    found = np.empty((distances.shape[1], sizes[0]), dtype=np.int64)
    table = np.empty(sizes)
    for m in range(distances.shape[1]):
        table[:] = np.inf
        for q in range(measured.size):
            if distances[q, m] < np.inf:
                table[measured[q], target[q]] = costs[q] if costs.size else distances[q, m]
        found[m] = greedy(table, limit)
    return found


@kernel()
@no_type_check
def fetch(block, rows, out):  # pragma: no cover - compiled
    """Copy the rows that particles hold; zeros for one that holds none."""
    for m in range(rows.size):
        if rows[m] >= 0:  # else the block may be empty
            out[m] = block[rows[m]]
        else:
            out[m] = 0.0


@kernel()
@no_type_check
def renumber(table, sizes, slots):  # pragma: no cover - compiled
    """Note in place that each particle has a row of its own of some landmarks, if it has them."""
    for slot in slots:
        sizes[slot] = table.shape[1]
        for m in range(table.shape[1]):
            if table[slot, m] >= 0:
                table[slot, m] = m


@kernel()
@no_type_check
def inherited(table, ancestors, sizes, out):  # pragma: no cover - compiled
    """Fill in which rows descendants hold, numbered anew where less than a quarter have a holder.

    Return the landmarks of which that is so, how many rows of each are held, and these rows, one
    landmark after the other. The look at a landmark ends when a quarter is reached, mostly soon.
    """
    N, M = out.shape
    slots, counts = np.empty(N, np.int64), np.empty(N, np.int64)
    kept = np.empty(N * (M // 4 + 1), np.int64)
    stamps, numbers = np.full(M, -1), np.empty(M, table.dtype)  # a block has at most M rows
    sources, few, begin = ancestors.astype(np.uint64), 0, 0  # unsigned: none counts from the end
    for n in range(N):
        for m in range(M):
            out[n, m] = table[n, sources[m]]
        enough, held = (sizes[n] + 3) // 4 if sizes[n] > 1 else 0, 0
        for m in range(M):
            if held == enough:
                break
            row = out[n, m]
            if row >= 0 and stamps[row] != n:
                stamps[row], numbers[row], kept[begin + held] = n, held, row
                held += 1
        if held < enough:
            for m in range(M):
                if out[n, m] >= 0:
                    out[n, m] = numbers[out[n, m]]
            slots[few], counts[few] = n, held
            few, begin = few + 1, begin + held
    return slots[:few], counts[:few], kept[:begin]
