"""Checks of readings of distances."""

import numpy as np


def check_readings(name: str, ranges: np.ndarray) -> None:
    """Raise ``ValueError`` unless there are readings, each positive; infinite ones may be there."""
    if not ranges.size:
        raise ValueError(f"{name} must be one reading at least, got {ranges.shape}")
    bad = np.count_nonzero(~(ranges > 0))
    if bad:
        raise ValueError(f"{name} must be positive, got {bad} of {ranges.size} NaN or not above 0")
