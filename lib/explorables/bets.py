"""Bets: the reader picks an answer before the result, and every answer gets its reply."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from hashlib import sha256
from string import ascii_uppercase

from explorables.figures.output import on_page
from explorables.media import Shown, with_mathematics
from explorables.outputs import output

MOST_ANSWERS = 6  # the style sheet shows so many replies


@dataclass(frozen=True, eq=False, slots=True)
class Bet:
    """A bet that stands in a notebook, with what its right answer follows from.

    Parameters
    ----------
    question, replies, right
        As for `bet`, which shows it.
    because
        Tells whether the right answer is what is computed; the tests ask.
    """

    question: str
    replies: Mapping[str, str]
    right: str
    because: Callable[[], bool]

    def _repr_mimebundle_(self, include: object = None, exclude: object = None) -> dict[str, str]:
        return bet(self.question, self.replies, self.right)._repr_mimebundle_()


def bet(question: str, replies: Mapping[str, str], right: str) -> Shown:
    """Ask the reader for a bet on the result that follows.

    Choosing an answer shows its reply, by HTML and CSS alone: no kernel and no script is needed. On
    paper the question and its answers stand in place, and the right answer with its reply at the
    end of the section.

    Parameters
    ----------
    question
        Plain text; may hold mathematics between dollars.
    replies
        What the reader is told, by answer: two to six answers, in the order in which they are
        shown. Both may hold mathematics.
    right
        The answer that is right, one of those in ``replies``.

    Raises
    ------
    ValueError
        If a text is empty, there are fewer than two answers or more than six, or the right one is
        none of them.

    Examples
    --------
    >>> bet("Is the sum even?", {"yes": "One is odd.", "no": "So is the other."}, "no")
    A bet. Is the sum even?
      A  yes
      B  no
    Replies
      A is wrong. One is odd.
      B is right. So is the other.
    """
    _worded("question", question)
    for answer, reply in replies.items():
        _worded("an answer in replies", answer)
        _worded(f"replies[{answer!r}]", reply)
    if not 2 <= len(replies) <= MOST_ANSWERS:
        raise ValueError(f"replies must hold 2 to {MOST_ANSWERS} answers, got {len(replies)}")
    if right not in replies:
        raise ValueError(f"right must be one of {', '.join(map(repr, replies))}, got {right!r}")
    return output(_html(question, replies, right), _text(question, replies, right), "bet.css")


def _worded(name: str, text: str) -> None:
    if not text.strip():
        raise ValueError(f"{name} must not be empty")


def _text(question: str, replies: Mapping[str, str], right: str) -> str:
    answers = [f"  {letter}  {answer}" for letter, answer in _lettered(replies)]
    told = [
        f"  {letter} is {_verdict(answer, right)}. {replies[answer]}"
        for letter, answer in _lettered(replies)
    ]
    return "\n".join([f"A bet. {question}", *answers, "Replies", *told])


def _html(question: str, replies: Mapping[str, str], right: str) -> str:
    name = f"bet-{sha256(repr((question, *replies)).encode()).hexdigest()[:12]}"
    asked = with_mathematics(question)
    answers = told = answered = ""
    for letter, answer in _lettered(replies):
        verdict, words = _verdict(answer, right), with_mathematics(answer)
        reply = with_mathematics(replies[answer])
        answers += (  # JupyterLab takes the arrow keys for itself unless an input says otherwise
            f'<input type="radio" name="{name}" id="{name}-{letter}" autocomplete="off"'
            f' data-lm-suppress-shortcuts="true"><label for="{name}-{letter}">'
            f'<b class="rp-letter">{letter}</b> {words}</label><br>'
        )
        told += (
            f'<p class="rp-reply rp-reply--{verdict}"><strong>{letter} is {verdict}.</strong> '
            f"{reply}</p>"
        )
        if answer == right:
            answered = f'<br><b class="rp-letter">{letter}</b> {words}<br>{reply}'
    html = (
        f'<div class="rp-bet"><fieldset><legend><strong>A bet.</strong> {asked}'
        f'</legend><div class="rp-answers">{answers}'
        f'<div class="rp-replies" role="status">{told}</div></div></fieldset></div>'
    )
    if on_page():  # the extension moves it to the end of the section
        html += (
            f'<p class="rp-bet-answer" data-waiting><strong>The bet.</strong> {asked}{answered}</p>'
        )
    return html


def _verdict(answer: str, right: str) -> str:
    return "right" if answer == right else "wrong"


def _lettered(replies: Mapping[str, str]) -> list[tuple[str, str]]:
    return list(zip(ascii_uppercase, replies, strict=False))
