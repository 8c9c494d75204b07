"""Valid calls of `appearance`."""

from tests.hostile.calls import _appearance_colour, _appearance_shape, _appearance_tracking

PARTS = (_appearance_colour, _appearance_shape, _appearance_tracking)
CALLS = {thing: valid for part in PARTS for thing, valid in part.CALLS.items()}
