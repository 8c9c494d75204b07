"""The command line, or what to install for it."""

from robot_perception.extras import advice


def main() -> None:
    """Run the command line; name the extra of a package that it needs and does not find."""
    try:
        from robot_perception.cli import main as command_line

        command_line()
    except ModuleNotFoundError as error:
        text = advice(error.name)
        if text is None:
            raise
        raise SystemExit(text) from error


if __name__ == "__main__":
    main()
