"""A drive through a synthetic office, its walls and their search range: Fig. 1 of the paper."""

from dataclasses import dataclass, field
from time import perf_counter

import numpy as np
from jaxtyping import Bool, Float, Int
from scipy.spatial import KDTree
from scipy.special import ndtri

from data_synth.laser import Scanner, Scans, scan
from data_synth.office import Office, drive, make_office
from robot_perception import walls
from robot_perception.evaluation.consistency import normalised_squared
from robot_perception.evaluation.intervals import Interval, mean, spread
from robot_perception.evaluation.sweep import sweep
from robot_perception.geometry import act
from robot_perception.teaching.claims import Finding
from robot_perception.teaching.ledger import Entry
from robot_perception.teaching.recorded import recorded
from robot_perception.teaching.results import kept
from robot_perception.teaching.studies import Change, Study
from robot_perception.teaching.tables import Table


@dataclass(frozen=True, slots=True)
class Config:
    """One drive through a synthetic office. The paper gives none of these values: all are ours.

    Rooms on each side of the corridor and pieces of furniture tried in each; a scanner of 361 beams
    over half a turn, with noise of 1.5 cm and readings in steps of 1 cm, which is the noise of the
    extraction; fewest scans in which a wall must be seen, and distance between scans, m.
    """

    rooms: int = 4
    furniture: int = 2
    scanner: Scanner = field(default_factory=Scanner)
    extraction: walls.Extraction = field(
        default_factory=lambda: walls.Extraction(walls.RangeNoise(0.0155))
    )
    gate: walls.Gate = field(default_factory=walls.Gate)
    least_scans: int = 3
    step: float = 0.25


@dataclass(frozen=True, eq=False, slots=True)
class Result:
    """A drive, the walls seen in enough scans, and how they agree with the floor plan.

    ``report`` says what became of all readings, ``seen`` which samples of the faces they reached,
    ``seconds`` how long this machine took to make the map.
    """

    config: Config
    office: Office
    poses: Float[np.ndarray, "scans 3"]
    scans: Scans
    found: walls.WallMap
    report: walls.ScanReport
    seen: Bool[np.ndarray, " samples"]
    score: walls.MapScore
    seconds: float

    @property
    def points(self) -> Float[np.ndarray, "readings 2"]:
        """All readings in the frame of the world, m."""
        return world_points(self.scans.ranges, self.config.scanner.angles, self.poses)


def run(config: Config, *, rng: np.random.Generator) -> Result:
    """Drive through an office, map its walls with known poses, and compare them with the plan."""
    office = make_office(rng=rng, rooms=config.rooms, furniture=config.furniture)
    poses = drive(office, step=config.step)
    scans = scan(office.faces, poses, config.scanner, rng=rng)
    angles = config.scanner.angles
    begin = perf_counter()
    found, report = walls.build_map(scans.ranges, angles, poses, config.extraction, config.gate)
    seconds = perf_counter() - begin
    found = found.seen_in(config.least_scans)
    seen = _reached(office, poses, scans, config.scanner)
    score = walls.score_map(found, office.faces, seen)
    return Result(config, office, poses, scans, found, report, seen, score, seconds)


@kept
def office_run() -> Result:
    """Return the chapter's drive; it is run once."""
    return run(Config(), rng=np.random.default_rng(1))


def setup() -> Table:
    """Return what the paper says about its experiment, what we take, and which of it matters."""
    config, gate = Config(), Config().gate
    scanner, tolerance = config.scanner, config.extraction.tolerance
    sigma = config.extraction.noise.range_sigma
    beams = f"simulated, {scanner.beams} beams over half a turn, up to {scanner.max_range:g} m"
    noise = f"{100 * scanner.range_sigma:g} cm, and steps of {100 * scanner.resolution:g} cm"
    gated = f"{gate.probability:.0%} of χ², walls rough by {100 * gate.roughness:g} cm and "
    gated += f"{np.rad2deg(gate.roughness_angle):g}°"
    rows = {
        "scanner": ("Leuze Rotoscan RS4", beams, "not varied here"),
        "noise σ of a range": ("not given", noise, "yes: it sets the least ε"),
        "tolerance ε": (
            "not given",
            f"{100 * tolerance:g} cm, or {tolerance / sigma:.0f}σ",
            "not between noise and furniture",
        ),
        "search range": ("drawn in Fig. 1a", gated, "yes: see “Break it”"),
        "scans that show a wall": (
            "“consecutive readings”",
            f"{config.least_scans} at least",
            "little: see the map of the office",
        ),
        "poses": ("estimated", "known exactly", "yes: see “Break it”"),
    }
    columns = {"the paper": "", "ours": "", "does it matter?": ""}
    return Table(rows, columns, corner="the experiment")


def scores(drive: Result, recorded: Entry) -> Table:
    """Return how the map of one drive agrees with its plan, and how those of ``walls-fig1`` do."""
    score, others = drive.score, recorded.evidence
    ours = [100 * (1 - score.precision), 100 * (1 - score.recall), 1e3 * score.rms_offset]
    theirs = [
        _missing(recorded.value),
        _missing(others["recall of the faces the beams reached"]),
        others["offset of a wall, rms"],
    ]
    rows = {
        "this office": [len(drive.found), *ours, np.rad2deg(score.rms_angle)],
        "twenty offices": [others["walls in the map"], *theirs, others["direction of a wall, rms"]],
    }
    columns = {
        "walls": "in the map; of the twenty, the median and the range of nineteen",
        "not real (%)": "share of the map's length that lies on no face of the floor plan, within "
        "5 cm and 5°",
        "missed (%)": "share of the length of the faces that beams reached that is not in the map",
        "offset (mm)": "root mean square distance of a wall from its face",
        "turn (°)": "root mean square difference of direction",
    }
    return Table(rows, columns, "mean and 95 % interval over offices", "map of")


def _missing(share: Interval) -> Interval:
    """Return what a share leaves, in per cent."""
    return Interval(*(100 * (1 - end) for end in (share.estimate, share.high, share.low)))


def world_points(
    ranges: Float[np.ndarray, "scans beams"],
    angles: Float[np.ndarray, " beams"],
    poses: Float[np.ndarray, "scans 3"],
) -> Float[np.ndarray, "readings 2"]:
    """Return the readings that came back, in the frame of the world, m."""
    valid = np.isfinite(ranges)
    return act(poses, walls.to_points(np.where(valid, ranges, 0.0), angles))[valid]


def _reached(office: Office, poses: np.ndarray, scans: Scans, scanner: Scanner) -> np.ndarray:
    """Samples of the faces with at least ten beams on the face within 10 cm."""
    true = np.where(np.isfinite(scans.ranges), scans.true_ranges, np.inf)
    hits, faces = world_points(true, scanner.angles, poses), scans.faces[np.isfinite(true)]
    samples, owner = walls.sample_faces(office.faces)
    beams = KDTree(np.c_[hits, faces])  # faces are 1 apart: none is near another
    return beams.query_ball_point(np.c_[samples, owner], 0.1, return_length=True) >= 10


Scores = tuple[Float[np.ndarray, "scores offices"], Float[np.ndarray, " lines"]]


def run_several(config: tuple[Config, int], *, rng: np.random.Generator) -> Scores:
    """Return how the maps of several offices agree with their floor plans, and NEES of lines."""
    drive, offices = config
    scores = sweep(_scored, [drive] * offices, rng=rng, desc="offices")
    return np.array(scores).T, line_nees(2000, rng.spawn(1)[0])


def _scored(config: Config, *, rng: np.random.Generator) -> tuple[float, ...]:
    result = run(config, rng=rng)
    score = result.score
    return score.precision, score.recall, score.rms_offset, score.rms_angle, len(result.found)


def line_nees(runs: int, rng: np.random.Generator) -> Float[np.ndarray, " runs"]:
    """Return normalised squared errors of fits to one wall, χ² with two degrees if C is right."""
    truth, angles = np.array([2.0, 0.4]), 0.4 + np.linspace(-0.9, 0.6, 60)
    ranges = truth[0] / np.cos(angles - truth[1]) + rng.normal(0, 0.02, (runs, 60))
    fits = walls.fit_line(ranges, angles, walls.RangeNoise(0.02))
    return normalised_squared(fits.mean - truth, fits.cov)


TOO_FAR = walls.Gate(roughness=0.6, roughness_angle=float(np.deg2rad(30.0)))
fig1 = Study(run_several, full=(Config(), 20), quick=(Config(rooms=2, step=0.5), 3))


@fig1.claim(
    "walls-fig1",
    paper="perception-issues",
    place="Fig. 1",
    basis="substitute",  # our office, scanner and tolerance
    statement="Walls are inferred from consecutive readings within a search range and merged "
    "into a map.",
    method="share of the length of our map that lies on a face of the synthetic floor plan",
    sabotage=Change(
        "a search range of 60 cm and 30°, in which different walls become one",
        config=(Config(rooms=2, step=1.0, gate=TOO_FAR), 3),
    ),
)
def walls_fig1(scores: Scores) -> Finding:
    """Average what the maps share with their floor plans."""
    (precision, recall, offset, angle, count), nees = scores
    evidence = {
        "recall of the faces the beams reached": mean(recall),
        "offset of a wall, rms": mean(1e3 * offset, "mm"),
        "direction of a wall, rms": mean(np.rad2deg(angle), "°"),
        "walls in the map": spread(count),
        "average NEES of a fitted line (2 is right)": mean(nees),
    }
    note = f"Share of the map's length that lies on a face of the floor plan, {count.size} offices."
    return Finding(mean(precision), evidence, note=note)


@dataclass(frozen=True, eq=False, slots=True)
class SearchRange:
    """The search range of a hypothesis along its wall; readings along and across the wall, m."""

    readings: Float[np.ndarray, "readings 2"]
    along: Float[np.ndarray, " places"]
    half_width: Float[np.ndarray, " places"]


def search_range(
    readings: int = 30, sigma: float = 0.02, probability: float = 0.99, roughness: float = 0.0
) -> SearchRange:
    r"""Return the band in which a wall hypothesis lets the same wall lie in another scan.

    It has so many readings, half a degree apart, of a wall 2 m away, with ranges of noise ``sigma``
    and a ``roughness`` of the wall, m; ``probability`` is the share of true matches let through at
    each place. At a distance t along the wall the standard deviation is
    :math:`\sigma^2(t) = (1, t)\, C\, (1, t)^\top` with C the covariance of (ρ, θ) seen from the
    middle of the readings.
    """
    rng = np.random.default_rng(0)
    angles = np.deg2rad(0.5) * (np.arange(readings) - (readings - 1) / 2) + np.pi / 2
    ranges = 2.0 / np.sin(angles) + sigma * rng.normal(size=readings)
    line = walls.fit_line(ranges, angles, walls.RangeNoise(sigma))
    points = walls.to_points(ranges, angles)
    middle = points.mean(axis=0)
    cov = walls.seen_from(line.mean[None], line.cov[None], middle)[1][0]
    cos, sin = np.cos(line.mean[1]), np.sin(line.mean[1])
    seen = (points - middle) @ np.array([[-sin, cos], [cos, sin]])  # along and across the wall
    along = np.linspace(-3.0, 3.0, 61)
    variance = cov[0, 0] - 2 * along * cov[0, 1] + along**2 * cov[1, 1] + roughness**2
    return SearchRange(seen, along, ndtri((1 + probability) / 2) * np.sqrt(variance))


@dataclass(frozen=True, eq=False, slots=True)
class Growing:
    """The map after so many scans: readings so far (thinned), walls, and the way."""

    scans: int
    points: Float[np.ndarray, "readings 2"]
    found: walls.WallMap
    way: Float[np.ndarray, "scans 2"]


@kept
def growing_map(frames: int = 24, most_points: int = 1500) -> tuple[Growing, ...]:
    """Return the map of the chapter's drive after equal numbers of scans."""
    result = office_run()
    config, scans, poses, points = result.config, result.scans.ranges, result.poses, result.points
    found, states, done = walls.WallMap.empty(), [], 0
    for stop in np.unique(np.linspace(1, len(poses), frames).round().astype(int)).tolist():
        for ranges, pose in zip(scans[done:stop], poses[done:stop], strict=True):
            segments, _ = walls.extract_segments(ranges, config.scanner.angles, config.extraction)
            found = walls.merge(found, walls.to_world(segments, pose), config.gate)
        done, reached = stop, np.isfinite(scans[:stop]).sum()
        thin = points[: reached : len(points) // most_points]  # a growing set
        states.append(Growing(stop, thin, found, poses[:stop, :2]))
    return tuple(states)


@kept
def seldom_study() -> dict[str, float]:
    """Compare the map of the drive with and without the walls seen in fewer than three scans.

    Of ``all`` walls these are ``gone``: the share of length that is not real goes from ``before``
    to ``after``, the share found sinks by ``cost``.
    """
    result, everything = office_run(), growing_map()[-1].found
    before, after = walls.score_map(everything, result.office.faces, result.seen), result.score
    return {
        "all": len(everything),
        "gone": len(everything) - len(result.found),
        "before": 1 - before.precision,
        "after": 1 - after.precision,
        "cost": before.recall - after.recall,
    }


@dataclass(frozen=True, eq=False, slots=True)
class GateStudy:
    """Maps of one drive with gates of several roughnesses, m.

    Number of walls, shares of length that are right and that were not found, and the median
    standard deviation across the walls at their middles, as their covariances state it, m.
    """

    roughness: Float[np.ndarray, " gates"]
    walls: Int[np.ndarray, " gates"]
    precision: Float[np.ndarray, " gates"]
    missed: Float[np.ndarray, " gates"]
    believed: Float[np.ndarray, " gates"]


@recorded("walls-gates")
def gate_study(roughness: tuple[float, ...] = (0.0, 0.005, 0.02, 0.08, 0.3, 0.6)) -> GateStudy:
    """Build the map of one drive with poses 2 cm wrong, with gates of several roughnesses, m."""
    rng = np.random.default_rng(9)
    small = run(Config(rooms=2, step=0.5), rng=rng)
    config, angles = small.config, small.config.scanner.angles
    poses = small.poses + rng.normal(0, [0.02, 0.02, np.deg2rad(0.3)], small.poses.shape)
    rows = []
    for sigma in roughness:
        gate = walls.Gate(roughness=sigma, roughness_angle=sigma * float(np.deg2rad(50.0)))
        found, _ = walls.build_map(small.scans.ranges, angles, poses, config.extraction, gate)
        found = found.seen_in(config.least_scans)
        score = walls.score_map(found, small.office.faces, small.seen)
        rows.append((len(found), score.precision, 1.0 - score.recall, _believed_sigma(found)))
    count, *shares = np.array(rows).T
    return GateStudy(np.array(roughness), count.astype(int), *shares)


def _believed_sigma(found: walls.WallMap) -> float:
    pairs = zip(found.lines[:, None], found.covs[:, None], found.ends.mean(axis=1), strict=True)
    variances = [walls.seen_from(line, cov, middle)[1][0, 0, 0] for line, cov, middle in pairs]
    return float(np.median(np.sqrt(variances)))
