"""``robot-perception register``: write down what claims measure before their rows exist."""

import click


@click.command()
@click.option("--claim", "ids", multiple=True, required=True, help="This claim; may be repeated.")
@click.option("--remark", required=True, help="Why it is registered, in a few words.")
@click.option(
    "--same", is_flag=True, help="The same by other code: rows give the recorded value and verdict."
)
def register(ids: tuple[str, ...], remark: str, same: bool) -> None:
    """Append claims to the list of registrations: words, measure, replicates, sabotage, range.

    A claim whose words or measure have changed since its rows were seen needs new replicates: what
    shares some with an earlier registration is refused.
    """
    from robot_perception import chapters
    from robot_perception.teaching import registration
    from robot_perception.teaching.badges import recorded
    from robot_perception.teaching.ledger import agrees
    from robot_perception.teaching.locks import changing

    declared = {claim.id: claim for claim in chapters.claims()}
    unknown = sorted(set(ids) - declared.keys())
    if unknown:
        raise click.ClickException(f"no claim {unknown[0]!r}; there are {', '.join(declared)}")
    try:
        other = [name for name in ids if same and not agrees(declared[name], recorded()[name])]
        if other:
            raise ValueError(f"{other[0]} is not the same: its rows give another value or verdict")
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
