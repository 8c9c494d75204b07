"""Sound: people who speak now and then, and what microphones on a robot hear of them.

A voice is a train of pulses and noise in syllables, louder to the front. It reaches each microphone
straight, from floor and ceiling, and from every wall that mirrors it once; a way that a wall cuts
is silent, and furniture is none. What is mirrored more often comes from everywhere, as a tail of
noise that decays. The robot's fan is heard by all microphones, what hisses in each by that alone.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from scipy.fft import irfft, rfft, rfftfreq

from data_synth._checks import array, generator, instance, number, whole, wholes
from data_synth._grid import on_grid
from data_synth.people.office import PeopleOffice
from data_synth.people.session import Session
from data_synth.people.world import Moment

SPEED = 343.0
"""Speed of sound, m/s."""

_QUIETEST = 20e-6  # pressure that levels refer to, Pa
_MOUTH = 0.1, 0.08  # before the axis of the body and below the middle of the head, m
_BEHIND = 0.4  # share of the pressure in front that a voice has behind
_FAN = -0.12, 0.06, 0.35  # where the robot's is: ahead, left and up, m
_RUMBLE = 250.0  # above it the fan gets quieter, Hz
_LONGEST = 0.1  # time that the longest way takes that is followed, s
_TAIL = 0.02, 0.75  # it begins, s, and ends, share of the time in which it falls by 60 dB
_PITCHES = 95.0, 230.0  # of voices, Hz
_PULSE = 1000.0  # how sharp the pulses of a voice are
_SYLLABLE = 0.12, 0.30  # s
_CONSONANT = 0.4  # most of a syllable that is noise, share
_BREATH = 0.4  # how loud that is
_BLOCK = 64  # frequencies that are turned together


def on_circle(count: int, radius: float) -> np.ndarray:
    """Return places (count, 2) on a circle, the first ahead, counter-clockwise, m.

    Parameters
    ----------
    count
        How many.
    radius
        Of the circle, m.
    """
    turns = 2 * np.pi / whole("count", count, 1, 1000) * np.arange(count)
    return number("radius", radius, 0.0, 10.0) * np.stack([np.cos(turns), np.sin(turns)], axis=-1)


@dataclass(frozen=True, eq=False, slots=True)
class MicrophoneArray:
    """Microphones on a robot, in a level plane; all values are ours.

    Parameters
    ----------
    places : (m, 2)
        Ahead and left of the robot's axis, m.
    height
        Above the floor, m.
    rate
        Samples in a second, Hz.
    """

    places: np.ndarray = field(default_factory=lambda: on_circle(4, 0.15))
    height: float = 1.2
    rate: float = 16000.0

    def __post_init__(self) -> None:
        places = array("places", self.places, (None, 2))
        if not len(places) or np.abs(places).max() > 10:
            raise ValueError(f"places must be one at least within 10 m, got {places.shape}")
        number("height", self.height, 0.0, 2.5)
        number("rate", self.rate, 1000.0, 200000.0)
        object.__setattr__(self, "places", places)


EARS = MicrophoneArray(np.array([[0.0, 0.1], [0.0, -0.1]]))
"""Two microphones, left and right, as the paper's robot has; it does not say where."""


@dataclass(frozen=True, slots=True)
class Acoustics:
    """Loudness of everything; all values are ours.

    Parameters
    ----------
    voice
        Level of a speaker ahead at 1 m, dB above 20 µPa.
    fan
        Level of the robot's fan on its axis between the microphones, dB; minus infinity for none.
    hiss
        Level of what each microphone hears by itself, dB; minus infinity for none.
    reflection
        Share of the pressure that walls, floor and ceiling send back; 0 for no mirror images.
    reverberation
        Time in which what is mirrored more than once falls by 60 dB, s; 0 for none of it.
    window
        Length of what is heard at a time, s.
    """

    voice: float = 60.0
    fan: float = 45.0
    hiss: float = 35.0
    reflection: float = 0.7
    reverberation: float = 0.4
    window: float = 0.25

    def __post_init__(self) -> None:
        number("voice", self.voice, -100.0, 140.0)
        for name in ("fan", "hiss"):
            level = getattr(self, name)
            if not (isinstance(level, float) and level == -np.inf):
                number(name, level, -300.0, 140.0)
        number("reflection", self.reflection, 0.0, 1.0)
        number("reverberation", self.reverberation, 0.0, 10.0)
        number("window", self.window, 0.02, 10.0)

    @property
    def lead(self) -> float:
        """Longest delay between what is said and what is heard, s."""
        return max(_LONGEST, _TAIL[1] * self.reverberation)


@dataclass(frozen=True, slots=True)
class Manners:
    """Rules by which people speak; all values are ours.

    Parameters
    ----------
    pause, turn
        Shortest and longest time that somebody is silent, and speaks, s.
    interrupts
        Probability of beginning while somebody else speaks; whoever does not waits again.
    """

    pause: tuple[float, float] = (2.0, 10.0)
    turn: tuple[float, float] = (1.0, 5.0)
    interrupts: float = 0.2

    def __post_init__(self) -> None:
        for name in ("pause", "turn"):
            low, high = array(name, getattr(self, name), (2,))
            if not 0.1 <= low <= high <= 3600:
                raise ValueError(f"{name} must rise from 0.1 s at least, got {low:g} to {high:g}")
        number("interrupts", self.interrupts, 0.0, 1.0)


@dataclass(frozen=True, eq=False, slots=True)
class Conversation:
    """Turns of a conversation: who speaks when.

    Parameters
    ----------
    pitches : (p,)
        Of the voices, Hz.
    who : (t,)
        Index of the speaker of each turn.
    starts, ends : (t,)
        Of the turns, s.
    seeds : (t,)
        What each turn sounds like.
    """

    pitches: np.ndarray
    who: np.ndarray
    starts: np.ndarray
    ends: np.ndarray
    seeds: np.ndarray

    def __post_init__(self) -> None:
        people = len(array("pitches", self.pitches, (None,)))
        turns = wholes("who (of pitches)", self.who, (None,), 0, people - 1).size
        array("starts", self.starts, (turns,))
        array("ends", self.ends, (turns,))
        wholes("seeds", self.seeds, (turns,), 0, np.iinfo(np.int64).max)

    def speaking(self, start: float, end: float) -> np.ndarray:
        """Return for how much of a time everybody speaks (p,), from 0 to 1.

        Parameters
        ----------
        start, end
            Of the time, s.
        """
        start, end = number("start", start), number("end", end)
        if not end > start:
            raise ValueError(f"end must be after start {start:g}, got {end:g}")
        shared = np.minimum(self.ends, end) - np.maximum(self.starts, start)
        return np.bincount(self.who, np.maximum(shared, 0.0), len(self.pitches)) / (end - start)


@dataclass(frozen=True, eq=False, slots=True)
class SoundWindow:
    """Signals of the microphones around a time, the middle (s): (m, n), Pa."""

    time: float
    signals: np.ndarray


def converse(
    session: Session, *, rng: np.random.Generator, manners: Manners | None = None
) -> Conversation:
    """Return who speaks when in a session; nobody does while away.

    Parameters
    ----------
    session
        The session, which stays as it is.
    rng
        Source of randomness.
    manners
        How long turns and pauses are.
    """
    instance("session", session, Session)
    generator(rng)
    manners = Manners() if manners is None else instance("manners", manners, Manners)
    count = len(session.people)
    pitches = rng.uniform(*_PITCHES, count)
    until = on_grid(rng.uniform(0.0, manners.pause[1], count))  # of the turn or the pause
    speaks = np.zeros((len(session.times) + 2, count), dtype=bool)  # nobody before and after
    for k, (time, present) in enumerate(zip(session.times, session.present, strict=True)):
        before, now = speaks[k : k + 2]
        now[:] = before & present
        for person in np.flatnonzero((until <= time) | (before & ~present)):
            now[person] = (
                not before[person]
                and present[person]
                and (not now.any() or rng.random() < manners.interrupts)
            )
            lasts = rng.uniform(*(manners.turn if now[person] else manners.pause))
            until[person] = on_grid(time + lasts)
    speaks[-2] = False  # a turn lasts a step at least
    edges = np.diff(speaks.astype(int), axis=0)
    who, first = np.nonzero(edges.T > 0)
    _, last = np.nonzero(edges.T < 0)
    seeds = rng.integers(2**32, size=len(who))
    times = on_grid(session.times)
    return Conversation(pitches, who, times[first], times[last], seeds)


def speech(duration: float, rate: float, pitch: float, *, rng: np.random.Generator) -> np.ndarray:
    """Return the sound of somebody who speaks (n,); its mean square is 1.

    Parameters
    ----------
    duration
        s.
    rate
        Samples in a second, Hz.
    pitch
        Of the voice in the mean, Hz.
    rng
        Source of randomness.
    """
    duration, rate = number("duration", duration, 0.01, 3600.0), number("rate", rate, 1e3, 2e5)
    pitch = number("pitch", pitch, 50.0, 500.0)
    time = np.arange(round(duration * rate)) / rate
    loud, vowel = _syllables(time, generator(rng))
    melody = pitch * np.exp(0.15 * np.sin(2 * np.pi * (0.6 * time + rng.random())))
    pulses = np.exp(_PULSE * (np.cos(2 * np.pi * np.cumsum(melody) / rate) - 1))
    breath = _BREATH * rng.standard_normal(len(time))
    excited = loud * np.where(vowel, pulses * (4 * np.pi * _PULSE) ** 0.25, breath)
    sound = irfft(rfft(excited) * _mouth(rfftfreq(len(time), 1 / rate), rng), n=len(time))
    return sound / np.sqrt((sound**2).mean())


def _syllables(time: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Loudness at each time, and whether that is a vowel."""
    count = int(time[-1] / _SYLLABLE[0]) + 2
    ends = np.cumsum(rng.uniform(*_SYLLABLE, count))
    which = np.searchsorted(ends, time, side="right")
    starts = np.r_[0.0, ends]
    share = (time - starts[which]) / (ends[which] - starts[which])
    peaks, onsets = rng.uniform(0.4, 1.0, count), rng.uniform(0.0, _CONSONANT, count)
    return peaks[which] * np.sqrt(np.sin(np.pi * share).clip(0.0)), share > onsets[which]


def _mouth(frequencies: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Transfer function of a mouth: with three formants, less above 500 Hz, little below 120."""
    passed = frequencies**2 / (frequencies**2 + 120.0**2) / np.hypot(1.0, frequencies / 500)
    formants = rng.uniform([400, 1000, 2300], [800, 2200, 3000])
    bumps = np.exp(-(((frequencies[:, None] - formants) / 200) ** 2) / 2)
    return passed * (1 + 3 * bumps.sum(axis=1))


def paths(
    office: PeopleOffice, source: np.ndarray, ear: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return where a sound seems to come from: the source and its mirror images.

    Parameters
    ----------
    office
        Where; its walls mirror and hide.
    source, ear : (3,)
        Where the sound is made and heard, m.

    Returns
    -------
    images : (k, 3)
        m; the source is the first, unless a wall hides it.
    mirrored : (k,)
        Which of them are images.
    leaves : (k,)
        Direction in which the sound leaves the source, rad.
    """
    walls, high = instance("office", office, PeopleOffice).stage.walls, office.stage.high
    source, ear = array("source", source, (3,)), array("ear", ear, (3,))
    here, there = source[:2], ear[:2]
    images, bounces = _mirrored(walls, here, there)
    clear = not _cross(here[None], there[None], walls).any()
    levels = np.array([source[2], -source[2], 2 * high - source[2]])[: 3 * clear]
    straight = np.column_stack([np.tile(here, (len(levels), 1)), levels])
    turned = np.column_stack([images, np.full(len(images), source[2])])
    way = np.concatenate([np.tile(there, (len(levels), 1)), bounces]) - here
    mirrored = np.arange(len(levels) + len(images)) >= clear
    return np.concatenate([straight, turned]), mirrored, np.arctan2(way[:, 1], way[:, 0])


def _mirrored(walls: np.ndarray, here: np.ndarray, there: np.ndarray):
    """Images (k, 2) in the walls that are seen from there, and where the ways bounce (k, 2)."""
    edges = walls[:, 1] - walls[:, 0]
    square = (edges**2).sum(axis=1)
    before = _area(edges, here - walls[:, 0])  # the free space is to the left
    after = _area(edges, there - walls[:, 0])
    images = here + 2 * (before / square)[:, None] * edges[:, ::-1] * [1, -1]
    front = (before > 0) & (after > 0)
    bounces = images + (before / np.where(front, before + after, 1.0))[:, None] * (there - images)
    along = ((bounces - walls[:, 0]) * edges).sum(axis=1)
    kept = np.flatnonzero(front & (along >= 0) & (along <= square))
    starts = np.broadcast_to(here, (len(kept), 2))
    ends = np.broadcast_to(there, (len(kept), 2))
    hidden = _cross(starts, bounces[kept], walls) | _cross(bounces[kept], ends, walls)
    hidden[np.arange(len(kept)), kept] = False  # the wall itself
    kept = kept[~hidden.any(axis=1)]
    return images[kept], bounces[kept]


def _cross(starts: np.ndarray, ends: np.ndarray, walls: np.ndarray) -> np.ndarray:
    """Tell (n, w) which straight ways cross which walls."""
    way, edge = (ends - starts)[:, None], walls[:, 1] - walls[:, 0]
    gap = walls[:, 0] - starts[:, None]
    area = _area(way, edge)
    area = np.where(area == 0, np.inf, area)
    along, across = _area(gap, edge) / area, _area(gap, way) / area
    return (along > 0) & (along < 1) & (across >= 0) & (across <= 1)


def _area(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def delayed(signal: np.ndarray, delays: np.ndarray, gains: np.ndarray) -> np.ndarray:
    """Return sums (m, n) of k copies of a signal, each late by its own time, round the end.

    Parameters
    ----------
    signal : (n,)
        What is copied.
    delays : (m, k)
        In samples, fractions too.
    gains : (m, k)
        Of the copies.
    """
    signal, delays = array("signal", signal, (None,)), array("delays", delays, (None, None))
    gains = array("gains (as delays)", gains, delays.shape)
    if not len(signal):
        raise ValueError("signal must hold a sample, got none")
    return irfft(rfft(signal) * _response(delays, gains, len(signal)), n=len(signal))


def _response(delays: np.ndarray, gains: np.ndarray, size: int) -> np.ndarray:
    """Transfer function of a sound on all ways to each microphone: (m, size // 2 + 1)."""
    bins = size // 2 + 1
    turn = -2j * np.pi / size * delays[..., None]
    near = np.exp(turn * np.arange(_BLOCK))  # a frequency is a block and a place in it
    far = np.exp(turn * np.arange(0, bins, _BLOCK))
    return ((gains[..., None] * far).mT @ near).reshape(len(delays), -1)[:, :bins]


def _tail(count: int, rate: float, acoustics: Acoustics, *, rng: np.random.Generator) -> np.ndarray:
    """Signals of a click from everywhere at the microphones (m, n), for a room of 1 m³."""
    time = np.arange(round(acoustics.lead * rate)) / rate
    lasts = max(acoustics.reverberation, 1e-3)
    noise = rng.standard_normal((count, len(time))) * 10.0 ** (-3 * time / lasts)
    # from the beginning on it would have 16π / A times the energy of what is heard straight at 1 m
    # for an area A = 0.161 V / T that swallows all (Sabine), and a voice is softer to the sides
    beside = ((1 + _BEHIND) / 2) ** 2 + ((1 - _BEHIND) / 2) ** 2 / 3
    energy = beside * 16 * np.pi * acoustics.reverberation / 0.161
    whole = lasts * rate / (6 * np.log(10))
    return np.sqrt(energy / whole) * noise * (time >= _TAIL[0])


def own_noise(
    microphones: MicrophoneArray, acoustics: Acoustics, *, rng: np.random.Generator
) -> np.ndarray:
    """Return what the microphones hear (m, n) while nobody speaks: fan and hiss, Pa.

    Parameters
    ----------
    microphones
        Where they are.
    acoustics
        How loud it is.
    rng
        Source of randomness.
    """
    instance("microphones", microphones, MicrophoneArray)
    instance("acoustics", acoustics, Acoustics)
    generator(rng)
    places, rate = microphones.places, microphones.rate
    size = round(acoustics.window * rate)
    hiss = _pressure(acoustics.hiss) * rng.standard_normal((len(places), size))
    shape = 1 / (1 + (rfftfreq(size, 1 / rate) / _RUMBLE) ** 2)
    fan = irfft(rfft(rng.standard_normal(size)) * shape, n=size)
    fan *= _pressure(acoustics.fan) / np.sqrt(irfft(shape**2, n=size)[0])
    fan_to = np.column_stack([places, np.full(len(places), microphones.height)]) - _FAN
    away = np.linalg.norm(fan_to, axis=1)[:, None]
    middle = np.linalg.norm([_FAN[0], _FAN[1], microphones.height - _FAN[2]])
    return hiss + delayed(fan, away / SPEED * rate, middle / away)


def _pressure(level: float) -> float:
    return _QUIETEST * 10.0 ** (level / 20)


def hear(
    session: Session,
    conversation: Conversation,
    microphones: MicrophoneArray,
    acoustics: Acoustics,
    *,
    rng: np.random.Generator,
) -> Iterator[SoundWindow]:
    """Yield what the microphones hear during a session, window after window.

    Parameters
    ----------
    session, conversation
        Who is where, and who speaks.
    microphones
        Where they are; people stand still during a window.
    acoustics
        How loud it is.
    rng
        Source of the noise.
    """
    instance("session", session, Session)
    instance("conversation", conversation, Conversation)
    if len(conversation.pitches) != len(session.people):
        raise ValueError(
            f"conversation must be of {len(session.people)} people, got {len(conversation.pitches)}"
        )
    instance("microphones", microphones, MicrophoneArray)
    instance("acoustics", acoustics, Acoustics)
    generator(rng)
    hearing = _Hearing(session, conversation, microphones, acoustics, rng)
    return (hearing.window(k) for k in range(int(session.times[-1] / acoustics.window + 1e-9)))


class _Hearing:
    """Microphones in a session; it keeps the voices of the last turns."""

    def __init__(
        self,
        session: Session,
        conversation: Conversation,
        microphones: MicrophoneArray,
        acoustics: Acoustics,
        rng: np.random.Generator,
    ) -> None:
        self.session, self.conversation = session, conversation
        self.microphones, self.acoustics, self.rng = microphones, acoustics, rng
        self.lead = round(acoustics.lead * microphones.rate)  # samples
        self.size = self.lead + round(acoustics.window * microphones.rate)
        self.voice = lru_cache(maxsize=len(session.people) + 1)(self._voice)

    def window(self, count: int) -> SoundWindow:
        """Signals of one of the windows, from the first on."""
        start, talk = count * self.acoustics.window, self.conversation
        end = start + self.acoustics.window
        moment = self.session.at((start + end) / 2)
        signals = own_noise(self.microphones, self.acoustics, rng=self.rng)
        there = (talk.starts < end) & (talk.ends > start - self.acoustics.lead)
        for turn in np.flatnonzero(there).tolist():
            sound, tail = self.voice(turn)
            first = round((start - talk.starts[turn]) * self.microphones.rate) - self.lead
            said = rfft(_piece(sound, first, self.size))
            heard = irfft(said * self.ways(int(talk.who[turn]), moment, tail), n=self.size)
            signals += _pressure(self.acoustics.voice) * heard[:, self.lead :]
        return SoundWindow((start + end) / 2, signals)

    def _voice(self, turn: int) -> tuple[np.ndarray, np.ndarray]:
        """Voice of a turn, and the share of each frequency that comes from everywhere."""
        talk, rate = self.conversation, self.microphones.rate
        own = np.random.default_rng(talk.seeds[turn])
        lasts = talk.ends[turn] - talk.starts[turn]
        sound = speech(lasts, rate, talk.pitches[talk.who[turn]], rng=own)
        tail = _tail(len(self.microphones.places), rate, self.acoustics, rng=own)
        return sound, rfft(tail, n=self.size)

    def ways(self, person: int, moment: Moment, tail: np.ndarray) -> np.ndarray:
        """Transfer function from a voice to each microphone, relative to 1 m ahead: (m, f)."""
        office, (x, y, heading) = self.session.office, moment.robot
        places, up = self.microphones.places, self.microphones.height
        turn = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
        ears = np.column_stack([[x, y] + places @ turn, np.full(len(places), up)])
        gaze, head = moment.gazes[person], self.session.people[person].head
        mouth = np.r_[moment.positions[person], head] + [
            *(_MOUTH[0] * np.array([np.cos(gaze), np.sin(gaze)])),
            -_MOUTH[1],
        ]
        images, mirrored, leaves = paths(office, mouth, np.array([x, y, up]))
        ahead = (1 + np.cos(leaves - gaze)) / 2
        gains = _BEHIND + (1 - _BEHIND) * ahead
        gains = gains * np.where(mirrored, self.acoustics.reflection, 1.0)
        away = np.linalg.norm(ears[:, None] - images, axis=-1)
        near = (away < _LONGEST * SPEED).all(axis=0) & (gains > 0)
        late, away = away[:, near] / SPEED * self.microphones.rate, np.maximum(away[:, near], 0.1)
        heard = _response(late, gains[near] / away, self.size)
        if mirrored.all():
            return heard  # nobody is in sight, nor in the same room
        low, high = office.rooms[office.room_of(moment.robot[:2])].reshape(2, 2)
        return heard + tail / np.sqrt(np.prod(high - low) * office.stage.high)


def _piece(sound: np.ndarray, first: int, size: int) -> np.ndarray:
    """Samples (size,) of a sound from one on; silent before it begins and after it ends."""
    piece = np.zeros(size)
    low, high = max(first, 0), min(first + size, len(sound))
    if low < high:
        piece[low - first : high - first] = sound[low:high]
    return piece
