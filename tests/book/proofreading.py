"""What a proof-reader looks for: each function returns what is wrong with a text."""

import re
from collections.abc import Collection, Iterable
from html import unescape

import nbformat

PLACEHOLDER = re.compile(r"\b(?:X{2,}|TODO|FIXME|TBD|[Ll]orem)\b|\?{2,}")
_ITEM = re.compile(r"^(\d+)\. ", re.MULTILINE)
_FENCED = re.compile(r"^(`{3,})(?!\{(?:admonition|dropdown|note)).*?^\1", re.MULTILINE | re.DOTALL)
_FORMULA = re.compile(r"\\begin\{(\w+\*?)\}.*?\\end\{\1\}|\$[^$]+\$", re.DOTALL)
_CODE = re.compile(r"`[^`]+`")
_NO_NUMBER = re.compile(r"(?<![\w.])[-−+]?(?:nan|NaN|inf)(?![\w.]*\w)")
_HOLE = re.compile(
    r"(?<=[a-z\d,;:(] )None\b|\{[a-z_]\w*(?:[.\[][^{}]*)?(?::[^{}]*)?\}|" + _NO_NUMBER.pattern
)
"""None begins a sentence of its own as a word, and stands within another one as a mistake."""


def without_code(text: str) -> str:
    """Return Markdown without formulas, fenced code and code within lines."""
    return _CODE.sub("", _FORMULA.sub("", _FENCED.sub("", text)))


def placeholders(text: str) -> list[str]:
    """Return what stands for a text that is still to be written."""
    return PLACEHOLDER.findall(without_code(text))


def numberless(text: str) -> list[str]:
    """Return what stands for a number and is none."""
    return _NO_NUMBER.findall(text)


def holes(text: str) -> list[str]:
    """Return numbers that are none, and names in braces whose place no number has taken."""
    return _HOLE.findall(text)


def broken_lists(text: str) -> list[str]:
    """Return the numbers of each list that do not run from one."""
    found: list[list[int]] = []
    for block in re.split(r"\n(?=#|:::)|\n\n(?!\d+\. | )", without_code(text)):
        numbers = [int(number) for number in _ITEM.findall(block)]
        found += [numbers] if numbers and numbers != [*range(1, len(numbers) + 1)] else []
    return [", ".join(map(str, numbers)) for numbers in found]


UNITS = (
    *("one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven"),
    *("twelve", "thirteen", "fourteen", "fifteen", "sixteen", "seventeen", "eighteen", "nineteen"),
)
NUMBERS = {name: k for k, name in enumerate(UNITS, 1)} | {
    name: 10 * k
    for k, name in enumerate(
        ("twenty", "thirty", "forty", "fifty", "sixty", "seventy", "eighty", "ninety"), 2
    )
}
ORDINALS = ("first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth")
_NAMES = "|".join(sorted(NUMBERS, key=len, reverse=True))
_SPELT = (
    rf"(?:a|{_NAMES}) (?:hundred|thousand)(?: and (?:{_NAMES}))?|(?:{_NAMES})(?:-(?:{_NAMES}))?"
)
_COUNTED = (
    "films? people persons? pictures? pairs? drives? sessions? buildings? walks? visits? scenes? "
    "galleries runs? seeds? faces photographs? ceilings? worlds? draws trials rooms? halls?"
).replace(" ", "|")
_COUNT = re.compile(
    rf"\b({_SPELT}|\d[\d\u202f]*) (?:(?!of|in|and|or|the)[a-z]+ )?(?:{_COUNTED})\b", re.IGNORECASE
)


def spelt(words: str) -> int:
    """Return the number that words spell, or digits."""
    if words[0].isdigit():
        return int(re.sub(r"\D", "", words))
    total = 0
    for word in re.split(r"[ -]", words.lower()):
        if word in ("hundred", "thousand"):
            total = max(total, 1) * (100 if word == "hundred" else 1000)
        else:
            total += NUMBERS.get(word, 0)
    return total


def numbers_in(text: str) -> set[int]:
    """Return the whole numbers of a text, in digits or words."""
    words = re.findall(rf"\b(?:{_SPELT})\b", text, re.IGNORECASE)
    return {spelt(number) for number in (*words, *re.findall(r"(?<![\d.])\d+\b", text))}


def uncounted(text: str, known: Collection[int], least: int = 5) -> list[str]:
    """Return counts of films, people, … that are none of those known."""
    text = " ".join(without_code(text).split())
    return [m[0] for m in _COUNT.finditer(text) if spelt(m[1]) not in known | set(range(least))]


_WHOLE = "three|four|five|ten thousand|ten|twenty|thirty|forty|fifty|a hundred|a thousand"
_SHARE = re.compile(
    rf"\b({_NAMES}) (?:[a-z]+ )?in ({_WHOLE})\b|"
    rf"\b({_NAMES}) [a-z]+ of ({_WHOLE})\b(?! [a-z]+s\b)",
    re.IGNORECASE,
)


def shares(text: str) -> dict[str, tuple[int, int]]:
    """Return the shares that are typed in words, as four in ten, with their two numbers."""
    text = " ".join(without_code(text).split())
    found = {m[0]: (m[1] or m[3], m[2] or m[4]) for m in _SHARE.finditer(text)}
    numbers = {words: (spelt(part), spelt(whole)) for words, (part, whole) in found.items()}
    return {words: (part, whole) for words, (part, whole) in numbers.items() if part < whole}


def is_rounded(share: tuple[int, int], value: float) -> bool:
    """Tell whether no other number of so many is nearer to a value, as four in ten to 0.38."""
    return abs(share[0] / share[1] - value) <= 0.5 / share[1]


_REFERENCE = re.compile(
    rf"\b(?:((?:{'|'.join(ORDINALS)}) (?:claim|statement))|(?:claim|statement|no\.) (\d+))\b",
    re.IGNORECASE,
)


def statements(text: str) -> int | None:
    """Return how many statements of the paper a section lists, or nothing if it is another."""
    head = r"^## What the papers? says?$(.*?)(?=^## |\Z)"
    found = re.search(head, text, re.MULTILINE | re.DOTALL)
    return len(_ITEM.findall(found[1])) if found else None


def misnumbered(text: str, listed: int) -> list[str]:
    """Return references to statements of the paper that do not say one of the numbers listed.

    A first claim may be the first of the list or the first that the text comes to; claim 1 cannot.
    """
    text = " ".join(without_code(text).split())
    return [m[0] for m in _REFERENCE.finditer(text) if m[1] or not 1 <= int(m[2]) <= listed]


def theme_colours(text: str) -> list[str]:
    """Return the colours of a text that are others in the dark: ink and ground."""
    return re.findall(r"(?<!\{)\b(?:black|white)\b", text, re.IGNORECASE)


PROMPT = "Show the code"


def unnamed_folds(notebook: nbformat.NotebookNode) -> list[str]:
    """Return the cells whose output is folded without a word that says what it holds."""
    return [
        cell.id
        for cell in notebook.cells
        if {"hide-output", "hide-cell"} & set(cell.metadata.get("tags", ()))
        and "show_source(" not in cell.source
        and not _is_named(cell.metadata)
    ]


def _is_named(metadata: nbformat.NotebookNode) -> bool:
    named = metadata.get("mystnb", {}).get("code_prompt_show", PROMPT)
    return named != PROMPT and "remove-input" in metadata.tags


_FOLD = re.compile(r"<details class=\"[^\"]*\bhide\b.*?</details>", re.DOTALL)
_RESULT = re.compile(r"<(?:table|figure)\b|class=\"(?:explorer|rp-figure|rp-film)\b")


def mislabelled_folds(html: str) -> list[str]:
    """Return how the folds of a page begin that say "Show the code" and hold a result."""
    wrong = [fold for fold in _FOLD.findall(html) if PROMPT in fold and _RESULT.search(fold)]
    return [" ".join(visible(fold).split()[:12]) for fold in wrong]


_UNREAD = re.compile(r"<(script|style|svg|pre|code|template|math)\b.*?</\1>|<!--.*?-->", re.DOTALL)
_SET = re.compile(r"\\\[.*?\\\]|\\\(.*?\\\)", re.DOTALL)
_INLINE = re.compile(r"</?(?:a|b|i|em|strong|small|span|sub|sup)\b[^>]*>")


def visible(html: str) -> str:
    """Return what a reader sees of a page, a line a block, but for code, formulas and drawings."""
    article = re.search(r"<article\b.*</article>", html, re.DOTALL)
    inside = _SET.sub(" ", _UNREAD.sub(" ", article[0] if article else html))
    blocks = map(unescape, re.split(r"<[^>]+>", _INLINE.sub("", inside)))
    return "\n".join(" ".join(block.split()) for block in blocks if block.strip())


def report(found: Iterable[tuple[object, Collection[str]]]) -> str:
    """Return a line for each place where something is wrong."""
    return "\n".join(f"{place}: {', '.join(map(repr, wrong))}" for place, wrong in found if wrong)
