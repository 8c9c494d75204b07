"""What tests of more than one chapter do with drives."""

from functools import cache

import numpy as np

from robot_perception.book import visual_slam as slam


@cache
def begun(frames=120):
    """Return what was seen on the beginning of the drive that is shown."""
    whole = slam.seen_in()
    rows = whole.frames < frames
    return slam.Seen(whole.poses[:frames], *(column[rows] for column in whole[1:]))


def ages(seen):
    """Return for each point in how many frames its track was seen by then."""
    counts, found = {}, []
    for track in seen.tracks.tolist():
        counts[track] = counts.get(track, 0) + 1
        found.append(counts[track])
    return np.array(found)


def asked_of(monkeypatch, module):
    """Let a trial tell with which options it drives, and by what it asks; nobody drives."""
    seen = []

    def driven(seed, building, draw, options, ask=None, **more):
        seen.append((options, ask, more))
        return {"path": 1.0}

    monkeypatch.setattr(module, "driven", driven)
    return seen
