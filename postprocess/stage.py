"""What the pictures share: frames of a run, a camera that clips nothing, an off-screen window. No program of its own.

Needs VTK's Python modules only, so it runs under pvbatch as well as under python3; both want a display (xvfb-run).
"""

import argparse
from pathlib import Path

import numpy as np
import vtkmodules.vtkRenderingOpenGL2  # noqa: F401  (the implementation behind vtkRenderingCore)
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkImageData, vtkPolyData
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkCommonTransforms import vtkTransform
from vtkmodules.vtkFiltersGeneral import vtkTransformPolyDataFilter
from vtkmodules.vtkRenderingCore import vtkCamera, vtkRenderer, vtkRenderWindow, vtkWindowToImageFilter

import trevi_run
from solid_colours import coloured_solids

BLUE = (40, 120, 220)
QUALITY, QUALITY_OF_FILMS = 82, 60  # of WebP, of 100
FILMS = (".webp", ".mp4")


class BadInput(Exception):
    pass


class Run:
    """The frames of a run as pictures want them: its floor is at z = 0. Times (s), spacing (m), corners of its box."""

    def __init__(self, folder):
        try:
            self._run = trevi_run.Run(folder)
            self._frames = self._run.frames
            if not len(self._frames):
                raise BadInput(f"{folder}: holds no frame; add [output.vtu] or [output.vtkhdf] to the scene")
            scene = self._run.scene if not (self._run.directory / "run.json").exists() else None
            report = {**scene["domain"], "spacing": scene["fluid"]["spacing"]} if scene else {
                **self._run.report["domain"], "spacing": self._run.report["spacing"]}
        except (trevi_run.RunError, KeyError) as error:
            raise BadInput(f"{error}; a picture needs the frames of [output.vtu] or [output.vtkhdf], and run.json or a "
                           "checkpoint") from error
        self.times, self.spacing = tuple(self._frames.times), report["spacing"]
        self._floor = report["min"][2]
        self.box = tuple(np.array(report[end]) - [0, 0, self._floor] for end in ("min", "max"))

    def nearest(self, time):
        """Number of the frame nearest a time; the last one without a time."""
        return len(self.times) - 1 if time is None else int(np.argmin(np.abs(np.array(self.times) - time)))

    def chosen(self, options):
        """Numbers of the frames that are asked for: those between the two times of a film, else one."""
        if not options.times:
            return [self.nearest(options.time)]
        first, last = options.times
        numbers = [number for number, time in enumerate(self.times) if first - 1e-6 <= time <= last + 1e-6]
        if len(numbers) < 2:
            raise BadInput(f"--times {first} {last}: a film needs two frames; the run has them from {self.times[0]:.6g} to "
                           f"{self.times[-1]:.6g} s")
        return numbers

    def milliseconds(self, numbers, options):
        """Of a frame of a film."""
        if len(numbers) < 2:
            return 0
        return 1000 * options.slow * (self.times[numbers[-1]] - self.times[numbers[0]]) / (len(numbers) - 1)

    def read(self, number):
        """Positions (m), colours (uint8, blue where the run has none), and velocities (m/s, zero where it has none)."""
        frame = self._frames[number]
        try:
            position, fields = frame.position.astype(float) - [0, 0, self._floor], frame.fields
            if not len(position):
                raise BadInput(f"{frame.path}: holds no particle")
            rgb = frame.rgb if "rgb" in fields else np.tile(np.array(BLUE, np.uint8), (len(position), 1))
            return position, rgb, frame.velocity.astype(float) if "velocity" in fields else np.zeros_like(position)
        except trevi_run.RunError as error:
            raise BadInput(str(error)) from error

    def solids(self, number):
        """The surfaces of obstacles and bodies, one vtkPolyData that looks towards the water, with an array `rgb` of
        the triangles that have a colour (solid_colours.py); None without any."""
        if not self._frames[number].solids:
            return None
        move, place = vtkTransformPolyDataFilter(), vtkTransform()
        place.Translate(0, 0, -self._floor)
        move.SetTransform(place)
        move.SetInputData(coloured_solids(self._frames[number].solids_to_vtk(), self._run))
        move.Update()
        return move.GetOutput()

    def bounds(self, numbers):
        """Corners (m) of what a picture of these frames and the first one shows: the box, as high as water and obstacles
        in it reach."""
        low, high = (corner.copy() for corner in self.box)
        top = 0
        for number in sorted({0, *numbers}):
            top = max(top, self.read(number)[0][:, 2].max())
            surface = self.solids(number)
            if surface and surface.GetNumberOfPoints():
                top = max(top, min(surface.GetBounds()[5], high[2]))
        high[2] = top
        return low, high


def camera_for(low, high, options):
    """Looks at the middle of the box, or of `options.box`, from azimuth and elevation, from so far that all of it is in
    the picture."""
    if options.box:
        low, high = np.array(options.box[:3]), np.array(options.box[3:])
    azimuth, elevation = np.radians([options.azimuth, options.elevation])
    back = np.array([np.cos(azimuth) * np.cos(elevation), np.sin(azimuth) * np.cos(elevation), np.sin(elevation)])
    right = np.array([-np.sin(azimuth), np.cos(azimuth), 0])
    axes = np.stack([right, np.cross(back, right), back])
    corners = np.array([[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)]) @ axes.T
    tangent = np.tan(np.radians(options.view_angle / 2)) * 0.96
    slopes = np.array([tangent * options.size[0] / options.size[1], tangent])
    # Each side of the picture is a plane through the eye: the corners bound where it may stand, seen along each axis.
    highest = (corners[:, :2] + corners[:, 2:] * slopes).max(axis=0)
    lowest = (corners[:, :2] - corners[:, 2:] * slopes).min(axis=0)
    depth = ((highest - lowest) / (2 * slopes)).max()
    eye = np.append((highest + lowest) / 2, depth)
    camera = vtkCamera()
    camera.SetViewAngle(options.view_angle)
    camera.SetPosition(*(eye @ axes))
    camera.SetFocalPoint(*((eye - [0, 0, 1]) @ axes))
    camera.SetViewUp(0, 0, 1)
    return camera


def window_for(size):
    """An off-screen window with one renderer; its depth buffer is read, so it must not be multisampled."""
    window, renderer = vtkRenderWindow(), vtkRenderer()
    window.SetOffScreenRendering(1)
    window.SetMultiSamples(0)
    window.SetSize(*size)
    window.AddRenderer(renderer)
    return window, renderer


def pixels(window, depth=False):
    """The picture as rows from the bottom: uint8 colours, or float depths in [0, 1]."""
    grab = vtkWindowToImageFilter()
    grab.SetInput(window)
    grab.ReadFrontBufferOff()
    if depth:
        grab.SetInputBufferTypeToZBuffer()
    else:
        grab.SetInputBufferTypeToRGB()
    grab.Update()
    image = grab.GetOutput()
    width, height, _ = image.GetDimensions()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(height, width, -1)


def save(pictures, path, milliseconds=0):
    """Writes uint8 rows from the bottom as PNG or, with Pillow, as WebP, of which several are a film that repeats."""
    Path(path).parent.mkdir(parents=True, exist_ok=True)
    if path.endswith(".webp"):
        from PIL import Image  # pylint: disable=import-outside-toplevel
        images = [Image.fromarray(np.ascontiguousarray(picture[::-1])) for picture in pictures]
        film = {"save_all": True, "append_images": images[1:], "duration": round(milliseconds), "loop": 0}
        images[0].save(path, quality=QUALITY_OF_FILMS if milliseconds else QUALITY, method=6, **(film if milliseconds else {}))
        print(path)
        return
    picture, image = next(iter(pictures)), vtkImageData()
    image.SetDimensions(picture.shape[1], picture.shape[0], 1)
    image.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(picture.reshape(-1, 3)), deep=1))
    writer = vtkPNGWriter()
    writer.SetFileName(str(path))
    writer.SetCompressionLevel(9)
    writer.SetInputData(image)
    writer.Write()
    print(path)


def checked_output(options, endings):
    """The ending of a file that is to be made, one of those that there are."""
    ending, films = Path(options.output).suffix.lower(), [end for end in endings if end in FILMS]
    if options.times and ending not in films:
        endings = films
    if ending not in endings:
        raise BadInput(f"{options.output}: cannot be made; give --output a name that ends in {' or '.join(endings)}")
    if options.slow <= 0:
        raise BadInput(f"--slow {options.slow:g}: must be above 0")
    return ending


def cloud_of(position, rgb):
    """Points with the array rgb and one vertex each, as mappers draw cells."""
    cloud, points, vertices = vtkPolyData(), vtkPoints(), vtkCellArray()
    points.SetData(numpy_to_vtk(position, deep=1))
    numbers = np.arange(len(position) + 1, dtype=np.int64)
    vertices.SetData(numpy_to_vtkIdTypeArray(numbers, deep=1), numpy_to_vtkIdTypeArray(numbers[:-1], deep=1))
    cloud.SetPoints(points)
    cloud.SetVerts(vertices)
    colours = numpy_to_vtk(np.ascontiguousarray(rgb), deep=1)
    colours.SetName("rgb")
    cloud.GetPointData().SetScalars(colours)
    return cloud


def add_options(parser):
    """The arguments that render.py and surface.py share."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("run", help="a run's directory, with [output.vtu] or [output.vtkhdf] in its scene")
    parser.add_argument("--output", default="picture.png", help="what is made, by its ending (default %(default)s)")
    parser.add_argument("--time", type=float, help="of the frame, s (default: the last)")
    parser.add_argument("--times", type=float, nargs=2, metavar=("FROM", "TO"), help="of the frames of a film, s")
    parser.add_argument("--slow", type=float, default=1, help="how many times slower than real time a film runs (default 1)")
    parser.add_argument("--azimuth", type=float, default=-60, help="degrees around the vertical (default %(default)s)")
    parser.add_argument("--elevation", type=float, default=12, help="degrees above the horizon (default %(default)s)")
    parser.add_argument("--box", type=float, nargs=6, metavar=tuple("xyzXYZ"),
                        help="corners of what fills the picture, m, the floor at z = 0 (default: the box, as high as the water)")
    parser.add_argument("--view-angle", type=float, default=28, help="of the camera, degrees (default %(default)s)")
    parser.add_argument("--size", type=int, nargs=2, default=[1280, 960], metavar=("WIDTH", "HEIGHT"))
