"""The book's own Sphinx extension: explorers on pages, no other host, mended theme.

It sets the environment variable by which kernels know that no reader sits behind them, keeps the
results of a page only as long as all they depend on is the same, copies MathJax from its
package into the site, moves the states of explorers and films into files beside the page and the
answers of bets to the ends of their sections, numbers figures and what refers to them, marks the
first use of a word (:mod:`.sphinx_terms`), writes pages of source code, lets pages link to what
outputs name, puts MathML beside formulas, and drops every script that would ask another host for
something.
"""

import base64
import json
import os
import re
import shutil
from collections.abc import Callable, Iterable
from importlib.resources import files
from pathlib import Path
from typing import Any
from weakref import WeakKeyDictionary

from docutils import nodes
from joblib import effective_n_jobs
from jupyter_client import KernelManager
from myst_nb.core.config import NbParserConfig
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.config import Config
from sphinx.environment import BuildEnvironment
from sphinx.transforms.post_transforms import SphinxPostTransform
from sphinx.util import logging

from studies.sweep import WORKERS
from studies.files import written
from robot_perception.teaching.pages import source_pages
from studies.keys.cells import study_cells
from studies.keys.dependencies import ROOT, Dependencies, code, hashed
from studies.pages.execution import execute
from explorables.figures.output import PAGE_VARIABLE
from robot_perception.teaching.words.formulas import with_mathml
from robot_perception.teaching.words.sphinx_terms import connect_terms

STORED = "_static/explorers"
COMPARED = '<span class="c1"># NBVAL_CHECK_OUTPUT</span>\n'  # a word to the tests, not to readers
UNNUMBERED = "the figure"
"""What a link to a figure says in a notebook; on a page it is the number."""

SHEETS = tuple(
    f"{name}.css"
    for name in ("figure", "explorer", "film", "badge", "bet", "check", "listing", "table")
)
MATHJAX = ("tex-mml-chtml.js", "output/chtml/fonts/woff-v2", "input/tex/extensions")

_LOG = logging.getLogger(__name__)
_FIGURE = re.compile(
    r'<figure class="rp-figure[^"]*"(?: id="(?P<id>[^"]*)")?>(?P<inside>.*?)</figure>', re.S
)
_CAPTION = re.compile(r"<figcaption[^>]*>")
_WAITING = " data-waiting"
_ANSWER = re.compile(rf'<p class="rp-bet-answer[^>]*{_WAITING}>.*?</p>', re.S)
_SECTION = re.compile(r"<section\b|</section>")
UNWANTED = {"sphinx_thebe": None, "sphinx.ext.viewcode": "html-collect-pages"}
"""Listeners that cannot be configured away, by module: to one event, or to all."""

NO_SCRIPTS = (
    '<p class="rp-note rp-unscripted">Your browser runs no scripts. Everything can be read, but '
    "controls need scripts: each figure shows its first state.</p>"
)
SCRIPTED = ('class="explorer"', 'class="rp-film"', 'class="rp-scorecard"')

_MENUS: WeakKeyDictionary[Sphinx, dict[tuple, str]] = WeakKeyDictionary()
_MATHEMATICS = re.compile(r"\$([^$]+)\$")
_NAMED = re.compile(r'<(?:a|article)\b[^>]*\sid="([^"]+)"')
_BADGE = re.compile(r'(<a\b[^>]*) id="(claim-[^"]+)"')
_STATES = re.compile(
    r'<div class="(?P<kind>explorer|rp-film)" id="(?P<id>\w+-(?P<name>\w+))">(?P<inside>.*?)'
    r'<script type="application/json" class="rp-states">(?P<states>[^<]*)</script></div>',
    re.S,
)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension with Sphinx."""
    app.add_config_value("book_contents", "", "env")  # a change of it renews every page's menu
    app.connect("config-inited", _configure)
    app.connect("builder-inited", _drop_listeners)
    app.connect("builder-inited", _copy_mathjax)
    app.connect("env-get-outdated", _expire)
    app.connect("env-before-read-docs", _execute)
    app.connect("source-read", _choose_cache)
    connect_figures(app)
    connect_terms(app)
    app.connect("env-check-consistency", _name_references)
    app.connect("doctree-read", _note_outputs)
    app.connect("html-collect-pages", _source_pages)
    app.connect("html-page-context", _share_menu, priority=400)  # before the theme asks for it
    app.connect("html-page-context", _finish_page, priority=900)
    app.connect("build-finished", _drop_orphans)
    app.add_post_transform(SetMathematics)
    app.add_js_file(None, body=_theme_script(), priority=100)
    for script in ("explorer.js", "film.js"):
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
    contents = Path(app.srcdir, "_toc.yml")
    config.book_contents = contents.read_text(encoding="utf-8") if contents.exists() else ""
    config.html_static_path.append(str(files("robot_perception.teaching") / "front_end"))
    # Kernels offer encryption; unasked they warn on every page that their sockets go without.
    KernelManager.transport_encryption.default_value = "auto"


def _expire(
    app: Sphinx, env: BuildEnvironment, added: set[str], changed: set[str], removed: set[str]
) -> list[str]:
    """Drop the results that no longer follow from the code, and have their pages read again."""
    before, dependencies = getattr(env, "page_keys", {}), Dependencies(ROOT)
    keys = {name: dependencies.key(Path(env.doc2path(name))) for name in env.found_docs}
    first = env.config.root_doc
    if keys.get(first) is not None:  # it shows the order of the chapters
        keys[first] = hashed(keys[first] + env.config.book_contents)
    env.page_keys = {name: key for name, key in keys.items() if key is not None}
    kept = {_cache(app, name) for name in env.page_keys}
    for stale in set(_caches(app).glob("*")) - kept:
        shutil.rmtree(stale) if stale.is_dir() else stale.unlink()
    return [name for name, key in env.page_keys.items() if before.get(name) != key]


def _execute(app: Sphinx, env: BuildEnvironment, names: list[str]) -> None:
    """Execute the pages that will be read, those with most cells first: workers end together.

    The landing page shows what chapters compute, so it comes after them; what else has code, a
    ledger or a second recording, computes little and is left for the worker that it leaves free.
    """

    def place(name: str) -> tuple[int, int, str]:
        page = Path(env.doc2path(name))
        computes = page.suffix == ".ipynb" and bool(study_cells(page))
        rank = 1 if name == env.config.root_doc else 0 if computes else 2
        return rank, -len(code(page)), name

    pages = sorted(env.page_keys.keys() & set(names), key=place)
    if not pages:
        return
    workers = effective_n_jobs(int(os.environ.get(WORKERS, "1")))
    kernels = min(workers, len(pages))
    os.environ[WORKERS] = str(workers // kernels)  # for the sweeps within each of them
    files = [Path(env.doc2path(name)) for name in pages]
    configs = [_config(app, name) for name in pages]
    execute(zip(files, configs, strict=True), env.myst_config, kernels)


def _choose_cache(app: Sphinx, name: str, source: list[str]) -> None:
    if name in app.env.page_keys:
        app.env.mystnb_config = _config(app, name)


def _config(app: Sphinx, name: str) -> NbParserConfig:
    return app.env.mystnb_config.copy(execution_cache_path=str(_cache(app, name)))


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


def _caches(app: Sphinx) -> Path:
    return Path(app.outdir).parent / ".jupyter_cache"


def _cache(app: Sphinx, name: str) -> Path:
    """Return the folder of the results of a page: another one for every change below it."""
    return _caches(app) / f"{name.replace('/', '-')}-{app.env.page_keys[name]}"


def _name_references(app: Sphinx, env: BuildEnvironment) -> None:
    """Let `references.md#key` link to an entry of the bibliography, from notebooks as well."""
    for citation in env.get_domain("cite").citations:
        slugs = env.metadata[citation.bibliography_key.docname].setdefault("myst_slugs", {})
        slugs[citation.key] = (0, citation.citation_id, citation.key)


def _drop_listeners(app: Sphinx) -> None:
    """Disconnect live code, which names other hosts, and viewcode's pages, which ours replace."""
    for event, listeners in app.events.listeners.items():
        for listener in list(listeners):
            if UNWANTED.get(listener.handler.__module__, "") in (None, event):
                app.disconnect(listener.id)


def _source_pages(app: Sphinx) -> Iterable[tuple[str, dict[str, Any], str]]:
    def highlight(code: str) -> str:
        return app.builder.highlighter.highlight_block(code, "python")

    return source_pages.pages(ROOT, Path(app.outdir), highlight)


def _note_outputs(app: Sphinx, doctree: nodes.document) -> None:
    """Let `page.ipynb#name` link to what an output names, a claim for instance.

    A page has formulas, too, if its outputs have.
    """
    slugs = app.env.metadata[app.env.docname].setdefault("myst_slugs", {})
    for node in doctree.findall(nodes.raw):
        slugs.update((name, (0, name, name)) for name in _NAMED.findall(node.astext()))
        if 'class="math' in node.astext():
            app.env.get_domain("math").data["has_equations"][app.env.docname] = True


class SetMathematics(SphinxPostTransform):
    """Sets the mathematics between dollars in the titles of the bibliography."""

    default_priority = 6  # after that of sphinxcontrib-bibtex

    def run(self, **kwargs: object) -> None:
        """Replace `$…$` in each entry by a formula."""
        texts = [t for c in self.document.findall(nodes.citation) for t in c.findall(nodes.Text)]
        for text in texts:
            parts = _MATHEMATICS.split(text.astext())
            if len(parts) > 1:
                made = [nodes.math("", p) if n % 2 else nodes.Text(p) for n, p in enumerate(parts)]
                text.parent.replace(text, made)
                self.env.get_domain("math").data["has_equations"][self.env.docname] = True


def _copy_mathjax(app: Sphinx) -> None:
    if app.builder.format != "html":
        return
    source = Path(str(files("mathjax"))) / "static" / "mathjax" / "es5"
    for name in MATHJAX:
        target = Path(app.outdir) / "_static" / "mathjax" / name
        if target.exists():
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        (shutil.copytree if (source / name).is_dir() else shutil.copy)(source / name, target)


def _finish_page(
    app: Sphinx, pagename: str, templatename: str, context: dict[str, Any], doctree: object
) -> None:
    context["default_mode"] = "auto"
    context["script_files"] = list(_local(context["script_files"]))
    context["css_files"] = [css for css in context["css_files"] if "thebe" not in str(css.filename)]
    if menu := context.get("generate_toctree_html"):
        context["generate_toctree_html"] = _with_names(menu)
    if context.get("sourcename"):
        _store_source(Path(app.outdir) / "_sources", Path(app.env.doc2path(pagename)), context)
    if not context.get("body"):
        return
    body = context["body"].replace('<div role="list" class="citation', '<div class="citation')
    body = body.replace('<summary aria-label="Toggle hidden content">', "<summary>")
    body = with_mathml(_first_only(_answers_last(body.replace(COMPARED, ""))))
    if any(word in body for word in SCRIPTED):
        body = NO_SCRIPTS + body

    def store(match: re.Match[str]) -> str:
        kind, identifier, name = match["kind"], match["id"], match["name"]
        _store(Path(app.outdir) / STORED, identifier, name, json.loads(match["states"]))
        place = context["pathto"](f"{STORED}/{name}.js", 1)
        opening = f'<div class="{kind}" id="{identifier}" data-states="{place}">'
        return f"{opening}{match['inside']}</div>"

    context["body"] = _STATES.sub(store, body)


def _share_menu(
    app: Sphinx, pagename: str, templatename: str, context: dict[str, Any], doctree: object
) -> None:
    """Make the menu of pages that it does not name, those of source code, once for each folder."""
    if pagename in app.env.found_docs:
        return
    make, menus = context["toctree"], _MENUS.setdefault(app, {})

    def shared(**options: Any) -> str:
        key = pagename.count("/"), *sorted(options.items())
        if key not in menus:
            menus[key] = make(**options)
        return menus[key]

    context["toctree"] = shared


def _with_names(menu: Callable[..., Any]) -> Callable[..., Any]:
    """Let what unfolds in the menu say, to who hears it, what it unfolds."""

    def named(**options: Any) -> Any:
        tree = menu(**options)
        for entry in tree.select("li:has(> details)"):
            entry.select_one("details > summary")["aria-label"] = f"More on {entry.a.get_text()}"
        return tree

    return named


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


def _first_only(body: str) -> str:
    """Drop the name of every badge of a claim but the first: a page names a thing once."""
    seen: set[str] = set()

    def keep(match: re.Match[str]) -> str:
        again = match[2] in seen
        seen.add(match[2])
        return match[1] if again else match[0]

    return _BADGE.sub(keep, body)


def _store(folder: Path, identifier: str, name: str, states: str | list[list[Any]]) -> None:
    """Write the states of an explorer or a film as a classic script, pictures as files."""
    folder.mkdir(parents=True, exist_ok=True)
    if isinstance(states, list):
        for number, state in enumerate(states):
            data, state[0] = base64.b64decode(state[0]), f"{name}-{number}.webp"
            with written(folder / state[0]) as beside:
                beside.write_bytes(data)
    script = f'explorables.register("{identifier}", {json.dumps(states)});\n'
    with written(folder / f"{name}.js") as beside:
        beside.write_text(script, "utf-8")


def _store_source(folder: Path, source: Path, context: dict[str, Any]) -> None:
    """Write the source of a page as a script too, by which it is saved without a server."""
    script = folder / f"{context['sourcename']}.js"
    script.parent.mkdir(parents=True, exist_ok=True)
    name, text = json.dumps(source.name), json.dumps(source.read_text("utf-8"))
    with written(script) as beside:
        beside.write_text(f"robotPerceptionSave({name}, {text});\n", "utf-8")


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


def _local(scripts: Iterable[Any]) -> Iterable[Any]:
    """Yield the scripts that need neither another host nor a kernel."""
    for script in scripts:
        name, kind = str(script.filename or ""), script.attributes.get("type", "")
        body = script.attributes.get("body", "")
        foreign = "://" in name or "thebe" in name or "thebe" in body
        if not (foreign or "widget-state" in kind):
            yield script


def _theme_script() -> str:
    """Set the theme before the first paint; the theme's own script accepts only light and dark.

    A page whose scripts run says so, to its style sheet.
    """
    return (
        'document.documentElement.classList.add("rp-scripted");'
        "{const page = document.documentElement.dataset;"
        'if (page.theme !== "light" && page.theme !== "dark")'
        ' page.theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";}'
    )
