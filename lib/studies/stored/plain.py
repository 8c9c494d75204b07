"""Plain data as files that a diff can show."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from studies.files import written


def write_json(path: Path | str, plain: Mapping[str, Any]) -> None:
    """Write a mapping as JSON, each item of its lists in a line, so that a diff shows what changes.

    Parameters
    ----------
    path
        The file.
    plain
        What it holds, by name.

    Raises
    ------
    TypeError
        If it holds what JSON cannot.
    """
    parts = []
    for name, value in plain.items():
        text = json.dumps(value)
        if isinstance(value, list):
            rows = ",\n  ".join(json.dumps(row, separators=(",", ":")) for row in value)
            text = f"[\n  {rows}\n ]"
        parts.append(f' "{name}": {text}')
    with written(path) as beside:
        beside.write_text("{\n" + ",\n".join(parts) + "\n}\n", encoding="utf-8")
