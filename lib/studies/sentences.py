"""A result as a sentence: quantity, value, interval, limit, verdict.

One function says it, on pages, in tables and on cards: "74 % [58, 85] of the faces are held while
they are covered; at least 50 % wanted: reproduced."
"""

import math
from enum import StrEnum

from studies.intervals import Interval
from studies.numbers import typeset
from studies.verdicts import Accepted

VALUE = "{value}"
"""Stands for the number in the words of a quantity."""
EXACT = 3
"""Significant digits of a number without an interval."""
MOST_DECIMALS, SMALL = 4, 1e-3
"""Decimals of a number at most; below that size it is written with a power of ten."""
WIDE = 20
"""An interval that reaches far to one side leaves the digits of this part of its width."""


class Form(StrEnum):
    """Form in which a quantity is written.

    ``share``: in per cent; ``points``: a difference of shares, in points; ``times``: a ratio;
    ``number``: as it is, with its unit.
    """

    SHARE = "share"
    POINTS = "points"
    TIMES = "times"
    NUMBER = "number"


FACTOR = {Form.SHARE: 100.0, Form.POINTS: 100.0}
UNIT = {Form.SHARE: "%", Form.POINTS: "points", Form.TIMES: "times"}
ENDS = {
    Form.SHARE: (0.0, 100.0),
    Form.POINTS: (-100.0, 100.0),
    Form.TIMES: (0.0, math.inf),
    Form.NUMBER: (-math.inf, math.inf),
}
"""Bounds that no value of a form can pass, as it is written."""


def with_interval(value: Interval, form: Form | str) -> str:
    """Return a value with its interval and unit, to the digits that the interval leaves."""
    form = Form(form)
    factor, unit = FACTOR.get(form, 1.0), UNIT.get(form, value.unit)
    low, middle, high = (factor * end for end in (value.low, value.estimate, value.high))
    if low == high:
        return _with_unit(_exact(middle), unit)
    near = min(part for part in (middle - low, high - middle) if part > 0)
    decimals = 1 - math.floor(math.log10(max(2 * near, (high - low) / WIDE)))
    written = [_number(end, decimals) for end in (low, middle, high)]
    return f"{_with_unit(written[1], unit)} [{written[0]}, {written[2]}]"


def wanted(accepted: Accepted, form: Form | str, value: Interval) -> str:
    """Return in words what a value must be for the statement to hold.

    An end that such a value cannot pass is no limit: zero is none where nothing measured is below.
    """
    form = Form(form)
    factor, unit = FACTOR.get(form, 1.0), UNIT.get(form, value.unit)
    least, most = ENDS[Form.POINTS if unit == UNIT[Form.POINTS] else form]
    low, high = factor * accepted.low, factor * accepted.high
    written = _exact(low), _exact(high)
    if low == high:
        word, limit = "exactly", high
    elif low <= least:
        word, limit = "at most", high
    elif high >= most:
        word, limit = "at least", low
    elif low == 0 and value.low >= 0 and form is Form.NUMBER:
        word, limit = "at most", high
    elif written[0] == written[1]:
        word, limit = "exactly", high
    else:
        return _with_unit(" to ".join(written), "" if " " in unit else unit)
    if form is Form.TIMES and math.isclose(limit, 1, rel_tol=1e-6):
        return "the same" if word == "exactly" else f"{word} the same"
    return _with_unit(f"{word} {_exact(limit)}", "" if " " in unit else unit)


def sentence(
    says: str,
    form: Form | str,
    value: Interval,
    accepted: Accepted | None,
    verdict: str = "",
) -> str:
    """Return a result as a sentence.

    Parameters
    ----------
    says
        Words of the quantity, with `VALUE` where the number stands.
    form
        How it is written.
    value
        What was measured.
    accepted
        The range in which the statement holds, if there is one.
    verdict
        What follows; left out where it stands beside.
    """
    text = says.replace(VALUE, with_interval(value, form))
    limit = "" if accepted is None else f"; {wanted(accepted, form, value)} wanted"
    return f"{text[:1].upper()}{text[1:]}{limit}{verdict and f': {verdict}'}."


def _exact(value: float) -> str:
    """Write a number without an interval; what is nearly a hundred does not look like it."""
    nearly = value != 100 and f"{value:.{EXACT}g}" == "100"
    return typeset(f"{value:.{EXACT + 2 * nearly}g}")


def _number(value: float, decimals: int) -> str:
    if decimals > MOST_DECIMALS and 0 < abs(value) < SMALL:
        return typeset(f"{value:.{EXACT - 1}e}")
    return typeset(f"{value:.{min(max(decimals, 0), MOST_DECIMALS)}f}")


def _with_unit(text: str, unit: str) -> str:
    return f"{text}\N{NO-BREAK SPACE}{unit}" if unit else text
