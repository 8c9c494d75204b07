"""The trees of frames in ROS bags: what is fixed to what, and the motions that they tell."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple, final

import numpy as np
from jaxtyping import Bool, Float

from robot_perception.datasets import bags
from robot_perception.datasets.bags import Bag, Meaning
from robot_perception.datasets.logs import CorruptLog

TREES = Meaning("a tree of frames", ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage"))
STATIC = "static"  # ends the name of a topic whose frames never move
BODIES = ("base_footprint", "base_link")  # of robots, by the ROS enhancement proposals 105 and 120
UNIT = 1e-3  # by how much the length of a quaternion may be off
STILL = 1e-6  # m, and of a rotation matrix: a frame that moves by less does not move

Ancestors = dict[str, Float[np.ndarray, "4 4"]]
"""The frames above a frame and itself, each with the motion from it to the frame."""


@dataclass(frozen=True, eq=False, slots=True)
class Edge:
    """Transforms of one frame in another that a topic holds.

    Parameters
    ----------
    parent, child
        Names of the frames; the first is empty if several are told.
    stamps, logged
        When each place was measured and recorded, ns.
    places : (k, 7)
        Position, m, and quaternion x, y, z, w of the child in its parent.
    static
        Whether its topic says that it never moves.
    """

    parent: str
    child: str
    stamps: list[int]
    logged: list[int]
    places: Float[np.ndarray, "k 7"]
    static: bool

    @property
    def moves(self) -> bool:
        """True if the child has several places in its parent."""
        return not np.abs(self.places - self.places[0]).max() <= STILL


class Motion(NamedTuple):
    """The motion of one frame in another, as a tree of frames tells it.

    Parameters
    ----------
    times : (k,)
        s since 1970, rising.
    poses : (k, 4, 4)
        Of the child in its ancestor, m.
    delay
        Usual time from measuring to recording, s.
    remarks
        Sentences on what was left out.
    """

    times: Float[np.ndarray, " k"]
    poses: Float[np.ndarray, "k 4 4"]
    delay: float
    remarks: list[str]


@final
class Frames:
    """The frames of an open bag, read when they are first asked for.

    Parameters
    ----------
    bag
        It stays open as long as this is used.
    """

    def __init__(self, bag: Bag) -> None:
        self.bag = bag

    @cached_property
    def edges(self) -> dict[str, dict[str, Edge]]:
        """Edges by topic and child."""
        topics = [name for name in self.bag.topics if self.bag.holds(name, TREES)]
        return {name: _edges(self.bag, name) for name in topics}

    def mount(self, body: str, sensor: str) -> Float[np.ndarray, "4 4"] | None:
        """Return where a sensor is mounted, ``T_body_sensor``; nothing if the bag does not tell.

        Frames that do not move are looked at: those of ``tf_static``, and those of other topics
        that are the same whenever they are told.

        Parameters
        ----------
        body, sensor
            Names of their frames.
        """
        if body == sensor:
            return np.eye(4)
        above_body, above_sensor = self._fixed_above(body), self._fixed_above(sensor)
        for name, T in above_sensor.items():
            if name in above_body:
                return np.linalg.inv(above_body[name]) @ T
        return None

    def body(self, sensor: str) -> str:
        """Return the frame of the robot that a sensor is mounted on; its own if none is told."""
        above = [*self._fixed_above(sensor)]
        return next((name for name in reversed(above) if _is_body(name)), above[-1])

    def are_fixed(self, first: str, second: str) -> bool:
        """Tell whether two frames do not move against each other."""
        return self.mount(first, second) is not None

    def motions(self, topic: str) -> list[tuple[str, str]]:
        """Return the frames that a topic moves, each after one above it.

        Of a robot they are the frames above its body, between which and the body something moves:
        what moves on the robot, such as its wheels, is none. Where no frame has the name of a
        body, they are all pairs between which something moves.
        """
        tree = self._tree(topic)
        moving = {child for child, edge in tree.items() if edge.moves and not edge.static}
        named = {*filter(_is_body, {*tree} | {edge.parent for edge in tree.values()})}
        found = []
        for child in sorted(named or moving):
            above = [edge for edge in _up(tree, child) if not edge.static]
            if named and any(edge.parent in named for edge in _up(tree, child)):
                continue  # fixed to the body, or another name of it
            steps = [edge for edge in above if edge.child in moving] or above[:1]
            found += [(edge.parent, child) for edge in steps]
        return found

    def two(self, topic: str, text: str) -> tuple[str, str]:
        """Return the two frames that a text with a point between them names.

        Raises
        ------
        CorruptLog
            If the topic does not tell of the second.
        """
        ends = [k for k, letter in enumerate(text) if letter == "."]
        pairs = [(frame_name(text[:k]), frame_name(text[k + 1 :])) for k in ends]
        for parent, child in pairs:
            if child in self._tree(topic):
                return parent, child
        raise CorruptLog(
            f"{self.bag.path}: {text!r} names no two frames of {topic}, which tells"
            f" {self._told(topic)}"
        )

    def motion(self, topic: str, parent: str, child: str, *, recorded: bool = False) -> Motion:
        """Return the motion of a frame in one above it, at the times of what moves it last.

        What moves above that is taken between the times at which it is told.

        Parameters
        ----------
        topic
            Of the tree.
        parent, child
            Names of the frames.
        recorded
            Whether to put the times on the clock of the recording.

        Raises
        ------
        CorruptLog
            If the tree does not lead from one to the other, no time is common to all that moves, or
            a transform is none.
        """
        path, name, steps = self.bag.path, f"{topic}:{parent}.{child}", []
        for edge in _up(self._tree(topic), child):
            steps.append(edge)
            if edge.parent == parent:
                break
        else:
            raise CorruptLog(
                f"{path}: {topic} does not tell where {child!r} is in {parent!r}; it tells"
                f" {self._told(topic)}"
            )
        told = [edge for edge in steps if not edge.static]
        leads = next((edge for edge in told if edge.moves), told[0] if told else steps[0])
        times, kept, delay, remarks = bags.rising(
            path, name, leads.stamps, leads.logged, recorded=recorded
        )
        times = times[kept] / 1e9
        T, covered = np.eye(4), np.ones(len(times), dtype=bool)
        for edge in reversed(steps):
            if edge is leads:
                step = _matrices(path, name, edge)[kept]
            elif edge.moves:
                step, there = _between(path, name, edge, times, recorded)
                covered &= there
            else:
                step = _matrices(path, name, edge)[:1]
            T = T @ step
        if not covered.any():
            raise CorruptLog(f"{path}: the frames of {name} are never told at one time")
        if lost := np.count_nonzero(~covered):
            remarks.append(f"{name}: {lost} poses skipped, frames above are not told at their time")
        return Motion(times[covered], T[covered], delay / 1e9, remarks)

    def _told(self, topic: str) -> str:
        return ", ".join(f"{a}.{b}" for a, b in self.motions(topic)) or "no motion"

    def _tree(self, topic: str) -> dict[str, Edge]:
        """Return the edges of a topic and of those that are static, by their children."""
        static = [edges for name, edges in self.edges.items() if name.endswith(STATIC)]
        return {child: edge for edges in static for child, edge in edges.items()} | self.edges[
            topic
        ]

    @cached_property
    def _placed(self) -> dict[str, tuple[str, Float[np.ndarray, "4 4"]]]:
        """Static frames by name: the parent's name, and the place in it."""
        placed, moving = {}, set()
        for edges in self.edges.values():
            for child, edge in edges.items():
                known = placed.setdefault(child, edge)
                off = np.abs(known.places[0] - edge.places[0]).max()
                if known.parent != edge.parent or not edge.parent or edge.moves or off > STILL:
                    moving.add(child)
        return {
            child: (edge.parent, _matrices(self.bag.path, child, edge)[0])
            for child, edge in placed.items()
            if child not in moving and _is_unit(edge.places[0])
        }

    def _fixed_above(self, frame: str) -> Ancestors:
        """Return the frames above a frame that do not move against it."""
        T, found = np.eye(4), {}
        while frame not in found:
            found[frame] = T
            if frame in self._placed:
                frame, step = self._placed[frame]
                T = step @ T
        return found


def _edges(bag: Bag, topic: str) -> dict[str, Edge]:
    """Return what a topic tells of each frame."""
    told: dict[str, tuple[set[str], list, list, list]] = {}
    for _, logged, content in bag.messages(topic, TREES.kinds):
        for one in content.transforms:
            at, q, stamp = one.transform.translation, one.transform.rotation, one.header.stamp
            place = told.setdefault(frame_name(one.child_frame_id), (set(), [], [], []))
            place[0].add(frame_name(one.header.frame_id))
            place[1].append(stamp.sec * 10**9 + stamp.nanosec)
            place[2].append(logged)
            place[3].append((at.x, at.y, at.z, q.x, q.y, q.z, q.w))
    edges = {}
    for child, (parents, stamps, logged, rows) in told.items():
        parent, places = parents.pop() if len(parents) == 1 else "", np.array(rows)
        places[places[:, 3:] @ places[0, 3:] < 0, 3:] *= -1  # the same rotations
        edges[child] = Edge(parent, child, stamps, logged, places, topic.endswith(STATIC))
    return edges


def _up(tree: dict[str, Edge], frame: str) -> Iterator[Edge]:
    """Yield the edges from a frame up to the top of its tree."""
    seen = set()
    while frame in tree and tree[frame].parent and frame not in seen:
        seen.add(frame)
        yield tree[frame]
        frame = tree[frame].parent


def _between(
    path: Path, name: str, edge: Edge, times: Float[np.ndarray, " k"], recorded: bool
) -> tuple[Float[np.ndarray, "k 4 4"], np.ndarray]:
    """Return an edge at given times, and whether they lie within those at which it is told."""
    from robot_perception.datasets.space_tracks import SpaceTrack  # which reads bags

    told = bags.rising(path, name, edge.stamps, edge.logged, recorded=recorded)
    track = SpaceTrack(told.times[told.kept] / 1e9, _matrices(path, name, edge)[told.kept])
    return track.at(times, longest_gap=np.inf)


def _matrices(path: Path, name: str, edge: Edge) -> Float[np.ndarray, "k 4 4"]:
    return rigid_motions(path, name, edge.places)


def rigid_motions(
    path: Path, name: str, places: Float[np.ndarray, "k 7"]
) -> Float[np.ndarray, "k 4 4"]:
    """Return rigid motions by positions and quaternions x, y, z, w.

    Parameters
    ----------
    path, name
        Of the bag and the topic.
    places : (k, 7)
        As messages tell them.

    Raises
    ------
    CorruptLog
        If a number is not finite, or a quaternion not of unit length.
    """
    from scipy.spatial.transform import Rotation  # the other readers do without

    check_finite(path, name, places)
    off = ~_is_unit(places)
    if off.any():
        k = int(np.argmax(off))
        raise CorruptLog(f"{path}: pose {k + 1} of {name} has no quaternion of unit length")
    T = np.zeros((len(places), 4, 4))
    T[:, :3, :3], T[:, 3, 3] = Rotation.from_quat(places[:, 3:]).as_matrix(), 1
    T[:, :3, 3] = places[:, :3]
    return T


def check_finite(path: Path, topic: str, values: Float[np.ndarray, "k n"]) -> None:
    """Raise `CorruptLog` at the first message that holds a number which is not finite."""
    bad = ~np.isfinite(values).all(axis=1)
    if bad.any():
        raise CorruptLog(f"{path}: message {np.argmax(bad) + 1} of {topic} is NaN or infinite")


def frame_name(name: str) -> str:
    """Return the name of a frame without the slash that ROS 1 let it begin with."""
    return name.lstrip("/")


def _is_unit(places: Float[np.ndarray, "... 7"]) -> np.bool_ | Bool[np.ndarray, "..."]:
    return np.abs(np.linalg.norm(places[..., 3:], axis=-1) - 1) < UNIT


def _is_body(frame: str) -> bool:
    return frame.rpartition("/")[2] in BODIES
