r"""Directions of speakers from the signals of a few microphones (GCC-PHAT, SRP-PHAT).

A wave from the direction :math:`\varphi` reaches the microphones one after the other. At each
frequency, the phases of the signals tell by how much one is later than another. Frequencies at
which the signals are louder than the background, the noise of the robot itself, have one vote each,
however loud they are (the phase transform). The directions on which most votes agree are those of
speakers. The distance remains unknown. Two microphones, or several in a line, cannot tell a
direction from its mirror image; then both are returned.
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
_ALIKE = 35 / 18  # ν, sum of squared correlations of bins under a Hann window: 1 + 2 (4/9 + 1/36)
_SILENT = 1e-300  # a spectrum below it has too few digits for a phase
_ANYWHERE = np.pi / np.sqrt(3)  # standard deviation of a uniform direction, rad
_TOUCHING = 1e-3  # microphones closer together are taken to be in one place, m


@dataclass(frozen=True, slots=True)
class SoundRules:
    """Rules for a speaker. All values are our choice.

    Parameters
    ----------
    band
        Lowest and highest frequency that may vote, Hz.
    louder
        A frequency votes if its power is more than this many times that of the background.
    voiced
        Share of the band's frequencies that must vote; with fewer, nobody speaks.
    least
        Least response of a speaker's direction: the mean agreement of the votes with it, 1 if all
        agree.
    beside
        Least response of a further speaker, as a share of the strongest one. It keeps remains of
        the strongest speaker from being taken for another: a mouth that is near, or higher than the
        microphones, does not respond exactly as the plane wave that is subtracted.
    most
        Largest number of speakers in one window.
    apart
        Least angle between two speakers, rad.
    bearing_sigma
        Standard deviation of a direction in addition to that of the peak, rad: a mouth is not above
        the middle of the body, and people move. The squares are added.
    elevation
        Elevation of a mouth as seen from the microphones, up or down, rad. Sound from there has
        smaller lags, as if it came from a direction more across a line of microphones.
    speed
        Speed of sound, m/s.
    distance, range_sigma
        Mean and standard deviation of the distance of every speaker, which is not measured, m.

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
    r"""Return when a plane wave reaches each microphone, relative to the robot's middle, s.

    .. math:: t_m(\varphi) = -\frac{x_m \cos\varphi + y_m \sin\varphi}{c}

    Parameters
    ----------
    places : (m, 2)
        Positions :math:`(x_m, y_m)` of the microphones, ahead and left of the robot's middle, m.
    directions : (d,)
        Directions :math:`\varphi` from which the wave comes, rad.
    speed
        Speed of sound :math:`c`, m/s.

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
    r"""Return the power of the background at each frequency, while nobody speaks.

    .. math:: N(f) = \frac{1}{w m} \sum_{i,j} \lvert X_{ij}(f) \rvert^2

    Parameters
    ----------
    recordings : (w, m, n)
        Windows i of the microphones j without speech, as long as the signals of `detect`.

    Returns
    -------
    (n // 2 + 1,)
        :math:`N(f)`, the mean squared size of the spectra :math:`X_{ij}` under a Hann window.

    Raises
    ------
    ValueError
        If there is no sample, or one is not finite.
    """
    recordings = checks.array("recordings", recordings, ("w", "m", "n"))
    if not recordings.size:
        raise ValueError(f"recordings must hold a sample, got {recordings.shape}")
    return (np.abs(_spectra(recordings)) ** 2).mean(axis=(0, 1))


def gcc_phat(
    signals: Float[np.ndarray, "m n"], counted: Bool[np.ndarray, " f"]
) -> Float[np.ndarray, "p l"]:
    r"""Return the cross-correlation of each pair of signals with phase transform (GCC-PHAT).

    .. math:: R_{ab}(\tau) = \frac{1}{|F|} \sum_{f \in F} \operatorname{Re} \left(
        \frac{X_a(f) X_b^*(f)}{\lvert X_a(f) X_b^*(f) \rvert} e^{j 2 \pi f \tau} \right)

    Parameters
    ----------
    signals : (m, n)
        Signals of the microphones in any unit.
    counted : (n // 2 + 1,)
        Which frequencies belong to the set :math:`F` of those that vote. The first one and, for an
        even n, the last one have no phase and must not be among them.

    Returns
    -------
    (m (m - 1) / 2, 8 n)
        A row for each pair (a, b): (0, 1), (0, 2) … A column for each lag :math:`\tau`, eight to a
        sample: from 0 up, then the negative lags up to 0, as in an FFT. A lag is positive where
        signal a is later than b. A value is 1 where all votes agree.

    Raises
    ------
    ValueError
        If the shapes disagree, there are fewer than two signals, one is not finite, or no frequency
        is counted.

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
    r"""Return the directions of speakers in one window.

    The response :math:`P` of a direction is the mean correlation of all pairs at the lags of a wave
    from there (SRP-PHAT). The direction with the largest response is taken. The response to a
    single plane wave from there is subtracted, and the search is repeated.

    .. math:: P(\varphi) = \overline{R_{ab}\bigl(t_a(\varphi) - t_b(\varphi)\bigr)}, \qquad
        \sigma_\varphi^2 = \frac{\nu \sum_f s_f^2 + e^2}{\bigl(\sum_f h_f\bigr)^2} + \sigma_0^2

    Here :math:`s_f` is the derivative by :math:`\varphi` of the votes of frequency f at the peak,
    and :math:`-h_f` the second derivative. At the peak the sum of the :math:`s_f` is zero, and the
    first term is the sandwich estimate of its variance, which holds whatever the errors of the
    phases are. Neighbouring frequencies share errors because of the Hann window, hence
    :math:`\nu = 35/18`. If the sound comes from the elevation of the rules, the sum of the
    :math:`s_f` changes by :math:`e`. :math:`\sigma_0` is ``bearing_sigma`` of the rules.

    Parameters
    ----------
    signals : (m, n)
        Signals of the microphones, sampled at the same times, in any unit.
    places : (m, 2)
        Positions of the microphones, ahead and left of the robot's middle, m.
    rate
        Sampling rate, Hz.
    background : (n // 2 + 1,)
        Power at each frequency while nobody speaks, from the function `background`.
    rules
        Rules for a speaker.

    Returns
    -------
    Gaussian
        Positions :math:`(r, \varphi)`, the strongest speaker first, an empty batch if nobody
        speaks. The distance and its variance are those of the rules; only the direction is
        measured. If the microphones stand in a line, each direction is followed by its mirror
        image.

    Raises
    ------
    ValueError
        If the shapes disagree, there are fewer than two microphones or two in one place, a number
        is not finite, the rate is not positive or not more than twice the band's upper end, the
        background is negative, or the signals are too short to have a frequency in the band.

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
    """Tell which frequencies of a window lie in the band."""
    low, high = rules.band
    if not rate > 2 * high:
        raise ValueError(f"rate must be more than twice the band's {high:g} Hz, got {rate:g}")
    frequencies = np.arange(size // 2 + 1) * rate / max(size, 1)
    band = (low <= frequencies) & (frequencies <= high)
    if not band.any():
        raise ValueError(f"signals of {size} samples at rate {rate:g} have nothing in the band")
    return band


def _spectra(signals: np.ndarray) -> np.ndarray:
    """Return the spectra of signals under a Hann window."""
    size = signals.shape[-1]
    return rfft(signals * np.sin(np.pi * np.arange(size) / size) ** 2)


def _votes(spectra: Complex[np.ndarray, "m f"]) -> Complex[np.ndarray, "p f"]:
    """Return the phase difference of each pair, as a number of size 1 or 0 where one is silent."""
    size = np.abs(spectra)
    heard = size >= _SILENT
    phases = np.where(heard, spectra, 0.0) / np.where(heard, size, 1.0)
    a, b = np.triu_indices(len(spectra), 1)
    return phases[a] * phases[b].conj()


def _correlate(votes: np.ndarray, counted: np.ndarray, size: int) -> np.ndarray:
    """Return the mean of the votes at each lag, by an inverse FFT; see `gcc_phat`."""
    spectra = np.zeros((len(votes), _FINER * size // 2 + 1), dtype=complex)
    spectra[:, : len(counted)][:, counted] = votes
    return irfft(spectra, n=_FINER * size) * (_FINER * size / 2 / np.count_nonzero(counted))


def _at(correlations: np.ndarray, lags: np.ndarray) -> np.ndarray:
    """Return correlations (p, l) at lags (…, p) in samples, by linear interpolation."""
    whole = np.floor(lags * _FINER)
    first, count = whole.astype(int), correlations.shape[1]
    share, pairs = lags * _FINER - whole, np.arange(len(correlations))
    low, high = correlations[pairs, first % count], correlations[pairs, (first + 1) % count]
    return low + share * (high - low)


def _lags(steps: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """Return how much later the wave reaches the first of each pair, in samples (d, p).

    ``steps`` are the places of the microphones, in units of the distance that sound travels in one
    sample.
    """
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
        if here < max(before, after):  # no peak, but the slope of one that is taken
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
    """Return the standard deviation of the direction of a peak; see `detect`.

    ``turns`` are the frequencies, rad for each sample, ``steps`` as in `_lags`.
    """
    a, b = np.triu_indices(len(steps), 1)
    x, y = (steps[a] - steps[b]).T
    lags = -(x * np.cos(phi) + y * np.sin(phi))[:, None] * turns  # (p, f), rad
    pull = (x * np.sin(phi) - y * np.cos(phi))[:, None] * turns  # their derivatives by φ
    agreed = votes * np.exp(1j * lags)
    slopes, bend = (pull * agreed.imag).sum(axis=0), float((pull**2 * agreed.real).sum())
    shorter = (1 - np.cos(elevation)) * float((pull * lags * agreed.real).sum())
    spread = float(np.sqrt(_ALIKE * slopes @ slopes + shorter**2))
    return spread / bend if spread < _ANYWHERE * bend else _ANYWHERE


def _with_mirrors(
    places: np.ndarray, phi: np.ndarray, sigma: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return directions, each followed by its mirror image if the microphones are in a line."""
    _, sizes, axes = np.linalg.svd(places - places.mean(axis=0))
    if sizes[-1] > _TOUCHING:
        return phi, sigma
    images = wrap_angle(2 * np.arctan2(axes[0, 1], axes[0, 0]) - phi)
    both, twice = np.stack([phi, images], axis=-1), np.repeat(sigma, 2)
    other = np.abs(wrap_angle(images - phi)) > _DIRECTIONS[1] - _DIRECTIONS[0]
    kept = np.stack([np.ones(len(phi), dtype=bool), other], axis=-1).ravel()
    return both.ravel()[kept], twice[kept]
