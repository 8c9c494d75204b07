"""Studies: data and one function, run once, and the claims that stand on what they give.

.. code-block:: python

    fig4 = Study(run, full=Config(runs=100), quick=Config(runs=20), seed=4)

    @fig4.claim("gain-vanishes", paper=PAPER, place="§2.2, Fig. 4", basis="mathematics",
                statement="…", method="…", accepted=Accepted(0.3819, 0.3820, "the pole 1/φ² …"),
                sabotage=Change("a landmark that wanders", walk=0.1))
    def gain_vanishes(result: Result) -> Finding: ...

``run(config, *, rng)`` computes; a study knows its configuration at the full size, which is
recorded, and at the quick one, which the tests compute, and its seed. Its result is kept
(:mod:`.results`), so that notebook, explorer, claim, sabotage and test share it. The decorated
function says what a result shows and becomes a :class:`.claims.Claim`; a sabotage is another
configuration of the same study, or another function that runs it, and its value is computed by the
same code.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, Generic, TypeVar

import numpy as np

from robot_perception.teaching.claims import Claim, Finding, Size, chapter_of
from robot_perception.teaching.results import keep, told

Config = TypeVar("Config")
Result = TypeVar("Result")

IN_MEMORY = 64
"""So many results of all studies stay in the memory of a process."""


class Change:
    """What a sabotage changes in a study, at its quick size.

    Parameters
    ----------
    text
        What was changed, in words that complete "The same with …".
    run
        A function that runs the study in another way; that of the study if none is given.
    config
        The whole configuration; that of the study's quick size if none is given.
    **fields
        Fields of the configuration and their other values.
    """

    def __init__(
        self, text: str, run: Callable[..., Any] | None = None, *, config: Any = None, **fields: Any
    ) -> None:
        self.text, self.run, self.config, self.fields = text, run, config, fields


@dataclass(frozen=True, slots=True, eq=False)
class Study(Generic[Config, Result]):
    """A function and the configurations that it is run with.

    Parameters
    ----------
    run
        Function of a configuration and ``rng`` that always gives the same for the same draws.
    full, quick
        The configurations of both sizes: a frozen dataclass, a number, a text, or a tuple of them.
    seed
        Of the generator of each run.
    """

    run: Callable[..., Result]
    full: Config
    quick: Config
    seed: int = 0

    def result(self, size: Size | str = Size.FULL, change: Change | None = None) -> Result:
        """Return what the study gives at a size, with a change if there is one; computed once."""
        run, config = self.run, getattr(self, Size(size))
        if change is not None:
            run = change.run or run
            config = config if change.config is None else change.config
            config = replace(config, **change.fields) if change.fields else config
        told(config)
        return _computed(run, config, self.seed)

    def claim(
        self, id: str, *, sabotage: Change | Sequence[Change] = (), **words: Any
    ) -> Callable[[Callable[..., Finding]], Claim]:
        """Declare a claim on the function that says what a result shows of it.

        The chapter is the package below ``chapters`` of the function.

        Parameters
        ----------
        id
            Identifier of the claim.
        sabotage
            What makes its statement false, or true where it fails.
        **words
            The other fields of `Claim`.

        Raises
        ------
        ValueError
            If the basis is unknown, a text that a reader needs is empty, or the function is
            outside the chapters.
        """
        changes = (sabotage,) if isinstance(sabotage, Change) else tuple(sabotage)

        def declare(finding: Callable[..., Finding]) -> Claim:
            chapter = chapter_of(id, finding)
            own = {"study": self, "compute": finding, "sabotages": changes}
            return Claim(id=id, chapter=chapter, **own, **words)

        return declare


@lru_cache(maxsize=IN_MEMORY)
def _computed(run: Callable[..., Any], config: Any, seed: int) -> Any:
    return keep(run, (config, seed), lambda: run(config, rng=np.random.default_rng(seed)))
