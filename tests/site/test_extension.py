"""The book's Sphinx extension: when results expire, and what it does to a page."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest
from bs4 import BeautifulSoup
from docutils import nodes
from docutils.utils import new_document
from jupyter_client import KernelManager
from myst_nb.core.config import NbParserConfig
from nbformat import write
from nbformat.v4 import new_code_cell, new_notebook

from explorables.media import with_mathematics
from explorables.pages import NO_SCRIPTS
from robot_perception.teaching import sphinx_extension
from tests.unchecked import unchecked


def expire(folder: Path, keys: dict[str, str | None], env: SimpleNamespace) -> list[str]:
    """Let a build begin with these keys of pages; return which pages are read again."""
    env.found_docs, env.doc2path = keys, str
    env.config = SimpleNamespace(root_doc="intro", book_contents="")
    app = SimpleNamespace(outdir=folder / "html", env=env)
    found = SimpleNamespace(key=lambda page: keys[page.name])
    with pytest.MonkeyPatch.context() as patch, unchecked():
        patch.setattr(sphinx_extension, "Dependencies", lambda root: found)
        outdated = sphinx_extension._expire(app, env, set(), set(), set())
        for name in keys:
            env.mystnb_config = NbParserConfig()
            sphinx_extension._choose_cache(app, name, [""])
            if path := env.mystnb_config.execution_cache_path:
                Path(path).mkdir(parents=True, exist_ok=True)
    return sorted(outdated)


def test_pages_whose_key_changed_are_read_again_and_lose_their_results(tmp_path: Path):
    env, caches = SimpleNamespace(), tmp_path / ".jupyter_cache"
    keys = {"walls": "1", "monobot": "1", "notes": None}
    assert expire(tmp_path, keys, env) == ["monobot", "walls"]
    assert {path.name for path in caches.iterdir()} == {"walls-1", "monobot-1"}
    (caches / "walls-1" / "results").touch()
    (caches / "monobot-1" / "results").touch()
    assert expire(tmp_path, keys, env) == []
    assert expire(tmp_path, keys | {"walls": "2"}, env) == ["walls"]
    assert {path.name for path in caches.iterdir()} == {"walls-2", "monobot-1"}
    assert not list((caches / "walls-2").iterdir())
    assert (caches / "monobot-1" / "results").exists()


def test_results_survive_a_lost_environment_and_all_pages_are_read(tmp_path: Path):
    keys, results = {"walls": "1"}, tmp_path / ".jupyter_cache" / "walls-1" / "results"
    assert expire(tmp_path, keys, SimpleNamespace()) == ["walls"]
    results.touch()
    assert expire(tmp_path, keys, SimpleNamespace()) == ["walls"]
    assert results.exists()


def test_kernels_of_the_build_are_encrypted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    trait = KernelManager.transport_encryption
    monkeypatch.setattr(trait, "default_value", trait.default_value)  # put back afterwards
    with unchecked():
        app = SimpleNamespace(srcdir=tmp_path)
        sphinx_extension._configure(app, SimpleNamespace(html_static_path=[]))
    manager = KernelManager(connection_file=str(tmp_path / "kernel.json"))
    manager.start_kernel()
    connection = json.loads((tmp_path / "kernel.json").read_text())
    manager.shutdown_kernel(now=True)
    assert connection["curve_secretkey"]


def finished(
    body: str, folder: Path, scripts: tuple[str, ...] = (), inline: dict[str, str] | None = None
) -> dict[str, object]:
    """Return the context of a page after the extension has finished it."""
    context = {
        "body": body,
        "pathto": lambda target, _: f"../{target}",
        "script_files": [
            *(SimpleNamespace(filename=name, attributes={}) for name in scripts),
            SimpleNamespace(filename=None, attributes=inline or {}),
        ],
        "css_files": [],
    }
    app = SimpleNamespace(outdir=folder)  # all of Sphinx that is asked
    with unchecked():
        sphinx_extension._finish_page(app, "page", "page.html", context, None)
    return context


def test_pages_beside_the_contents_share_their_menu():
    made = []

    class App:
        env = SimpleNamespace(found_docs={"intro", "walls"})

    app = App()

    def menu(page: str, **options: object) -> str:
        context = {"toctree": lambda **how: made.append(how) or page}
        with unchecked():
            sphinx_extension._share_menu(app, page, "", context, None)
        return context["toctree"](**options)

    assert [menu("walls"), menu("intro"), menu("walls")] == ["walls", "intro", "walls"]
    assert menu("_modules/a/one", collapse=True) == "_modules/a/one"
    assert menu("_modules/a/two", collapse=True) == "_modules/a/one"
    assert menu("_modules/a/two", collapse=False) == "_modules/a/two"  # another menu
    assert menu("_modules/three", collapse=True) == "_modules/three"  # its links are others
    assert len(made) == 6


def test_the_landing_page_follows_the_chapters_and_the_rest_runs_beside_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    def page(name: str, cells: int, tags: list[str]) -> None:
        made = [new_code_cell("1", metadata={"tags": tags}) for _ in range(cells)]
        write(new_notebook(cells=made), tmp_path / name)

    page("short.ipynb", 2, ["study"])
    page("long.ipynb", 5, ["study"])
    page("ledger.ipynb", 4, [])
    page("intro.ipynb", 3, [])
    names = ["intro", "ledger", "long", "short"]
    env = SimpleNamespace(
        page_keys=dict.fromkeys(names, "key"),
        config=SimpleNamespace(root_doc="intro"),
        doc2path=lambda name: str(tmp_path / f"{name}.ipynb"),
        mystnb_config=NbParserConfig(),
        myst_config=None,
    )
    order: list[str] = []
    monkeypatch.setattr(
        sphinx_extension,
        "execute",
        lambda pages, config, kernels: order.extend(place.stem for place, _ in pages),
    )
    monkeypatch.setenv(sphinx_extension.WORKERS, "2")
    with unchecked():
        app = SimpleNamespace(env=env, outdir=tmp_path / "html")
        sphinx_extension._execute(app, env, names)
    assert order == ["long", "short", "intro", "ledger"]


def test_what_unfolds_in_the_menu_has_a_name():
    entry = '<li><a href="a.html">1. Walls</a>{}</li>'
    below = "<details><summary><span></span></summary><ul>{}</ul></details>"
    menu = BeautifulSoup(entry.format(below.format(entry.format(""))), "html.parser")
    named = sphinx_extension._with_names(lambda **options: menu)(kind="sidebar")
    assert [s["aria-label"] for s in named("summary")] == ["More on 1. Walls"]


def test_scripts_of_other_hosts_and_widget_state_are_dropped(tmp_path: Path):
    scripts = ("_static/explorer.js", "https://unpkg.com/x.js", "sphinx-thebe.js")
    state = {"type": "application/vnd.jupyter.widget-state+json", "body": "{}"}
    kept = finished("<p></p>", tmp_path, scripts, state)["script_files"]
    assert [script.filename for script in kept] == ["_static/explorer.js"]


def test_no_built_page_names_a_script_or_style_of_another_host(site: Path):
    for page in site.glob("*.html"):
        text = page.read_text("utf-8")
        assert 'src="http' not in text, page.name
        assert 'rel="stylesheet" href="http' not in text, page.name
        assert "THEBE" not in text, page.name
        assert "vnd.jupyter.widget-state" not in text, page.name


def test_words_to_the_tests_are_not_shown_to_readers(tmp_path: Path):
    body = f"<pre><span></span>{sphinx_extension.COMPARED}print(1)</pre>"
    assert finished(body, tmp_path)["body"] == "<pre><span></span>print(1)</pre>"


def test_a_badge_that_stands_twice_names_its_place_once(tmp_path: Path):
    badge = '<a class="rp-badge" id="claim-a" href="scorecard.html#a">a</a>'
    body = finished(badge + badge.replace("-a", "-b") + badge, tmp_path)["body"]
    assert body.count('id="claim-a"') == 1
    assert body.index('id="claim-a"') < body.index('id="claim-b"')
    assert body.count('href="scorecard.html#a"') == 3


def test_a_scorecard_says_once_what_needs_scripts(tmp_path: Path):
    card = '<div class="rp-scorecard">'
    assert finished(card, tmp_path)["body"] == NO_SCRIPTS + card
    assert finished(NO_SCRIPTS + card, tmp_path)["body"] == NO_SCRIPTS + card


def test_beside_each_formula_stands_mathml(tmp_path: Path):
    page = (
        r'<p>a <span class="math notranslate">\(x &lt; 1\)</span></p><div class="math">\[y\]</div>'
    )
    inline, block = finished(page, tmp_path)["body"].split("</p>")
    assert inline.startswith(
        r'<p>a <span class="math notranslate"><span class="rp-tex">\(x &lt; 1\)'
    )
    assert (
        "<mo>&#x0003C;</mo>" in inline.split("<noscript><math ")[1].split("</noscript></span>")[0]
    )
    assert 'display="block"' in block.split(r"\[y\]</span><noscript><math ")[1]


def test_the_source_of_a_page_comes_as_a_script_too(tmp_path: Path):
    source = tmp_path / "page.md"
    source.write_text('A "quoted" word, ε\n', "utf-8")
    context = {"sourcename": "library/page.md"}
    with unchecked():
        sphinx_extension._store_source(tmp_path / "_sources", source, context)
    script = (tmp_path / "_sources" / "library" / "page.md.js").read_text("utf-8")
    name, text = json.loads(script.replace("robotPerceptionSave(", "[").replace(");", "]"))
    assert (name, text) == ("page.md", source.read_text("utf-8"))


def test_what_outputs_name_can_be_linked_to():
    document = new_document("")
    html = (
        '<article class="rp-claim" id="dp-a"><a id="claim-b" href="#"></a><g id="glyph"/></article>'
    )
    document += nodes.raw("", html, format="html")
    metadata = {"walls": {"myst_slugs": {"a-heading": (1, "id1", "A heading")}}}
    assert noted(document, metadata) == {}
    assert list(metadata["walls"]["myst_slugs"]) == ["a-heading", "dp-a", "claim-b"]
    assert metadata["walls"]["myst_slugs"]["dp-a"] == (0, "dp-a", "dp-a")


def test_a_page_whose_outputs_have_formulas_has_formulas():
    document = new_document("")
    document += nodes.raw("", with_mathematics("a length $x$"), format="html")
    assert noted(document, {"walls": {}}) == {"walls": True}


def noted(document: nodes.document, metadata: dict[str, dict]) -> dict[str, bool]:
    """Have the outputs of a page noted; return which pages have formulas."""
    domain = SimpleNamespace(data={"has_equations": {}})
    env = SimpleNamespace(docname="walls", metadata=metadata, get_domain=lambda name: domain)
    with unchecked():
        sphinx_extension._note_outputs(SimpleNamespace(env=env), document)
    return domain.data["has_equations"]


def test_mathematics_of_the_bibliography_becomes_formulas():
    document = new_document("")
    paragraph = nodes.paragraph("", "", nodes.Text(r"Lines in $O(n)$ or $n \log n$ time, for 5 $."))
    document += [nodes.citation("", paragraph), nodes.paragraph("", "costs $1 or $2")]
    domain = SimpleNamespace(data={"has_equations": {}})
    env = SimpleNamespace(docname="references", get_domain=lambda name: domain)
    document.settings.env = env
    transform = sphinx_extension.SetMathematics(document)
    transform.run()
    assert [node.astext() for node in document.findall(nodes.math)] == ["O(n)", r"n \log n"]
    assert paragraph.astext() == r"Lines in O(n) or n \log n time, for 5 $."
    assert domain.data["has_equations"] == {"references": True}
    assert document[1].astext() == "costs $1 or $2"


def test_pages_of_source_are_ours_and_live_code_is_nobodys():
    def listener(module: str, number: int) -> SimpleNamespace:
        return SimpleNamespace(id=number, handler=SimpleNamespace(__module__=module))

    events = {
        "html-collect-pages": [listener("sphinx.ext.viewcode", 1), listener("gallery", 2)],
        "doctree-read": [listener("sphinx.ext.viewcode", 3), listener("sphinx_thebe", 4)],
    }
    dropped: list[int] = []
    with unchecked():
        app = SimpleNamespace(events=SimpleNamespace(listeners=events), disconnect=dropped.append)
        sphinx_extension._drop_listeners(app)
    assert dropped == [1, 4]
