"""Values and calls between two processes, as lines of JSON.

What is sent is numbers, texts, truth values, arrays, and tuples, lists and tables of these: no
pickle, so that nothing that is received can run code. A function stays where it is; the other side
gets a function that sends its arguments and waits for what comes back.
"""

import json
import time
from collections.abc import Callable, Mapping
from dataclasses import fields
from importlib import import_module
from socket import socket
from typing import Any

import numpy as np

OBJECTS = {("robot_perception.companion.interaction", "Event")}
"""Types whose objects are sent by their fields: module and name."""
CHUNK = 1 << 16
NO_VALUE = "what was sent is no value"
ENDED = "the process has ended"
LONGEST = 1000
"""Characters of an error's text that are sent."""

Message = dict[str, Any]


class BrokenLine(BaseException):
    """Error: the other side sends nothing more; it is no ``Exception``, so judges let it through.

    Parameters
    ----------
    said
        Why.
    late
        Whether the time is up.
    """

    def __init__(self, said: str, *, late: bool = False) -> None:
        super().__init__(said)
        self.late = late


class Failed(Exception):  # noqa: N818 - it names what happened to a function, not an error of ours
    """A function on the other side has raised an error, or returned what cannot be sent."""


class Unsent(TypeError):  # noqa: N818 - it names the thing, not the failure
    """A value that no message can hold."""


class Line:
    """One end of a line between two processes.

    Parameters
    ----------
    end
        A socket of a pair.
    most
        Bytes of a message that is received; ``None`` for any number.
    """

    def __init__(self, end: socket, most: int | None = None) -> None:
        self._end, self._most = end, most
        self._held: list[Callable[..., Any]] = []
        self._read = bytearray()
        self._until: float | None = None

    def wait(self, seconds: float) -> None:
        """Let all that is sent and received from now on take so long together."""
        self._until = time.monotonic() + seconds

    def send(self, message: Message, most: int | None = None) -> None:
        """Send a message.

        Raises
        ------
        BrokenLine
            If nobody takes it.
        ValueError
            If it is longer than so many bytes.
        """
        text = json.dumps(message).encode("ascii") + b"\n"
        if most is not None and len(text) > most:
            raise ValueError(f"{len(text)} bytes to judge, where {most} is the most")
        with self._ready():
            self._end.sendall(text)

    def receive(self) -> Message:
        """Return the next message.

        Raises
        ------
        BrokenLine
            If there is none in time, or it is no message.
        """
        while b"\n" not in self._read:
            if self._most is not None and len(self._read) > self._most:
                raise BrokenLine(f"more than {self._most} bytes were sent")
            with self._ready():
                chunk = self._end.recv(CHUNK)
            if not chunk:
                raise BrokenLine(ENDED)
            self._read += chunk
        text, _, rest = self._read.partition(b"\n")
        self._read = rest
        try:
            message = json.loads(text)
        except (ValueError, RecursionError) as error:
            raise BrokenLine(NO_VALUE) from error
        if not isinstance(message, dict):
            raise BrokenLine(NO_VALUE)
        return message

    def ask(self, message: Message) -> Message:
        """Send a message and return what is replied; calls that come before that are answered."""
        self.send(message)
        while "call" in (reply := self.receive()):
            self.answer(reply)
        return reply

    def answer(self, message: Message, most: int | None = None) -> None:
        """Answer a call of a function that was sent from here."""
        self.reply(lambda: self._called(message), most)

    def reply(self, compute: Callable[[], Any], most: int | None = None) -> None:
        """Send the value that a function returns, or what is wrong with it."""
        try:
            self.send({"value": self.encoded(compute())}, most)
        except Unsent as error:
            self.send({"unsent": str(error)})
        except BrokenLine:
            raise
        except BaseException as error:  # whatever it is, who asked is told
            self.send({"error": told(error)})

    def encoded(self, value: Any) -> Any:
        """Return what JSON holds of a value; functions are kept, and called by their number.

        Raises
        ------
        Unsent
            If the value is of another kind than those of this module.
        """
        match value:
            case np.ndarray() | np.generic() if value.dtype.kind in "biuf":
                flat = np.asarray(value)
                flat = flat.astype(float) if flat.dtype.kind == "f" else flat
                return {"array": flat.ravel().tolist(), "shape": list(flat.shape)}
            case None | bool() | int() | float() | str():
                return value
            case list():
                return [self.encoded(item) for item in value]
            case tuple():
                return {"tuple": [self.encoded(item) for item in value]}
            case Mapping() if all(isinstance(key, str) for key in value):
                return {"table": {key: self.encoded(item) for key, item in value.items()}}
        kind = type(value)
        if value is ...:
            return {"dots": True}
        if (kind.__module__, kind.__qualname__) in OBJECTS:
            parts = {one.name: self.encoded(getattr(value, one.name)) for one in fields(value)}
            return {"object": [kind.__module__, kind.__qualname__], "fields": parts}
        if callable(value):
            self._held.append(value)
            return {"function": len(self._held) - 1}
        raise Unsent(f"a value of the type {kind.__name__}")

    def decoded(self, data: Any) -> Any:
        """Return the value of which JSON holds this.

        Raises
        ------
        BrokenLine
            If it is none.
        """
        try:
            return self._decoded(data)
        except (ArithmeticError, LookupError, RecursionError, TypeError, ValueError) as error:
            raise BrokenLine(NO_VALUE) from error

    def _decoded(self, data: Any) -> Any:
        match data:
            case None | bool() | int() | float() | str():
                return data
            case list():
                return [self._decoded(item) for item in data]
            case {"array": list(flat), "shape": list(shape)}:
                array = np.array(flat) if flat else np.zeros(0)
                if array.ndim == 1 and array.dtype.kind in "biuf":
                    return array.reshape(shape)[()]
            case {"tuple": list(items)}:
                return tuple(self._decoded(item) for item in items)
            case {"table": dict(table)}:
                return {key: self._decoded(item) for key, item in table.items()}
            case {"dots": True}:
                return ...
            case {"object": [str(module), str(name)], "fields": dict(parts)} if (
                module,
                name,
            ) in OBJECTS:
                kind = getattr(import_module(module), name)
                return kind(**{key: self._decoded(item) for key, item in parts.items()})
            case {"function": int(number)}:
                return self._far(number)
        raise ValueError(NO_VALUE)

    def _far(self, number: int) -> Callable[..., Any]:
        """Return a function that calls one on the other side."""

        def far(*given: Any, **named: Any) -> Any:
            reply = self.ask({"call": number, "given": self.encoded((given, named))})
            if "value" not in reply:
                raise Failed(str(reply.get("error", reply.get("unsent", NO_VALUE))))
            value = self.decoded(reply["value"])
            if _holds_nothing(value):  # arrays without a number are close to any number
                raise Failed("nothing was returned")
            return value

        return far

    def _called(self, message: Message) -> Any:
        match message:
            case {"call": int(number), "given": data} if 0 <= number < len(self._held):
                match self.decoded(data):
                    case (tuple(given), dict(named)):
                        return self._held[number](*given, **named)
        raise BrokenLine(NO_VALUE)

    def _ready(self) -> "_Waiting":
        return _Waiting(self._end, self._until)


class _Waiting:
    """The time that a socket has, and one error for all that it raises."""

    def __init__(self, end: socket, until: float | None) -> None:
        self._end, self._until = end, until

    def __enter__(self) -> None:
        left = None if self._until is None else self._until - time.monotonic()
        if left is not None and left <= 0:
            raise BrokenLine("no time is left", late=True)
        self._end.settimeout(left)

    def __exit__(self, kind: type | None, error: BaseException | None, _: object) -> None:
        if isinstance(error, TimeoutError):
            raise BrokenLine("no time is left", late=True) from error
        if isinstance(error, OSError):
            raise BrokenLine(ENDED) from error


def _holds_nothing(value: Any) -> bool:
    if isinstance(value, list | tuple):
        return all(map(_holds_nothing, value))
    return isinstance(value, np.ndarray) and value.size == 0


def told(error: BaseException) -> str:
    """Return an error's kind and text in a line, whatever its text raises."""
    try:
        return f"{type(error).__name__}: {' '.join(str(error).split())}"[:LONGEST]
    except BaseException:  # a text of an answer's own making
        return "an error without a text"
