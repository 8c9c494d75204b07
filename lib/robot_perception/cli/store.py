"""``robot-perception store``: compute the stored results of recordings and long runs anew."""

import click

from robot_perception.cli.workers import with_workers, working


@click.command()
@click.option("--chapter", "stems", multiple=True, help="Only this chapter; may be repeated.")
@click.option("--only", "names", multiple=True, help="Only this stored result; may be repeated.")
@click.option("--keys", is_flag=True, help="Only renew the keys of results that are the stored.")
@with_workers
def store(
    stems: tuple[str, ...],
    names: tuple[str, ...],
    keys: bool,
    workers: int | None,
    dask: str | None,
    ray: str | None,
) -> None:
    """Recompute the stored results of real recordings and long runs; write them beside the ledger.

    After a change of code that should change no result, --keys leaves what is stored as it is and
    says which results have changed after all.
    """
    from tqdm import tqdm

    from robot_perception import chapters

    try:
        stems = stems or chapters.CHAPTERS
        found = (*chapters.recordings(stems), *chapters.states(stems))
        known = [recording.store for recording in found]
        unknown = sorted(set(names) - set(known))
        if unknown:
            raise ValueError(f"no stored result {unknown[0]!r}; there are {', '.join(known)}")
        with working(workers, dask, ray):
            for recording in tqdm(found, desc="results", unit="result", disable=None):
                if not names or recording.store in names:
                    click.echo(_renew(recording) if keys else _store(recording))
    except (ValueError, OSError) as error:
        raise click.ClickException(str(error)) from error


def _store(recording) -> str:
    """Store the result of one recording, or keep the stored one; return what was done."""
    from robot_perception.datasets import DatasetMissing

    try:
        file = recording.write()
    except DatasetMissing:
        return f"{recording.store}: kept as it is, {recording.dataset} is not on this computer"
    source = getattr(recording, "dataset", "seeds")  # a simulated run has no data set
    return f"{recording.store}: computed from {source}, {file.stat().st_size / 1e3:.0f} kB"


def _renew(recording) -> str:
    """Renew the keys of a stored result that is what the code computes; return what was done."""
    from robot_perception.datasets import DatasetMissing

    if recording.is_current():
        return f"{recording.store}: current"
    try:
        same = recording.renew()
    except DatasetMissing:
        return f"{recording.store}: kept as it is, {recording.dataset} is not on this computer"
    if same:
        return f"{recording.store}: the same, keys renewed"
    again = f"`robot-perception store --only {recording.store}` stores what it is now"
    return f"{recording.store}: NOT the same; {again}"
