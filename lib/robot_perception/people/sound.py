r"""Speakers in what a few microphones hear: a direction each, and no distance.

A wave from the direction :math:`\varphi` passes the microphones one after the other. Each frequency
at which the window is louder than the robot by itself says by its phases how late each of them is,
and all such frequencies have one vote, however loud (the phase transform). The directions on which
most of them agree are those of speakers. Two microphones, and any number in a line, cannot tell a
direction from its mirror image; then both are reported.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Complex, Float
from scipy.fft import irfft, rfft

from robot_perception import checks
from robot_perception.beliefs import Gaussian
from robot_perception.geometry.angles import wrap_angle
from robot_perception.people._bearings import DISTANCE, RANGE_SIGMA, bearings

_DIRECTIONS = wrap_angle(2 * np.pi / 180 * np.arange(180))
_FINER = 8  # lags for each sample
_ALIKE = 35 / 18  # bins that share the noise of one: 1 + 2 (4/9 + 1/36) with a Hann window
_SILENT = 1e-300  # a spectrum below it has no digits for a phase
_ANYWHERE = np.pi / np.sqrt(3)  # deviation of a direction of which nothing is known, rad
_TOUCHING = 1e-3  # microphones nearer to each other are in one place, m


@dataclass(frozen=True, slots=True)
class SoundRules:
    """Rules for a speaker. All values are our choice.

    Parameters
    ----------
    band
        Frequencies that are looked at, Hz.
    louder
        How many times the power of the background a frequency must have to vote.
    voiced
        Share of the band that must vote; with less, nobody speaks.
    least
        Least response of a speaker's direction: the share of votes that agree on it.
    beside
        Least response of a further speaker, as a share of the strongest's: somebody near, or higher
        than the microphones, does not respond everywhere as a wave from afar would.
    most
        Speakers looked for in one window.
    apart
        Directions nearer than that to a found one are its own, rad.
    bearing_sigma
        Standard deviation of a direction beside that of its peak, rad: a mouth is not above the
        middle of the body, and people move.
    elevation
        How far above or below the microphones a mouth is seen, rad; sound from there arrives
        within less time, as if from a direction more across a line of microphones.
    speed
        Of sound, m/s.
    distance, range_sigma
        Mean and standard deviation of the distance that is claimed of everybody, m.

    Raises
    ------
    ValueError
        If a number is out of its range, or the band does not rise.
    """

    band: tuple[float, float] = (500.0, 4000.0)
    louder: float = 4.0
    voiced: float = 0.1
    least: float = 0.15
    beside: float = 0.5
    most: int = 2
    apart: float = np.deg2rad(15.0)
    bearing_sigma: float = np.deg2rad(3.5)
    elevation: float = np.deg2rad(15.0)
    speed: float = 343.0
    distance: float = DISTANCE
    range_sigma: float = RANGE_SIGMA

    def __post_init__(self) -> None:
        low, high = checks.vector("band", self.band, 2).tolist()
        if not 0 < low < high:
            raise ValueError(f"band must rise above 0, got {self.band}")
        object.__setattr__(self, "band", (low, high))
        for name in ("louder", "apart", "speed", "distance", "range_sigma"):
            object.__setattr__(self, name, checks.positive(name, getattr(self, name)))
        for name in ("voiced", "least", "beside"):
            object.__setattr__(self, name, checks.level(name, getattr(self, name)))
        object.__setattr__(self, "most", checks.whole("most", self.most, 1, 100))
        sigma = checks.not_negative("bearing_sigma", self.bearing_sigma)
        object.__setattr__(self, "bearing_sigma", sigma)
        if not 0 <= checks.number("elevation", self.elevation) < np.pi / 2:
            raise ValueError(f"elevation must be from 0 to π/2, got {self.elevation}")
        object.__setattr__(self, "elevation", float(self.elevation))


def arrivals(
    places: Float[np.ndarray, "m 2"], directions: Float[np.ndarray, " d"], speed: float = 343.0
) -> Float[np.ndarray, "d m"]:
    r"""Return when a wave from far away passes each microphone, against the robot's middle, s.

    .. math:: t_m(\varphi) = -\frac{x_m \cos\varphi + y_m \sin\varphi}{c}

    Parameters
    ----------
    places : (m, 2)
        Of the microphones, ahead and left of the middle, m.
    directions : (d,)
        Where the wave comes from, rad.
    speed
        :math:`c`, m/s.

    Raises
    ------
    ValueError
        If a shape is another, or the speed is not positive.
    """
    places = checks.array("places", places, ("m", 2))
    phi = checks.array("directions", directions, ("d",))
    speed = checks.positive("speed", speed)
    return -np.stack([np.cos(phi), np.sin(phi)], axis=-1) @ places.T / speed


def background(recordings: Float[np.ndarray, "w m n"]) -> Float[np.ndarray, " f"]:
    r"""Return the power at each frequency of what is heard while nobody speaks.

    .. math:: N(f) = \frac{1}{w m} \sum_{i,j} \lvert X_{ij}(f) \rvert^2

    Parameters
    ----------
    recordings : (w, m, n)
        Windows of that, as long as those of `detect`.

    Returns
    -------
    (n // 2 + 1,)
        Mean square of the spectra :math:`X`, under a Hann window.

    Raises
    ------
    ValueError
        If there is none, or one is not finite.
    """
    recordings = checks.array("recordings", recordings, ("w", "m", "n"))
    if not recordings.size:
        raise ValueError(f"recordings must hold a sample, got {recordings.shape}")
    return (np.abs(_spectra(recordings)) ** 2).mean(axis=(0, 1))


def gcc_phat(
    signals: Float[np.ndarray, "m n"], counted: Bool[np.ndarray, " f"]
) -> Float[np.ndarray, "p l"]:
    r"""Return the correlation of all pairs of signals after the phase transform.

    .. math:: R_{ab}(\tau) = \frac{1}{|F|} \sum_{f \in F} \operatorname{Re}
        \frac{X_a(f) X_b^*(f)}{\lvert X_a(f) X_b^*(f) \rvert} e^{j 2 \pi f \tau}

    Parameters
    ----------
    signals : (m, n)
        Whatever their unit.
    counted : (n // 2 + 1,)
        Which frequencies :math:`F` have a vote; the first and, for an even n, the last have no
        phase and must not be among them.

    Returns
    -------
    (m (m - 1) / 2, 8 n)
        By pairs (0, 1), (0, 2) … and by lags, eight to a sample from 0 on and round the end: where
        signal a is late, the lag is positive. 1 where all votes agree.

    Raises
    ------
    ValueError
        If the shapes disagree, there are no two signals, one is not finite, or nothing is counted.

    References
    ----------
    Knapp and Carter, "The generalized correlation method for estimation of time delay", IEEE
    Transactions on Acoustics, Speech, and Signal Processing 24(4), 1976.
    """
    signals = checks.array("signals", signals, ("m", "n"))
    if len(signals) < 2:
        raise ValueError(f"signals must be two at least, got {signals.shape}")
    size = signals.shape[1]
    counted = checks.instance("counted", counted, np.ndarray)
    checks.shaped("counted", counted, (size // 2 + 1,), f"signals {signals.shape}")
    if counted.dtype != bool or not counted.any() or counted[0] or counted[(size + 1) // 2 :].any():
        raise ValueError("counted must tell frequencies with a phase, and one at least")
    return _correlate(_votes(_spectra(signals)[:, counted]), counted, size)


def detect(
    signals: Float[np.ndarray, "m n"],
    places: Float[np.ndarray, "m 2"],
    rate: float,
    background: Float[np.ndarray, " f"],
    rules: SoundRules = SoundRules(),
) -> Gaussian:
    r"""Return in which directions people seem to speak.

    The response of a direction is the mean correlation of all pairs at the lags of its wave; the
    best direction is taken, what a single wave from there would respond everywhere is subtracted,
    and so on.

    .. math:: P(\varphi) = \overline{R_{ab}\bigl(t_a(\varphi) - t_b(\varphi)\bigr)}, \qquad
        \sigma_\varphi^2 = \frac{\nu \sum_f s_f^2 + e^2}{\bigl(\sum_f h_f\bigr)^2} + \sigma_0^2

    with the slopes :math:`s_f` and the negative curvatures :math:`h_f` of the votes of each
    frequency at the peak: the variance of an estimate that makes the sum of slopes vanish, whatever
    the errors of the phases are. Under a Hann window :math:`\nu = 35/18` frequencies share one
    error. By :math:`e` the sum of slopes changes if the sound comes from the rules' elevation, and
    :math:`\sigma_0` is the rules' ``bearing_sigma``.

    Parameters
    ----------
    signals : (m, n)
        Of the microphones, at the same times, whatever their unit.
    places : (m, 2)
        Of the microphones, ahead and left of the robot's middle, m.
    rate
        Samples in a second, Hz.
    background : (n // 2 + 1,)
        What is heard while nobody speaks, see `background`.
    rules
        What counts as a speaker.

    Returns
    -------
    Gaussian
        Positions :math:`(r, \varphi)`, the strongest first: a mean and a variance of the distance
        that say nothing, and the direction with its variance. If the microphones stand in a line,
        each direction is followed by its mirror image. None where nobody speaks.

    Raises
    ------
    ValueError
        If the shapes disagree, there are no two microphones or two in one place, a number is not
        finite, the rate is not positive or less than twice the band, the background is negative, or
        the signals are too short to have a frequency in the band.

    References
    ----------
    DiBiase, Silverman and Brandstein, "Robust localization in reverberant rooms", in *Microphone
    Arrays*, Springer 2001. Schaffernicht et al. 2005 (see `Detections`), section 3.1, for what a
    hypothesis is.
    """
    signals = checks.array("signals", signals, ("m", "n"))
    places = checks.array("places", places, (len(signals), 2), f"signals {signals.shape}")
    _check_apart(places)
    size = signals.shape[1]
    noise = checks.array("background", background, (size // 2 + 1,), f"signals {signals.shape}")
    if (noise < 0).any():
        raise ValueError(f"background must not be negative, got {noise.min():g}")
    band = _in_band(
        checks.positive("rate", rate), size, checks.instance("rules", rules, SoundRules)
    )
    spectra = _spectra(signals)
    counted = band & ((np.abs(spectra) ** 2).mean(axis=0) > rules.louder * noise)
    if counted.sum() < rules.voiced * band.sum():
        return bearings(np.zeros(0), np.zeros(0), rules.distance, rules.range_sigma)
    votes = _votes(spectra[:, counted])
    steps = places * rate / rules.speed  # in samples
    phi = _peaks(votes, counted, steps, size, rules)
    turns = 2 * np.pi / size * np.flatnonzero(counted)
    sigma = np.array([_sigma(votes, turns, steps, one, rules.elevation) for one in phi])
    phi, sigma = _with_mirrors(places, phi, np.hypot(sigma, rules.bearing_sigma))
    return bearings(phi, sigma, rules.distance, rules.range_sigma)


def _check_apart(places: np.ndarray) -> None:
    """Raise ``ValueError`` unless there are two microphones, each in its own place."""
    if len(places) < 2:
        raise ValueError(f"places must be of two microphones at least, got {places.shape}")
    a, b = np.triu_indices(len(places), 1)
    gap = np.hypot(*(places[a] - places[b]).T).min()
    if gap < _TOUCHING:
        raise ValueError(f"places must be apart, got two with {gap:g} m between them")


def _in_band(rate: float, size: int, rules: SoundRules) -> Bool[np.ndarray, " f"]:
    """Tell which frequencies of a window are looked at."""
    low, high = rules.band
    if not rate > 2 * high:
        raise ValueError(f"rate must be more than twice the band's {high:g} Hz, got {rate:g}")
    frequencies = np.arange(size // 2 + 1) * rate / max(size, 1)
    band = (low <= frequencies) & (frequencies <= high)
    if not band.any():
        raise ValueError(f"signals of {size} samples at rate {rate:g} have nothing in the band")
    return band


def _spectra(signals: np.ndarray) -> np.ndarray:
    """Return spectra under a Hann window."""
    size = signals.shape[-1]
    return rfft(signals * np.sin(np.pi * np.arange(size) / size) ** 2)


def _votes(spectra: Complex[np.ndarray, "m f"]) -> Complex[np.ndarray, "p f"]:
    """Return the phases of all pairs as numbers of size 1, or 0 where one is silent."""
    size = np.abs(spectra)
    heard = size >= _SILENT
    phases = np.where(heard, spectra, 0.0) / np.where(heard, size, 1.0)
    a, b = np.triu_indices(len(spectra), 1)
    return phases[a] * phases[b].conj()


def _correlate(votes: np.ndarray, counted: np.ndarray, size: int) -> np.ndarray:
    """Return the mean of votes turned by each lag."""
    spectra = np.zeros((len(votes), _FINER * size // 2 + 1), dtype=complex)
    spectra[:, : len(counted)][:, counted] = votes
    return irfft(spectra, n=_FINER * size) * (_FINER * size / 2 / np.count_nonzero(counted))


def _at(correlations: np.ndarray, lags: np.ndarray) -> np.ndarray:
    """Return correlations (p, l) at lags (…, p) in samples, between those that are there."""
    whole = np.floor(lags * _FINER)
    first, count = whole.astype(int), correlations.shape[1]
    share, pairs = lags * _FINER - whole, np.arange(len(correlations))  # one may serve for all
    low, high = correlations[pairs, first % count], correlations[pairs, (first + 1) % count]
    return low + share * (high - low)


def _lags(steps: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Return by how much the first of each pair is late (d, p); steps are places in samples."""
    a, b = np.triu_indices(len(steps), 1)
    late = arrivals(steps, phi, 1.0)
    return late[:, a] - late[:, b]


def _peaks(
    votes: np.ndarray, counted: np.ndarray, steps: np.ndarray, size: int, rules: SoundRules
) -> Float[np.ndarray, " k"]:
    """Return the directions of speakers, the strongest first."""
    lags = _lags(steps, _DIRECTIONS)
    response = _at(_correlate(votes, counted, size), lags).mean(axis=1)
    one_wave = np.repeat(
        _correlate(np.ones((1, votes.shape[1])), counted, size), len(votes), axis=0
    )
    free, found = np.ones(len(_DIRECTIONS), dtype=bool), []
    least = max(rules.least, rules.beside * response.max())
    while len(found) < rules.most:
        k = int(np.where(free, response, -np.inf).argmax())
        if not free[k] or response[k] < least:
            break
        before, here, after = response[[k - 1, k, (k + 1) % len(_DIRECTIONS)]]
        if here < max(before, after):  # the slope of a direction that is taken
            free[k] = False
            continue
        bend = before - 2 * here + after
        off = (before - after) / 2 / bend if bend < 0 else 0.0
        phi = wrap_angle(_DIRECTIONS[k] + off * (_DIRECTIONS[1] - _DIRECTIONS[0]))
        found.append(phi)
        spread = _at(one_wave, lags - _lags(steps, np.array([phi]))).mean(axis=1)
        response = response - here * spread
        free &= np.abs(wrap_angle(_DIRECTIONS - phi)) > rules.apart
    return np.array(found)


def _sigma(
    votes: np.ndarray, turns: np.ndarray, steps: np.ndarray, phi: float, elevation: float
) -> float:
    """Return the standard deviation of the direction of a peak; turns are rad for each sample."""
    a, b = np.triu_indices(len(steps), 1)
    x, y = (steps[a] - steps[b]).T
    lags = -(x * np.cos(phi) + y * np.sin(phi))[:, None] * turns  # (p, f), rad
    pull = (x * np.sin(phi) - y * np.cos(phi))[:, None] * turns  # their derivative
    agreed = votes * np.exp(1j * lags)
    slopes, bend = (pull * agreed.imag).sum(axis=0), float((pull**2 * agreed.real).sum())
    shorter = (1 - np.cos(elevation)) * float((pull * lags * agreed.real).sum())
    spread = float(np.sqrt(_ALIKE * slopes @ slopes + shorter**2))
    return spread / bend if spread < _ANYWHERE * bend else _ANYWHERE


def _with_mirrors(
    places: np.ndarray, phi: np.ndarray, sigma: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return directions with their mirror images behind them, if the microphones are in a line."""
    _, sizes, axes = np.linalg.svd(places - places.mean(axis=0))
    if sizes[-1] > _TOUCHING:
        return phi, sigma
    images = wrap_angle(2 * np.arctan2(axes[0, 1], axes[0, 0]) - phi)
    both, twice = np.stack([phi, images], axis=-1), np.repeat(sigma, 2)
    other = np.abs(wrap_angle(images - phi)) > _DIRECTIONS[1] - _DIRECTIONS[0]
    kept = np.stack([np.ones(len(phi), dtype=bool), other], axis=-1).ravel()
    return both.ravel()[kept], twice[kept]
