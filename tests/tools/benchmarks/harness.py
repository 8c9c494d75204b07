"""Benchmarks: ratios against a peer, measured side by side on one core, medians."""

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Row:
    """One line of the benchmark table.

    Parameters
    ----------
    work
        What is done, with exact sizes.
    ours
        Does the work once with this library.
    peer
        Does the same work once with the peer, or ``None`` if there is no peer.
    peer_name
        Name of the peer.
    ratio
        Least ratio peer time / our time that counts as reached, or ``None``.
    at_most
        Longest time of ours that counts as reached, in seconds, or ``None``.
    agree
        Raises ``AssertionError`` unless both sides give the same answer.
    repeats
        How many alternating pairs are timed.
    inner
        Calls of ``ours`` per timed sample, for work of microseconds; the peer gets as many.
    """

    work: str
    ours: Callable[[], object]
    peer: Callable[[], object] | None = None
    peer_name: str = ""
    ratio: float | None = None
    at_most: float | None = None
    agree: Callable[[], None] = field(default=lambda: None)
    repeats: int = 9
    inner: int = 1


@dataclass(frozen=True, slots=True)
class Timing:
    """Medians of one row, in seconds, and whether the target was reached."""

    work: str
    ours_s: float
    peer_s: float | None
    peer_name: str
    target: str
    reached: bool

    @property
    def ratio(self) -> float | None:
        """Peer time over our time."""
        return None if self.peer_s is None else self.peer_s / self.ours_s


def _seconds(work: Callable[[], object], inner: int) -> float:
    start = time.perf_counter()
    for _ in range(inner):
        work()
    return (time.perf_counter() - start) / inner


def measure(row: Row) -> Timing:
    """Check that both sides agree, warm both up, then time them in alternation."""
    row.agree()
    row.ours()
    ours, peer = [], []
    for _ in range(row.repeats):
        ours.append(_seconds(row.ours, row.inner))
        if row.peer is not None:
            peer.append(_seconds(row.peer, row.inner))
    ours_s = statistics.median(ours)
    peer_s = statistics.median(peer) if peer else None
    targets, reached = [], True
    if row.ratio is not None:
        targets.append(f"≥ {row.ratio:g}× {row.peer_name}")
        reached &= peer_s / ours_s >= row.ratio
    if row.at_most is not None:
        targets.append(f"≤ {row.at_most * 1e3:g} ms")
        reached &= ours_s <= row.at_most
    return Timing(row.work, ours_s, peer_s, row.peer_name, ", ".join(targets) or "–", reached)
