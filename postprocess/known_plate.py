"""A plane jet that falls on a level plate, of which the right answer is known: it runs out both ways, at its surface with
the speed of its total head, sqrt(U² + 2 g (H − d)); the plate bears the weight of the water over it and takes what
momentum comes down to it (Milne-Thomson, Theoretical Hydrodynamics, §11.42). U is the speed with which water leaves the
nozzle, a spacing ahead of the opening (inputs/README.md, "Inlets and drains"), and H the height of that above the plate.
No program of its own; study_motion.py runs it.
"""

import math
from functools import partial

import numpy as np

from known_motion import Motion, scene_of
from study import GRAVITY


def plate(rate, spacing=0.05, wide=0.2, speed=3.0, fall=0.65, seconds=1.2, length=1.4):
    """A plane jet, six spacings across, goes down at `speed` from an opening `fall` above the plate, an obstacle; the water
    ends beyond `length` both ways."""
    width, top = round(6 * spacing, 12), 2 * spacing
    box = (f'[[obstacle]]\ntype = "box"\ncenter = [0, {width / 2!r}, {top - 0.3!r}]\n'
           f"size = [{2 * length + 2!r}, {width + 1!r}, 0.6]\n")
    inlet = (f'[[inlet]]\ntype = "rectangle"\ncenter = [0, {width / 2!r}, {top + fall!r}]\nsize = [{wide!r}, {width!r}]\n'
             f"direction = [0, 0, -1]\nspeed = {speed!r}\n")
    drains = "".join(f'[[drain]]\ntype = "plane"\ncenter = [{side * length!r}, 0, 0]\naxis = [{side}, 0, 0]\n'
                     for side in (1, -1))
    text = scene_of((-length - 0.2, 0, 0), (length + 0.2, width, top + fall + 0.5), spacing, 1 / rate, seconds, every=0.02,
                    extra=box + inlet + drains)
    return Motion(text, partial(plate_figures, spacing, wide, speed, fall, top))


def plate_figures(spacing, wide, speed, fall, top, run, last=0.4, high=0.5):
    """In the mean of the last 0.4 s, from 0.8 to 1.2 m beside the jet: speed along the plate over that of the total head
    at the surface. And the force on the plate over the weight and momentum of the water below `high`, m, over it."""
    fall -= spacing  # from the end of the nozzle
    late = [state for state, time in zip(run.states, run.times) if time > run.times[-1] - last]
    place, velocity = (np.concatenate(part) for part in zip(*late))
    width, height = 6 * spacing, place[:, 2] - top
    sheet = (np.abs(place[:, 0]) > 0.8) & (np.abs(place[:, 0]) < 1.2)
    thick = sheet.sum() / len(late) * spacing**3 / (0.8 * width)
    ideal = math.sqrt(speed**2 + 2 * GRAVITY * (fall - thick))
    below = (height < high).sum() / len(late) * 1000 * spacing**3 * GRAVITY
    arriving = 1000 * speed * wide * width * math.sqrt(speed**2 + 2 * GRAVITY * (fall - high))
    time = np.array(run.obstacles["time"])
    force = -np.array(run.obstacles["force_z_0"])[time > run.times[-1] - last].mean()
    return {"speed_ratio": np.abs(velocity[sheet, 0]).mean() / ideal,
            "speed_across": np.abs(velocity[sheet, 1]).mean() / ideal, "force_ratio": force / (below + arriving)}
