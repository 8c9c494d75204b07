"""Explorers, figures, films and bets: outputs of a notebook that stay alive on a page."""

from importlib.util import find_spec

for _package in ("matplotlib", "anywidget", "PIL"):
    if find_spec(_package) is None:
        raise ModuleNotFoundError(
            f"This needs {_package}: pip install 'robot-perception[book]'", name=_package
        )
