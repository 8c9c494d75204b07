"""What tests of more than one chapter do with drives."""

import numpy as np


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
