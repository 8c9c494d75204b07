"""Tones of skin that all people of these worlds share, from light to dark."""

import numpy as np

from data_synth.coloured.filming import linear

__all__ = ["SKINS"]

SKINS = linear(
    np.array(
        [
            (248, 217, 190),
            (238, 196, 160),
            (220, 172, 132),
            (190, 138, 100),
            (140, 92, 62),
            (92, 60, 44),
        ]
    )
    / 255
)
"""Shares of full light that skin gives back (6, 3)."""
