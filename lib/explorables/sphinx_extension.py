"""A Sphinx extension: explorers, films, bets and numbered figures on the pages of a book.

It sets the environment variable by which kernels know that no reader sits behind them, gives pages
the front end, moves the states of explorers and films into files beside the page and the answers of
bets to the ends of their sections, and numbers figures and what refers to them. A Jupyter Book has
it by a line of its ``_config.yml``::

    sphinx:
      extra_extensions: [explorables.sphinx_extension]
"""

import base64
import json
import os
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.config import Config
from sphinx.environment import BuildEnvironment
from sphinx.util import logging

from explorables.figures.output import FRONT_END, PAGE_VARIABLE
from explorables.pages import NO_SCRIPTS, SCRIPTS, SHEETS, THEME

STORED = "_static/explorers"
UNNUMBERED = "the figure"
"""Text of a link to a figure in a notebook; on a page it is the number."""

_LOG = logging.getLogger(__name__)
_FIGURE = re.compile(
    r'<figure class="rp-figure[^"]*"(?: id="(?P<id>[^"]*)")?>(?P<inside>.*?)</figure>', re.S
)
_CAPTION = re.compile(r"<figcaption[^>]*>")
_WAITING = " data-waiting"
_ANSWER = re.compile(rf'<p class="rp-bet-answer[^>]*{_WAITING}>.*?</p>', re.S)
_SECTION = re.compile(r"<section\b|</section>")

SCRIPTED = ('class="explorer"', 'class="rp-film"')
_STATES = re.compile(
    r'<div class="(?P<kind>explorer|rp-film)" id="(?P<id>\w+-(?P<name>\w+))">(?P<inside>.*?)'
    r'<script type="application/json" class="rp-states">(?P<states>[^<]*)</script></div>',
    re.S,
)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension with Sphinx."""
    app.connect("config-inited", _configure)
    connect_figures(app)
    app.connect("html-page-context", _finish_page, priority=800)
    app.connect("build-finished", _drop_orphans)
    app.add_js_file(None, body=THEME, priority=100)
    for script in SCRIPTS:
        app.add_js_file(script)
    for sheet in SHEETS:
        app.add_css_file(sheet)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def connect_figures(app: Sphinx) -> None:
    """Have figures numbered: what `setup` does for them, for a book that wants nothing else."""
    app.connect("env-purge-doc", _forget_figures)
    app.connect("env-merge-info", _merge_figures)
    app.connect("doctree-read", _note_figures)
    app.connect("env-get-updated", _number_figures, priority=900)  # after the chapters
    app.connect("html-page-context", _write_numbers)


def _configure(app: Sphinx, config: Config) -> None:
    os.environ[PAGE_VARIABLE] = "1"
    config.html_static_path.append(str(FRONT_END))


def _figures(env: BuildEnvironment) -> dict[str, list[str]]:
    """The captioned figures of each page in their order: addresses, empty without a name."""
    if not hasattr(env, "book_figures"):
        env.book_figures, env.book_links, env.book_numbers = {}, {}, {}
    return env.book_figures


def _forget_figures(app: Sphinx, env: BuildEnvironment, page: str) -> None:
    _figures(env).pop(page, None)
    env.book_links.pop(page, None)


def _merge_figures(
    app: Sphinx, env: BuildEnvironment, pages: Iterable[str], other: BuildEnvironment
) -> None:
    known, read = _figures(env), _figures(other)
    for page in pages:
        known[page], env.book_links[page] = read[page], other.book_links[page]


def _note_figures(app: Sphinx, doctree: nodes.document) -> None:
    """Note which figures a page shows and which it refers to."""
    page = app.env.docname
    outputs = [node.astext() for node in doctree.findall(nodes.raw) if node["format"] == "html"]
    _figures(app.env)[page] = [
        match["id"] or ""
        for output in outputs
        for match in _FIGURE.finditer(output)
        if _CAPTION.search(match["inside"])
    ]
    links = [node for node in doctree.findall(pending_xref) if "reftarget" in node]
    links = [node for node in links if node["reftarget"].startswith("fig-")]
    app.env.book_links[page] = {node["reftarget"] for node in links}
    for node in links:
        if node.astext() == UNNUMBERED:
            node["refexplicit"] = False
            node.children = [nodes.inline()]


def _number_figures(app: Sphinx, env: BuildEnvironment) -> list[str]:
    """Number the figures of the book; return the pages that refer to a number that has changed."""
    names = env.get_domain("std")
    numbers: dict[str, tuple[str, str]] = {}
    for page, figures in sorted(_figures(env).items()):
        for figure, number in zip(figures, _numbers(env, page), strict=True):
            if figure in numbers:
                _LOG.warning("figure %s stands twice: %s", figure, numbers[figure], location=page)
            if figure:
                numbers[figure] = page, number
                names.anonlabels[figure] = page, figure
                names.labels[figure] = page, figure, number
    changed = {name for name, place in numbers.items() if env.book_numbers.get(name) != place}
    changed |= env.book_numbers.keys() - numbers.keys()
    env.book_numbers = numbers
    return [page for page, links in env.book_links.items() if links & changed]


def _numbers(env: BuildEnvironment, page: str) -> list[str]:
    chapter = env.toc_secnumbers.get(page, {}).get("", ())
    count = len(_figures(env).get(page, ()))
    return [f"Fig. {'.'.join(map(str, (*chapter, k)))}" for k in range(1, count + 1)]


def _write_numbers(
    app: Sphinx, pagename: str, templatename: str, context: dict[str, Any], doctree: object
) -> None:
    """Write into each caption the number of its figure."""
    numbers = iter(_numbers(app.env, pagename))

    def write(match: re.Match[str]) -> str:
        return _CAPTION.sub(
            lambda caption: f'{caption[0]}<span class="rp-number">{next(numbers)}</span> ', match[0]
        )

    if context.get("body"):
        context["body"] = _FIGURE.sub(write, context["body"])


def _finish_page(
    app: Sphinx, pagename: str, templatename: str, context: dict[str, Any], doctree: object
) -> None:
    context["default_mode"] = "auto"  # of the theme that Jupyter Book has
    if not context.get("body"):
        return
    body = _answers_last(context["body"])
    if any(word in body for word in SCRIPTED):
        body = NO_SCRIPTS + body

    def store(match: re.Match[str]) -> str:
        kind, identifier, name = match["kind"], match["id"], match["name"]
        _store(Path(app.outdir) / STORED, identifier, name, json.loads(match["states"]))
        place = context["pathto"](f"{STORED}/{name}.js", 1)
        opening = f'<div class="{kind}" id="{identifier}" data-states="{place}">'
        return f"{opening}{match['inside']}</div>"

    context["body"] = _STATES.sub(store, body)


def _answers_last(body: str) -> str:
    """Move the answer of each bet, which only paper shows, to the end of its section."""
    while waiting := _ANSWER.search(body):
        start, end = waiting.span()
        deep = 0
        for edge in _SECTION.finditer(body, end):
            deep += -1 if edge[0].startswith("</") else 1
            if deep < 0:
                break
        answer = waiting[0].replace(_WAITING, "", 1)
        last = edge.start() if deep < 0 else end
        body = body[:start] + body[end:last] + answer + body[last:]
    return body


def _store(folder: Path, identifier: str, name: str, states: str | list[list[Any]]) -> None:
    """Write the states of an explorer or a film as a classic script, pictures as files."""
    folder.mkdir(parents=True, exist_ok=True)
    if isinstance(states, list):
        for number, state in enumerate(states):
            data, state[0] = base64.b64decode(state[0]), f"{name}-{number}.webp"
            _write(folder / state[0], data)
    script = f'explorables.register("{identifier}", {json.dumps(states)});\n'
    _write(folder / f"{name}.js", script.encode())


def _write(file: Path, data: bytes) -> None:
    """Write a file at once: another process may write the same."""
    beside = file.with_name(f".{file.name}.{os.getpid()}")
    beside.write_bytes(data)
    os.replace(beside, file)


def _drop_orphans(app: Sphinx, exception: Exception | None) -> None:
    """Remove states of explorers and films that no page shows any more."""
    stored = Path(app.outdir) / STORED
    if exception is not None or not stored.is_dir():
        return
    pages = (page.read_text("utf-8") for page in Path(app.outdir).glob("*.html"))
    shown = {name for page in pages for name in re.findall(r"explorers/(\w+)\.js", page)}
    for path in stored.iterdir():
        if re.split(r"[-.]", path.name)[0] not in shown:
            path.unlink()
