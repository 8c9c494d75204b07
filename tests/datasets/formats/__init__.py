"""Every format that is read, declared as data: `tests.datasets.test_formats` has the laws."""

from tests.datasets.formats import (
    arrays,
    bags,
    calibrations,
    films,
    lasers,
    mrclam,
    pictures,
    stereo,
    tables,
    tracks,
)
from tests.datasets.formats.declared import Format

ROOMS = (arrays, bags, calibrations, films, lasers, mrclam, pictures, stereo, tables, tracks)
ALL: dict[str, Format] = {name: one for room in ROOMS for name, one in room.FORMATS.items()}
