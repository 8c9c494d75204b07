"""Built pages as trees, without what makes them large: data of scripts, and drawings."""

import re

from bs4 import BeautifulSoup

LARGE = re.compile(r"(<(script|svg)\b[^>]*>).*?(</\2>)", re.DOTALL)
"""Scripts hold the states of explorers, drawings thousands of paths; neither is prose."""
LISTING = re.compile(r"<pre\b.*?</pre>", re.DOTALL)
COLOURED = re.compile(r"</?span\b[^>]*>")


def parsed(html: str) -> BeautifulSoup:
    """Return a page with empty scripts and drawings, and code in one colour: read in a tenth."""
    plain = LISTING.sub(lambda found: COLOURED.sub("", found[0]), LARGE.sub(r"\1\3", html))
    return BeautifulSoup(plain, "html.parser")
