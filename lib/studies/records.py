"""Paths of a project's recorded results: ledger, registrations, stored runs, rows."""

from pathlib import Path

from studies.project import project


def records() -> Path:
    """Return the folder of recorded results.

    Raises
    ------
    FileNotFoundError
        If the project says that there is none.
    """
    return project().records()
