"""The tests; ``checked`` is the type checker that enforces shapes while they run.

It is beartype, except that an int may stand for a float.
"""

from beartype import BeartypeConf, beartype

checked = beartype(conf=BeartypeConf(is_pep484_tower=True))
