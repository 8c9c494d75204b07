"""Valid calls of `appearance`."""

from tests.hostile.calls import _appearance_shape

RESULTS = {*_appearance_shape.RESULTS}
CALLS = {**_appearance_shape.CALLS}
