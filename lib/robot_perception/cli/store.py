"""``robot-perception store``: compute the stored results of the real recordings anew."""

import click

from robot_perception.cli.workers import with_workers, working


@click.command()
@click.option("--chapter", "stems", multiple=True, help="Only this chapter; may be repeated.")
@click.option("--only", "names", multiple=True, help="Only this stored result; may be repeated.")
@with_workers
def store(
    stems: tuple[str, ...],
    names: tuple[str, ...],
    workers: int | None,
    dask: str | None,
    ray: str | None,
) -> None:
    """Recompute the stored results of the real recordings and write them beside the ledger."""
    from tqdm import tqdm

    from robot_perception import chapters

    try:
        found = chapters.recordings(stems or chapters.CHAPTERS)
        known = [recording.store for recording in found]
        unknown = sorted(set(names) - set(known))
        if unknown:
            raise ValueError(f"no stored result {unknown[0]!r}; there are {', '.join(known)}")
        with working(workers, dask, ray):
            for recording in tqdm(found, desc="recordings", unit="recording", disable=None):
                if not names or recording.store in names:
                    click.echo(_store(recording))
    except (ValueError, OSError) as error:
        raise click.ClickException(str(error)) from error


def _store(recording) -> str:
    """Store the result of one recording, or keep the stored one; return what was done."""
    from robot_perception.datasets import DatasetMissing

    try:
        file = recording.write()
    except DatasetMissing:
        return f"{recording.store}: kept as it is, {recording.dataset} is not on this computer"
    return (
        f"{recording.store}: computed from {recording.dataset}, {file.stat().st_size / 1e3:.0f} kB"
    )
