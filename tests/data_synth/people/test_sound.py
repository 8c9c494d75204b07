"""Sound in the office: turns of speech, ways of sound by laws of mirrors, levels, delays."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from data_synth.people import Person, Wander, World, make_session, record, walk
from data_synth.people.sound import (
    EARS,
    SPEED,
    Acoustics,
    Conversation,
    Manners,
    MicrophoneArray,
    converse,
    delayed,
    hear,
    on_circle,
    own_noise,
    paths,
    speech,
)
from tests.data_synth.last_bits import WAYS, last_bits
from tests.data_synth.offices import office

OFFICE = office(1)
ROOM = OFFICE.rooms[4]
MIDDLE = (ROOM[:2] + ROOM[2:]) / 2
DRY = Acoustics(fan=-np.inf, hiss=-np.inf, reflection=0.0, reverberation=0.0)
COLUMNS = ("who", "starts", "ends", "pitches", "seeds")


@cache
def session():
    rng = np.random.default_rng(3)
    return make_session(OFFICE, rng=rng, duration=60.0, people=3, act=Wander(leaves=0.6))


def talk_of(count=1, *, end=9.0):
    """Everybody speaks from the beginning on."""
    return Conversation(
        *(np.full(count, 120.0), np.arange(count), np.zeros(count), np.full(count, end)),
        np.arange(count) + 7,
    )


def stands(place, *, heading=0.0, facing="robot"):
    """A session of somebody who stands still at a place ahead and left of a robot."""
    turn = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
    place = MIDDLE + np.asarray(place) @ turn
    script = walk(np.array([place, place]), np.array([-5.0, 9.0]), facing=facing)
    person = Person(head=1.5)
    world = World(
        *(OFFICE, [person], [script], np.array([*MIDDLE, heading])), rng=np.random.default_rng(0)
    )
    return record(
        world, [world.now, *(world.advance(0.5) for _ in range(4))], rng=np.random.default_rng(0)
    )


def signals(session, microphones, acoustics, talk=None, seed=0):
    """All windows behind each other (m, n)."""
    talk = talk_of(len(session.people)) if talk is None else talk
    windows = hear(session, talk, microphones, acoustics, rng=np.random.default_rng(seed))
    return np.concatenate([window.signals for window in windows], axis=1)


def level(sound):
    return 20 * np.log10(np.sqrt((sound**2).mean()) / 20e-6)


def test_nobody_speaks_while_absent_and_turns_and_pauses_have_their_lengths():
    assert not session().present.all()
    manners = Manners(pause=(1.0, 3.0), turn=(0.5, 2.0), interrupts=1.0)
    talk = converse(session(), rng=np.random.default_rng(0), manners=manners)
    assert len(talk.who) > 20
    lasts = talk.ends - talk.starts
    assert (lasts > 0).all()
    assert lasts.max() <= 2.0 + 0.051
    for person in range(3):
        mine = talk.who == person
        assert (talk.starts[mine][1:] - talk.ends[mine][:-1] >= 1.0 - 1e-6).all()
        for start, end in zip(talk.starts[mine], talk.ends[mine], strict=True):
            inside = (start - 1e-6 <= session().times) & (session().times < end - 1e-6)
            assert session().present[inside, person].all()
            cut = not session().present[np.abs(session().times - end).argmin(), person]
            assert end - start > 0.5 - 1e-6 or cut or end > 59.9


def test_who_does_not_interrupt_waits_until_the_others_are_silent():
    at_once = {}
    for interrupts in (0.0, 1.0):
        manners = Manners(pause=(0.5, 2.0), interrupts=interrupts)
        talk = converse(session(), rng=np.random.default_rng(1), manners=manners)
        times = np.arange(0.0, 59.9, 0.05)
        speaking = np.array([talk.speaking(t, t + 1e-6) for t in times])
        at_once[interrupts] = (speaking.sum(axis=1) > 1).mean()
    assert at_once[0.0] == 0
    assert at_once[1.0] > 0.3


def test_who_waits_may_begin_as_soon_as_the_speaker_is_gone():
    """Both ask in each of the steps; the first comes late, and the other leaves."""
    times, manners = np.arange(20) * 0.5, Manners((0.1, 0.1), (1000.0, 1000.0), 0.0)
    present = np.stack([times > 2.9, times < 5.9], axis=-1)
    few = replace(session(), people=session().people[:2], times=times, present=present)
    talk = converse(few, rng=np.random.default_rng(0), manners=manners)
    assert talk.who.tolist() == [0, 1]
    np.testing.assert_allclose(talk.ends, [9.5, 6.0])
    np.testing.assert_allclose(talk.starts, [6.0, 0.5])


def test_how_much_of_a_time_somebody_speaks():
    starts, ends = np.array([1.0, 3, 2]), np.array([2.0, 4, 9])
    talk = Conversation(np.ones(2), np.array([0, 0, 1]), starts, ends, np.arange(3))
    np.testing.assert_allclose(talk.speaking(1.5, 3.5), [0.5, 0.75])
    np.testing.assert_allclose(talk.speaking(0.0, 1.0), 0)
    with pytest.raises(ValueError, match="end must be after start 1, got 1"):
        talk.speaking(1.0, 1.0)


@pytest.mark.parametrize("way", WAYS)
def test_a_conversation_is_the_same_with_other_last_bits(way):
    expected = converse(session(), rng=np.random.default_rng(2))
    with last_bits(way):
        found = converse(session(), rng=np.random.default_rng(2))
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**31), st.integers(2, 400))
def test_what_is_delayed_is_a_sum_of_turned_waves(seed, size):
    """A sine is delayed as a formula says, by fractions too; whole delays only roll."""
    rng = np.random.default_rng(seed)
    delays, gains = rng.uniform(0, 50, (2, 3)), rng.normal(size=(2, 3))
    time, turn = np.arange(size), 2 * np.pi * rng.integers(0, (size + 1) // 2) / size
    late = np.cos(turn * (time - delays[..., None]) + 0.3)
    found = delayed(np.cos(turn * time + 0.3), delays, gains)
    np.testing.assert_allclose(found, (gains[..., None] * late).sum(axis=1), atol=1e-9)
    noise, whole = rng.normal(size=size), rng.integers(0, 50, (2, 1))
    rolled = [gain * np.roll(noise, by) for (by,), (gain,) in zip(whole, gains[:, :1], strict=True)]
    np.testing.assert_allclose(delayed(noise, whole, gains[:, :1]), rolled, atol=1e-9)


def test_speech_is_in_syllables_voiced_and_in_the_voice_s_band():
    rate = 16000.0
    sound = speech(8.0, rate, 130.0, rng=np.random.default_rng(0))
    assert sound.shape == (128000,)
    assert (sound**2).mean() == pytest.approx(1)
    power, frequencies = np.abs(np.fft.rfft(sound)) ** 2, np.fft.rfftfreq(128000, 1 / rate)
    assert power[(frequencies > 80) & (frequencies < 5000)].sum() > 0.97 * power.sum()
    assert power[(frequencies > 500) & (frequencies < 4000)].sum() > 0.2 * power.sum()
    loud = 10 * np.log10((sound.reshape(-1, 320) ** 2).mean(axis=1) + 1e-12)
    assert np.percentile(loud, 90) - np.percentile(loud, 10) > 10
    drops = np.diff(np.sign(np.convolve(loud, np.ones(5) / 5, "valid") - loud.mean()))
    assert 15 < (drops != 0).sum() < 120  # some five syllables in a second
    frames = sound.reshape(-1, 1600)
    frames = frames[(frames**2).mean(axis=1) > 0.5]
    whole = np.fft.irfft(np.abs(np.fft.rfft(frames, n=3200)) ** 2)[:, 60:250]
    periods = (whole.argmax(axis=1) + 60) / rate
    assert 1 / np.median(periods) == pytest.approx(130, rel=0.2)


def test_in_a_room_a_sound_comes_straight_and_from_its_mirror_images():
    low, high = ROOM.reshape(2, 2)
    source, ear = np.array([*MIDDLE - [1.1, -0.4], 1.6]), np.array([*MIDDLE, 1.2])
    images, mirrored, leaves = paths(OFFICE, source, ear)
    x, y, z = source
    expected = {
        (x, y, z, False),
        (x, y, -z, True),
        (x, y, 2 * OFFICE.stage.high - z, True),
        (2 * low[0] - x, y, z, True),
        (2 * high[0] - x, y, z, True),
        (x, 2 * low[1] - y, z, True),
        (x, 2 * high[1] - y, z, True),
    }
    door = OFFICE.doors[4].mean(axis=0)  # in the wall with the lower y
    bounce = x + (y - low[1]) / (y + ear[1] - 2 * low[1]) * (ear[0] - x)
    if abs(bounce - door[0]) < 0.55:
        expected.remove((x, 2 * low[1] - y, z, True))
    found = {
        (*place, flag)
        for place, flag in zip(images.round(6).tolist(), mirrored.tolist(), strict=True)
    }
    assert found == {(*np.round(one[:3], 6).tolist(), one[3]) for one in expected}
    toward = np.arctan2(*(ear - source)[1::-1])
    np.testing.assert_allclose(leaves[:3], toward)  # straight, floor and ceiling


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**31))
def test_ways_of_sound_are_the_same_to_and_fro(seed):
    """As long, as many, and what leaves in one direction arrives from its reverse."""
    rng = np.random.default_rng(seed)
    low, high = OFFICE.rooms[:, :2].min(axis=0), OFFICE.rooms[:, 2:].max(axis=0)
    here, there = np.column_stack([rng.uniform(low, high, (2, 2)), rng.uniform(0.5, 2, 2)])
    ways = []
    for source, ear in ((here, there), (there, here)):
        images, mirrored, leaves = paths(OFFICE, source, ear)
        arrives = np.arctan2(*(images - ear)[:, 1::-1].T)
        ways.append((np.linalg.norm(images - ear, axis=1), mirrored, leaves, arrives))
    (long, flags, leaves, _), (back, others, _, arrives) = ways
    order, other = np.argsort(long.round(9)), np.argsort(back.round(9))
    np.testing.assert_allclose(long[order], back[other])
    np.testing.assert_array_equal(flags[order], others[other])
    np.testing.assert_allclose(np.exp(1j * leaves[order]), np.exp(1j * arrives[other]), atol=1e-9)


def test_a_wall_between_hides_and_a_door_lets_sound_through():
    ear = np.array([*MIDDLE, 1.2])
    for other in (0, 1, 2, 3, 5):
        beyond = np.array([*(OFFICE.rooms[other, :2] + OFFICE.rooms[other, 2:]) / 2, 1.6])
        assert paths(OFFICE, beyond, ear)[1].all()
    door = np.column_stack([OFFICE.doors[4], [1.6, 1.2]])
    assert not paths(OFFICE, *door)[1].all()


@pytest.mark.parametrize("heading", [0.0, 2.0])
def test_each_microphone_hears_with_its_delay(heading):
    """The lag between two of them is that of the ways to the mouth, by plain correlation."""
    microphones = MicrophoneArray(rate=48000.0)
    session = stands([1.0, 0.7], heading=heading)
    heard = signals(session, microphones, DRY)
    now = session.at(0.5)
    turn = np.array([[np.cos(heading), np.sin(heading)], [-np.sin(heading), np.cos(heading)]])
    ears = MIDDLE + microphones.places @ turn
    mouth = now.positions[0] + 0.1 * np.array([np.cos(now.gazes[0]), np.sin(now.gazes[0])])
    away = np.hypot(np.hypot(*(ears - mouth).T), 1.5 - 0.08 - 1.2)
    for one in (1, 2, 3):
        together = [heard[0] @ np.roll(heard[one], by) for by in range(-50, 51)]
        lag = np.argmax(together) - 50
        assert lag == pytest.approx((away[0] - away[one]) / SPEED * 48000, abs=0.6)
    gains = np.sqrt((heard**2).mean(axis=1)) * away
    np.testing.assert_allclose(gains, gains[0], rtol=2e-3)


def test_a_voice_gets_softer_with_distance_and_to_its_back():
    one = MicrophoneArray(np.zeros((1, 2)), height=1.42)

    def heard(away, **more):  # after the first 1.5 s, in which the body turns
        return level(signals(stands([away, 0.0], **more), one, DRY)[:, 24000:])

    near, far, behind = heard(1.1), heard(2.1), heard(1.9, facing=0.0)
    assert near == pytest.approx(60, abs=3)  # of half a second of nine
    assert near - far == pytest.approx(20 * np.log10(2), abs=0.1)
    assert far - behind == pytest.approx(20 * np.log10(1 / 0.4), abs=0.1)
    loud = replace(DRY, voice=70.0)
    np.testing.assert_allclose(
        signals(stands([1, 1]), one, loud), np.sqrt(10) * signals(stands([1, 1]), one, DRY)
    )


@pytest.mark.parametrize("bearing", [np.pi / 4, np.pi / 2, 2.5])
def test_who_faces_the_robot_is_as_loud_from_every_side(bearing):
    one = MicrophoneArray(np.zeros((1, 2)))
    place = 1.1 * np.array([np.cos(bearing), np.sin(bearing)])
    ahead, aside = (signals(stands(p), one, DRY)[:, 24000:] for p in ([1.1, 0.0], place))
    assert level(aside) == pytest.approx(level(ahead), abs=0.1)


def test_windows_join():
    """What is heard of somebody who stands is one sound, however it is cut."""
    echoes = Acoustics(fan=-np.inf, hiss=-np.inf)
    session, talk = stands([1.3, -0.5]), talk_of(end=1.2)
    short, long = (
        signals(session, EARS, replace(echoes, window=window), talk) for window in (0.25, 1.0)
    )
    assert np.abs(short - long).max() < np.abs(long).max() / 300  # the rings of the cuts
    assert np.abs(short[:, int(1.21 * 16000)]).max() > 0  # the last echoes come later
    assert np.abs(short[:, -1600:]).max() < 1e-6


def test_walls_and_the_tail_add_what_sabine_says():
    """The energy from everywhere is 16π / A of that at 1 m; a voice is softer to the sides."""
    one = MicrophoneArray(np.zeros((1, 2)))
    session = stands([1.5, 0.0])
    size = np.prod(ROOM[2:] - ROOM[:2]) * OFFICE.stage.high
    for seconds in (0.3, 0.8):
        heard = signals(session, one, replace(DRY, reverberation=seconds))
        straight = signals(session, one, DRY)
        late = 10 ** (-6 * 0.02 / seconds)  # from 20 ms on
        area = 0.161 * size / seconds
        beside = np.mean([(0.7 + 0.3 * c) ** 2 for c in np.linspace(-1, 1, 2001)])
        said = (straight**2).mean() * (1.4**2 + 0.22**2)  # at 1 m
        expected = late * beside * 16 * np.pi / area * said
        assert ((heard - straight) ** 2).mean() == pytest.approx(expected, rel=0.2)
    mirrored = signals(session, one, replace(DRY, reflection=0.7))
    assert level(mirrored) > level(straight) + 0.3


def test_of_who_is_in_another_room_nothing_comes_from_everywhere():
    other = (OFFICE.rooms[3, :2] + OFFICE.rooms[3, 2:]) / 2 - MIDDLE
    loud = replace(DRY, reverberation=1.0)
    assert not signals(stands(other), EARS, loud).any()
    assert signals(stands([1.0, 0.0]), EARS, loud).any()


def test_the_fan_is_one_source_and_hiss_is_each_microphone_s_own():
    array, rng = MicrophoneArray(on_circle(4, 0.15)), np.random.default_rng(0)
    for fan, hiss in ((50.0, -np.inf), (-np.inf, 30.0)):
        acoustics = Acoustics(fan=fan, hiss=hiss, window=4.0)
        noise = own_noise(array, acoustics, rng=rng)
        assert noise.shape == (4, 64000)
        assert level(noise) == pytest.approx(max(fan, hiss), abs=0.5)
        alike = np.corrcoef(noise)[np.triu_indices(4, 1)]
        assert (alike > 0.9).all() if fan > 0 else (np.abs(alike) < 0.02).all()
    low, high = (
        (np.abs(np.fft.rfft(own_noise(array, Acoustics(hiss=-np.inf), rng=rng))) ** 2)
        .T[[np.arange(5, 60), np.arange(500, 555)]]
        .mean(axis=(1, 2))
    )
    assert low > 1000 * high


def test_the_same_seed_gives_the_same_sound_and_windows_follow_each_other():
    talk = converse(session(), rng=np.random.default_rng(5))
    one, other = (
        [next(windows) for _ in range(12)]
        for windows in (
            hear(session(), talk, EARS, Acoustics(), rng=np.random.default_rng(6)) for _ in "ab"
        )
    )
    for a, b in zip(one, other, strict=True):
        np.testing.assert_array_equal(a.signals, b.signals)
        assert a.signals.shape == (2, 4000)
    np.testing.assert_allclose([w.time for w in one], 0.125 + 0.25 * np.arange(12))
    count = sum(
        1 for _ in hear(session(), talk, EARS, Acoustics(window=2.0), rng=np.random.default_rng(6))
    )
    assert count == 30


def test_places_on_a_circle_begin_ahead_and_go_left():
    np.testing.assert_allclose(
        on_circle(4, 0.2), 0.2 * np.array([[1, 0], [0, 1], [-1, 0], [0, -1]]), atol=1e-12
    )


@pytest.mark.parametrize(
    ("make", "reason"),
    [
        (lambda: MicrophoneArray(np.zeros((0, 2))), "places must be one at least"),
        (lambda: Acoustics(reflection=1.5), "reflection must be"),
        (lambda: Acoustics(fan=200.0), "fan must be finite and from -300 to 140"),
        (lambda: Manners(turn=(2.0, 1.0)), "turn must rise from 0.1 s at least, got 2 to 1"),
        (
            lambda: hear(session(), talk_of(2), EARS, DRY, rng=np.random.default_rng(0)),
            "conversation must be of 3 people, got 2",
        ),
        (lambda: delayed(np.zeros(0), np.zeros((1, 1)), np.ones((1, 1))), "signal must hold"),
    ],
)
def test_what_cannot_be_is_refused(make, reason):
    with pytest.raises(ValueError, match=reason):
        make()
