"""The command ``robot-perception datasets``: what there is, what is here, and fetching the rest."""

import textwrap

import click

from robot_perception.datasets.entries import GITHUB, Dataset, UnknownDataset, dataset, registry
from robot_perception.datasets.store import (
    DatasetMissing,
    DownloadError,
    FileStatus,
    fetch,
    size_text,
    status,
)


@click.group()
def datasets() -> None:
    """Real recordings: list them, show one, fetch what is missing."""


@datasets.command("list")
def list_command() -> None:
    """List the data sets: state, size, licence."""
    rows = [("name", "state", "size", "licence")]
    for entry in registry().values():
        size = size_text(sum(file.bytes for file in entry.files))
        rows.append((entry.name, _state(status(entry.name)), size, entry.licence))
    _table(rows)


@datasets.command()
@click.argument("name")
def info(name: str) -> None:
    """Show the files, hashes, origin, citation and terms of data set NAME."""
    entry = _dataset(name)
    click.echo(f"{entry.name}: {entry.title}")
    for label, text in (("Cite", entry.citation), ("Terms", entry.terms)):
        click.echo(textwrap.fill(f"{label}: {text}", 96, subsequent_indent="  "))
    for item in status(name):
        file = item.file
        where = f", {item.path}" if item.path else ""
        click.echo(f"\n{file.name}: {_file_state(item)}{where}")
        click.echo(f"  {size_text(file.bytes)}, sha256 {file.sha256}")
        if file.origin is None:
            click.echo(f"  {file.made_from}")
        else:
            click.echo(f"  {file.copy} of {file.origin.address()}")
            if file.copy == "gzip":
                click.echo(
                    f"  the original: {size_text(file.downloaded_bytes)}, sha256 "
                    f"{file.downloaded_sha256}"
                )


@datasets.command("fetch")
@click.argument("names", nargs=-1, metavar="[NAME]...")
@click.option("--all", "everything", is_flag=True, help="Fetch all that can be downloaded.")
@click.option(
    "--address", default=GITHUB, show_default=True, help="Server laid out like GitHub's raw files."
)
@click.option(
    "--timeout", default=30.0, show_default=True, help="Seconds to wait for the server to speak."
)
def fetch_command(names: tuple[str, ...], everything: bool, address: str, timeout: float) -> None:
    """Download what is missing of the data sets NAME... into the cache."""
    if everything == bool(names):
        raise click.UsageError("give the names of data sets, or --all")
    for name in names or registry():
        entry = _dataset(name)
        for file in entry.files:
            if everything and file.origin is None:
                continue
            try:
                fetch(name, file.name, progress=True, address=address, timeout=timeout)
            except (DownloadError, DatasetMissing) as error:
                raise click.ClickException(str(error)) from error
        click.echo(f"{name}: {_state(status(name))}")


def _dataset(name: str) -> Dataset:
    try:
        return dataset(name)
    except UnknownDataset as error:
        raise click.ClickException(str(error)) from error


def _state(items: tuple[FileStatus, ...]) -> str:
    """Return the state of a data set in a few words."""
    here = [item for item in items if item.state != "missing"]
    changed = sum(item.state == "differs" for item in items)
    lost = sum(item.state == "missing" and item.file.origin is None for item in items)
    missing = len(items) - len(here)
    parts = []
    if not missing:
        parts.append("present")
    elif here:
        parts.append(f"{len(here)} of {len(items)} files present")
    else:
        parts.append("missing")
    if changed:
        parts.append(f"{changed} with another hash")
    if missing and not lost:
        parts.append("downloadable")
    elif missing == lost and missing:
        parts.append("not downloadable")
    elif missing:
        parts.append(f"{missing - lost} downloadable")
    return ", ".join(parts)


def _file_state(item: FileStatus) -> str:
    if item.state == "differs":
        return "differs from the pinned hash"
    if item.state == "missing":
        return "missing, not downloadable" if item.file.origin is None else "missing, downloadable"
    return "present"


def _table(rows: list[tuple[str, ...]]) -> None:
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = (cell.ljust(width) for cell, width in zip(row, widths, strict=True))
        click.echo("  ".join(cells).rstrip())
