"""``robot-perception claims``: print the recorded ledger, or compute and record claims."""

import platform
import traceback
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import click

from robot_perception.cli.workers import with_workers, working

if TYPE_CHECKING:
    from studies.claims import Claim
    from studies.ledger import Entry, Ledger


@click.command()
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of a table.")
@click.option("--run", is_flag=True, help="Compute the claims instead of printing the record.")
@click.option("--chapter", "stems", multiple=True, help="Only this chapter; may be repeated.")
@click.option("--claim", "ids", multiple=True, help="Only this claim; may be repeated.")
@click.option(
    "--write",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Record what was computed in this file, rows that are missing as well; entries of other "
    "claims stay as they are.",
)
@click.option("--withdraw", help="Keep this scored claim among the withdrawn; with --why, --write.")
@click.option("--why", default="", help="Why it is withdrawn, in a sentence.")
@click.option("--instead", default="", help="The claim that took its place.")
@with_workers
def claims(
    as_json: bool,
    run: bool,
    stems: tuple[str, ...],
    ids: tuple[str, ...],
    write: Path | None,
    withdraw: str | None,
    why: str,
    instead: str,
    workers: int | None,
    dask: str | None,
    ray: str | None,
) -> None:
    """Print the claim ledger: what each paper says, what we find, and the verdict."""
    from robot_perception.teaching.scores.badges import as_text

    if write is not None and not run and withdraw is None:
        raise click.UsageError("--write records what is computed: say --run")
    if write is not None and not write.parent.is_dir():
        raise click.UsageError(f"--write: there is no folder {write.parent}")
    try:
        if withdraw is not None:
            click.echo(_withdrawn(withdraw, why, instead, write))
            return
        chosen = _chosen(stems, ids)
        before = _recorded(write)
        if write is not None:
            before.merged((), _order())  # before anything dear is computed
    except (ValueError, OSError) as error:
        raise click.ClickException(str(error)) from error
    failed: list[str] = []
    if run:
        with working(workers, dask, ray):
            ledger, failed = _computed(chosen, write)
    else:
        names = {claim.id for claim in chosen}
        gone = () if stems or ids else before.withdrawn
        ledger = type(before)(tuple(e for e in before.entries if e.id in names), gone)
    click.echo(ledger.to_json().encode() if as_json else as_text(ledger))
    if failed:
        raise click.ClickException(
            f"{len(failed)} claims could not be computed: {', '.join(failed)}"
        )


def _chosen(stems: tuple[str, ...], ids: tuple[str, ...]) -> tuple["Claim", ...]:
    """Return the claims of some chapters, or those of some identifiers."""
    from robot_perception import chapters

    declared = chapters.claims(stems or chapters.CHAPTERS)
    unknown = sorted(set(ids) - {claim.id for claim in declared})
    if unknown:
        raise ValueError(
            f"no claim {', '.join(map(repr, unknown))}; there are "
            f"{', '.join(claim.id for claim in declared)}"
        )
    return tuple(claim for claim in declared if not ids or claim.id in ids)


def _recorded(file: Path | None) -> "Ledger":
    """Return the ledger of a file that is to be written, an empty one if it is new."""
    from studies.ledger import Ledger
    from studies.records import records

    if file is None:
        return Ledger.read(records() / "claims.json")
    return Ledger.read(file) if file.exists() else Ledger(())


def _computed(chosen: tuple["Claim", ...], write: Path | None) -> tuple["Ledger", list[str]]:
    """Compute claims, one after the other; each is written as soon as it is there."""
    from tqdm import tqdm

    from studies.ledger import Ledger, entry, record

    made: list[Entry] = []
    failed: list[str] = []
    bar = tqdm(chosen, desc="claims", unit="claim", disable=None)
    for claim in bar:
        bar.set_postfix_str(claim.id)
        try:
            if write is None:
                made.append(entry(claim, claim.find()))
                continue
            _with_rows(claim)
            made.append(record(claim, versions=_versions()))
            _write(made[-1], write)
        except Exception as error:  # one claim that fails must not lose the others
            click.echo("".join(traceback.format_exception(error)), err=True)
            failed.append(claim.id)
    return Ledger(tuple(made)), failed


def _write(made: "Entry", file: Path) -> None:
    """Put an entry in its place in a ledger, which others may have written meanwhile."""
    from studies.stored.locks import changing

    with changing(file):
        _recorded(file).merged([made], _order()).write(file)


def _order() -> list[str]:
    """Return the identifiers of all declared claims in the order of the book."""
    from robot_perception import chapters

    return [claim.id for claim in chapters.claims()]


def _withdrawn(name: str, why: str, instead: str, file: Path | None) -> str:
    """Put a scored claim among the withdrawn of a ledger; return what was done.

    Raises
    ------
    ValueError
        If it was not scored, is still declared, or it is not said why.
    """
    from datetime import date

    from studies.stored.locks import changing

    if file is None or not file.exists():
        raise ValueError("--withdraw changes a ledger: name its file by --write")
    if name in _order():
        raise ValueError(f"{name} is still declared: take it out of its chapter first")
    with changing(file):
        ledger = _recorded(file)
        known = [entry.id for entry in ledger.entries]
        if name not in known:
            raise ValueError(f"no scored claim {name!r}; there are {', '.join(known)}")
        today = date.today().isoformat()
        ledger.withdrawing(name, why=why, instead=instead, day=today).write(file)
    return f"{name}: withdrawn on {today}"


def _with_rows(claim: "Claim") -> None:
    """Record the rows of a claim and of its sabotages where they are missing or of other code.

    Raises
    ------
    ValueError
        If the claim is not registered as it is declared.
    """
    from studies import registration

    own = registration.of(registration.read(), claim.id)
    if not own or registration.changed(own[-1], claim):
        what = f" (other {registration.changed(own[-1], claim)})" if own else ""
        raise ValueError(
            f"{claim.id} is not registered as it is declared{what}: `robot-perception register "
            f"--claim {claim.id} --remark …` before its rows exist"
        )
    for study in (claim.study, *(change.study for change in claim.sabotages)):
        if not study.is_current():
            study.record()


def _versions() -> str:
    """Return what computes the numbers, the BLAS kernel included, which picks their last digits."""
    from threadpoolctl import threadpool_info

    names = ("robot-perception", "numpy", "scipy", "numba", "opencv-python-headless")
    blas = {f"{i['internal_api']} {i.get('architecture', '')}".strip() for i in threadpool_info()}
    parts = [f"python {platform.python_version()}", *(f"{name} {version(name)}" for name in names)]
    return ", ".join([*parts, *sorted(blas)])
