"""Sound: delays of plane waves, directions with their deviations, mirrors, silence, echoes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from data_synth.people import Person, World, record, walk
from data_synth.people.sound import Acoustics, Conversation, MicrophoneArray, hear, own_noise
from robot_perception.people import skin, sound
from robot_perception.people.sound import SoundRules, arrivals, background, detect, gcc_phat
from tests.data_synth.offices import office
from tests.unchecked import unchecked

RATE, SIZE = 16000.0, 4000
SQUARE = np.array([[0.15, 0], [0, 0.15], [-0.15, 0], [0, -0.15]])
EARS = np.array([[0.0, 0.1], [0.0, -0.1]])
SURE = SoundRules(bearing_sigma=0.0, elevation=0.0)
FLAT = np.full(SIZE // 2 + 1, 1e-9)
seeds = st.integers(0, 2**31)


def wave(places, phi, rng, *, level=1.0, elevation=0.0):
    """Return white noise that comes from afar; by its delays in the frequency domain."""
    spectrum = np.fft.rfft(level * rng.standard_normal(SIZE))
    toward = np.cos(elevation) * np.array([np.cos(phi), np.sin(phi)])
    late = -(np.asarray(places) @ toward) / 343.0
    turns = 2 * np.pi * np.fft.rfftfreq(SIZE, 1 / RATE)
    return np.fft.irfft(spectrum * np.exp(-1j * late[:, None] * turns), n=SIZE)


def off(found, phi):
    """Return how far directions are from another, rad."""
    return np.abs(np.angle(np.exp(1j * (np.asarray(found) - phi))))


def some(rng, *, count=4):
    """Return places of microphones in no line, some way apart."""
    turns = 2 * np.pi / count * (np.arange(count) + rng.uniform(-0.3, 0.3, count))
    radius = rng.uniform(0.08, 0.2, count)
    return np.stack([radius * np.cos(turns), radius * np.sin(turns)], axis=-1)


@settings(max_examples=20, deadline=None)
@given(seeds, st.floats(-10, 10))
def test_a_delay_is_found_to_a_fraction_of_a_sample(seed, late):
    rng = np.random.default_rng(seed)
    spectrum = np.fft.rfft(rng.standard_normal(SIZE))
    turn = np.exp(-2j * np.pi * late / SIZE * np.arange(SIZE // 2 + 1))
    signals = np.fft.irfft(np.stack([spectrum * turn, spectrum]), n=SIZE)
    counted = np.arange(SIZE // 2 + 1) % (SIZE // 2) > 0
    (correlation,) = gcc_phat(signals, counted)
    lags = (np.arange(8 * SIZE) / 8 + SIZE / 2) % SIZE - SIZE / 2
    assert lags[correlation.argmax()] == pytest.approx(late, abs=1 / 16 + 1e-3)
    assert 0.8 < correlation.max() < 1 + 1e-9


@settings(max_examples=10, deadline=None)
@given(seeds)
def test_the_correlation_is_that_of_whitened_signals(seed):
    """Sample by sample, in the time domain."""
    rng = np.random.default_rng(seed)
    size = int(rng.integers(40, 60))
    signals, counted = rng.standard_normal((3, size)), np.zeros(size // 2 + 1, dtype=bool)
    counted[rng.choice(np.arange(1, (size - 1) // 2 + 1), 9, replace=False)] = True
    hann = 0.5 - 0.5 * np.cos(2 * np.pi * np.arange(size) / size)
    spectra = np.fft.rfft(signals * hann)
    white = np.fft.irfft(np.where(counted, spectra / np.abs(spectra), 0), n=size)
    found = gcc_phat(signals, counted)
    for row, (a, b) in enumerate([(0, 1), (0, 2), (1, 2)]):
        plain = [
            sum(white[a, (t + lag) % size] * white[b, t] for t in range(size))
            for lag in range(size)
        ]
        np.testing.assert_allclose(found[row, ::8], size / 18 * np.array(plain), atol=1e-9)


@settings(max_examples=20, deadline=None)
@given(seeds, st.floats(-np.pi, np.pi))
def test_a_wave_comes_from_its_direction(seed, phi):
    rng = np.random.default_rng(seed)
    places = some(rng, count=int(rng.integers(3, 6)))
    found = detect(wave(places, phi, rng), places, RATE, FLAT, SoundRules(most=1))
    assert off(found.mean[0, 1], phi) < np.deg2rad(0.5)
    assert np.sqrt(found.cov[0, 1, 1]) == pytest.approx(SoundRules().bearing_sigma, rel=0.3)


def test_arrivals_are_those_of_a_plane_that_moves():
    phi = np.array([0.0, np.pi / 2, -2.0])
    found = arrivals(SQUARE, phi, 340.0)
    np.testing.assert_allclose(found[0], [-0.15 / 340, 0, 0.15 / 340, 0], atol=1e-12)
    np.testing.assert_allclose(found[1], [0, -0.15 / 340, 0, 0.15 / 340], atol=1e-12)
    np.testing.assert_allclose(found[2], -np.cos(phi[2] - np.arange(4) * np.pi / 2) * 0.15 / 340)


@settings(max_examples=20, deadline=None)
@given(seeds, st.floats(-np.pi, np.pi))
def test_a_turn_of_the_robot_turns_the_directions(seed, turn):
    """The same sound at microphones that are said to stand turned comes from a turned direction."""
    rng = np.random.default_rng(seed)
    places = some(rng)
    signals = wave(places, rng.uniform(-np.pi, np.pi), rng) + 0.5 * rng.standard_normal((4, SIZE))
    spin = np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    before = detect(signals, places, RATE, FLAT, SoundRules(most=1))
    after = detect(signals, places @ spin, RATE, FLAT, SoundRules(most=1))
    assert off(after.mean[0, 1], before.mean[0, 1] + turn) < np.deg2rad(0.5)
    np.testing.assert_allclose(after.cov, before.cov, rtol=0.1)


@pytest.mark.parametrize("steps", [1, 2, 3])
def test_a_quarter_of_a_turn_changes_nothing_else(steps):
    signals = wave(SQUARE, 3.0, np.random.default_rng(1))
    before = detect(signals, SQUARE, RATE, FLAT)
    after = detect(np.roll(signals, steps, axis=0), SQUARE, RATE, FLAT)
    turned = off(after.mean[:, 1], before.mean[:, 1])
    np.testing.assert_allclose(turned, (2 - abs(2 - steps)) * np.pi / 2)
    np.testing.assert_allclose(after.cov, before.cov)


def test_how_loud_it_is_does_not_matter_nor_the_order_of_microphones():
    rng = np.random.default_rng(2)
    signals = wave(SQUARE, 1.0, rng) + rng.standard_normal((4, SIZE))
    before = detect(signals, SQUARE, RATE, FLAT)
    for scale, order in ((1e-3, [0, 1, 2, 3]), (1.0, [2, 0, 3, 1])):
        after = detect(scale * signals[order], SQUARE[order], RATE, scale**2 * FLAT)
        np.testing.assert_allclose(after.mean, before.mean, atol=1e-9)
        np.testing.assert_allclose(after.cov, before.cov, atol=1e-9)


@pytest.mark.parametrize("level", [1e-6, 1.0])
def test_in_silence_nobody_is_heard(level):
    rng = np.random.default_rng(3)
    array, acoustics = MicrophoneArray(SQUARE), Acoustics()
    noise = level * np.array([own_noise(array, acoustics, rng=rng) for _ in range(80)])
    known = background(noise[:20])
    assert sum(len(detect(one, SQUARE, RATE, known).mean) for one in noise[20:]) == 0
    assert len(detect(np.zeros((4, SIZE)), SQUARE, RATE, known).mean) == 0
    assert len(detect(np.zeros((4, SIZE)), SQUARE, RATE, 0 * known).mean) == 0


@pytest.mark.parametrize("level", [1e-2, 1.0])
def test_noise_that_comes_from_nowhere_is_nobody_however_loud(level):
    """Each microphone has its own: no direction agrees, and the best of them is not good."""
    rng = np.random.default_rng(15)
    for _ in range(5):
        assert len(detect(level * rng.standard_normal((4, SIZE)), SQUARE, RATE, FLAT).mean) == 0


def test_the_background_is_the_mean_power_of_what_is_heard():
    rng = np.random.default_rng(4)
    noise = rng.standard_normal((300, 2, 64))
    found = background(noise)
    np.testing.assert_allclose(found[1:-1], 0.375 * 64, rtol=0.2)  # of a Hann window
    np.testing.assert_allclose(background(3 * noise), 9 * found)


def test_a_steady_loud_noise_is_part_of_the_background():
    """The fan comes from somewhere; a voice over it is found and the fan is not."""
    rng = np.random.default_rng(5)
    fan = [wave(SQUARE, -2.0, rng) + 0.1 * rng.standard_normal((4, SIZE)) for _ in range(40)]
    known = background(np.array(fan[:20]))
    assert not any(len(detect(one, SQUARE, RATE, known).mean) for one in fan[20:])
    found = detect(fan[20] + wave(SQUARE, 1.0, rng, level=4.0), SQUARE, RATE, known)
    assert off(found.mean[0, 1], 1.0) < np.deg2rad(3)


def test_a_quarter_of_a_second_of_a_whistle_is_no_voice():
    whistle = np.sin(2 * np.pi * 1000 * np.arange(SIZE) / RATE)[None].repeat(4, axis=0)
    noise = 0.01 * np.random.default_rng(6).standard_normal((4, SIZE))
    known, voice = background(noise[None]), wave(SQUARE, 0.3, np.random.default_rng(7))
    assert len(detect(whistle + noise, SQUARE, RATE, known).mean) == 0
    assert len(detect(voice + noise, SQUARE, RATE, known).mean) == 1


@pytest.mark.parametrize("seed", range(5))
def test_several_speakers_are_several_directions(seed):
    rng = np.random.default_rng(seed)
    phi = rng.uniform(-np.pi, np.pi) + np.array([0.0, 1.5, 3.5])
    signals = sum(wave(SQUARE, p, rng, level=v) for p, v in zip(phi, (2.0, 1.6, 1.3), strict=True))
    three = detect(signals, SQUARE, RATE, FLAT, SoundRules(most=3, beside=0.1)).mean[:, 1]
    assert (off(three[:, None], phi).argmin(axis=1) == [0, 1, 2]).all()  # the strongest first
    assert off(three, phi).max() < np.deg2rad(6)
    for most in (1, 2):
        found = detect(signals, SQUARE, RATE, FLAT, SoundRules(most=most, beside=0.1)).mean[:, 1]
        np.testing.assert_array_equal(found, three[:most])


@pytest.mark.parametrize("middle", [0.0, 1.5, np.pi])
def test_what_is_near_to_a_speaker_is_that_speaker_also_behind(middle):
    rng = np.random.default_rng(1)
    signals = sum(wave(SQUARE, middle + side, rng) for side in (-0.4, 0.4))
    for apart, count in ((0.5, 2), (0.9, 1)):
        rules = SoundRules(apart=apart, beside=0.3)
        assert len(detect(signals, SQUARE, RATE, FLAT, rules).mean) == count


def test_one_wave_is_one_direction_however_many_are_asked_for():
    signals = wave(SQUARE, 0.7, np.random.default_rng(8))
    assert len(detect(signals, SQUARE, RATE, FLAT, SoundRules(most=9)).mean) == 1


@pytest.mark.parametrize("phi", [0.0, 0.8, -2.0])
def test_somebody_near_and_above_is_one_direction(phi):
    """No plane wave fits a mouth 0.8 m away and 0.4 m up: what it leaves over is nobody."""
    rng = np.random.default_rng(8)
    mouth = np.array([0.8 * np.cos(phi), 0.8 * np.sin(phi), 0.4])
    late = np.linalg.norm(np.column_stack([SQUARE, np.zeros(4)]) - mouth, axis=1) / 343.0
    turns = 2 * np.pi * np.fft.rfftfreq(SIZE, 1 / RATE)
    spectrum = np.fft.rfft(rng.standard_normal(SIZE))
    signals = np.fft.irfft(spectrum * np.exp(-1j * late[:, None] * turns), n=SIZE)
    found = detect(signals, SQUARE, RATE, FLAT)
    assert len(found.mean) == 1
    assert off(found.mean[0, 1], phi) < np.deg2rad(10)
    assert len(detect(signals, SQUARE, RATE, FLAT, SoundRules(beside=0.1)).mean) == 2


@pytest.mark.parametrize("axis", [np.pi / 2, 0.4])
@pytest.mark.parametrize("count", [2, 3])
def test_microphones_in_a_line_report_both_mirror_directions(axis, count):
    line = np.linspace(-0.1, 0.1, count)[:, None] * [np.cos(axis), np.sin(axis)] + [0.02, 0.01]
    rng = np.random.default_rng(9)
    for away in (0.6, 1.5, -2.3):
        found = detect(wave(line, axis + away, rng), line, RATE, FLAT, SoundRules(most=1))
        assert len(found.mean) == 2
        assert off(found.mean[:, 1].sum(), 2 * axis) == pytest.approx(0, abs=1e-9)
        assert off(found.mean[:, 1], axis + away).min() < np.deg2rad(2)
        np.testing.assert_array_equal(found.cov[0], found.cov[1])
    along = detect(wave(line, axis, rng), line, RATE, FLAT, SoundRules(most=1))
    assert off(along.mean[:, 1], axis).max() < np.deg2rad(10)
    assert along.cov[0, 1, 1] > 4 * found.cov[0, 1, 1]


@pytest.mark.parametrize(("places", "level"), [(SQUARE, 0.7), (SQUARE, 1.2), (EARS, 0.7)])
def test_directions_are_as_far_off_as_they_say(places, level):
    """The mean of squared errors over claimed variances; 0.8 to 1.25 is 3 sigma of 300 draws."""
    rng = np.random.default_rng(10)
    ratios = []
    for _ in range(300):
        phi = rng.uniform(-0.5, 0.5)
        signals = wave(places, phi, rng) + level * rng.standard_normal((len(places), SIZE))
        found = detect(signals, places, RATE, FLAT, SURE)
        if len(found.mean):
            ratios.append(off(found.mean[:, 1], phi).min() ** 2 / found.cov[0, 1, 1])
    assert len(ratios) > 250
    assert 0.7 < np.mean(ratios) < 1.5


@pytest.mark.parametrize("theta", [0.5, 1.0, 2.0])
def test_of_a_line_of_microphones_an_unknown_elevation_is_part_of_the_deviation(theta):
    r"""From an elevation ε the lag is that of :math:`\cos\theta' = \cos\varepsilon \cos\theta`."""
    rules = SoundRules(bearing_sigma=0.0, elevation=0.2)
    phi = np.pi / 2 - theta  # theta from the line
    signals = wave(EARS, phi, np.random.default_rng(11))
    found = detect(signals, EARS, RATE, FLAT, rules)
    expected = (1 - np.cos(0.2)) / abs(np.tan(theta))
    assert np.sqrt(found.cov[0, 1, 1]) == pytest.approx(expected, rel=0.1)
    signals = wave(EARS, phi, np.random.default_rng(11), elevation=0.2)
    raised = detect(signals, EARS, RATE, FLAT, rules)
    moved = off(np.arccos(np.cos(0.2) * np.cos(theta)), theta)
    assert off(raised.mean[:, 1], found.mean[0, 1]).min() == pytest.approx(moved, abs=0.01)
    square = detect(wave(SQUARE, phi, np.random.default_rng(11)), SQUARE, RATE, FLAT, rules)
    assert np.sqrt(square.cov[0, 1, 1]) < 0.1 * expected


def test_nothing_is_known_of_the_distance_as_with_the_camera():
    found = detect(wave(SQUARE, 1.0, np.random.default_rng(12)), SQUARE, RATE, FLAT)
    camera = skin.SkinRules()
    assert found.mean[0, 0] == camera.distance
    assert found.cov[0, 0, 0] == camera.range_sigma**2
    assert found.cov[0, 0, 1] == found.cov[0, 1, 0] == 0
    far = detect(
        wave(SQUARE, 1.0, np.random.default_rng(12)),
        *(SQUARE, RATE, FLAT, SoundRules(distance=5.0, range_sigma=3.0)),
    )
    assert (far.mean[0, 0], far.cov[0, 0, 0]) == (5.0, 9.0)


OFFICE = office(1)
MIDDLE = (OFFICE.rooms[4, :2] + OFFICE.rooms[4, 2:]) / 2


def heard(phi, acoustics):
    """Return what is heard for 4 s of somebody who speaks at 2 m and looks away from the robot."""
    place = MIDDLE + 2.0 * np.array([np.cos(phi), np.sin(phi)])
    stands = walk(np.array([place, place]), np.array([0.0, 9.0]), facing=phi)
    rng = np.random.default_rng(13)
    world = World(OFFICE, [Person()], [stands], np.array([*MIDDLE, 0.0]), rng=rng)
    session = record(world, [world.now, *(world.advance(1.0) for _ in range(6))], rng=rng)
    talk = Conversation(
        *(np.array([120.0]), np.array([0]), np.zeros(1), np.array([9.0]), np.array([1]))
    )
    windows = hear(session, talk, MicrophoneArray(SQUARE), acoustics, rng=rng)
    return np.array([window.signals for window in windows])[8:]  # until then the body turns


@pytest.mark.parametrize("reflection", [0.0, 0.9])
def test_echoes_are_heard_too_and_the_direct_sound_is_found(reflection):
    """Who looks at a wall is heard from there, too: such directions are nobody's."""
    acoustics = Acoustics(reflection=reflection, reverberation=0.0)
    rng, array = np.random.default_rng(14), MicrophoneArray(SQUARE)
    known = background(np.array([own_noise(array, acoustics, rng=rng) for _ in range(20)]))
    false = 0
    for phi in (0.4, 2.5, -1.3):
        windows = heard(phi, acoustics)
        found = [detect(w, SQUARE, RATE, known, SoundRules(most=3)).mean[:, 1] for w in windows]
        right = [bool((off(one, phi) < np.deg2rad(10)).any()) for one in found]
        assert np.mean(right) > (0.8 if reflection else 0.9)
        false += sum((off(one, phi) > np.deg2rad(10)).sum() for one in found)
    assert 0 < false < 1.5 * 48 if reflection else false == 0


@pytest.mark.parametrize(
    ("changed", "reason"),
    [
        ({"signals": np.ones((4, 9, 1))}, r"signals must be \(m, n\)"),
        ({"signals": np.full((4, SIZE), np.nan)}, "signals must be finite"),
        ({"places": SQUARE[:3]}, r"places must be \(4, 2\) for signals"),
        ({"places": np.zeros((4, 2))}, "places must be apart, got two with 0 m"),
        ({"places": SQUARE * [1, 0]}, "places must be apart"),
        (
            {"signals": np.ones((1, SIZE)), "places": SQUARE[:1]},
            "places must be of two microphones",
        ),
        ({"rate": 0.0}, "rate must be positive"),
        ({"rate": 8000.0}, "rate must be more than twice the band's 4000 Hz, got 8000"),
        ({"background": FLAT[:-1]}, r"background must be \(2001,\) for signals"),
        ({"background": -FLAT}, "background must not be negative"),
        ({"signals": np.ones((4, 3)), "background": np.ones(2)}, "signals of 3 samples at rate"),
    ],
)
def test_what_is_no_window_is_refused(changed, reason):
    valid = {"signals": np.ones((4, SIZE)), "places": SQUARE, "rate": RATE, "background": FLAT}
    with unchecked(), pytest.raises(ValueError, match=reason):
        detect(**{**valid, **changed})


@pytest.mark.parametrize(
    ("changed", "reason"),
    [
        ({"band": (4000.0, 500.0)}, "band must rise"),
        ({"elevation": 1.6}, "elevation must be from 0 to π/2"),
        ({"bearing_sigma": -0.1}, "bearing_sigma must not be negative"),
        ({"voiced": 0.0}, "voiced must be between 0 and 1"),
        ({"most": 0}, "most must be"),
    ],
)
def test_what_are_no_rules_is_refused(changed, reason):
    with pytest.raises(ValueError, match=reason):
        SoundRules(**changed)


@pytest.mark.parametrize("scale", [1e-30, 1e-300, 1e-307, 1e-310, 5e-324, 0.0])
def test_however_low_a_sound_is_its_correlation_is_a_number(scale):
    counted = np.arange(101) % 100 > 0
    signals = np.random.default_rng(0).uniform(0.5, 2, (3, 200))
    found, loud = gcc_phat(scale * signals, counted), gcc_phat(signals, counted)
    assert np.isfinite(found).all()
    assert np.allclose(found, loud if scale > 1e-300 else 0.0, atol=1e-6) or scale == 1e-300


@pytest.mark.parametrize("which", [[0], [4], [9]])
def test_only_frequencies_with_a_phase_can_be_counted(which):
    counted = np.zeros(5, dtype=bool)
    counted[[k for k in which if k < 5]] = True
    with pytest.raises(ValueError, match="counted must tell frequencies with a phase"):
        gcc_phat(np.random.default_rng(0).standard_normal((2, 8)), counted)
    assert sound.gcc_phat(np.eye(2, 9) + 1.0, np.arange(5) > 0).shape == (1, 72)
