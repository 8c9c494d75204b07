"""What the book quotes from the papers, word for word.

The papers are not part of this repository. Where they are there every quotation is looked up in
them; elsewhere its digest must stand in the list beside this file, which ``python -m
tests.book.quotations`` writes from them.
"""

import re
from collections.abc import Iterator, Mapping
from functools import cache
from hashlib import sha256
from pathlib import Path
from types import MappingProxyType

from robot_perception.teaching.scores.papers import PAPERS
from tests.book.pages import Passage, claims, papers, prose, words

LIST = Path(__file__).with_name("quotations.tsv")
_QUOTED = re.compile(r"“([^”]+)”|\"([^\"]+)\"")
_FENCED = re.compile(r"^(`{3,}).*?^\1|`[^`]+`|<a id=\"[\w-]+\">", re.MULTILINE | re.DOTALL)
_FORMULA = re.compile(r"\$.*\$")
_LEFT_OUT = re.compile(r"…|\.\.\.|\[[^\]]*\]")
_CAPTION = re.compile(r"\n\n(?:Fig|FIG|Tab|TAB)[^\n]+(?=\n\n)")

OTHERS = MappingProxyType(
    {
        "Our robot starts at its dock, always with the same heading. So the start is known "
        "exactly, and your third direction is no problem.": "a colleague in an exercise",
        "Our system recognises 98 % of the enrolled people.": "a vendor in an exercise",
        "so that the filter listens again": "a student in an exercise",
        "Break it": "a heading of the chapter",
        "lost from the start": "a preset of an explorer",
        "good wheels": "a preset of an explorer",
        "twenty landmarks, start known": "a preset of an explorer",
        "inside ±3σ": "a key of a table",
        "no change": "a name of ours",
        "a cell that is not empty": "our words for the paper's rule",
        "somewhere": "our word for a range that is not known",
        "Fewer particles for good results": "a claim's statement, in our words",
        "no return": "a reader's scanner",
    }
)
"""What stands between quotation marks and is said by nobody in a paper."""


def quotations(text: str) -> list[str]:
    """Return what stands between quotation marks in a text."""
    blocks = re.split(r"\n\s*\n", _FENCED.sub("", text))
    found = [a or b for block in blocks for a, b in _QUOTED.findall(" ".join(block.split()))]
    return [quotation for quotation in found if not _FORMULA.fullmatch(quotation)]


def squashed(text: str) -> str:
    """Return the letters and digits of a text: layout, emphasis and hyphens are not quoted."""
    return re.sub(r"[\W_]+", "", text.lower())


def parts(quotation: str) -> list[str]:
    """Return the parts of a quotation between what it leaves out, squashed."""
    return [part for part in map(squashed, _LEFT_OUT.split(quotation)) if part]


def digest(quotation: str) -> str:
    """Return what a quotation is known by where the papers are not there."""
    return sha256("…".join(parts(quotation)).encode()).hexdigest()[:16]


def readings(paper: str) -> tuple[str, str]:
    """Return a paper as it runs, and without the captions that break its sentences, squashed."""
    return squashed(paper), squashed(_CAPTION.sub("", paper))


def is_quoted(quotation: str, paper: tuple[str, str]) -> bool:
    """Tell whether the readings of a paper say what a quotation says, in its order."""
    pattern = re.compile(".*?".join(map(re.escape, parts(quotation))))
    return any(pattern.search(reading) for reading in paper)


@cache
def texts() -> Mapping[str, tuple[str, str]]:
    """Return the readings of the papers that are there by their keys in claims."""
    found = [readings(text) for text in papers().values()]
    return {
        key: reading
        for key, paper in PAPERS.items()
        for reading in found
        if squashed(paper.title) in reading[0]
    }


@cache
def speaks_of() -> Mapping[str, frozenset[str]]:
    """Return the papers that a chapter's claims are about, by chapter."""
    found: dict[str, frozenset[str]] = {}
    for claim in claims():
        found[claim["chapter"]] = found.get(claim["chapter"], frozenset()) | {claim["paper"]}
    return found


def quoted() -> Iterator[tuple[Passage, str, frozenset[str]]]:
    """Yield each quotation from a paper, where it stands, and the papers that it may be from."""
    for passage in (*prose(), *words()):
        for quotation in quotations(passage.text):
            if quotation not in OTHERS:
                yield passage, quotation, speaks_of().get(passage.page, frozenset(PAPERS))


@cache
def listed() -> Mapping[str, frozenset[str]]:
    """Return the digests in the list, by paper."""
    rows = [line.split("\t") for line in LIST.read_text("utf-8").splitlines()[1:]]
    return {key: frozenset(row[0] for row in rows if row[1] == key) for key in PAPERS}


def lines() -> list[str]:
    """Return the list as the papers have it: digest, paper, and how the quotation begins."""
    rows = {
        (key, " ".join(quotation.split()[:5]), digest(quotation))
        for _, quotation, keys in quoted()
        for key in keys
        if is_quoted(quotation, texts()[key])
    }
    return ["digest\tpaper\tbegins", *(f"{d}\t{key}\t{start}" for key, start, d in sorted(rows))]


if __name__ == "__main__":
    LIST.write_text("\n".join(lines()) + "\n", encoding="utf-8")
