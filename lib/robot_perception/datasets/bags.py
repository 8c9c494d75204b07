"""ROS bags: the topics in them, and their messages with the times at which they were measured."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple, final

import numpy as np
from jaxtyping import Bool, Int

from robot_perception.checks import instance, instances
from robot_perception.datasets.logs import CorruptLog, ReadReport, as_path
from robot_perception.extras import needing
from robot_perception.files import reading

Topics = str | Sequence[str] | None
"""A topic, several of which one is meant, or the only one that will do."""

ENDINGS = (".bag", ".mcap", ".db3")
"""Of a ROS 1 bag, and of the files that hold the messages of a ROS 2 bag."""
METADATA = "metadata.yaml"
TELLTALE = b"rosbag2_bagfile_information"  # the first key of that file
SQLITE, LARGEST_PAGE = b"SQLite format 3\0", 65536  # bytes, of which the header says 1
SET_BACK = 10**9  # ns: a clock that falls by more was set, or the recording was played twice
DAMAGED = "no ROS bag, or a damaged one"
NOT_AFTER = "time stamp not after the one before"
UNSTAMPED = "without time stamp"


def is_bag(path: str | Path) -> bool:
    """Tell whether a path is that of a ROS bag, by its ending or by what is in the folder.

    Parameters
    ----------
    path
        A ROS 1 bag (``.bag``), an MCAP file (``.mcap``) or an SQLite file (``.db3``) of a ROS 2
        bag; or the folder of a ROS 2 bag, which has such a file or the ``metadata.yaml`` of one.
    """
    path = as_path(path)
    if not path.is_dir():
        return path.suffix.lower() in ENDINGS
    return bool(_stored(path)) or _has_metadata(path)


def bag_topics(path: str | Path) -> dict[str, str]:
    """Return the topics of a ROS bag, each with the type of its messages.

    Parameters
    ----------
    path
        The bag, as `is_bag` describes it.

    Raises
    ------
    CorruptLog
        If it is no bag, or a damaged one.
    FileNotFoundError
        If there is none.
    """
    with opened(path) as bag:
        return {name: " or ".join(kinds) for name, kinds in bag.topics.items()}


class Stamped(NamedTuple):
    """A message of a bag.

    Parameters
    ----------
    stamp
        When it was measured, ns; 0 if it does not say.
    logged
        When it was recorded, ns.
    content
        Its fields, as the library `rosbags` gives them.
    """

    stamp: int
    logged: int
    content: Any


@final
class Bag:
    """An open ROS bag.

    Parameters
    ----------
    path
        The file or the folder.
    reader
        Of the library `rosbags`, open.
    """

    def __init__(self, path: Path, reader: Any) -> None:
        self.path = path
        self.reader = reader
        self.topics: dict[str, tuple[str, ...]] = {}
        """The types of each topic's messages, of topics that have any."""
        self.counts: dict[str, int] = {}
        for one in sorted(reader.connections, key=lambda one: one.topic):
            if one.msgcount:
                kinds = {*self.topics.get(one.topic, ()), one.msgtype}
                self.topics[one.topic] = tuple(sorted(kinds))
                self.counts[one.topic] = self.counts.get(one.topic, 0) + one.msgcount

    def choose(self, kinds: Sequence[str], wanted: Topics) -> str:
        """Return the topic that is meant, of those that hold one of some types.

        Where none of these types is named, the topics of the first type that is there are meant.

        Raises
        ------
        CorruptLog
            If a topic that is named is not there or of another type, or none or several would do.
        """
        found = self.candidates(kinds, wanted)
        if len(found) == 1:
            return found[0]
        names = " or ".join(map(short, kinds))
        if not found:
            raise CorruptLog(f"{self.path}: no topic holds {names}; it has {self._told()}")
        raise CorruptLog(
            f"{self.path}: {len(found)} topics hold {names}: {', '.join(found)};"
            " say which (topic=…, in a script --topic)"
        )

    def candidates(self, kinds: Sequence[str], wanted: Topics) -> list[str]:
        """Return the topics that may be meant, as `choose` looks for them."""
        named = dict.fromkeys([wanted] if isinstance(wanted, str) else wanted or ())
        there = {name.strip("/"): name for name in self.topics}
        for name in named:
            if name.strip("/") not in there:
                told = f"topic {name!r} is not in this bag, which has {self._told()}"
                raise CorruptLog(f"{self.path}: {told}")
        meant = [there[name.strip("/")] for name in named]
        found = [name for name in meant if {*kinds} & {*self.topics[name]}]
        if isinstance(wanted, str) and not found:
            holds = " or ".join(map(short, self.topics[meant[0]]))
            names = " or ".join(map(short, kinds))
            raise CorruptLog(f"{self.path}: topic {wanted!r} holds {holds}, not {names}")
        by_kind = ([name for name in self.topics if kind in self.topics[name]] for kind in kinds)
        return found or next(filter(None, by_kind), [])

    def messages(self, topic: str, kinds: Sequence[str]) -> Iterator[Stamped]:
        """Yield the messages of a topic in the order in which they were recorded.

        Raises
        ------
        CorruptLog
            At the first that cannot be read, or at the end if there are fewer than the bag says.
        """
        chosen = [c for c in self.reader.connections if c.topic == topic and c.msgtype in kinds]
        count, promised = 0, sum(one.msgcount for one in chosen)
        for count, (connection, logged, raw) in enumerate(self._raw(chosen), start=1):
            with reading(f"{self.path}, {topic}, message {count}", "damaged", CorruptLog):
                content = self.reader.deserialize(raw, connection.msgtype)
            yield Stamped(_nanoseconds(content), logged, content)
        if count != promised:
            raise CorruptLog(f"{self.path}: {topic} has {count} of its {promised} messages")

    def _raw(self, chosen: list) -> Iterator[tuple[Any, int, bytes]]:
        with reading(self.path, DAMAGED, CorruptLog):
            yield from self.reader.messages(connections=chosen)

    def report(self, kept: dict[str, int], remarks: Sequence[str] = ()) -> ReadReport:
        """Return the account of all messages, by the topics of which some became data."""
        others = {name: count for name, count in self.counts.items() if name not in kept}
        left = {f"{name}, skipped": self.counts[name] - count for name, count in kept.items()}
        others |= {name: count for name, count in left.items() if count}
        return ReadReport(self.path, kept, others, "messages", tuple(remarks))

    def _told(self) -> str:
        told = [f"{name} ({' or '.join(map(short, self.topics[name]))})" for name in self.topics]
        return ", ".join(told) or "no message at all"


@contextmanager
def opened(path: str | Path) -> Iterator[Bag]:
    """Open a ROS bag, and close it at the end.

    Raises
    ------
    CorruptLog
        If it is no bag, a damaged one, or one whose recording was not brought to its end.
    FileNotFoundError
        If there is none.
    """
    with needing():
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore

    path = as_path(path)
    source = _source(path)
    with ExitStack() as stack:
        with reading(path, DAMAGED, CorruptLog):
            store = get_typestore(Stores.LATEST)  # of ROS 2 bags that do not describe their types
            reader = stack.enter_context(AnyReader([source], default_typestore=store))
            bag = Bag(path, reader)
        yield bag


def check_topic(topic: Topics) -> Topics:
    """Return the name of a topic, or several, or raise ``TypeError``."""
    if topic is None or isinstance(topic, str):
        return topic
    instance("topic", topic, Sequence)
    return instances("topic", topic, str)


def rising(
    path: Path, topic: str, stamps: Sequence[int], logged: Sequence[int]
) -> tuple[Int[np.ndarray, " n"], Bool[np.ndarray, " n"], list[str]]:
    """Return the times of messages, and which of them rise.

    Parameters
    ----------
    path, topic
        Of the bag.
    stamps, logged
        When they were measured and recorded, ns. If none says when it was measured, the times of
        recording are taken.

    Returns
    -------
    times : (n,)
        ns.
    kept : (n,)
        Whether a message has a time, and it lies after those before.
    remarks
        Sentences on the others.

    Raises
    ------
    CorruptLog
        If no message is kept, or time falls by more than a second.
    """
    times, remarks = np.array(stamps, dtype=np.int64), []
    if not times.any():
        times = np.array(logged, dtype=np.int64)
        remarks.append(f"{topic}: no time stamps, so the times of recording were taken")
    there = times != 0
    before = np.maximum.accumulate(np.concatenate([[0], np.where(there, times, 0)[:-1]]))
    fall = np.where(there, before - times, 0)
    if fall.max() > SET_BACK:
        raise CorruptLog(
            f"{path}: at message {np.argmax(fall > SET_BACK) + 1} of {topic} time falls by"
            f" {fall.max() / 1e9:g} s: the clock was set, or a recording was played twice"
        )
    kept = there & (times > before)
    late = np.count_nonzero(there & ~kept)
    for count, reason in ((np.count_nonzero(~there), UNSTAMPED), (late, NOT_AFTER)):
        if count:
            remarks.append(f"{topic}: {count} messages skipped, {reason}")
    if not kept.any():
        raise CorruptLog(f"{path}: {topic} holds no message with a time")
    return times, kept, remarks


def short(kind: str) -> str:
    """Return the name of a type of messages without its package."""
    return kind.rpartition("/")[2]


def _nanoseconds(content: Any) -> int:
    """Return the time stamp of a message; 0 if it has none."""
    header = getattr(content, "header", None)
    return 0 if header is None else header.stamp.sec * 10**9 + header.stamp.nanosec


def _source(path: Path) -> Path:
    """Return what is to be opened: a file, or a folder with metadata."""
    if not path.exists():
        raise FileNotFoundError(f"no such bag: {path}")
    files = _stored(path) if path.is_dir() else [path]
    for file in files:
        rest = file.with_name(f"{file.name}-wal")
        if rest.is_file() and rest.stat().st_size:
            told = f"its recording was not ended, and messages are in {rest.name}"
            raise CorruptLog(f"{path}: {told}")
        if file.suffix.lower() == ".db3" and (lost := _lost_pages(file)):
            raise CorruptLog(f"{path}: {file.name} was cut, {lost} pages are missing")
    if not path.is_dir():
        if path.suffix.lower() not in ENDINGS:
            raise CorruptLog(f"{path}: {DAMAGED} (its name must end in {', '.join(ENDINGS)})")
        return path
    if _has_metadata(path):
        return path
    if len(files) != 1:
        raise CorruptLog(
            f"{path}: no ROS 2 bag: no {METADATA}, and {len(files)} files of messages"
            " (`ros2 bag reindex` writes it)"
        )
    return files[0]


def _stored(folder: Path) -> list[Path]:
    """Return the files of a folder in which a ROS 2 bag holds its messages."""
    return sorted(
        path
        for path in folder.iterdir()
        if path.suffix.lower() in ENDINGS[1:] and not path.name.startswith(".")
    )


def _lost_pages(file: Path) -> int:
    """Return how many pages an SQLite file lacks, which its readers notice on those alone."""
    with file.open("rb") as opened:
        head = opened.read(100)
    if len(head) < 100 or not head.startswith(SQLITE) or head[24:28] != head[92:96]:
        return 0  # no such file, or by a writer that does not count its pages
    size = int.from_bytes(head[16:18])
    there = file.stat().st_size // (LARGEST_PAGE if size == 1 else size)
    return max(int.from_bytes(head[28:32]) - there, 0)


def _has_metadata(folder: Path) -> bool:
    path = folder / METADATA
    return path.is_file() and TELLTALE in path.read_bytes()[:4096]
