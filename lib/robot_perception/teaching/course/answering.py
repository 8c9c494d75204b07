"""The process in which a student's answers run, and the one beside it that ends what they start.

The names of an answer are those of the book's study cells without the sheet of exercises
(`copies.without_sheet`), so that no right answer is there. What is handed to ``check`` goes to who
grades as a message (`teaching.course.messages`); a function stays here, and is called from there.
"""

import contextlib
import ctypes
import os
import select
import signal
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from importlib import import_module
from pathlib import Path
from socket import socket
from types import ModuleType
from typing import Any

from robot_perception.project import BOOK
from robot_perception.teaching.course.copies import without_sheet
from robot_perception.teaching.course.messages import BrokenLine, Line, told
from studies.keys.cells import folder, run

LONGEST = 100_000
"""Bytes of a message from an answer."""
TICK_S = 0.02
CLEARING_S = 5.0
"""Seconds in which the processes that an answer left are ended, if they can be."""
ADOPT_ORPHANS = 36
"""``PR_SET_CHILD_SUBREAPER`` of Linux: who loses its parent becomes a child of this process."""
END_WITH_PARENT = 1
"""``PR_SET_PDEATHSIG`` of Linux: the signal that this process gets where its parent ends."""


def work(end: socket, stem: str, memory: int) -> None:
    """Answer in a process of its own where the system forks, and end all that it has started.

    Parameters
    ----------
    end
        Of the line to who grades. When its other end is closed, the answering is over.
    stem
        The chapter.
    memory
        Bytes that answers may take beside the study cells.
    """
    if not hasattr(os, "fork"):
        answer(end, stem, memory)
        return
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the line tells when it is over
    _control(ADOPT_ORPHANS, 1)
    child = os.fork()
    if not child:
        with _leaving():
            os.setsid()
            _control(END_WITH_PARENT, signal.SIGKILL)
            answer(end, stem, memory)
    watched = select.poll()
    watched.register(end, 0)  # that the other end is closed is told in any case
    while not (ended := os.waitpid(child, os.WNOHANG) != (0, 0)) and not watched.poll(0):
        time.sleep(TICK_S)
    _killed(os.killpg, child)
    if not ended:
        _killed(os.kill, child)
    _end_children()


def answer(end: socket, stem: str, memory: int) -> None:
    """Run the cells that are received, and reply what each hands to ``check``."""
    nowhere = os.open(os.devnull, os.O_RDWR)
    for number in range(3):  # what an answer prints is not shown
        os.dup2(nowhere, number)
    sys.stdout = sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - to the end
    line = Line(end)
    names = vars(_study(stem))
    _limit(memory)
    line.send({"ready": True})
    serve(line, names)


def serve(line: Line, names: Mapping[str, Any]) -> None:
    """Run cells and call functions as it is asked, until the other end is closed."""
    try:
        while True:
            match line.receive():
                case {"run": str(source), "key": str(key)}:
                    handed(line, names, key, source)
                case call:
                    line.answer(call, LONGEST)
    except BrokenLine:
        return


def handed(line: Line, names: Mapping[str, Any], key: str, source: str) -> None:
    """Run an answer's cell, and reply what it hands to ``check``."""
    given: dict[str, Any] = {}
    inside = {**names, "check": given.__setitem__, "__name__": "__main__"}
    try:
        exec(compile(source, f"answer of {key}", "exec"), inside)
    except BaseException as error:  # whatever a student writes, the next one is graded
        line.send({"error": told(error)})
        return
    if key in given:
        line.reply(lambda: given[key], LONGEST)
    else:
        line.send({"missing": True})


def _study(stem: str) -> ModuleType:
    """Return the module of a chapter's study cells without its sheet, as imports find it."""
    name = f"{BOOK}{stem}"
    import_module(name.rpartition(".")[0])
    page = folder() / f"{stem}.ipynb"
    module = sys.modules[name] = ModuleType(name)
    module.__file__ = str(page)
    run(without_sheet(page), vars(module))
    return module


def _limit(memory: int) -> None:
    """Bound the memory of this process, and of each that it starts, where the system can."""
    try:
        import resource
    except ModuleNotFoundError:  # Windows
        return
    sizes = Path("/proc/self/statm")
    taken = int(sizes.read_text().split()[0]) * resource.getpagesize() if sizes.exists() else 0
    with contextlib.suppress(OSError, ValueError):  # a lower one holds already, or none can
        resource.setrlimit(resource.RLIMIT_AS, (taken + memory, taken + memory))


@contextlib.contextmanager
def _leaving() -> Iterator[None]:
    """End a forked process without what its parent would do at its own end."""
    try:
        yield
    finally:
        os._exit(0)


def _control(what: int, how: int) -> None:
    """Tell the system how to treat this process, where it is a Linux."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(what, how, 0, 0, 0)


def _end_children() -> None:
    """End the processes below this one; on Linux those that left their group are among them."""
    until = time.monotonic() + CLEARING_S
    while time.monotonic() < until:
        for orphan in _children():
            _killed(os.kill, orphan)
        try:
            while os.waitpid(-1, os.WNOHANG) != (0, 0):
                continue
        except ChildProcessError:
            return
        time.sleep(TICK_S)


def _killed(kill: Callable[[int, int], None], number: int) -> None:
    with contextlib.suppress(ProcessLookupError, PermissionError):  # gone, or not ours
        kill(number, signal.SIGKILL)


def _children() -> Iterator[int]:
    """Yield the processes whose parent this one is, where the system lists them."""
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):  # it has ended meanwhile
            if int(stat.read_bytes().rpartition(b")")[2].split()[1]) == os.getpid():
                yield int(stat.parent.name)
