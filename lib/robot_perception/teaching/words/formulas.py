"""Formulas of the built pages, for readers whose browser runs no scripts.

MathJax sets LaTeX when a page is read. Beside the LaTeX stands MathML, which browsers set without
scripts; a style sheet hides the LaTeX until a script says that scripts run.
"""

import re
from html import unescape

from latex2mathml.converter import convert

_FORMULA = re.compile(
    r'(?P<opening><(?P<kind>span|div) class="[^"]*\bmath\b[^>]*>)(?P<tex>[^<]+)</(?P=kind)>'
)
_DELIMITERS = re.compile(r"^\s*\\[(\[]|\\[)\]]\s*$")
_SPLIT = re.compile(r"\\(?:begin|end)\{split\}")


def with_mathml(html: str) -> str:
    """Return a page with MathML beside each formula."""
    return _FORMULA.sub(_both, html)


def _both(match: re.Match[str]) -> str:
    opening, kind, tex = match["opening"], match["kind"], match["tex"]
    bare = _DELIMITERS.sub("", unescape(tex))
    if r"\begin{aligned}" in bare:  # unknown to the converter; and Sphinx puts a split round it
        bare = _SPLIT.sub("", bare).replace("{aligned}", "{split}")
    mathml = convert(bare, display="block" if kind == "div" else "inline")
    return f'{opening}<span class="rp-tex">{tex}</span><noscript>{mathml}</noscript></{kind}>'
