"""``robot-perception register``: write down what claims measure before their rows exist."""

from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    from studies.claims import Claim
    from studies.ledger import Ledger


@click.command()
@click.option("--claim", "ids", multiple=True, required=True, help="This claim; may be repeated.")
@click.option("--remark", required=True, help="Why it is registered, in a few words.")
@click.option(
    "--same", is_flag=True, help="The same by other code: rows give the recorded value and verdict."
)
def register(ids: tuple[str, ...], remark: str, same: bool) -> None:
    """Append claims to the list of registrations: words, measure, replicates, trial and world.

    A claim of which one of these has changed since its rows were seen needs new replicates: what
    shares some with an earlier registration is refused. With --same it keeps its number: rows of
    this code must give the recorded value and verdict, and its sabotages theirs.
    """
    from robot_perception import chapters
    from robot_perception.teaching.scores.badges import recorded
    from studies import registration
    from studies.stored.locks import changing

    declared = {claim.id: claim for claim in chapters.claims()}
    unknown = sorted(set(ids) - declared.keys())
    if unknown:
        raise click.ClickException(f"no claim {unknown[0]!r}; there are {', '.join(declared)}")
    try:
        for name in ids if same else ():
            _refuse_another(declared[name], recorded())
        with changing(registration.file()):
            before = registration.read()
            made = [registration.anew(declared[name], before, remark, same=same) for name in ids]
            every = [*before, *made]
            refused = set(registration.reused(every)) - set(registration.reused(before))
            if refused:
                raise ValueError(f"{'; '.join(sorted(refused))}: draw new replicates")
            registration.write(every)
    except (ValueError, OSError) as error:
        raise click.ClickException(str(error)) from error
    for one in made:
        click.echo(f"{one.claim}: registration {one.number}, {one.replicates}")


def _refuse_another(claim: "Claim", recorded: "Ledger") -> None:
    """Raise ``ValueError`` unless rows of this code give what is recorded, of sabotages too."""
    from studies.ledger import agrees

    for study in (claim.study, *(change.study for change in claim.sabotages)):
        if not study.is_current():
            name = f"{study.stem}.{study.name}"
            raise ValueError(
                f"{claim.id}: rows of {name} ({study.changed or 'as declared'}) are of other code, "
                f"so nothing says that it is the same: `robot-perception store --only {name}`, "
                "with --keys where no number should have changed"
            )
    if not agrees(claim, recorded[claim.id]):
        raise ValueError(
            f"{claim.id} is not the same: its rows, or those of a sabotage, give another value or "
            "verdict"
        )
