"""Where the book keeps its recorded results: the claim ledger, stored figures, benchmark table."""

from pathlib import Path


def records() -> Path:
    """Return the folder of recorded results: of the checkout, or shipped inside the package.

    Raises
    ------
    FileNotFoundError
        If neither exists.
    """
    package = Path(__file__).parents[1]
    for folder in (package.parents[1] / "book" / "_data", package / "_data"):
        if folder.is_dir():
            return folder
    raise FileNotFoundError("the recorded results are missing; write them with `make reproduce`")
