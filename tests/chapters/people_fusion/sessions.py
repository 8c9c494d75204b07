"""A session of people who stand still, written down by hand."""

from dataclasses import fields, replace

import numpy as np

from data_synth.people.staging import RIG, SENSORS
from robot_perception.book.people_fusion import HEARD
from robot_perception.book.people_sensors import Told
from tests.chapters.people_sensors.test_studies import recording

SPREAD = {"laser": (0.1, 0.05), "sonar": (0.3, 0.15), "camera": (2.0, 0.05)}


def session(people, duration=12.0, sees=("laser", "sonar", "camera")):
    """Return a session in which those who stand still are seen in each reading of some sensors.

    The laser sees those ahead, the sonars those within 2 m, the camera all, at 2 m.
    """
    people = np.array(people, float).reshape(-1, 2)
    rows = sorted(
        (float(time), sensor)
        for sensor, (rate, delay) in enumerate(zip(RIG.rates, RIG.delays, strict=True))
        for time in np.arange(delay, duration, 1 / rate)
    )
    parts = []
    for _, sensor in rows:
        name = SENSORS[sensor]
        heard = {
            "laser": np.abs(people[:, 1]) < np.pi / 2,
            "sonar": people[:, 0] < HEARD,
            "camera": people[:, 0] > 0,
        }[name] & (name in sees)
        found = people[heard]
        parts.append(np.c_[np.full(len(found), 2.0), found[:, 1]] if name == "camera" else found)
    only, n = recording(people, []), len(rows)
    spreads = [np.diag(SPREAD[SENSORS[sensor]]) ** 2 for _, sensor in rows]
    covs = [np.tile(one, (len(p), 1, 1)) for one, p in zip(spreads, parts, strict=True)]
    times, sensors = (np.array(column) for column in zip(*rows, strict=True))
    still = {f.name for f in fields(Told)} - {
        *("times", "sensors", "poses", "reckoned", "counts", "means", "covs", "judged", "skirt")
    }
    return replace(
        only,
        times=times,
        sensors=sensors,
        poses=np.zeros((n, 3)),
        reckoned=np.zeros((n, 3)),
        counts=np.array([len(part) for part in parts]),
        means=np.concatenate(parts),
        covs=np.concatenate(covs),
        judged=np.arange(n),
        **{name: np.repeat(getattr(only, name), n, axis=0) for name in still},
    )
