"""Coloured things that move in changing light, with their true outlines.

They stand in for the film of a perception paper that is not to be had: circles that change colour,
a rectangle that revolves about a lamp, a beetle, a snail and a head. All images have 320 × 240
pixels, red, green and blue of 8 bits.
"""

from data_synth.coloured.beetles import beetle
from data_synth.coloured.discs import circles
from data_synth.coloured.heads import HeadScene, head
from data_synth.coloured.lamp import rectangle
from data_synth.coloured.sequences import Camera, HeadSequence, LampSequence, Sequence
from data_synth.coloured.snails import snail

__all__ = [
    "Camera",
    "HeadScene",
    "HeadSequence",
    "LampSequence",
    "Sequence",
    "beetle",
    "circles",
    "head",
    "rectangle",
    "snail",
]
