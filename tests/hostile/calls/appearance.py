"""Valid calls of `appearance`."""

from tests.hostile.calls import _appearance_colour, _appearance_shape

RESULTS = {*_appearance_colour.RESULTS, *_appearance_shape.RESULTS}
CALLS = {**_appearance_colour.CALLS, **_appearance_shape.CALLS}
