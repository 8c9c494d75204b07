"""``robot-perception store``: compute rows, long runs and results of recordings anew."""

import click

from robot_perception.cli.workers import with_workers, working

DRAWN = 3
"""Trials of each combination of factors that are computed before a key is renewed."""
MOST = 30
"""Trials in all at most: where there are more combinations each has fewer, but one at least."""


@click.command()
@click.option("--chapter", "stems", multiple=True, help="Only this chapter; may be repeated.")
@click.option(
    "--only",
    "names",
    multiple=True,
    help="Only this stored result, or the rows of this study; may be repeated.",
)
@click.option("--keys", is_flag=True, help="Only renew the keys of results that are the stored.")
@click.option(
    "--anew", is_flag=True, help="Compute rows that are current as well, from the first trial on."
)
@click.option(
    "--prune", is_flag=True, help="Only remove what this computer has kept and not used for long."
)
@with_workers
def store(
    stems: tuple[str, ...],
    names: tuple[str, ...],
    keys: bool,
    anew: bool,
    prune: bool,
    workers: int | None,
    dask: str | None,
    ray: str | None,
) -> None:
    """Compute what the book has stored: rows of studies, long runs, results of real recordings.

    Rows whose code and trials have not changed stay; so do trials that this computer has computed
    before. After a change of code that should change no result, --keys leaves what is stored as it
    is and says which results have changed after all; of a study it computes a few trials of each
    combination of factors anew. What cannot be stored is named, and the others are.
    """
    if prune:
        click.echo(_prune())
        return
    from tqdm import tqdm

    from robot_perception import chapters
    from studies.trials import forget_anew

    try:
        stems = stems or chapters.CHAPTERS
        studies = chapters.trials(stems)
        found = (*chapters.recordings(stems), *chapters.states(stems))
        known = [*dict.fromkeys(_name(one) for one in (*studies, *found))]
        unknown = sorted(set(names) - set(known))
        if unknown:
            raise ValueError(f"no stored result {unknown[0]!r}; there are {', '.join(known)}")
        chosen = [one for one in (*studies, *found) if not names or _name(one) in names]
        failed = []
        with working(workers, dask, ray):
            for one in tqdm(chosen, desc="results", unit="result", disable=None):
                try:
                    click.echo(_stored(one, keys, anew))
                except (ValueError, OSError) as error:
                    click.echo(f"{_name(one)}: {error}")
                    failed.append(_name(one))
    except (ValueError, OSError) as error:
        raise click.ClickException(str(error)) from error
    if failed:
        raise click.ClickException(f"not stored: {', '.join(dict.fromkeys(failed))}")
    if anew:
        forget_anew()


def _prune() -> str:
    """Remove old results and trials of this computer; return what was done."""
    from studies.stored import results

    done = results.prune()
    removed = f"{done.removed} files removed, {done.removed_bytes / 1e6:.1f} MB"
    return f"{removed}; {done.left} left, {done.left_bytes / 1e6:.1f} MB"


def _name(one) -> str:
    """Return the name of a stored result: of rows, chapter and study."""
    return one.store if hasattr(one, "store") else f"{one.stem}.{one.name}"


def _stored(one, keys: bool, anew: bool) -> str:
    """Store rows or a result, or renew its keys; return what was done."""
    if hasattr(one, "replicates"):
        return _renew_rows(one) if keys else _record(one, anew)
    return _renew(one) if keys else _store(one)


def _current(stored) -> str:
    """Return that a result is of this code, and with which other packages it was computed."""
    others = stored.other_packages()
    return f"current, computed with {others}; --keys tries these" if others else "current"


def _record(study, anew: bool) -> str:
    """Record the rows of a study unless they are there; return what was done."""
    said = f"{_name(study)} ({study.changed or 'as declared'})"
    current = study.is_current()
    if current and not anew:
        return f"{said}: {_current(study)}"
    before = study.rows().table if current else None
    study.record(anew=anew)
    rows = study.rows()
    same = before is None or study.same(rows.table, before)
    words = "" if before is None else f", {'the same' if same else 'NOT the same'}"
    return f"{said}: recorded, {len(rows)} rows{words}"


def _renew_rows(study) -> str:
    """Renew the key of rows that this code gives, as some trials say; return what was done."""
    said = f"{_name(study)} ({study.changed or 'as declared'})"
    if study.is_current() and not study.other_packages():
        return f"{said}: current"
    chosen = drawn(study)
    lines = study.renew(chosen)
    if not lines:
        of = f"{len(chosen)} of {len(list(study.trials()))} trials drawn for this code"
        return f"{said}: the same in {of}, keys renewed"
    again = f"`robot-perception store --only {_name(study)}` records what it is now"
    return "\n".join([f"{said}: NOT the same; {again}", *lines])


def drawn(study) -> list[dict]:
    """Return trials of each combination of a study's factors, drawn by the hash of its code.

    Other code draws others. There are `DRAWN` of each combination where that makes no more than
    `MOST`; otherwise as many of each as do not, and one at least.
    """
    from random import Random

    combinations: dict[str, list[dict]] = {}
    for where in study.trials():
        factors = {name: level for name, level in where.items() if name != study.replicate}
        combinations.setdefault(repr(factors), []).append(where)
    random = Random(f"{_name(study)} {study.changed} {study.code()}")
    count = max(1, min(DRAWN, MOST // len(combinations)))
    return [
        where
        for trials in combinations.values()
        for where in random.sample(trials, min(count, len(trials)))
    ]


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

    if recording.is_current() and not recording.other_packages():
        return f"{recording.store}: current"
    try:
        same = recording.renew()
    except DatasetMissing:
        return f"{recording.store}: kept as it is, {recording.dataset} is not on this computer"
    if same:
        return f"{recording.store}: the same, keys renewed"
    again = f"`robot-perception store --only {recording.store}` stores what it is now"
    return f"{recording.store}: NOT the same; {again}"
