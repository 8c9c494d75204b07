"""More than five frames: what the rule of stable tracks does to the map."""

from dataclasses import dataclass, replace

import numpy as np

from robot_perception.chapters.visual_slam import drives, frontend, maps
from robot_perception.chapters.visual_slam.drives import Options
from robot_perception.chapters.visual_slam.frontend import Seen
from robot_perception.chapters.visual_slam.maps import OPTIONS, PAPER, Account
from robot_perception.evaluation.intervals import Interval, bootstrap_mean, bootstrap_ratio
from robot_perception.geometry import se3
from robot_perception.teaching.claims import Finding, Size, claim
from robot_perception.teaching.tables import Table
from robot_perception.teaching.verdicts import Accepted


@dataclass(frozen=True, slots=True)
class Config:
    """Rules by the least number of frames; paper: more than 5. 0 is no rule; ours: 1, 2, 10."""

    rules: tuple[int, ...] = (0, 2, 5, 10)
    seeds: int = 5
    options: Options = OPTIONS
    film: frontend.Config = frontend.PAPER


QUICK = Config((0, 5), 2, film=frontend.PAPER.first(120))


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """Accounts of all drives by rule."""

    config: Config
    drives: dict[int, Account]

    @property
    def smaller(self) -> Interval:
        """The map with the paper's rule over that without any."""
        return bootstrap_ratio(self.drives[5].landmarks, self.drives[0].landmarks, "landmarks")

    def table(self) -> Table:
        """Return size and error of the maps."""
        rows = {
            f"more than {rule}" if rule else "none": (
                bootstrap_mean(a.landmarks),
                bootstrap_mean(a.path, "m"),
                bootstrap_mean(a.wrong),
            )
            for rule, a in self.drives.items()
        }
        columns = {
            "landmarks": "in the map at the end",
            "ATE (m)": "root mean squared error of the position",
            "wrong": "tracks taken for the wrong landmark",
        }
        about = f"mean and 95 % bootstrap interval over {self.config.seeds} drives"
        return Table(rows, columns, about, "frames")


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Drive with each rule, on the same wheels."""
    variants = {str(rule): replace(config.options, stable=rule) for rule in config.rules}
    found = maps.compare(variants, config.film, config.seeds, rng=rng)
    return Result(config, {int(name): account for name, account in found.items()})


@claim(
    "stable-landmarks",
    paper=PAPER,
    place="§5",
    basis="substitute",
    statement="With only those points in the map that were tracked for more than five frames, it "
    "holds far fewer landmarks.",
    paper_value="about 1500, against about 100 000 of Sim et al. (2005)",
    method="The rendered drive with ten particles: landmarks with the rule over those without.",
    accepted=Accepted(0.0, 0.5, "at most half as many", "our choice"),
    seed=45,
)
def stable_landmarks(size: Size, rng: np.random.Generator) -> Finding:
    """Count the landmarks with and without the rule."""
    result = run(Config() if size is Size.FULL else QUICK, rng=rng)
    five, none = result.drives[5], result.drives[0]
    return Finding(
        result.smaller,
        {
            "landmarks with the rule": bootstrap_mean(five.landmarks),
            "landmarks without": bootstrap_mean(none.landmarks),
            "ATE, with over without": bootstrap_ratio(five.path, none.path),
        },
        {"rules": result.table()},
        note=f"{five.landmarks.mean():.0f} landmarks in place of {none.landmarks.mean():.0f}.",
    )


@stable_landmarks.sabotage("only points that stay in sight for more than five frames")
def lasting_points(size: Size, rng: np.random.Generator) -> Finding:
    """Leave out all other points beforehand, so that the rule has nothing to do."""
    seen = lasting(frontend.seen(QUICK.film), 5)
    sizes = {0: [], 5: []}
    for own in rng.spawn(2):
        wheel, *streams = own.spawn(3)
        report = drives.roll(seen.poses, rng=wheel)
        for rule, stream in zip(sizes, streams, strict=True):
            options = replace(OPTIONS, stable=rule)
            sizes[rule].append(len(drives.run(seen, options, report, rng=stream).places))
    return Finding(bootstrap_ratio(np.array(sizes[5], float), np.array(sizes[0], float)))


DEEP = 0.1
"""A depth is wrong where it errs by more than this share; ours."""


def wrong_depths(seen: Seen) -> tuple[float, float]:
    """Return the share of wrong depths among points of one frame, and among stable tracks."""
    T = se3.compose(se3.from_se2(seen.poses), frontend.RIG.T_robot_camera)[seen.frames]
    depths = np.einsum("ni,ni->n", T[:, :3, 2], seen.places - T[:, :3, 3])
    wrong = np.abs(seen.points[:, 2] / depths - 1) > DEEP
    lengths = np.bincount(seen.tracks)[seen.tracks]
    return float(wrong[lengths == 1].mean()), float(wrong[lengths > OPTIONS.stable].mean())


def lasting(seen: Seen, frames: int) -> Seen:
    """Return the points whose tracks last for more than so many frames, now or later."""
    lengths = np.bincount(seen.tracks)
    numbers = np.cumsum(lengths > frames) - 1  # tracks are numbered without gaps
    kept = lengths[seen.tracks] > frames
    return Seen(
        seen.poses,
        seen.frames[kept],
        numbers[seen.tracks[kept]],
        seen.pixels[kept],
        seen.points[kept],
        seen.covs[kept],
        seen.descriptors[kept],
        seen.places[kept],
        seen.carriers[kept],
    )
