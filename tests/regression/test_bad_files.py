#!/usr/bin/python3
"""Damaged and foreign HDF5 files, as particle input and as checkpoint, and restarts that cannot be.

Each such case must end with exit code 2, a message that names the file and what is wrong in it, no stack trace, on 1
and 2 ranks alike. Those of older versions go on. usage: test_bad_files.py [RANKS ...] (default 1 2). How the program is found: runs.py.
"""

import re
import shutil
import sys
from pathlib import Path

import h5py
import numpy
import runs
from runs import CHECKPOINTS, CUBE, FLOW, FRAMES, Folder

COUNT = 600
CLOUD = CUBE[:CUBE.index("[[particles]]")] + '[[particles]]\ntype = "file"\npath = "cloud.h5"\n' + CUBE[CUBE.index("[time]"):]


# ---- what is done to a good file; each takes the open file ------------------------------------------------------

def replace(name, data, **options):
    def change(file):
        del file[name]
        file.create_dataset(name, data=data, **options)
    return change


def element(name, row, value):
    def change(file):
        file[name][row] = value
    return change


def remove(name):
    def change(file):
        del file[name]
    return change


def attribute(name, value):
    def change(file):
        if value is None:
            del file.attrs[name]
        else:
            file.attrs[name] = value
    return change


def never_filled(name, shape, **options):
    """A table that is named and has no rows on the disk: a few kB that claim gigabytes."""
    def change(file):
        del file[name]
        file.create_dataset(name, shape, **options)
    return change


def group_in_place(name):
    def change(file):
        del file[name]
        file.create_group(name)
    return change


def link(name, target):
    def change(file):
        del file[name]
        file[name] = target
    return change


# ---- or to its bytes -------------------------------------------------------------------------------------------------

def cut(share):
    return lambda data: data[:int(len(data) * share)]


def flip(place):
    def change(data):
        at = place if place >= 0 else len(data) + place
        return data[:at] + bytes([data[at] ^ 0x10]) + data[at + 1:]
    return change


def flip_after(mark, distance):
    return lambda data: flip(data.index(mark) + distance)(data)


NUMBERS = numpy.random.default_rng(1)
PLACES = NUMBERS.uniform(0.1, 0.5, (COUNT, 3))
IDS = numpy.arange(COUNT)

# name: change, words of the message
PARTICLE_FILES = {
    "not there": (None, ["No such file"]),
    "empty": (lambda data: b"", ["not an HDF5 file"]),
    "text": (lambda data: b"x y z\n1 2 3\n", ["not an HDF5 file"]),
    "cut to half": (cut(0.5), ["cut short"]),
    "cut by a byte": (cut(0.99999), ["cut short"]),
    "no particles": (remove("particles"), ["/particles/position", "missing"]),
    "no position": (remove("particles/position"), ["/particles/position", "missing"]),
    "a group for a table": (group_in_place("particles/position"), ["/particles/position", "dataset"]),
    "a link to nowhere": (link("particles/position", h5py.SoftLink("/nowhere")), ["/particles/position"]),
    "a link to another file": (link("particles/position", h5py.ExternalLink("gone.h5", "/x")), ["/particles/position"]),
    "two columns": (replace("particles/position", PLACES[:, :2]), ["shape (600, 2)", "(N, 3)"]),
    "a sparse table": (never_filled("particles/position", (400_000_000, 3), dtype=float, chunks=(4096, 3)),
                       ["/particles/position: claims 400000000 rows, 9.6 GB"]),
    "an empty table": (never_filled("particles/position", (400_000_000, 3), dtype=float),
                       ["/particles/position: claims 400000000 rows, 9.6 GB"]),
    "flat": (replace("particles/position", PLACES.ravel()), ["shape (1800)", "(N, 3)"]),
    "three dimensions": (replace("particles/position", PLACES[None]), ["shape (1, 600, 3)"]),
    "a single number": (replace("particles/position", 1.0), ["/particles/position", "shape"]),
    "whole numbers": (replace("particles/position", PLACES.astype(int)), ["wrong type of number", "floating-point"]),
    "words": (replace("particles/position", numpy.full((COUNT, 3), b"abc")), ["wrong type of number"]),
    "a NaN": (element("particles/position", 17, [0.1, numpy.nan, 0.1]), ["/particles/position", "row 17", "not finite"]),
    "infinite": (element("particles/velocity", 599, numpy.inf), ["/particles/velocity", "row 599", "not finite"]),
    "outside": (element("particles/position", 3, [9, 0, 0]), ["/particles/position: row 3 is outside the box"]),
    "short velocity": (replace("particles/velocity", PLACES[:-1]), ["/particles/velocity", "599 rows", "600"]),
    "ids twice": (element("particles/id", 5, 6), ["/particles/id", "6 occurs more than once"]),
    "an id below 0": (element("particles/id", 5, -6), ["/particles/id", "row 5 is -6", "from 0"]),
    "an id too large": (element("particles/id", 5, 2**63 - 1), ["/particles/id", "row 5", "below 2^62"]),
    "broken ids": (replace("particles/id", IDS + 0.5), ["/particles/id", "wrong type", "integers"]),
    "ids in two columns": (replace("particles/id", numpy.stack([IDS, IDS], 1)), ["/particles/id", "shape (600, 2)"]),
    "no rows": (lambda file: [replace("particles/" + n, numpy.zeros(s))(file) for n, s in
                              (("position", (0, 3)), ("velocity", (0, 3)))] and remove("particles/id")(file),
                ["no particles"]),
}
CHECKPOINT_FILES = {
    "not there": (None, ["No such file"]),
    "a particle file": ("cloud", ["attribute format", "missing"]),
    "cut to half": (cut(0.5), ["cut short"]),
    "cut by a byte": (cut(0.99999), ["cut short"]),
    "head damaged": (flip(20), ["cloud.h5"]),
    "no step": (attribute("step", None), ["attribute step", "missing"]),
    "step in words": (attribute("step", "ten"), ["attribute step", "number"]),
    "negative step": (attribute("step", -3), ["attribute step"]),
    "steps in a row": (attribute("step", [1, 2]), ["attribute step", "single number"]),
    "dt not a number": (attribute("dt", numpy.nan), ["attribute dt"]),
    "no velocity": (remove("particles/velocity"), ["/particles/velocity", "missing"]),
    "no ids": (remove("particles/id"), ["/particles/id", "missing"]),
    "a number changed": (element("particles/position", 100, [0.3, 0.3, 0.3]), ["/particles/position", "checksum", "0 to"]),
    "a checksum changed": (element("checksums/velocity", 0, 1), ["/particles/velocity", "checksum"]),
    "no checksums": (remove("checksums"), ["/checksums/id", "missing"]),
    "checksums of another shape": (replace("checksums/id", numpy.zeros(7, int)), ["/checksums/id", "7 rows"]),
    "a scene changed": (lambda file: replace("scene", numpy.bytes_(b"[domain]"))(file), ["/scene", "checksum"]),
    "no scene": (remove("scene"), ["/scene", "missing"]),
    "a scene of a gigabyte": (never_filled("scene", (), dtype="S1000000000"), ["/scene", "claims 1000000000 characters"]),
    "another format": (attribute("format", 99), ["attribute format: 99", "restart with trevi "]),
    "more overrides than lines": (attribute("scene_overrides", 5), ["/scene", "overrides"]),
    "overrides without end": (attribute("scene_overrides", 2**62), ["overrides"]),
}


def damage(good, path, change):
    """A copy of `good` at `path` on which `change` has worked; changes of bytes take and return bytes."""
    if change is None:
        return
    shutil.copyfile(good, path)
    data = path.read_bytes()
    try:
        path.write_bytes(change(data))
    except (TypeError, AttributeError, ValueError):  # a change of the content, then
        path.write_bytes(data)
        with h5py.File(path, "r+") as file:
            change(file)


def problems(ranks, scene, output, words, *arguments):
    code, told = runs.run(ranks, scene, output, *arguments)
    found = [f"exit code {code}"] if code != 2 else []
    found += [f"no {word!r}" for word in words if word not in told]
    found += ["stack trace"] if re.search(r"\*\*\* Process received signal|Segmentation|terminate called", told) else []
    found += [f"{told.count('trevi: ')} messages"] if told.count("trevi: ") != 1 else []
    found += ["output written"] if output.exists() and any(output.iterdir()) else []
    return [f"{', '.join(found)}: {told.strip()}"] if found else []


def check_particle_files(folder, ranks):
    cloud, good = folder.path("cloud.h5"), folder.path("good.h5")
    with h5py.File(good, "w") as file:
        file["particles/position"], file["particles/velocity"], file["particles/id"] = PLACES, 0 * PLACES, IDS
    scene = folder.scene(CLOUD)
    for name, (change, words) in PARTICLE_FILES.items():
        cloud.unlink(missing_ok=True)
        damage(good, cloud, change)
        for n in ranks:
            yield f"particle file, {name}, {n} ranks", problems(n, scene, folder.path(f"{name} {n}"), ["cloud.h5"] + words, "--steps", 1)


def check_checkpoints(folder, ranks):
    scene, bad = folder.scene(CUBE + CHECKPOINTS.format(5, 2)), folder.path("bad.h5")
    runs.run_well(1, scene, folder.path("made"), "--steps", 5)
    good = runs.last_checkpoint(folder.path("made"))
    for name, (change, words) in CHECKPOINT_FILES.items():
        bad.unlink(missing_ok=True)
        if change == "cloud":
            shutil.copyfile(folder.path("good.h5"), bad)
        else:
            damage(good, bad, change)
        words = ["bad.h5"] + [word for word in words if word != "cloud.h5"]
        for n in ranks:
            yield f"checkpoint, {name}, {n} ranks", problems(n, scene, folder.path(f"checkpoint {name} {n}"), words, "--restart", bad)


def check_checkpoints_of_1_0_0(folder, ranks):
    """They are gone on with: later versions only wrote more, which is taken away here."""
    known = {"particles", "checksums", "scene", "flow", "streams"}
    for name, text in (("cube", CUBE), ("inlets", FLOW)):
        scene, made, old = folder.scene(text + CHECKPOINTS.format(5, 2)), folder.path(f"made {name}"), folder.path(f"{name}.h5")
        runs.run_well(1, scene, made, "--steps", 5)
        shutil.copyfile(runs.last_checkpoint(made), old)
        with h5py.File(old, "r+") as file:
            for more in set(file) - known:
                del file[more]
            file.attrs["program_version"] = numpy.bytes_(b"1.0.0")
        for n in ranks:
            code, told = runs.run(n, scene, folder.path(f"on {name} {n}"), "--restart", old, "--steps", 8)
            yield f"checkpoint of 1.0.0, {name}, {n} ranks", [f"exit code {code}: {told}"] if code != 0 else []


WAVES = """
[domain]
min = [0, 0, 0]
max = [3.0, 0.4, 1.0]
[fluid]
spacing = 0.1
[[particles]]
min = [0.5, 0, 0]
max = [3.0, 0.4, 0.6]
[time]
dt = 0.01
end = 1.0
[gravity]
[[wavemaker]]
type = "piston"
position = 0.5
depth = 0.6
height = 0.1
period = 1.2
absorb = true
[output.series]
every_steps = 1
"""


def check_checkpoints_of_2_0_0(folder, ranks):
    """Their offsets of paddles have another name, and are taken on."""
    scene, straight, old = folder.scene(WAVES + CHECKPOINTS.format(5, 9)), folder.path("straight"), folder.path("waves.h5")
    runs.run_well(1, scene, straight, "--steps", 20)
    shutil.copyfile(straight / "checkpoint_000010.h5", old)
    with h5py.File(old, "r+") as file:
        file.move("paddle_offsets", "paddle_ways")
    for n in ranks:
        on = folder.path(f"waves on {n}")
        code, told = runs.run(n, scene, on, "--restart", old, "--steps", 20)
        one, other = (runs.particles(runs.last_checkpoint(output)) for output in (straight, on))
        same = code == 0 and one["particles/position"] == other["particles/position"]
        yield f"checkpoint of 2.0.0, {n} ranks", [] if same else [f"exit code {code}: {told}; or other positions"]


def check_lists_of_frames(folder, ranks):
    """One that is cut is told of and set aside, and its whole lines stay."""
    scene = folder.scene(CUBE + FRAMES + CHECKPOINTS.format(10, 10))
    for n in ranks:
        output = folder.path(f"frames {n}")
        runs.run_well(1, scene, output, "--steps", 20)
        lists = [*output.glob("*.pvd"), *output.glob("*.series")]
        for path in lists:  # the line of step 20 is cut
            text = path.read_text()
            path.write_text(text[:text.index("000020")])
        code, told = runs.run(n, scene, output, "--steps", 30, "--restart", "latest")
        found = [f"exit code {code}: {told}"] if code != 0 or not lists else []
        for path in lists:
            steps = sorted(set(re.findall(r"particles_(\d{6})\.", path.read_text())))
            if f"sets it aside as .stale, and lists anew what can be read of it: {path}: damaged" not in told:
                found.append(f"{path} is not told of: {told}")
            if steps != ["000000", "000010", "000030"] or not Path(f"{path}.stale").exists():
                found.append(f"{path} has the steps {steps}, or was not set aside")
        yield f"lists of frames, {n} ranks", found


def main():
    ranks = [int(word) for word in sys.argv[1:]] or [1, 2]
    failed = count = 0
    with Folder() as folder:
        for check in (check_particle_files, check_checkpoints, check_checkpoints_of_1_0_0,
                      check_checkpoints_of_2_0_0, check_lists_of_frames):
            for case, found in check(folder, ranks):
                count += 1
                failed += bool(found)
                for line in found:
                    print(f"FAILED {case}: {line}", flush=True)
    print(f"bad files: {len(PARTICLE_FILES)} of particles and {len(CHECKPOINT_FILES)} checkpoints, each on "
          f"{' and '.join(map(str, ranks))} ranks: {count} cases, {failed} failed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
