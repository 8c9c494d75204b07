"""The command line: claims, stored results, data sets, a detector to train, notebooks of a course.

Only what a command needs is imported, when it runs, so that ``--help`` answers at once.
"""

import sys

import click

from robot_perception import __version__
from robot_perception.cli.claims import claims
from robot_perception.cli.course import course, grade
from robot_perception.cli.datasets import datasets
from robot_perception.cli.day import day
from robot_perception.cli.hands import hands
from robot_perception.cli.register import register
from robot_perception.cli.store import store


@click.group()
@click.version_option(__version__, prog_name="robot-perception")
def main() -> None:
    """An executable book on how mobile robots perceive: its claims and its recordings."""
    if hasattr(sys.stdout, "reconfigure"):  # not every encoding of a file has all our characters
        sys.stdout.reconfigure(errors="replace")


main.add_command(claims)
main.add_command(course)
main.add_command(datasets)
main.add_command(day)
main.add_command(grade)
main.add_command(hands)
main.add_command(register)
main.add_command(store)
