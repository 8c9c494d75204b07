"""NEES and trajectory errors of your own run: python judge.py ESTIMATE TRUTH"""

from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np

from robot_perception.datasets import (
    SpaceTrack,
    Track,
    is_bag,
    read_space_track,
    read_track,
    track_format,
)
from robot_perception.evaluation import spatial, trajectories
from robot_perception.evaluation.consistency import average_bounds, coverage, normalised_squared
from robot_perception.geometry import wrap_angle
from robot_perception.scripts import Clocks, Recording, for_each, installed, script, tell

with installed():
    import click

GAP = 0.5  # longest gap of the truth that is bridged, s
NEAR = 0.01  # largest difference of two times that are one, in space, s
DISTANCE = 1.0  # over which relative errors are taken, m
TRACK = (
    "CSV with columns time_s,x_m,y_m,heading_rad; or in space TUM, KITTI, EuRoC, CSV with columns"
    " time_s,x_m,y_m,z_m,qx,qy,qz,qw; or a ROS bag."
)
TRUTH = "The same of the truth, in the form of ESTIMATE or another."
FREE = "In space: what of the estimate is free, nothing (the default), its frame, its scale, too."
BETWEEN = "In space: take the truth between its poses, not the pose that is nearest in time."


def say(what: str, measured: Callable[[], str]) -> None:
    """Print a measure, or why this run has none: it is too short, or does not turn."""
    try:
        print(f"{what}: {measured()}")
    except ValueError as error:
        print(f"{what}: none ({error})")


def relative(how: ModuleType, poses: np.ndarray, true: np.ndarray) -> str:
    """How far off a motion over some distance is, wherever it begins."""
    errors = how.relative_error_over(poses, true, DISTANCE)
    return f"{errors.translation_rms:.3f} m, {np.rad2deg(errors.rotation_rms):.2f} deg"


def in_plane(estimate: Track, truth: Track) -> None:
    """Errors of x, y and heading, and whether the covariances fit them."""
    true, covered = truth.at(estimate.times, longest_gap=GAP)
    print(f"poses: {len(covered)}, covered by the truth: {covered.sum()}")
    poses, true = estimate.poses[covered], true[covered]
    print(f"ATE: {trajectories.absolute_error(poses, true, aligned=False):.3f} m")
    say("ATE after alignment", lambda: f"{trajectories.absolute_error(poses, true, True):.3f} m")
    say(f"relative error over {DISTANCE:g} m", lambda: relative(trajectories, poses, true))
    end = trajectories.end_error(poses, true)
    print(f"at the end: {end.position:.3f} m, {np.rad2deg(end.heading):.1f} deg")
    say("NEES", lambda: consistency(estimate, true, covered))


def consistency(estimate: Track, truth: np.ndarray, covered: np.ndarray) -> str:
    """What the NEES says, in four lines."""
    if estimate.covs is None:
        raise ValueError("it needs covariances, which this file does not hold")
    error = estimate.poses[covered] - truth
    error[:, 2] = wrap_angle(error[:, 2])
    nees = normalised_squared(error, estimate.covs[covered])
    inside = coverage(nees[None], 3, independent=1).single_share
    told = [f"{nees.mean():.2f} on average, 3 if the filter is consistent;"]
    for count, what in ((1, "all errors are one"), (len(nees), "errors are independent")):
        told.append("  by chance {:.2f} to {:.2f} if {}".format(*average_bounds(3, count), what))
    return "\n".join([*told, f"  {inside:.1%} of the poses lie inside their 95 % region"])


def together(
    estimate: SpaceTrack, truth: SpaceTrack, files: tuple[Path, Path], between: bool
) -> tuple[np.ndarray, np.ndarray, list[Path]]:
    """Poses in space at the same times, or in the same order; and which files have no times."""
    estimate_file, truth_file = files
    poses, true = estimate.poses, truth.poses
    untimed = [f for f, t in ((estimate_file, estimate), (truth_file, truth)) if t.times is None]
    if untimed:
        if len(poses) != len(true):
            told = f"{estimate_file} has {len(poses)} poses and {truth_file} {len(true)}"
            raise ValueError(f"without times there must be as many poses in both, {told}")
    elif between:
        true, covered = truth.at(estimate.times, longest_gap=GAP)
        poses, true = poses[covered], true[covered]
    else:
        first, second = spatial.associate(estimate.times, truth.times, NEAR).T
        poses, true = poses[first], true[second]
    print(f"poses: {len(estimate)}, of the truth: {len(truth)}, together: {len(poses)}")
    if not len(poses):
        helps = not between and truth.at(estimate.times, longest_gap=GAP)[1].any()
        raise ValueError(
            f"no pose of {estimate_file} is at the time of one of {truth_file}, to {NEAR:g} s"
            + (
                "; --interpolate takes what lies between two"
                if helps
                else f", nor between two that are at most {GAP:g} s apart (NEAR, GAP)"
            )
        )
    return poses, true, untimed


def in_space(estimate: SpaceTrack, truth: SpaceTrack, alignment: str, files, between) -> None:
    """Errors of positions and rotations, as evo has them."""
    poses, true, untimed = together(estimate, truth, files, between)
    poses, found = spatial.align_poses(poses, true, alignment)
    print(f"alignment: {alignment}, scale {found.scale:.4f}")
    print(f"ATE: {spatial.absolute_error(poses[:, :3, 3], true[:, :3, 3]):.3f} m")
    last = spatial.absolute_error(poses[-1:, :3, 3], true[-1:, :3, 3])
    say(f"relative error over {DISTANCE:g} m", lambda: relative(spatial, poses, true))
    print(f"at the end: {last:.3f} m")
    if untimed:
        print(f"poses were paired by their order: no times in {' and '.join(map(str, untimed))}")


@script
@click.argument("estimate", type=Recording(TRACK))
@click.argument("truth", type=Recording(TRUTH))
@click.option("--align", type=click.Choice(spatial.ALIGNMENTS), default="none", help=FREE)
@click.option("--interpolate", is_flag=True, help=BETWEEN)
def main(estimate, truth, align, interpolate, topic, time_unit):
    """Errors of your own run: CSV with headings in the plane; TUM, KITTI and EuRoC in space."""
    files, topics = (estimate, truth), for_each("--topic", topic, 2)
    kinds = {track_format(file, topic=of): file for file, of in zip(files, topics, strict=True)}
    if is_bag(estimate) and estimate == truth and topics[0] == topics[1]:
        raise ValueError(f"{truth} would be judged by itself: --topic for the estimate, then truth")
    flat, clocks = kinds.get("plane"), Clocks(time_unit, *files)
    if flat and (align != "none" or interpolate):
        raise ValueError(f"{flat} is in the plane: --align and --interpolate are of space")
    for kind, file in kinds.items():
        if flat and kind != "plane":
            print(f"in the plane, as {flat}: heights and tilts of {file} are left out")
    read = read_track if flat else read_space_track
    both = [tell(clocks.read(read, file, topic=of)) for file, of in zip(files, topics, strict=True)]
    if all(track.times is not None for track in both):
        clocks.check(*zip(files, (track.times for track in both), strict=True))
    if flat:
        in_plane(*both)
    else:
        in_space(*both, align, files, interpolate)


if __name__ == "__main__":
    main()
