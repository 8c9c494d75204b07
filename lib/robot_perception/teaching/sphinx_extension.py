"""The book's own Sphinx extension, beside that of explorers: results that expire, mended theme.

It keeps the results of a page only as long as all they depend on is the same, copies MathJax from
its package into the site, says ranges beside types, marks the first use of a word
(:mod:`.sphinx_terms`), writes pages of source code, lets pages link to what outputs name, puts
MathML beside formulas, and drops every script that would ask another host for something. Explorers,
films, bets and figures come to the pages by :mod:`explorables.sphinx_extension`, which it brings.
"""

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
from sphinx.application import Sphinx
from sphinx.config import Config
from sphinx.environment import BuildEnvironment
from sphinx.transforms.post_transforms import SphinxPostTransform

from explorables.pages import NO_SCRIPTS
from robot_perception.project import ROOT
from robot_perception.teaching import FRONT_END
from robot_perception.teaching.pages import source_pages
from robot_perception.teaching.pages.signatures import with_ranges
from robot_perception.teaching.words.formulas import with_mathml
from robot_perception.teaching.words.sphinx_terms import connect_terms
from studies.files import written
from studies.keys.cells import study_cells
from studies.keys.dependencies import Dependencies, code, hashed
from studies.pages.execution import execute
from studies.sweep import WORKERS

COMPARED = '<span class="c1"># NBVAL_CHECK_OUTPUT</span>\n'  # a word to the tests, not to readers
SHEETS = ("badge.css", "check.css", "listing.css")
SCRIPTED = 'class="rp-scorecard"'
MATHJAX = ("tex-mml-chtml.js", "output/chtml/fonts/woff-v2", "input/tex/extensions")

UNWANTED = {"sphinx_thebe": None, "sphinx.ext.viewcode": "html-collect-pages"}
"""Listeners that cannot be configured away, by module: to one event, or to all."""

_MENUS: WeakKeyDictionary[Sphinx, dict[tuple, str]] = WeakKeyDictionary()
_MATHEMATICS = re.compile(r"\$([^$]+)\$")
_NAMED = re.compile(r'<(?:a|article)\b[^>]*\sid="([^"]+)"')
_BADGE = re.compile(r'(<a\b[^>]*) id="(claim-[^"]+)"')


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the extension with Sphinx."""
    app.setup_extension("explorables.sphinx_extension")
    app.add_config_value("book_contents", "", "env")  # a change of it renews every page's menu
    app.connect("config-inited", _configure)
    app.connect("builder-inited", _drop_listeners)
    app.connect("builder-inited", _copy_mathjax)
    app.connect("env-get-outdated", _expire)
    app.connect("autodoc-before-process-signature", with_ranges)
    app.connect("env-before-read-docs", _execute)
    app.connect("source-read", _choose_cache)
    connect_terms(app)
    app.connect("env-check-consistency", _name_references)
    app.connect("doctree-read", _note_outputs)
    app.connect("html-collect-pages", _source_pages)
    app.connect("html-page-context", _share_menu, priority=400)  # before the theme asks for it
    app.connect("html-page-context", _finish_page, priority=900)
    app.add_post_transform(SetMathematics)
    for sheet in SHEETS:
        app.add_css_file(sheet)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def _configure(app: Sphinx, config: Config) -> None:
    contents = Path(app.srcdir, "_toc.yml")
    config.book_contents = contents.read_text(encoding="utf-8") if contents.exists() else ""
    config.html_static_path.append(str(FRONT_END))
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
    body = with_mathml(_first_only(body.replace(COMPARED, "")))
    if SCRIPTED in body and NO_SCRIPTS not in body:
        body = NO_SCRIPTS + body
    context["body"] = body


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


def _first_only(body: str) -> str:
    """Drop the name of every badge of a claim but the first: a page names a thing once."""
    seen: set[str] = set()

    def keep(match: re.Match[str]) -> str:
        again = match[2] in seen
        seen.add(match[2])
        return match[1] if again else match[0]

    return _BADGE.sub(keep, body)


def _store_source(folder: Path, source: Path, context: dict[str, Any]) -> None:
    """Write the source of a page as a script too, by which it is saved without a server."""
    script = folder / f"{context['sourcename']}.js"
    script.parent.mkdir(parents=True, exist_ok=True)
    name, text = json.dumps(source.name), json.dumps(source.read_text("utf-8"))
    with written(script) as beside:
        beside.write_text(f"robotPerceptionSave({name}, {text});\n", "utf-8")


def _local(scripts: Iterable[Any]) -> Iterable[Any]:
    """Yield the scripts that need neither another host nor a kernel."""
    for script in scripts:
        name, kind = str(script.filename or ""), script.attributes.get("type", "")
        body = script.attributes.get("body", "")
        foreign = "://" in name or "thebe" in name or "thebe" in body
        if not (foreign or "widget-state" in kind):
            yield script
