#!/usr/bin/python3
"""Waves by paddles in a thin tank: how high they are, what they lose on their way, and what the zone at the end sends back.

  postprocess/study_waves.py postprocess/results/waves.csv

What the disc of a gauge takes of a wave is divided out. Regular waves: the first harmonic of each of a row of gauges over
whole periods once the waves are there is split by least squares into one wave that goes and decays, and one that comes back;
three harmonics make up crests and troughs. Irregular waves: H_m0 and the peak of the spectrum of one gauge. Beside both stands
what potential flow (known_waves.py) has of the same piston, over what it has of waves a tenth as high. Solitary wave: speed and
height by lines through the crests that 41 gauges see. One row for each quantity, beside what theory says.
"""

import math
import tempfile
from pathlib import Path

import numpy as np

from known_waves import first_harmonic_of_piston, levels_of_irregular, levels_of_solitary, share_seen, wave_numbers
from study import GRAVITY, columns_of, launch, parser_of, two_at_a_time, write_table

SPACING = 0.05  # m
LAYERS = 15
LENGTH = 60  # spacings a wavelength
WIDE = 6  # spacings, across
DEPTH = LAYERS * SPACING
GAUGE_RADIUS = 2  # spacings, the default
SCENE = """
[domain]
min = [0, 0, 0]
max = [{end}, {wide}, {high}]
periodic = ["y"]
[fluid]
spacing = {spacing}
[[particles]]
min = [0, 0, 0]
max = [{end}, {wide}, {depth}]
[time]
dt = {dt}
end = {seconds}
[gravity]
[[wavemaker]]
{waves}
height = {height}
position = {front}
[[damping]]
min = [{zone}, 0, 0]
max = [{end}, {wide}, {high}]
rate = {rate}
[output.gauges]
every = 0.0333333333333333
"""
GAUGE = '[[gauge]]\ntype = "height"\ncenter = [{}, {}, 0]\n'
# Height in spacings, a step in s; finer: layers of half the spacing, in two dimensions; lengths of the tank up to the zone,
# in wavelengths.
CASES = {
    "piston": {"paddle": "piston", "height": 3, "dt": 1 / 60},
    "piston, half the step": {"paddle": "piston", "height": 3, "dt": 1 / 120},
    "piston, long tank": {"paddle": "piston", "height": 3, "dt": 1 / 60, "lengths": 11},
    "piston, low": {"paddle": "piston", "height": 1.5, "dt": 1 / 60},
    "piston, high": {"paddle": "piston", "height": 4, "dt": 1 / 60},
    "flap": {"paddle": "flap", "height": 3, "dt": 1 / 60},
    "solitary": {"paddle": "piston", "height": 0.3 * LAYERS, "dt": 1 / 60},
    "jonswap": {"paddle": "piston", "height": 4, "dt": 1 / 60},
    "jonswap, half as steep": {"paddle": "piston", "height": 4, "dt": 1 / 120, "finer": 2},
}


def tank(case, waves, **more):
    """The scene of a tank with a paddle 0.5 m from its end; `length` up to the zone, m."""
    front = 1.0 if "solitary" in waves else 0.5
    zone = front + more["length"]
    end = round((zone + more["absorbing"]) / (2 * SPACING)) * 2 * SPACING
    spacing = SPACING / case.get("finer", 1)
    text = SCENE.format(end=end, wide=WIDE * SPACING, high=2 * DEPTH, spacing=spacing, depth=DEPTH, dt=case["dt"],
                        seconds=more["seconds"], waves=waves, height=case["height"] * spacing, front=front,
                        zone=end - more["absorbing"], rate=more.get("rate", 5))
    return text + "".join(GAUGE.format(front + x, WIDE * SPACING / 2) for x in more["places"])


def run(text, folder, name, trevi, settings=()):
    scene, output = folder / f"{name}.toml", folder / name
    scene.write_text(text, encoding="utf-8")
    code, message = launch(trevi, scene, output, settings, 7200)
    if code != 0:
        raise SystemExit(f"study_waves.py: {name}: {message}")
    columns = {key: np.array(values) for key, values in columns_of(output / "gauges.csv").items()}
    heights = [columns[f"height_{k}"] for k in range(sum(key.startswith("height_") for key in columns))]
    return columns["time"], np.array(heights)


def harmonics_of(time, height, period, cycles):
    """Of n = 1, 2, 3: a of a cos(nwt) + b sin(nwt) as a - ib, over the last cycles."""
    late = time > time[-1] - cycles * period
    t, h = time[late], height[late]
    waves = [f(2 * math.pi * n * t / period) for n in (1, 2, 3) for f in (np.cos, np.sin)]
    parts = np.linalg.lstsq(np.stack([np.ones_like(t), *waves], axis=1), h, rcond=None)[0][1:]
    return parts[::2] - 1j * parts[1::2]


def crest_to_trough(harmonics):
    """Of the wave that they make up."""
    phase = np.linspace(0, 2 * math.pi, 360, endpoint=False)
    return np.ptp(sum((a * np.exp(1j * n * phase)).real for n, a in enumerate(harmonics, 1)))


def split(places, harmonics):
    """Wavelength and decay a wavelength of the wave that goes, its amplitude at 0, and that of the one that comes back over that
    of the one that goes at the last place. Places are in wavelengths of theory."""
    best = (np.inf, )
    for length in np.linspace(0.94, 1.06, 121):
        for decay in np.linspace(-0.02, 0.08, 101):
            along = (2j * math.pi / length + decay) * places
            both = np.stack([np.exp(-along), np.exp(along)], axis=1)
            parts, *_ = np.linalg.lstsq(both, harmonics, rcond=None)
            off = np.linalg.norm(both @ parts - harmonics)
            if off < best[0]:
                back = abs(parts[1]) * math.exp(2 * decay * places[-1]) / abs(parts[0])
                best = off, length, decay, abs(parts[0]), back
    return best[1:]


def regular(case, folder, name, trevi):
    length = LENGTH * SPACING
    k = 2 * math.pi / length
    period = 2 * math.pi / math.sqrt(GRAVITY * k * math.tanh(k * DEPTH))
    lengths = case.get("lengths", 6)
    places = np.arange(0.5, lengths - 0.49, 0.25)
    text = tank(case, f'type = "{case["paddle"]}"\nperiod = {period}', length=lengths * length, absorbing=2 * length,
                seconds=(13 + 2 * lengths) * period, places=places * length)
    time, heights = run(text, folder, name, trevi)
    harmonics = np.array([harmonics_of(time, height, period, 11) for height in heights])
    harmonics /= share_seen(k * np.arange(1, 4), SPACING, GAUGE_RADIUS * SPACING, 3)
    long, decay, amplitude, back = split(places, harmonics[:, 0])
    over = 2 * amplitude / (case["height"] * SPACING)
    yield "wavelength over that of theory", 1, long
    for n in (0, 2, 5, 10)[:4 if lengths > 10 else 3]:
        yield f"height over that of theory, {n} wavelengths from the paddle", 1, over * math.exp(-decay * n)
    crests = np.mean([crest_to_trough(one) for one in harmonics]) / (case["height"] * SPACING)
    yield "height from crest to trough over that of theory, mean of all gauges", 1, crests
    yield "height lost per wavelength", 0, 1 - math.exp(-decay)
    yield "reflection from the zone", 0, back
    if case["paddle"] == "piston":
        high = case["height"] * SPACING
        yield "height over that of theory, potential flow in place of particles", 1, \
            first_harmonic_of_piston(high, length, DEPTH) / first_harmonic_of_piston(high / 10, length, DEPTH)


def solitary(case, folder, name, trevi):
    height, depths = case["height"] * SPACING, np.arange(10, 30.01, 0.5)
    celerity = math.sqrt(GRAVITY * (DEPTH + height))
    text = tank(case, 'type = "piston"\nwave = "solitary"', length=34 * DEPTH, absorbing=6 * DEPTH,
                seconds=30 * DEPTH / celerity + 6, places=depths * DEPTH)
    time, heights = run(text, folder, name, trevi)
    yield from crests_of(time, heights - DEPTH, depths, height, "")
    times, levels = levels_of_solitary(height, DEPTH, depths)
    yield from crests_of(times, levels.T, depths, height, ", potential flow in place of particles")


def crests_of(time, levels, depths, height, whose):
    """Speed and height of a solitary wave by lines through what is seen at all places, as single crests scatter."""
    arrivals, crests = [], []
    for level in levels:
        top = np.argmax(level)
        near = slice(max(top - 5, 0), top + 6)  # a parabola through the crest
        a, b, c = np.polyfit(time[near] - time[top], level[near], 2)
        arrivals.append(time[top] - b / (2 * a))
        crests.append(c - b * b / (4 * a))
    line = np.polyfit(depths, crests, 1)
    near, far = np.polyval(line, [10, 30])
    speed = DEPTH / np.polyfit(depths, arrivals, 1)[0]
    yield "celerity over that of theory" + whose, 1, speed / math.sqrt(GRAVITY * (DEPTH + np.mean(crests)))
    yield "height over that of theory, 10 depths from the paddle" + whose, 1, near / height
    yield "height lost in 20 depths" + whose, 0, 1 - far / near
    yield "scatter of single crests about their line, of the height" + whose, 0, np.std(crests - np.polyval(line, depths)) / height


def significant_height(time, level, period, seen=None):
    """H_m0 from 0.4 to 3 of the peak's frequency, and the peak's over what was asked for, from eight periods on; seen: of each
    angular frequency the share of the amplitude that is measured, by default all."""
    late = time > 8 * period
    level, step = level[late] - level[late].mean(), time[1] - time[0]
    frequency, density = np.fft.rfftfreq(len(level), step), np.abs(np.fft.rfft(level)) ** 2
    band = (frequency > 0.4 / period) & (frequency < 3 / period)
    frequency, density = frequency[band], density[band] * 2 / len(level) ** 2
    if seen is not None:
        density /= seen(2 * math.pi * frequency) ** 2
    wide = np.convolve(density, np.ones(9) / 9, "same") ** 4
    # Delft: a mean weighted by the fourth power of the smoothed density.
    return 4 * math.sqrt(density.sum()), (frequency * wide).sum() / wide.sum() * period


def irregular(case, folder, name, trevi):
    length, spacing, plane = LENGTH * SPACING, SPACING / case.get("finer", 1), "finer" in case
    k, height = 2 * math.pi / length, case["height"] * spacing
    period = 2 * math.pi / math.sqrt(GRAVITY * k * math.tanh(k * DEPTH))
    text = tank(case, f'type = "piston"\nwave = "irregular"\nperiod = {period}', length=2 * length, absorbing=2 * length,
                seconds=72 * period, places=[length], rate=6)
    settings = ["domain.dimensions=2", "domain.periodic=[]"] if plane else []
    time, heights = run(text, folder, name, trevi, settings)

    def seen(omega):
        return share_seen(wave_numbers(omega, DEPTH), spacing, GAUGE_RADIUS * spacing, 2 if plane else 3)

    significant, peak = significant_height(time, heights[0], period, seen)
    yield "H_m0 over what was asked for, from 0.4 to 3 of the peak's frequency", 1, significant / height
    yield "peak's frequency over what was asked for", 1, peak
    high, low = (significant_height(*levels_of_irregular(h, length, DEPTH, 40), period)[0] for h in (height, height / 10))
    yield "H_m0 over what was asked for, potential flow in place of particles", 1, high / low / 10


def main():
    parser = parser_of(__doc__, "CSV")
    parser.add_argument("--only", default="", help="cases with this in their names")
    options = parser.parse_args()
    kinds = {"solitary": solitary, "jonswap": irregular}

    def rows_of(name):
        case = CASES[name]
        quantities = kinds.get(name.split(",")[0], regular)(case, folder, name.replace(", ", "_").replace(" ", "_"), options.trevi)
        return [{"case": name, "height_spacings": case["height"], "step_s": round(case["dt"], 5), "quantity": quantity,
                 "theory": theory, "measured": round(float(measured), 4)} for quantity, theory, measured in quantities]

    rows = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for some in two_at_a_time(rows_of, [name for name in CASES if options.only in name]):
            for row in some:
                print(*row.values(), sep=", ", flush=True)
            rows += some
    write_table(options.output, rows)


if __name__ == "__main__":
    main()
