"""NEES and trajectory errors of your own run: python judge.py ESTIMATE TRUTH"""

import numpy as np

from robot_perception.datasets import read_track
from robot_perception.evaluation.consistency import average_bounds, coverage, normalised_squared
from robot_perception.evaluation.trajectories import absolute_error, end_error, relative_error_over
from robot_perception.extras import needing
from robot_perception.geometry import wrap_angle
from robot_perception.scripts import Recording, script

with needing():
    import click

GAP = 0.5  # longest gap of the truth that is bridged, s
DISTANCE = 1.0  # over which relative errors are taken, m


@script
@click.argument("estimate", type=Recording())
@click.argument("truth", type=Recording())
def main(estimate, truth):
    """NEES and trajectory errors of your own run."""
    estimate = read_track(estimate)
    truth, covered = read_track(truth).at(estimate.times, longest_gap=GAP)
    print(f"poses: {len(covered)}, covered by the truth: {covered.sum()}")
    poses, truth = estimate.poses[covered], truth[covered]
    end, relative = end_error(poses, truth), relative_error_over(poses, truth, DISTANCE)
    print(f"ATE: {absolute_error(poses, truth, aligned=False):.3f} m")
    print(f"ATE after alignment: {absolute_error(poses, truth, aligned=True):.3f} m")
    print(f"relative error over {DISTANCE:g} m: {relative.translation_rms:.3f} m")
    print(f"at the end: {end.position:.3f} m, {np.rad2deg(end.heading):.1f} deg")
    if estimate.covs is None:
        print("NEES: needs covariances, which this file does not hold")
        return
    error = poses - truth
    error[:, 2] = wrap_angle(error[:, 2])
    nees = normalised_squared(error, estimate.covs[covered])
    inside = coverage(nees[None], 3, independent=1).single_share
    print(f"NEES: {nees.mean():.2f} on average, 3 if the filter is consistent;")
    for count, what in ((1, "all errors are one"), (len(nees), "errors are independent")):
        print("  by chance {:.2f} to {:.2f} if {}".format(*average_bounds(3, count), what))
    print(f"  {inside:.1%} of the poses lie inside their 95 % region")


if __name__ == "__main__":
    main()
