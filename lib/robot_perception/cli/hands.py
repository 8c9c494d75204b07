"""``robot-perception hands``: train the detector of open hands anew."""

from pathlib import Path

import click


@click.command()
@click.option(
    "--write",
    "file",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Where to store the model; without it only what each stage reaches is told.",
)
@click.option("--brief", is_flag=True, help="A small model in seconds, to try the command.")
def hands(file: Path | None, brief: bool) -> None:
    """Train the detector of open hands on rendered hands, as the chapter "Follow me" has it.

    It takes some seven minutes of one processor and gives the same model every time.
    """
    import numpy as np

    from robot_perception.book import tutor_following as page
    from robot_perception.chapters.tutor_following.training import write

    def told(report) -> None:
        click.echo(
            f"{report.features:3d} features: of {report.hands} hands {report.detection:.1%} pass, "
            f"of {report.others} others {report.false_alarms:.1%}"
        )

    config = page.BRIEF if brief else {}
    found = page.trained(np.random.default_rng(page.TRAINED_BY), told=told, **config)
    if file is not None:
        write(found, file)
        click.echo(f"{len(found.cascade.stages)} stages are stored in {file}")
