"""The command line, or what to install for it."""

import re
from importlib.metadata import requires


def main() -> None:
    """Run the command line; name the extra of a package that it needs and does not find."""
    try:
        from robot_perception.cli import main as command_line

        command_line()
    except ModuleNotFoundError as error:
        name = str(error.name).partition(".")[0]
        if name in ("robot_perception", "data_synth"):
            raise
        raise SystemExit(
            f"This needs {name}: pip install 'robot-perception[{_extra(name)}]'"
        ) from error


def _extra(name: str) -> str:
    """Return the extra that brings a package; the book's holds the others and what is in none."""
    found = (re.match(rf"{name}\W.*extra == .(\w+)", line) for line in requires("robot-perception"))
    return min({match[1] for match in found if match} - {"book"}, default="book")


if __name__ == "__main__":
    main()
