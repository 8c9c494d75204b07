"""ROS bags: the topics in them, and their messages with the times at which they were measured."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, NamedTuple, final

import numpy as np
from jaxtyping import Bool, Float, Int

from robot_perception.checks import instance, instances
from robot_perception.datasets.logs import CorruptLog, ReadReport, as_path
from robot_perception.extras import needing
from studies.files import reading

Topics = str | Sequence[str] | None
"""A topic, several of which one is meant, or the only one that will do."""

ENDINGS = (".bag", ".mcap", ".db3")
"""Endings of a ROS 1 bag, and of the files that hold the messages of a ROS 2 bag."""
METADATA = "metadata.yaml"
TELLTALE = b"rosbag2_bagfile_information"  # the first key of that file
SQLITE, LARGEST_PAGE = b"SQLite format 3\0", 65536  # bytes, of which the header says 1
SET_BACK = 10**9  # ns: a clock that falls by more was set, or the recording was played twice
STEADY = 10**8  # ns: by how much the delay of half of the messages may differ from the usual one
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


def share_topics(topics: Sequence[str], *paths: str | Path | None) -> tuple[tuple[str, ...], ...]:
    """Return for each of several files which of some topics it holds.

    Parameters
    ----------
    topics
        Their names.
    paths
        The files, of which some may be bags, and some none at all. Where one is a bag or none is,
        all topics are meant for each.

    Raises
    ------
    CorruptLog
        If one of the topics is in none of several bags, or a bag is damaged.
    FileNotFoundError
        If there is no such bag.
    """
    topics = instances("topics", instance("topics", topics, list, tuple), str)
    files = [path if path is None else as_path(path, "paths") for path in paths]
    there = {path: bag_topics(path) for path in files if path is not None and is_bag(path)}
    if len(topics) < 2 or len([path for path in files if path in there]) < 2:
        return (tuple(topics),) * len(files)
    names = {path: {name.strip("/") for name in found} for path, found in there.items()}
    shared = tuple(
        tuple(name for name in topics if _topic(name).strip("/") in names.get(path, ()))
        for path in files
    )
    for name in topics:
        if not any(name in held for held in shared):
            raise CorruptLog(f"topic {name!r} is not in {' or '.join(map(str, there))}")
    return shared


class Meaning(NamedTuple):
    """Meaning that messages of several types have in common.

    Parameters
    ----------
    name
        What they are.
    kinds
        The types, of which none goes before another.
    """

    name: str
    kinds: tuple[str, ...]


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
        self.remarks: list[str] = []
        """Sentences on which topics were taken without being named."""
        for one in sorted(reader.connections, key=lambda one: one.topic):
            if one.msgcount:
                kinds = {*self.topics.get(one.topic, ()), one.msgtype}
                self.topics[one.topic] = tuple(sorted(kinds))
                self.counts[one.topic] = self.counts.get(one.topic, 0) + one.msgcount

    def choose(
        self, meaning: Meaning, wanted: Topics, fits: Callable[[str], bool] | None = None
    ) -> str:
        """Return the topic that is meant, of those that hold messages of a meaning.

        One that was not named is named in the remarks.

        Parameters
        ----------
        meaning
            Of the messages.
        wanted
            The topics that are named.
        fits
            Whether a topic would do, where none is named; if none does, all are meant.

        Raises
        ------
        CorruptLog
            If a topic that is named is not there or of another type, or none or several would do.
        """
        named = any(self.holds(name, meaning) for name, _ in self.named(wanted))
        return self.only(meaning, self.candidates(meaning, wanted, fits), named=named)

    def only(self, meaning: Meaning, found: Sequence[str], *, named: bool) -> str:
        """Return the one topic that was found, or raise `CorruptLog`; say which, if nobody did."""
        if len(found) == 1:
            if not named:
                self.remarks.append(f"{meaning.name} of {found[0]}")
            return found[0]
        if not found:
            kinds = ", ".join(map(short, meaning.kinds))
            raise CorruptLog(
                f"{self.path}: no topic holds {meaning.name} ({kinds}); it has {self._told()}"
            )
        raise CorruptLog(
            f"{self.path}: {len(found)} topics hold {meaning.name}:"
            f" {', '.join(map(self._described, found))};"
            " say which (topic=…, in a script --topic; of two files one for each)"
        )

    def candidates(
        self, meaning: Meaning, wanted: Topics, fits: Callable[[str], bool] | None = None
    ) -> list[str]:
        """Return the topics that may be meant, as `choose` looks for them."""
        named = [name for name, _ in self.named(wanted)]
        found = [name for name in named if self.holds(name, meaning)]
        if isinstance(wanted, str) and not found:
            holds = " or ".join(map(short, self.topics[named[0]]))
            kinds = ", ".join(map(short, meaning.kinds))
            raise CorruptLog(
                f"{self.path}: topic {wanted!r} holds {holds}, not {meaning.name} ({kinds})"
            )
        if found:
            return found
        found = [name for name in self.topics if self.holds(name, meaning)]
        return [name for name in found if fits is None or fits(name)] or found

    def named(self, wanted: Topics) -> list[tuple[str, str]]:
        """Return the topics that are named, each with what follows it after a colon.

        Raises
        ------
        CorruptLog
            If one of them is not there.
        """
        there = {name.strip("/"): name for name in self.topics}
        found = []
        for name in dict.fromkeys([wanted] if isinstance(wanted, str) else wanted or ()):
            topic, _, more = name.partition(":")
            if topic.strip("/") not in there:
                told = f"topic {topic!r} is not in this bag, which has {self._told()}"
                raise CorruptLog(f"{self.path}: {told}")
            found.append((there[topic.strip("/")], more))
        return found

    def holds(self, topic: str, meaning: Meaning) -> bool:
        """Tell whether a topic holds messages of a meaning."""
        return not {*meaning.kinds}.isdisjoint(self.topics[topic])

    def first(self, topic: str, meaning: Meaning) -> Any:
        """Return the fields of the first message of a topic."""
        return next(self.messages(topic, meaning.kinds)).content

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
        told = dict.fromkeys([*self.remarks, *remarks])
        return ReadReport(self.path, kept, others, "messages", tuple(told))

    def _told(self) -> str:
        return ", ".join(map(self._described, self.topics)) or "no message at all"

    def _described(self, name: str) -> str:
        """Return the name of a topic with its types and the number of its messages."""
        kinds = " or ".join(map(short, self.topics[_topic(name)]))
        count = self.counts[_topic(name)]
        return f"{name} ({kinds}, {count} {'message' if count == 1 else 'messages'})"


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


class Times(NamedTuple):
    """Times at which the messages of a topic were measured.

    Parameters
    ----------
    times : (n,)
        ns.
    kept : (n,)
        Whether a message has a time, and it lies after those before.
    delay
        Usual time from measuring to recording, as the clocks of both show it, ns.
    remarks
        Sentences on messages that are not kept.
    """

    times: Int[np.ndarray, " n"]
    kept: Bool[np.ndarray, " n"]
    delay: int
    remarks: list[str]


def rising(
    path: Path,
    topic: str,
    stamps: Sequence[int],
    logged: Sequence[int],
    *,
    recorded: bool = False,
) -> Times:
    """Return the times of messages, and which of them rise.

    Parameters
    ----------
    path, topic
        Of the bag.
    stamps, logged
        When they were measured and recorded, ns. If none says when it was measured, the times of
        recording are taken.
    recorded
        Whether to put the times on the clock of the recording, by the usual delay.

    Raises
    ------
    CorruptLog
        If no message is kept, time falls by more than a second, or the two clocks run apart.
    """
    times, written, remarks = *np.array([stamps, logged], dtype=np.int64), []
    if not times.any():
        times = written
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
    delays = (written - times)[kept]
    delay = int(np.median(delays))
    if recorded and np.median(np.abs(delays - delay)) > STEADY:
        raise CorruptLog(f"{path}: the clock of {topic} runs unlike that of the recording")
    return Times(times + delay * recorded, kept, delay, remarks)


def gap(first: Float[np.ndarray, " k"], second: Float[np.ndarray, " m"]) -> float:
    """Return how far two series of times, rising, are apart, s; below 0 where they overlap."""
    return float(max(first[0], second[0]) - min(first[-1], second[-1]))


def span(times: Float[np.ndarray, " k"]) -> str:
    """Return from when to when times, rising, reach, in words."""
    return f"from {times[0]:.3f} to {times[-1]:.3f} s"


def short(kind: str) -> str:
    """Return the name of a type of messages without its package."""
    return kind.rpartition("/")[2]


def _topic(name: str) -> str:
    """Return the topic in a name that may go on with frames after a colon."""
    return name.partition(":")[0]


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
