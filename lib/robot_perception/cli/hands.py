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
@click.option(
    "--others",
    "folders",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    multiple=True,
    help="Photographs and films in which no open hand is shown, to be told from hands as well; "
    "may be repeated.",
)
@click.option("--brief", is_flag=True, help="A small model in seconds, to try the command.")
def hands(file: Path | None, folders: tuple[Path, ...], brief: bool) -> None:
    """Train the detector of open hands on rendered hands, as the chapter "Follow me" has it.

    It takes some seven minutes of one processor and gives the same model every time. A detector
    for rooms of your own sees less that is not there if it is trained on pictures of them, too.
    """
    import numpy as np

    from robot_perception.book import tutor_following as page
    from robot_perception.chapters.tutor_following.training import photographs, write
    from studies.files import DamagedFile

    def told(report) -> None:
        click.echo(
            f"{report.features:3d} features: of {report.hands} hands {report.detection:.1%} pass, "
            f"of {report.others} others {report.false_alarms:.1%}"
        )

    config = page.BRIEF if brief else {}
    seen = []
    for folder in folders:
        try:
            images, skipped = photographs(folder)
        except (ValueError, DamagedFile) as error:
            raise click.ClickException(str(error)) from error
        seen += images
        if skipped:
            click.echo(f"{folder}: files that are no pictures and no films: {skipped}")
    found = page.trained(
        np.random.default_rng(page.TRAINED_BY), told=told, photographs=seen, **config
    )
    if file is not None:
        write(found, file)
        click.echo(f"{len(found.cascade.stages)} stages are stored in {file}")
