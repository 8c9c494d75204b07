"""The command ``robot-perception datasets``: what there is, what is here, and fetching the rest."""

import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from robot_perception.datasets.store import FileStatus

SHOWN = 20
STATES = {
    "present": "present",
    "differs": "differs from the pinned hash",
    "missing": "missing",
    "unchecked": "present, unpacked, so that the pinned hash says nothing of it",
}


class _Group(click.Group):
    """Commands whose expected errors are one line, without traceback."""

    def invoke(self, ctx: click.Context) -> Any:
        from robot_perception.datasets.entries import UnknownDataset
        from robot_perception.datasets.store import DatasetMissing, DownloadError

        try:
            return super().invoke(ctx)
        except (DatasetMissing, DownloadError, NotADirectoryError, UnknownDataset) as error:
            raise click.ClickException(str(error)) from error
        except ValueError as error:  # of a registry
            raise click.ClickException(str(error)) from error


@click.group(cls=_Group)
def datasets() -> None:
    """Real recordings: list them, show one, fetch what is missing, add one's own."""


@datasets.command("list")
def list_command() -> None:
    """List the data sets: state, files, size, licence."""
    from robot_perception.datasets.entries import registry
    from robot_perception.datasets.store import size_text, status

    rows = [("name", "state", "files", "size", "licence")]
    for entry in registry().values():
        count = str(entry.members or len(entry.files))
        state = _state(status(entry.name))
        rows.append((entry.name, state, count, size_text(entry.bytes), entry.licence))
    _table(rows)


@datasets.command()
@click.argument("name")
def info(name: str) -> None:
    """Show the files, hashes, origin and terms of data set NAME."""
    from robot_perception.datasets.entries import dataset, some
    from robot_perception.datasets.store import size_text, status

    entry = dataset(name)
    click.echo(f"{entry.name}: {entry.title}")
    for label in ("origin", "licence", "note"):
        if text := getattr(entry, label):
            click.echo(textwrap.fill(f"{label.title()}: {text}", 96, subsequent_indent="  "))
    items = status(name)
    click.echo(f"Files: {entry.members or len(items)}, {size_text(entry.bytes)}; {_state(items)}")
    for item in items[:SHOWN]:
        where = f", {item.path}" if item.path else ""
        click.echo(f"\n{item.file.name}: {STATES[item.state]}{where}")
        click.echo(f"  sha256 {item.file.sha256}")
        click.echo(f"  {item.file.url or 'not downloadable: no address is pinned'}")
    if len(items) > SHOWN:
        click.echo(f"\n… and {len(items) - SHOWN} more")
    differing = [item.file.name for item in items[SHOWN:] if item.state == "differs"]
    if differing:
        click.echo(f"of these, another hash: {some(differing)}")


@datasets.command("fetch")
@click.argument("names", nargs=-1, metavar="[NAME]...")
@click.option("--all", "everything", is_flag=True, help="Fetch all that can be downloaded.")
@click.option(
    "--timeout", default=30.0, show_default=True, help="Seconds to wait for the server to speak."
)
def fetch_command(names: tuple[str, ...], everything: bool, timeout: float) -> None:
    """Download what is missing of the data sets NAME... into the cache."""
    from robot_perception.datasets.entries import registry
    from robot_perception.datasets.store import DatasetMissing, fetch, status

    if everything == bool(names):
        raise click.UsageError("give the names of data sets, or --all")
    for name in names or registry():
        try:
            fetch(name, progress=True, timeout=timeout)
        except DatasetMissing:
            if not everything:
                raise
        click.echo(f"{name}: {_state(status(name))}")


@datasets.command("add")
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--title", default="", help="What it is, in a line.")
@click.option("--licence", default="", help="On what terms it may be used, in a few words.")
@click.option("--origin", default="", help="Who recorded it, and how to cite it.")
@click.option("--note", default="", help="More on terms, or what was made from what.")
@click.option("--url", help="Address below which the files can be downloaded.")
@click.option(
    "--to",
    type=click.Path(exists=True, file_okay=False, path_type=Path),
    help="Directory of the registry (that of your recordings, if not given).",
)
def add_command(folder: Path, **fields: Any) -> None:
    """Add FOLDER to a registry: the hash of each file, and whose they are."""
    from robot_perception.datasets.entries import add_dataset
    from robot_perception.datasets.store import size_text

    entry = add_dataset(folder, **fields)
    click.echo(f"{entry.name}: {len(entry.files)} files, {size_text(entry.bytes)}")


def _state(items: tuple["FileStatus", ...]) -> str:
    """Return the state of a data set in a few words."""
    missing = [item for item in items if item.path is None]
    changed = sum(item.state == "differs" for item in items)
    here = len(items) - len(missing)
    parts = [f"{here} of {len(items)} files present" if missing and here else ""]
    parts += ["" if missing and here else "missing" if missing else "present"]
    parts += [f"{changed} with another hash" if changed else ""]
    if missing:
        loads = sum(item.file.url is not None for item in missing)
        every = "" if loads in (0, len(missing)) else f"{loads} "
        parts += [f"{every}downloadable" if loads else "not downloadable"]
    return ", ".join(filter(None, parts))


def _table(rows: list[tuple[str, ...]]) -> None:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        click.echo("  ".join(cells).rstrip())
