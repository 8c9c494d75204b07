"""``robot-perception day``: a day of one robot with the systems of all five papers."""

from pathlib import Path

import click

from robot_perception.cli.workers import with_workers, working


@click.command()
@click.option("--seed", default=3, show_default=True, help="Of building, people, ways and noise.")
@click.option(
    "--days",
    default=1,
    show_default=True,
    type=click.IntRange(1),
    help="So many days, each of its own seed, from this one on.",
)
@click.option(
    "--without",
    multiple=True,
    help="Leave a system out: stereo, ceiling, laser, sonar, skin, faces, arms or intersection; "
    "may be repeated. The wheels stand in for those that tell where the robot is.",
)
@click.option(
    "--film",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Where to write a film of the day (MP4): what the robot sees, and a plan from above.",
)
@click.option(
    "--log",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Where to write what the robot believes beside the truth, a line of JSON a step.",
)
@with_workers
def day(
    seed: int,
    days: int,
    without: tuple[str, ...],
    film: Path | None,
    log: Path | None,
    workers: int | None,
    dask: str | None,
    ray: str | None,
) -> None:
    """Run a day: a robot learns a floor, finds itself, guides, recognises, follows, and is sent.

    Nine acts follow each other. The truth decides how each ends, and the day ends with the first
    whose goal is not reached. A day takes some minutes of one processor.
    """
    from robot_perception.day.robot import SYSTEMS

    if unknown := sorted(set(without) - set(SYSTEMS)):
        known = ", ".join(SYSTEMS)
        raise click.BadParameter(f"{unknown[0]!r} is none of {known}", param_hint="--without")
    if days > 1 and (film or log):
        raise click.UsageError("a film or a log is of one day: leave out --days")
    from robot_perception.cli import day_report

    times: list[str] = []
    if days == 1:
        ends, times = day_report.one(seed, frozenset(without), film, log)
        found = {seed: ends}
    else:
        with working(workers, dask, ray):
            found = day_report.many(range(seed, seed + days), frozenset(without))
    for line in (*day_report.table(found), *times):
        click.echo(line)
