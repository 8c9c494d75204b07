"""The registry: every entry complete, every address pinned, nothing that could not be checked."""

import re

import pytest

from robot_perception.datasets import registry

FILES = [
    pytest.param(entry, file, id=f"{entry.name}/{file.name}")
    for entry in registry().values()
    for file in entry.files
]
NEEDED = {
    "carmen_intel",
    "carmen_fr079",
    "carmen_corrected",
    "malaga_sena",
    "utias_mrclam_6",
    "victoria_park",
}


def test_the_books_recordings_are_registered():
    assert set(registry()) >= NEEDED


@pytest.mark.parametrize("entry", registry().values(), ids=list(registry()))
def test_every_set_says_whose_it_is(entry):
    for text in (entry.title, entry.licence, entry.terms, entry.citation):
        assert text.strip() == text != ""
    names = [file.plain_name for file in entry.files]
    assert len(set(names)) == len(names) > 0


@pytest.mark.parametrize(("entry", "file"), FILES)
def test_every_file_can_be_checked_and_says_where_it_comes_from(entry, file):
    assert re.fullmatch(r"[0-9a-f]{64}", file.sha256)
    assert file.bytes > 0
    assert (file.content_sha256 is None) == (not file.name.endswith(".gz"))
    if file.content_sha256 is not None:
        assert re.fullmatch(r"[0-9a-f]{64}", file.content_sha256)
        assert file.content_bytes > 0
    if file.copy == "converted":
        assert file.origin is None
        assert file.made_from
        return
    assert re.fullmatch(r"[\w.-]+/[\w.-]+", file.origin.repository)
    assert re.fullmatch(r"[0-9a-f]{40}", file.origin.commit)
    assert file.origin.address().startswith("https://raw.githubusercontent.com/")
    as_original = {"as is": file.sha256, "gzip": file.content_sha256}
    assert file.downloaded_sha256 == as_original[file.copy]


def test_file_is_found_with_or_without_gz():
    entry = registry()["carmen_fr079"]
    assert entry.file("fr079_graph.log") is entry.file("fr079_graph.log.gz")
