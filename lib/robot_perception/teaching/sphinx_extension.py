"""The book's own Sphinx extension: explorers on pages, no other host, mended theme.

It sets the environment variable by which kernels know that no reader sits behind them, keeps the
results of a page only as long as all they depend on is the same, copies MathJax from its
package into the site, moves the states of explorers and films into files beside the page, writes
pages of source code, lets pages link to what outputs name, and drops every script that would ask
another host for something.
"""

import base64
import json
import os
import re
import shutil
from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path
from typing import Any

from docutils import nodes
from jupyter_client import KernelManager
from sphinx.application import Sphinx
from sphinx.config import Config
from sphinx.environment import BuildEnvironment
from sphinx.transforms.post_transforms import SphinxPostTransform

from robot_perception.teaching import source_pages
from robot_perception.teaching.dependencies import ROOT, Dependencies
from robot_perception.teaching.figures.output import PAGE_VARIABLE

STORED = "_static/explorers"
COMPARED = '<span class="c1"># NBVAL_CHECK_OUTPUT</span>\n'  # a word to the tests, not to readers
MATHJAX = ("tex-mml-chtml.js", "output/chtml/fonts/woff-v2", "input/tex/extensions")

UNWANTED = {"sphinx_thebe": None, "sphinx.ext.viewcode": "html-collect-pages"}
"""Listeners that cannot be configured away, by module: to one event, or to all."""

NO_SCRIPTS = (
    '<noscript><p class="rp-note">Your browser runs no scripts. Everything can be read, but '
    "formulas stand as LaTeX source, and controls need scripts: each figure shows its first state."
    "</p></noscript>"
)
SCRIPTED = ('class="math', 'class="explorer"', 'class="rp-film"', 'class="rp-scorecard"')

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
    app.connect("source-read", _choose_cache)
    app.connect("doctree-read", _name_outputs)
    app.connect("html-collect-pages", _source_pages)
    app.connect("html-page-context", _finish_page, priority=900)
    app.connect("build-finished", _drop_orphans)
    app.add_post_transform(SetMathematics)
    app.add_js_file(None, body=_theme_script(), priority=100)
    for script in ("explorer.js", "film.js"):
        app.add_js_file(script)
    for sheet in ("figure.css", "explorer.css", "film.css"):
        app.add_css_file(sheet)
    return {"parallel_read_safe": True, "parallel_write_safe": True}


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
    env.page_keys = {name: key for name, key in keys.items() if key is not None}
    kept = {_cache(app, name) for name in env.page_keys}
    for stale in set(_caches(app).glob("*")) - kept:
        shutil.rmtree(stale) if stale.is_dir() else stale.unlink()
    return [name for name, key in env.page_keys.items() if before.get(name) != key]


def _choose_cache(app: Sphinx, name: str, source: list[str]) -> None:
    if name in app.env.page_keys:
        path = str(_cache(app, name))
        app.env.mystnb_config = app.env.mystnb_config.copy(execution_cache_path=path)


def _caches(app: Sphinx) -> Path:
    return Path(app.outdir).parent / ".jupyter_cache"


def _cache(app: Sphinx, name: str) -> Path:
    """Return the folder of the results of a page: another one for every change below it."""
    return _caches(app) / f"{name.replace('/', '-')}-{app.env.page_keys[name]}"


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


def _name_outputs(app: Sphinx, doctree: nodes.document) -> None:
    """Let `page.ipynb#name` link to what an output names, a claim for instance."""
    slugs = app.env.metadata[app.env.docname].setdefault("myst_slugs", {})
    for node in doctree.findall(nodes.raw):
        slugs.update((name, (0, name, name)) for name in _NAMED.findall(node.astext()))


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
    if context.get("sourcename"):
        _store_source(Path(app.outdir) / "_sources", Path(app.env.doc2path(pagename)), context)
    if not context.get("body"):
        return
    body = context["body"].replace('<div role="list" class="citation', '<div class="citation')
    body = body.replace('<summary aria-label="Toggle hidden content">', "<summary>")
    body = _first_only(body.replace(COMPARED, ""))
    if any(word in body for word in SCRIPTED):
        body = NO_SCRIPTS + body

    def store(match: re.Match[str]) -> str:
        kind, identifier, name = match["kind"], match["id"], match["name"]
        _store(Path(app.outdir) / STORED, identifier, name, json.loads(match["states"]))
        place = context["pathto"](f"{STORED}/{name}.js", 1)
        opening = f'<div class="{kind}" id="{identifier}" data-states="{place}">'
        return f"{opening}{match['inside']}</div>"

    context["body"] = _STATES.sub(store, body)


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
            (folder / state[0]).write_bytes(data)
    script = f'robotPerception.register("{identifier}", {json.dumps(states)});\n'
    (folder / f"{name}.js").write_text(script, "utf-8")


def _store_source(folder: Path, source: Path, context: dict[str, Any]) -> None:
    """Write the source of a page as a script too, by which it is saved without a server."""
    script = folder / f"{context['sourcename']}.js"
    script.parent.mkdir(parents=True, exist_ok=True)
    name, text = json.dumps(source.name), json.dumps(source.read_text("utf-8"))
    script.write_text(f"robotPerceptionSave({name}, {text});\n", "utf-8")


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
    """Set the theme before the first paint; the theme's own script accepts only light and dark."""
    return (
        "{const page = document.documentElement.dataset;"
        'if (page.theme !== "light" && page.theme !== "dark")'
        ' page.theme = matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light";}'
    )
