"""Valid calls of `ceiling`."""

from tests.hostile.calls import _ceiling_patterns

PARTS = (_ceiling_patterns,)
CALLS = {thing: valid for part in PARTS for thing, valid in part.CALLS.items()}
