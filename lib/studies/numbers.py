"""Numbers as print writes them."""

import re

_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
_POWER = re.compile(r"e([+-]\d+)")


def typeset(number: str) -> str:
    """Write a number that Python has formatted as print does: −2, 2 × 10⁻¹⁵, 5 %, 10 000.

    There is no negative zero.
    """
    text = number if re.search("[1-9]", number) else number.replace("-", "")
    text = _POWER.sub(lambda m: f" × 10{str(int(m[1])).translate(_RAISED)}", text)
    text = text.replace(",", "\N{NARROW NO-BREAK SPACE}")
    return text.replace("-", "−").replace("%", "\N{NO-BREAK SPACE}%")
