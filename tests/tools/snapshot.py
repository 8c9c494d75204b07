"""Explorers' snapshots: ``python -m tests.tools.snapshot [STEM …] [--write]``.

Computes what the explorers of chapters, of all without a name, say in all states, prints where it
differs from what ``tests/book/states`` records, and with ``--write`` records it.
"""

import argparse
import sys
from collections.abc import Sequence

from studies.stored.recorded_rows import processor
from tests.book import predicates, states
from tests.book.computing import COMPUTING, module


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare or record; return 1 if something differs and is not recorded."""
    parser = argparse.ArgumentParser(prog="python -m tests.tools.snapshot", description=__doc__)
    parser.add_argument("stems", nargs="*", metavar="STEM", help="chapters; all without a name")
    parser.add_argument("--write", action="store_true", help="record what is computed")
    options = parser.parse_args(arguments)
    if unknown := set(options.stems) - set(COMPUTING):
        parser.error(f"STEM: {', '.join(sorted(unknown))} is no chapter")
    failed = False
    for stem in options.stems or COMPUTING:
        before = states.recorded(stem)
        now = {
            name: states.described(explorer, states.computed(stem, name))
            for name, explorer in states.explorers(stem).items()
        }
        lines = _compared(before, now)
        print("\n".join([f"{stem}: {len(now)} explorers, {len(lines)} differences", *lines]))
        if options.write:
            states.FOLDER.mkdir(exist_ok=True)
            for name, said in now.items():
                said["finds"] = predicates.plain(
                    predicates.judged_of(module(stem), name, said).verdicts
                )
            file = states.FOLDER / f"{stem}.json"
            file.write_text(states.written(processor(), now), encoding="utf-8")
        else:
            failed |= bool(lines)
    return int(failed)


def _compared(before: dict, now: dict) -> list[str]:
    elsewhere = before["processor"] != processor()
    known = before["explorers"]
    lines = [f"  {name}: is no explorer any more" for name in known.keys() - now.keys()]
    for name, said in now.items():
        told = states.differences(known[name], said, elsewhere) if name in known else ["is new"]
        lines += [f"  {name}: {line}" for line in told]
    return lines


if __name__ == "__main__":
    sys.exit(main())
