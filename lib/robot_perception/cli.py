"""The command line: the claim ledger and the data sets."""

import platform
from datetime import date
from importlib.metadata import version
from pathlib import Path

import click
from tqdm import tqdm

from robot_perception import __version__, chapters
from robot_perception.datasets import DatasetMissing
from robot_perception.datasets.commands import datasets
from robot_perception.teaching.badges import as_text
from robot_perception.teaching.claims import Claim, Ledger, Size
from robot_perception.teaching.recordings import Recording
from robot_perception.teaching.records import records


@click.group()
@click.version_option(__version__, prog_name="robot-perception")
def main() -> None:
    """An executable book on how mobile robots perceive: its claims and its recordings."""


main.add_command(datasets)


@main.command()
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of a table.")
@click.option(
    "--run",
    "size",
    type=click.Choice([s.value for s in Size]),
    is_flag=False,
    flag_value=Size.QUICK.value,
    help="Recompute the claims (quick if no size is given) instead of printing the record.",
)
@click.option(
    "--chapter", "stems", multiple=True, help="Only this chapter (may be given several times)."
)
@click.option(
    "--write",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Also write the ledger to this file.",
)
def claims(as_json: bool, size: str | None, stems: tuple[str, ...], write: Path | None) -> None:
    """Print the claim ledger: what each paper says, what we find, and the verdict."""
    try:
        ledger = _ledger(size, stems)
    except (ValueError, OSError) as error:
        raise click.ClickException(str(error)) from error
    if write is not None:
        write.write_text(ledger.to_json(), encoding="utf-8")
    click.echo(ledger.to_json() if as_json else as_text(ledger))


def _ledger(size: str | None, stems: tuple[str, ...]) -> Ledger:
    """Return the recorded ledger, or compute it at a size."""
    stems = stems or chapters.CHAPTERS
    for stem in stems:
        chapters.chapter(stem)  # an unknown chapter is an error, not an empty table
    if size is None:
        ledger = Ledger.read(records() / "claims.json")
        kept = tuple(e for e in ledger.entries if e.chapter in stems)
        return Ledger(kept, ledger.versions, ledger.date)
    bar = tqdm(chapters.claims(stems), desc="claims", unit="claim")
    return Ledger(tuple(_run(claim, size, bar) for claim in bar), _versions(), str(date.today()))


def _run(claim: Claim, size: str, bar: tqdm):
    bar.set_postfix_str(claim.id)
    return claim.run(size)


def _versions() -> dict[str, str]:
    names = ("robot-perception", "numpy", "scipy", "numba", "opencv-python-headless")
    return {"python": platform.python_version(), **{name: version(name) for name in names}}


@main.command()
@click.option("--chapter", "stems", multiple=True, help="Only this chapter.")
def store(stems: tuple[str, ...]) -> None:
    """Recompute the stored results of the real recordings and write them beside the ledger."""
    try:
        recordings = [
            recording
            for stem in stems or chapters.CHAPTERS
            for recording in chapters.chapter(stem).RECORDINGS
        ]
        for recording in tqdm(recordings, desc="recordings", unit="recording"):
            click.echo(_store(recording))
    except (ValueError, OSError) as error:
        raise click.ClickException(str(error)) from error


def _store(recording: Recording) -> str:
    """Store the result of one recording, or keep the stored one; return what was done."""
    try:
        file = recording.write()
    except DatasetMissing:
        return f"{recording.store}: kept as it is, {recording.dataset} is not on this computer"
    return (
        f"{recording.store}: computed from {recording.dataset}, {file.stat().st_size / 1e3:.0f} kB"
    )
