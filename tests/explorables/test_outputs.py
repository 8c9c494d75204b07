"""Outputs of cells: a notebook gets the style with the HTML, and links that lead somewhere."""

import pytest

from explorables.outputs import output

HTML = '<p><a href="scorecard.html#good">good</a> <a href="errata.html">x</a></p>'


def made(*more):
    return output(HTML, "good", "bet.css", *more).bundle


def test_a_page_gets_what_is_given(monkeypatch):
    monkeypatch.setenv("EXPLORABLES_PAGE", "1")
    assert made() == {"text/html": HTML, "text/plain": "good"}


def test_a_notebook_gets_the_sheets_and_links_to_the_notebooks_beside_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scorecard.ipynb").touch()
    (tmp_path / "errata.md").touch()
    (tmp_path / "own.css").write_text(".own {}")
    html = made(tmp_path / "own.css")["text/html"]
    assert html.startswith("<style>")
    assert ".rp-bet" in html
    assert ".own {}</style>" in html
    assert "--rp-ink" in html
    assert '<a href="scorecard.ipynb#good">good</a> <a href="errata.md">x</a>' in html


def test_a_notebook_alone_has_no_link_that_leads_nowhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert made()["text/html"].endswith("<p><a>good</a> <a>x</a></p>")


@pytest.mark.parametrize("address", ["https://doi.org/10.1/x.html", "#here", "_static/x.js"])
def test_other_links_stay(address, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    link = f'<a href="{address}">x</a>'
    assert output(link, "x").bundle["text/html"].endswith(link)
