#!/usr/bin/python3
"""Renders the particles of a run as shaded balls in their own colours, its obstacles as stone: a picture of one frame,
or a film.

  jobs/render.sh render.py out/fountain --time 4 --output fountain.png
  jobs/render.sh render.py out/musical_fountain --sound inputs/ode_to_joy.wav --output fountain.mp4
  jobs/render.sh render.py out/falling_cube --times 0 1 --slow 2 --output cube.webp

A film is MP4 (H.264, with --sound AAC), of all frames or those between --times, and needs ffmpeg; or WebP. Without a
display start it through jobs/render.sh.
"""

import argparse
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import vtkmodules.vtkRenderingOpenGL2 as opengl
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtkmodules.vtkFiltersSources import vtkCubeSource
from vtkmodules.vtkRenderingCore import vtkActor, vtkLight, vtkPolyDataMapper

from stage import BadInput, Run, add_options, camera_for, checked_output, cloud_of, pixels, save, window_for

SKY = ((0.02, 0.03, 0.07), (0.10, 0.13, 0.24))  # bottom, top
STONE = (0.30, 0.31, 0.36)
MARBLE = (0.80, 0.76, 0.70)
EDGE = 35  # degrees; sharper ones are seen as edges
RIM = 0.15  # m; thickness of the floor, and width of it that is seen around the water


def balls(radius):
    """An actor for particles; its mapper draws each as a ball without any triangles."""
    actor, mapper = vtkActor(), opengl.vtkOpenGLSphereMapper()
    mapper.SetRadius(radius)
    mapper.SetScalarModeToUsePointData()
    mapper.SetColorModeToDirectScalars()
    actor.SetMapper(mapper)
    actor.GetProperty().SetAmbient(0.25)
    actor.GetProperty().SetDiffuse(0.8)
    actor.GetProperty().SetSpecular(0.25)
    actor.GetProperty().SetSpecularPower(30)
    return actor


def marble():
    """An actor for obstacles. Only what looks at the camera, so that one sees the water in a vessel."""
    actor, mapper = vtkActor(), vtkPolyDataMapper()
    mapper.SetScalarModeToUseCellFieldData()
    mapper.SetColorModeToDirectScalars()
    mapper.SelectColorArray("rgb")
    actor.SetMapper(mapper)
    actor.GetProperty().SetAmbient(0.15)
    actor.GetProperty().SetDiffuse(0.75)
    actor.GetProperty().SetSpecular(0.15)
    actor.GetProperty().SetSpecularPower(20)
    actor.GetProperty().BackfaceCullingOn()
    return actor


def show(actors, run, number):
    """Particles and obstacles of a frame."""
    particles, obstacles = actors
    particles.GetMapper().SetInputData(cloud_of(*run.read(number)[:2]))
    surface = run.solids(number)
    if surface is None:
        return
    colours = vtk_to_numpy(surface.GetCellData().GetArray("rgb"))  # written to: marble is what has none
    colours[~colours.any(axis=1)] = np.round(255 * np.array(MARBLE))
    rounded = vtkPolyDataNormals()
    rounded.SetInputData(surface)
    rounded.SetFeatureAngle(EDGE)
    obstacles.GetMapper().SetInputConnection(rounded.GetOutputPort())


def floor(low, high):
    """Its top is at z = 0."""
    source, actor = vtkCubeSource(), vtkActor()
    source.SetBounds(low[0] - RIM, high[0] + RIM, low[1] - RIM, high[1] + RIM, -RIM, 0)
    mapper = vtkPolyDataMapper()
    mapper.SetInputConnection(source.GetOutputPort())
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(STONE)
    return actor


def light_from(azimuth, elevation, strength):
    light = vtkLight()
    light.SetLightTypeToCameraLight()
    a, e = np.radians([azimuth, elevation])
    light.SetPosition(np.sin(a) * np.cos(e), np.sin(e), np.cos(a) * np.cos(e))
    light.SetIntensity(strength)
    return light


def stage(low, high, options):
    """Window and the actors of balls and obstacles, in a night sky above a stone floor."""
    window, renderer = window_for(options.size)
    renderer.SetBackground(SKY[0])
    renderer.SetBackground2(SKY[1])
    renderer.GradientBackgroundOn()
    renderer.SetUseFXAA(True)
    for light in (light_from(-35, 40, 0.85), light_from(50, 15, 0.3)):
        renderer.AddLight(light)
    actors = balls(options.radius), marble()
    for actor in (*actors, floor(low, high)):
        renderer.AddActor(actor)
    renderer.SetActiveCamera(camera_for(low - [RIM, RIM, RIM], high + [RIM, RIM, RIM], options))
    renderer.ResetCameraClippingRange(low[0] - RIM, high[0] + RIM, low[1] - RIM, high[1] + RIM, -RIM, high[2] + RIM)
    return window, actors


def seconds_of(sound):
    """How long a sound file plays."""
    told = subprocess.run(["ffprobe", "-v", "error", "-show_entries", "format=duration", "-of", "csv=p=0", sound],
                          capture_output=True, text=True, check=False)
    try:
        return float(told.stdout)
    except ValueError as error:
        raise BadInput(f"{sound}: ffprobe cannot tell how long it is; {told.stderr.strip()}") from error


def frames_of(run, numbers, window, actors):
    """The pictures of these frames, uint8 rows from the bottom."""
    for number in numbers:
        show(actors, run, number)
        window.Render()
        yield pixels(window)


def film(pictures, count, milliseconds, options):
    """Pipes the pictures through ffmpeg; the last one stays while there is sound."""
    if not shutil.which("ffmpeg"):
        raise BadInput("ffmpeg is not installed; jobs/render.sh installs it")
    rate, (width, height) = 1000 / milliseconds, options.size
    command = ["ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}",
               "-r", f"{rate:.6g}", "-i", "-"]
    command += ["-i", options.sound, "-c:a", "aac", "-b:a", "96k"] if options.sound else []
    longer = max(0.0, seconds_of(options.sound) - count / rate) if options.sound else 0
    command += ["-vf", f"vflip,tpad=stop_mode=clone:stop_duration={longer:.3f}", "-c:v", "libx264", "-crf",
                str(options.crf), "-pix_fmt", "yuv420p", "-movflags", "+faststart", options.output]
    with subprocess.Popen(command, stdin=subprocess.PIPE) as encoder:
        for done, picture in enumerate(pictures, 1):
            encoder.stdin.write(picture.tobytes())
            print(f"\rframe {done} of {count}", end="", file=sys.stderr, flush=True)
    print(file=sys.stderr)
    if encoder.returncode:
        raise BadInput(f"ffmpeg failed with exit code {encoder.returncode}")
    print(options.output)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    add_options(parser)
    parser.add_argument("--radius", type=float, help="of a ball, m (default 0.55 spacings)")
    parser.add_argument("--sound", help="sound file to play with a film")
    parser.add_argument("--crf", type=int, default=24, help="of H.264; lower is better (default %(default)s)")
    options = parser.parse_args()
    try:
        if options.sound and not Path(options.sound).is_file():
            raise BadInput(f"{options.sound}: no such sound file")
        ending = checked_output(options, (".png", ".webp", ".mp4"))
        run = Run(options.run)
        options.radius = options.radius or 0.55 * run.spacing
        if ending == ".mp4" and not options.times:
            options.times = run.times[0], run.times[-1]
        numbers = run.chosen(options)
        pictures = frames_of(run, numbers, *stage(*run.bounds(numbers), options))
        if ending == ".mp4":
            film(pictures, len(numbers), run.milliseconds(numbers, options), options)
        else:
            save(pictures, options.output, run.milliseconds(numbers, options))
    except (BadInput, OSError) as error:
        print(f"render.py: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
