"""Pages of source code have a target at each definition, for every module of the library."""

import os

import pytest

from robot_perception.project import ROOT
from robot_perception.teaching.pages import source_pages
from robot_perception.teaching.pages.source_pages import (
    address,
    definitions,
    modules,
    pages,
    with_targets,
)

CODE = '''"""Says."""


@decorated(
    1
)
def first():
    def inner():
        pass


class Second:
    @property
    def third(self): ...
'''


def test_definitions_begin_at_their_decorators():
    assert definitions(CODE) == {4: "first", 12: "Second", 13: "Second.third"}


def test_targets_stand_before_the_lines_of_definitions():
    html = f'<div class="highlight"><pre>\n{CODE}</pre></div>'.replace("<pre>\n", "<pre>")
    made = with_targets(html, definitions(CODE))
    assert (
        made.replace('<span class="rp-definition" id="first"></span>@dec', "@dec").count(
            'id="first"'
        )
        == 0
    )
    assert '<span class="rp-definition" id="Second"></span>class Second:' in made
    assert '<span class="rp-definition" id="Second.third"></span>    @property' in made
    assert made.count("<span") == 3


def test_every_module_has_a_page_and_only_those_that_are_older_than_it_are_written(tmp_path):
    source = tmp_path / "lib" / "robot_perception" / "room"
    tests = tmp_path / "tests" / "chapters" / "walls"
    for folder in (source, tests):
        folder.mkdir(parents=True)
    for file in (source / "__init__.py", source / "one.py", tests / "test_claims.py"):
        file.write_text("def a(): ...\n")
    (tests / "test_more.py").write_text("")
    names = [
        "robot_perception.room",
        "robot_perception.room.one",
        "tests.chapters.walls.test_claims",
    ]
    assert list(modules(tmp_path)) == names

    def written():
        found = pages(tmp_path, tmp_path / "html", lambda code: f"<pre>{code}</pre>")
        return {page: context["body"] for page, context, _ in found}

    made = written()
    one = "_modules/robot_perception/room/one"
    assert set(made) == {
        "_modules/index",
        *(f"_modules/{name.replace('.', '/')}" for name in names),
    }
    assert 'id="a"' in made[one]
    assert '<a href="../../index.html">All modules</a>' in made[one]
    assert '<a href="robot_perception/room/one.html">' in made["_modules/index"]
    built = tmp_path / "html" / f"{one}.html"
    built.parent.mkdir(parents=True)
    built.touch()
    os.utime(built, (2e9, 2e9))
    assert one not in written()
    os.utime(source / "one.py", (3e9, 3e9))
    assert one in written()


@pytest.mark.parametrize("thing", [address, source_pages.modules])
def test_addresses_lead_to_pages_with_that_target(thing):
    page, name = address(thing.__module__, thing.__qualname__).split("#")
    module = page.removeprefix("_modules/").removesuffix(".html").replace("/", ".")
    assert name in definitions(modules(ROOT)[module].read_text("utf-8")).values()
