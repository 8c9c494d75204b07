"""Plain data come back, and a diff shows what changes."""

import json

import pytest

from studies.stored.plain import write_json


def test_json_has_a_line_for_each_item_of_a_list_and_comes_back(tmp_path):
    plain = {"version": 2, "name": "a", "rows": [[1, 2.5], {"k": None}], "empty": []}
    write_json(tmp_path / "a.json", plain)
    text = (tmp_path / "a.json").read_text("utf-8")
    assert json.loads(text) == plain
    assert "  [1,2.5],\n" in text
    with pytest.raises(TypeError):
        write_json(tmp_path / "a.json", {"bad": {1, 2}})
    assert (tmp_path / "a.json").read_text("utf-8") == text, "left as it was"
