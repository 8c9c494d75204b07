"""The real recordings of tests, on a computer that has them."""

from pathlib import Path

import pytest

from robot_perception import datasets


def recording(name: str, file: str | None = None) -> Path:
    """Return where a recording is, or one file of it; skip the test if it is not here."""
    found = datasets.find(name, file)
    if found is None:
        pytest.skip(f"the recording {name}{(file and f'/{file}') or ''} is not on this computer")
    return found
