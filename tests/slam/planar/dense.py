"""The planar filter over a drive as an oracle: whole matrices, and the rules of the docstrings.

Nothing is kept from one step to the next but the belief, and nothing is computed in place. Only the
models of motion and sensors are the library's: they have oracles of their own.
"""

from collections import Counter
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from robot_perception.gating import gate, joint_compatibility
from robot_perception.slam.planar import Compass, History, MapBelief, Settings, Step, Truth
from tests.slam.planar.drives import assert_close, wrapped

IGNORED, NEW = -1, -2


@dataclass
class Record:
    """What the oracle believes after a step, and what the step showed."""

    mean: np.ndarray
    cov: np.ndarray
    names: list[int]
    nis: float
    dof: int
    used: list[int]
    point: np.ndarray


class Dense:
    """The oracle under way."""

    def __init__(self, start: MapBelief, settings: Settings) -> None:
        self.settings, self.truth = settings, settings.linearisation
        self.x, self.P, self.names = start.mean, start.cov, start.ids.tolist()
        self.anchors, self.frozen = dict(settings.anchors), {}
        self.considered, self.uses, self.counts = set(), Counter(), Counter()
        self.first = self.x  # estimates when they were first made
        if isinstance(self.truth, Truth):
            self.first = np.r_[self.truth.poses[0], self.true_places(self.names)]
        self.highest = max([-1, *self.names, *self.anchors])

    def true_places(self, names):
        return np.array([self.truth.landmarks[name] for name in names]).ravel()

    @property
    def point(self):
        """Where Jacobians are taken."""
        return self.x if self.truth == "latest" else self.first

    def step(self, k: int, step: Step) -> Record:
        """Take a step."""
        if step.motion is not None:
            self.move(k, step.motion)
        nis, dof, used = 0.0, 0, []
        for fix in step.fixes:
            H, difference = np.eye(2, self.x.size), fix.value - self.x[:2]
            if isinstance(fix, Compass):
                H, difference = np.eye(1, self.x.size, 2), wrapped(fix.value - self.x[2:3])
            noise = fix.variance * np.eye(1) if isinstance(fix, Compass) else fix.noise
            nis += self.revise(H, noise, difference)
            dof += len(H)
        if step.observations is not None:
            used, squared, size = self.see(step.observations)
            nis, dof = nis + squared, dof + size
        return Record(self.x, self.P, list(self.names), nis, dof, used, self.point)

    def move(self, k, motion):
        moved = motion.move(self.x[:3])
        before, after = self.point[:3], moved
        if isinstance(self.truth, Truth):
            before, after = self.truth.poses[k : k + 2]
        F, G = np.eye(self.x.size), np.zeros((self.x.size, 3))
        F[:2, 2] = before[1] - after[1], after[0] - before[0]
        c, s = np.cos(before[2]), np.sin(before[2])
        G[:3] = [[c, -s, 0], [s, c, 0], [0, 0, 1]]
        self.x, self.P = np.r_[moved, self.x[3:]], F @ self.P @ F.T + G @ motion.increment_cov @ G.T
        self.first = np.r_[after, self.first[3:]]

    def revise(self, H, R, innovation):
        """Update with the best gain, but none for what is considered; Joseph's form, eq. (9)."""
        S = H @ self.P @ H.T + R
        K = self.P @ H.T @ np.linalg.inv(S)
        for name in self.considered:
            K[self.rows(name)] = 0
        rest = np.eye(self.x.size) - K @ H
        self.x, self.P = self.x + K @ innovation, rest @ self.P @ rest.T + K @ R @ K.T
        self.x[2] = wrapped(self.x[2])
        return innovation @ np.linalg.solve(S, innovation)

    def rows(self, name):
        return 3 + 2 * self.names.index(name) + np.arange(2)

    def look(self, name, value, at):
        """Return the innovation of one observation, and its two rows of H at a point."""
        known = name in self.anchors
        there, here = (
            self.anchors[name] if known else state[self.rows(name)] for state in (at, self.x)
        )
        sensor, H = self.settings.sensor, np.zeros((2, self.x.size))
        _, by_pose, by_place = sensor.expect(at[:3], there[None])
        H[:, :3] = by_pose[0]
        if not known:
            H[:, self.rows(name)] = by_place[0]
        expected = sensor.expect(self.x[:3], here[None])[0]
        return sensor.residual(value[None], expected)[0], H

    def see(self, observed):
        values = observed.values
        noises = [self.settings.sensor.noise] * len(values)
        noises = noises if observed.covs is None else list(observed.covs)
        association, used = self.settings.association, observed.ids.tolist()
        if association.kind != "known":
            used = self.associated(used, values, noises)
        self.counts["observed"] += len(used)
        self.counts["ignored"] += used.count(IGNORED)
        known = {*self.names, *self.anchors}
        new = [i for i, name in enumerate(used) if name not in known and name != IGNORED]
        seen = []
        for i in (i for i, name in enumerate(used) if name in known):
            z, H = self.look(used[i], values[i], self.point)
            distance = z @ np.linalg.solve(H @ self.P @ H.T + noises[i], z)
            if association.kind == "known" and distance > association.limit:
                used[i] = IGNORED
                self.counts["rejected"] += 1
            else:
                seen.append((i, z, H))
        squared = 0.0
        if seen:
            rows, z, H = zip(*seen, strict=True)
            R = block_diag(*(noises[i] for i in rows))
            squared = self.revise(np.vstack(H), R, np.concatenate(z))
        for i, _, _ in seen:
            self.count(used[i])
        self.highest = max([self.highest, *used])
        for i in new:
            if used[i] == NEW:
                self.highest += 1
                used[i] = self.highest
        if new:
            self.add([used[i] for i in new], values[new], [noises[i] for i in new])
        return used, squared, 2 * len(seen)

    def associated(self, ids, values, noises):
        """Return which landmark each observation is of: one by one, with its own noise."""
        association, found = self.settings.association, list(ids)
        names = [name for name in (*self.names, *self.anchors) if name not in ids]
        unnamed = [i for i, name in enumerate(ids) if name == IGNORED]
        looks = {(i, n): self.look(n, values[i], self.x) for i in unnamed for n in names}
        distances = {
            pair: z @ np.linalg.solve(H @ self.P @ H.T + noises[pair[0]], z)
            for pair, (z, H) in looks.items()
        }
        inner = [pair for pair in looks if distances[pair] <= gate(association.level, 2)]
        for i in unnamed:
            near = any(distances[i, n] <= gate(association.outer, 2) for n in names)
            found[i] = IGNORED if near else NEW
        if association.kind == "joint" and inner:
            z, H = (np.concatenate(parts) for parts in zip(*map(looks.get, inner), strict=True))
            S = H @ self.P @ H.T + block_diag(*(noises[i] for i, _ in inner))
            limits = np.array([gate(association.level, 2 * k) for k in range(1, len(inner) + 1)])
            chosen = joint_compatibility(np.array(inner), z.reshape(-1, 2), S, limits)
            return self.named(found, [inner[k] for k in chosen])
        chosen = []
        for i, name in sorted(inner, key=distances.get):
            if all(i != other and name != taken for other, taken in chosen):
                chosen.append((i, name))
        return self.named(found, chosen)

    def named(self, found, pairs):
        for i, name in pairs:
            found[i] = name
        return found

    def count(self, name):
        self.counts["anchored" if name in self.anchors else "matched"] += 1
        if name in self.anchors:
            return
        self.uses[name] += 1
        if self.uses[name] - 1 != self.settings.revision_limit:
            return
        self.counts["retired"] += 1
        if self.settings.retirement == "consider":
            self.considered.add(name)
            return
        keep = np.delete(np.arange(self.x.size), self.rows(name))
        self.anchors[name] = self.frozen[name] = self.x[self.rows(name)]
        self.names.remove(name)
        self.x, self.first, self.P = self.x[keep], self.first[keep], self.P[np.ix_(keep, keep)]

    def add(self, names, values, noises):
        sensor, n = self.settings.sensor, self.x.size
        places = sensor.locate(self.x[:3], values)
        true = isinstance(self.truth, Truth)
        there = self.true_places(names).reshape(-1, 2) if true else places
        by_pose, by_value = sensor.locate_jacobians(self.point[:3], there, values)
        Y = np.eye(n + 2 * len(names))
        Y[n:, :3], Y[n:, n:] = by_pose.reshape(-1, 3), block_diag(*by_value)
        self.P = Y @ block_diag(self.P, *noises) @ Y.T
        self.x, self.first = np.r_[self.x, places.ravel()], np.r_[self.first, there.ravel()]
        self.names += names
        self.counts["new"] += len(names)


def assert_is_dense(run: History, start: MapBelief, steps: list[Step], settings: Settings) -> None:
    """Compare all that a run reports with the oracle: means, all blocks, both triangles, counts."""
    oracle = Dense(start, settings)
    records = [oracle.step(k, step) for k, step in enumerate(steps)]
    beliefs = {**run.kept, len(steps) - 1: run.belief}
    assert sorted(run.kept) == sorted(run.points) == sorted(settings.keep)
    for k, record in enumerate(records):
        assert_close(run.poses[k], record.mean[:3])
        assert_close(run.pose_covs[k], record.cov[:3, :3])
        np.testing.assert_allclose(run.nis[k], record.nis, rtol=1e-6, atol=1e-9)
        assert run.dof[k] == record.dof
        assert run.sizes[k] == len(record.names)
        assert run.used[k].tolist() == record.used
        if k in run.points:
            assert_close(run.points[k], record.point)
        if k in beliefs:
            assert beliefs[k].ids.tolist() == record.names
            assert_close(beliefs[k].mean, record.mean)
            assert_close(beliefs[k].cov, record.cov)
            np.testing.assert_array_equal(beliefs[k].cov, beliefs[k].cov.T)
    for name, count in oracle.counts.items():
        assert getattr(run.counts, name) == count
    assert list(run.frozen) == list(oracle.frozen)
    for name, place in oracle.frozen.items():
        assert_close(run.frozen[name], place)
