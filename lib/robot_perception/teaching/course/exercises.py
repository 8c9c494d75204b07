"""Exercises that check themselves: right, wrong with a hint, or not yet."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from html import escape

import numpy as np

from explorables.media import Shown
from explorables.outputs import output
from robot_perception.checks import shown
from robot_perception.teaching import FRONT_END


@dataclass(frozen=True, eq=False)
class Exercise:
    """Judge of an exercise: right answers, and replies to the typical mistakes.

    Parameters
    ----------
    answer
        The right answer (number, array, truth value or text), or a predicate of the reader's
        answer.
    mistakes
        Pairs of a typical wrong answer (value or predicate) and the hint for it.
    hint
        The hint for any other wrong answer.
    rtol
        Relative tolerance for numbers; the absolute tolerance is ``rtol`` as well.
    """

    answer: object
    mistakes: tuple[tuple[object, str], ...] = ()
    hint: str = "Look again at what is asked."
    rtol: float = 1e-6

    def __post_init__(self) -> None:
        answer = self.answer if isinstance(self.answer, float | np.ndarray) else 0.0
        if np.asarray(answer).dtype.kind in "fc" and np.isnan(answer).any():
            raise ValueError(f"answer must not be NaN, got {shown(self.answer)}")
        for pair in self.mistakes:
            if len(pair) != 2 or not isinstance(pair[1], str):
                raise ValueError(f"mistakes must be pairs of an answer and a hint, got {pair!r}")

    def judge(self, answer: object) -> tuple[str, str]:
        """Return the outcome (``"right"``, ``"wrong"``, ``"not yet"``) and what to say."""
        if answer is ... or answer is None:
            return "not yet", "Put your answer in place of the dots and run the cell again."
        try:
            if self._matches(self.answer, answer):
                return "right", "Right."
            for wrong, hint in self.mistakes:
                if self._matches(wrong, answer):
                    return "wrong", f"Not quite: {hint}"
        except Exception as error:  # the reader's answer may be any object
            return "wrong", f"This answer cannot be checked ({error}). {self.hint}"
        return "wrong", f"Not quite. {self.hint}"

    def _matches(self, wanted: object, given: object) -> bool:
        if isinstance(wanted, Callable):
            return bool(wanted(given))
        if isinstance(wanted, str):
            return isinstance(given, str) and _words(given) == _words(wanted)
        flags = [isinstance(one, bool | np.bool_) for one in (wanted, given)]
        if any(flags):
            return all(flags) and bool(given) == bool(wanted)
        wanted, given = np.asarray(wanted, dtype=float), np.asarray(given, dtype=float)
        if wanted.shape != given.shape:
            return False
        return bool(np.allclose(given, wanted, rtol=self.rtol, atol=self.rtol))


def _words(text: str) -> str:
    return re.sub(r"\W+", " ", text).strip().casefold()


class Sheet(dict[str, Exercise]):
    """The exercises of one chapter by identifier, such as ``"monobot-1"``."""

    def check(self, key: str, answer: object) -> Shown:
        """Judge an answer and say so.

        Raises
        ------
        ValueError
            If the chapter has no exercise of that name.
        """
        if key not in self:
            raise ValueError(f"key: no exercise {key!r}; this chapter has {', '.join(self)}")
        outcome, words = self[key].judge(answer)
        style = outcome.replace(" ", "-")
        html = f'<p class="rp-check rp-check--{style}" role="status">{escape(words)}</p>'
        return output(html, f"{key}: {outcome}. {words}", FRONT_END / "check.css")
