#!/usr/bin/python3
"""Reconstructs the water surface of a frame and renders it as water, at night or by day.

  jobs/render.sh surface.py out/musical_fountain --time 3.5 --output water.png
  jobs/render.sh surface.py out/dam_break_obstacle --time 1 --light day --output water.webp
  jobs/render.sh surface.py out/dam_break_obstacle --times 0.5 1.5 --slow 2 --output water.webp   # a film
  jobs/render.sh surface.py out/musical_fountain --time 3.5 --output water.ply   # the surface itself, for Blender; or .obj

Surface: where the share of water, spread by kernels that follow the water's shape, is that of which it holds its
volume, about 0.4 (anisotropic.py). Picture: each
pixel's ray is refracted, reflected and absorbed (water.py, light.py), obstacles are stone (solids.py). White is what air is driven into, and spray has white specks
about it; both want frames with the field velocity. --tint mixes in the particles' own colours, for a fountain lit by
coloured lamps.
"""

import argparse
import sys
from collections import namedtuple

import numpy as np
from scipy.optimize import brentq
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkStaticPointLocator
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D, vtkMassProperties, vtkPolyDataNormals, vtkWindowedSincPolyDataFilter
from vtkmodules.vtkFiltersPoints import vtkSPHCubicKernel, vtkSPHInterpolator
from vtkmodules.vtkIOGeometry import vtkOBJWriter
from vtkmodules.vtkIOPLY import vtkPLYWriter
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from anisotropic import LEVELS, share_of_water, white
from light import LIGHTS, Surroundings, normalised
from solids import Seen, Solids, lit, points_on
from stage import BadInput, Run, add_options, camera_for, checked_output, cloud_of, pixels, save, window_for
from water import developed, water

SMOOTHING, PASS_BAND = 14, 0.2
SPECKS = 12  # about a particle of spray, within a spacing
SPECK_SIZE = 0.12  # spacings
FOAM_WHITE = np.array([0.80, 0.86, 0.92], np.float32)
# x and y of the normal in the camera's axes, 12 bits each; z follows, as what is seen faces the camera.
PACKED_NORMAL = """//VTK::Light::Impl
  ivec2 n = ivec2(round((normalVCVSOutput.xy * 0.5 + 0.5) * 4095.0));
  fragOutput0 = vec4(vec3(n.x >> 4, (n.x & 15) << 4 | n.y >> 8, n.y & 255) / 255.0, 1.0);
"""
Hit = namedtuple("Hit", "point normal direction depth")


def interpolator(cloud, spacing):
    kernel, result = vtkSPHCubicKernel(), vtkSPHInterpolator()
    kernel.SetSpatialStep(spacing)
    result.SetKernel(kernel)
    result.SetLocator(vtkStaticPointLocator())
    result.SetSourceData(cloud)
    result.PassFieldArraysOff()
    return result


def contour_of(grid, level):
    """The contour's mesh with normals, its facets smoothed away."""
    contour, smooth, normals = vtkFlyingEdges3D(), vtkWindowedSincPolyDataFilter(), vtkPolyDataNormals()
    contour.SetInputData(grid)
    contour.SetValue(0, level)
    contour.ComputeNormalsOff()
    contour.ComputeScalarsOff()
    smooth.SetInputConnection(contour.GetOutputPort())
    smooth.SetNumberOfIterations(SMOOTHING)
    smooth.SetPassBand(PASS_BAND)
    smooth.NormalizeCoordinatesOn()
    normals.SetInputConnection(smooth.GetOutputPort())
    normals.SplittingOff()
    normals.Update()
    return normals.GetOutput()


def volume_of(mesh):
    mass = vtkMassProperties()
    mass.SetInputData(mesh)
    mass.Update()
    return mass.GetVolume()


def surface_of(position, spacing):
    """Closed triangles around the water, which hold as much of it as there is: the level is chosen so."""
    low, cell, size, share = share_of_water(position, spacing)
    grid = vtkImageData()
    grid.SetOrigin(*low)
    grid.SetSpacing(cell, cell, cell)
    grid.SetDimensions(*(int(n) for n in size))
    grid.GetPointData().SetScalars(numpy_to_vtk(share, deep=1))
    water = len(position) * spacing**3

    def excess(level):
        return volume_of(contour_of(grid, level)) / water - 1

    lowest, highest = LEVELS
    if excess(lowest) < 0:
        level = lowest
    elif excess(highest) > 0:
        level = highest
    else:
        level = brentq(excess, lowest, highest, xtol=0.004)
    return contour_of(grid, level)


def coloured(mesh, position, rgb, whiteness, spacing):
    """The mesh with the arrays rgb and white (as grey), the means of the particles beside."""
    cloud = cloud_of(position, rgb.astype(np.float32))
    grey = numpy_to_vtk(np.repeat(255 * whiteness[:, None], 3, axis=1).astype(np.float32), deep=1)
    grey.SetName("white")
    cloud.GetPointData().AddArray(grey)
    sums = interpolator(cloud, spacing)
    sums.SetInputData(mesh)
    sums.ComputeShepardSumOn()
    sums.Update()
    mesh = sums.GetOutput()
    total = vtk_to_numpy(mesh.GetPointData().GetArray(sums.GetShepardSumArrayName()))
    for name in ("rgb", "white"):
        colour = vtk_to_numpy(mesh.GetPointData().GetArray(name)) / np.maximum(total, 1e-6)[:, None]
        mean = numpy_to_vtk(colour.clip(0, 255).astype(np.uint8), deep=1)
        mean.SetName(name)
        mesh.GetPointData().AddArray(mean)
    return mesh


def actor_of(mesh):
    actor, mapper = vtkActor(), vtkPolyDataMapper()
    mapper.SetInputData(mesh)
    mapper.ScalarVisibilityOff()
    actor.SetMapper(mapper)
    return actor


def normals_and_depth(actor, camera, size):
    """Of each pixel, by VTK: normal in the camera's axes and depth buffer of the front side; and the window."""
    window, renderer = window_for(size)
    renderer.AddActor(actor)
    renderer.SetActiveCamera(camera)
    actor.GetShaderProperty().AddFragmentShaderReplacement("//VTK::Light::Impl", True, PACKED_NORMAL, False)
    window.Render()
    r, g, b = np.moveaxis(pixels(window).astype(np.int32), -1, 0)
    x, y = (r << 4 | g >> 4) / 2047.5 - 1, ((g & 15) << 8 | b) / 2047.5 - 1
    normal = np.stack([x, y, np.sqrt(np.clip(1 - x * x - y * y, 0, 1))], axis=-1).astype(np.float32)
    front = pixels(window, depth=True)[..., 0].copy()
    actor.GetShaderProperty().ClearAllFragmentShaderReplacements()
    return normal, front, window


def buffers(mesh, camera, size):
    """Of each pixel, by VTK: normal in the camera's axes, colour, white, and depth buffers of the front and back sides."""
    actor = actor_of(mesh)
    normal, front, window = normals_and_depth(actor, camera, size)
    mapper = actor.GetMapper()
    mapper.ScalarVisibilityOn()
    mapper.SetScalarModeToUsePointFieldData()
    mapper.SetColorModeToDirectScalars()
    actor.GetProperty().LightingOff()
    colours = []
    for name in ("rgb", "white"):
        mapper.SelectColorArray(name)
        window.Render()
        colours.append(pixels(window).astype(np.float32) / 255)
    actor.GetProperty().FrontfaceCullingOn()
    window.Render()
    back = pixels(window, depth=True)[..., 0].copy()
    return normal, *colours, front, back


def rays(camera, size):
    """Eye, direction of each pixel (rows from the bottom), and the camera's axes right, up, back as rows."""
    eye = np.array(camera.GetPosition())
    back = (eye - camera.GetFocalPoint()) / camera.GetDistance()
    right = np.cross(camera.GetViewUp(), back)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(back, right), back]).astype(np.float32)
    tangent = np.tan(np.radians(camera.GetViewAngle() / 2))
    x = (np.arange(size[0]) + 0.5) / size[1] * 2 - size[0] / size[1]
    y = (np.arange(size[1]) + 0.5) / size[1] * 2 - 1
    plane = np.stack([*np.meshgrid(x * tangent, y * tangent), np.full(size[::-1], -1.0)], axis=-1).astype(np.float32)
    return eye.astype(np.float32), plane.reshape(-1, 3) @ axes, axes


def distance_of(depth, camera):
    """Along the viewing axis, from a depth buffer."""
    near, far = camera.GetClippingRange()
    return (near * far / (far - depth * (far - near))).astype(np.float32)


def specks(position, whiteness, spacing):
    """Places and brightness of what is thrown about by white spray."""
    random = np.random.default_rng(1)
    offset = random.normal(size=(len(position), SPECKS, 3)) * spacing / 2
    return (position[:, None] + offset).reshape(-1, 3), np.repeat(whiteness, SPECKS)


def projection(camera, size):
    """A function from points to column, row and distance along the viewing axis; infinite columns behind the camera."""
    eye, _, axes = rays(camera, [1, 1])
    focal = size[1] / 2 / np.tan(np.radians(camera.GetViewAngle() / 2))

    def project(points):
        x, y, back = ((points - eye) @ axes.T).T
        scale = np.where(back < 0, focal / np.minimum(back, -1e-9), np.nan) * -1
        return (np.nan_to_num(size[0] / 2 + x * scale, nan=-1), np.nan_to_num(size[1] / 2 + y * scale, nan=-1), -back)
    return project


def add_specks(result, front, camera, size, places, brightness, width):
    """Specks in front of the water, each as bright as the share of a pixel that it covers. front: distances."""
    column, row, distance = projection(camera, size)(places)
    column, row = (np.floor(c).astype(int) for c in (column, row))
    seen = (column >= 0) & (column < size[0]) & (row >= 0) & (row < size[1])
    pixel = (row * size[0] + column)[seen]
    free = distance[seen] < front[pixel]
    scale = size[1] / 2 / np.tan(np.radians(camera.GetViewAngle() / 2)) / distance[seen]
    cover = brightness[seen] * np.minimum(1, (width * scale) ** 2)
    covered = np.bincount(pixel[free], cover[free], len(result)).clip(0, 1)[:, None]
    return result * (1 - covered) + FOAM_WHITE * covered


def clip(camera, low, high):
    """One clipping range for all that is drawn with the camera, from its distance to the corners of a box."""
    eye, _, axes = rays(camera, [1, 1])
    corners = np.array([[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)])
    away = -((corners - eye) @ axes[2])
    camera.SetClippingRange(max(away.min(), 0.01 * away.max()), away.max())


def own_colours(actor, window):
    """Of each pixel that of what the actor's picture shows there, linear; black where it has none."""
    mapper = actor.GetMapper()
    mapper.ScalarVisibilityOn()
    mapper.SetScalarModeToUseCellFieldData()
    mapper.SetColorModeToDirectScalars()
    mapper.SelectColorArray("rgb")
    actor.GetProperty().LightingOff()
    window.Render()
    return (pixels(window).reshape(-1, 3).astype(np.float32) / 255) ** 2.2


def solids_of(surface, camera, size, light):
    """Only what looks at the camera, so that one sees the water in a vessel. None without obstacles."""
    if surface is None:
        return None
    normals = vtkPolyDataNormals()
    normals.SetInputData(surface)
    normals.SetFeatureAngle(35)  # degrees; sharper edges are seen as edges
    normals.Update()
    actor = actor_of(normals.GetOutput())
    actor.GetProperty().BackfaceCullingOn()
    normal, front, window = normals_and_depth(actor, camera, size)
    eye, plane, axes = rays(camera, size)
    front = front.reshape(-1)
    colour = own_colours(actor, window)
    distance = np.where(front < 1, distance_of(front, camera), np.inf).astype(np.float32)
    above = eye[2] + plane[:, 2] * np.where(front < 1, distance, 0) >= 0  # what is below the ground is not seen
    distance[~above] = np.inf
    return Solids(Seen(normalised(normal.reshape(-1, 3) @ axes), distance, colour), size, projection(camera, size), light)


def picture(mesh, solids, camera, size, around, options):
    """Linear colours of all pixels, a row each, and the distance of the nearest water or stone."""
    layers = (layer.reshape(size[0] * size[1], -1) for layer in buffers(mesh, camera, size))
    normal, colour, whiteness, front, back = layers
    eye, plane, axes = rays(camera, size)
    direction = normalised(plane)
    result = around.seen(np.broadcast_to(eye, plane.shape), direction)
    distance = np.where(front[:, 0] < 1, distance_of(front[:, 0], camera), np.inf).astype(np.float32)
    dry = np.zeros(len(result), bool)
    if solids:
        dry = lit(result, solids, distance)
        distance = np.minimum(distance, solids.distance)
    wet = np.flatnonzero((front[:, 0] < 1) & ~dry)
    nearest, behind = distance_of(front[wet], camera), distance_of(back[wet], camera)
    slant = np.linalg.norm(plane[wet], axis=1, keepdims=True)
    hit = Hit(eye + plane[wet] * nearest, normalised(normal[wet] @ axes), direction[wet],
              np.clip(behind - nearest, 0.02, 20) * slant)
    tint = FOAM_WHITE + options.tint * (colour[wet] ** 2.2 - FOAM_WHITE)
    foam = 0.03 + 0.12 * options.tint + (options.foam - 0.03) * whiteness[wet, :1]
    result[wet] = water(around, hit, tint, foam, solids)
    return result, distance


def write_mesh(mesh, path):
    """For other programs, with the colours of the particles (PLY)."""
    writer = vtkPLYWriter() if path.endswith(".ply") else vtkOBJWriter()
    if path.endswith(".ply"):
        writer.SetArrayName("rgb")
    writer.SetFileName(path)
    writer.SetInputData(mesh)
    writer.Write()
    print(path)


def halved(image):
    """Each pixel the mean of 2 x 2."""
    height, width, _ = image.shape
    return image.reshape(height // 2, 2, width // 2, 2, 3).mean(axis=(1, 3)).round().astype(np.uint8)


def scene_of(run, number, mesh, spray, view, options):
    """The picture of a frame, uint8 rows from the bottom. spray: places and whiteness of its particles."""
    low, high, camera, size = view
    light, stone = LIGHTS[options.light], run.solids(number)
    solids = solids_of(stone, camera, size, light)
    around = Surroundings(low, high, light, (spray[0], points_on(stone, run.box)))
    linear, front = picture(mesh, solids, camera, size, around, options)
    linear = add_specks(linear, front, camera, size, *specks(*spray, options.spacing), SPECK_SIZE * options.spacing)
    return halved(developed(linear.reshape(size[1], size[0], 3)))


def in_sight(position, camera, size, margin):
    """Which points the picture shows, or would if it were wider by a margin, m."""
    eye, _, axes = rays(camera, [1, 1])
    x, y, back = ((position - eye) @ axes.T).T
    height = margin - back * np.tan(np.radians(camera.GetViewAngle() / 2))
    return (np.abs(y) < height) & (np.abs(x) < margin + (height - margin) * size[0] / size[1])


def water_of(run, number, spacing, view=None):
    """The surface of a frame, and the places and whiteness of its spray; in a view, of what is in sight only."""
    position, rgb, velocity = run.read(number)
    if view:
        seen = in_sight(position, *view[2:], 20 * spacing)
        if not seen.any():
            raise BadInput(f"{run.times[number]:.6g} s: no water is in the picture; mind --box, --azimuth and --elevation")
        position, rgb, velocity = position[seen], rgb[seen], velocity[seen]
    whiteness, spray = white(position, velocity, spacing)
    return coloured(surface_of(position, spacing), position, rgb, whiteness, spacing), (position[spray], whiteness[spray])


def view_of(run, numbers, options):
    """Corners of what is seen in all of these frames, the camera, and twice the size of the picture."""
    low, high = run.bounds(numbers)
    camera = camera_for(low - 0.3, high + 0.3, options)
    clip(camera, low - 1, high + 1)
    return low, high, camera, [2 * n for n in options.size]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    add_options(parser)
    parser.add_argument("--spacing", type=float, help="of the lattice, m (default: the run's)")
    parser.add_argument("--tint", type=float, default=0, help="share of the particles' colours, 0 to 1 (default 0)")
    parser.add_argument("--foam", type=float, default=0.9, help="white where air is driven in, 0 to 1 (default 0.9)")
    parser.add_argument("--light", choices=LIGHTS, default="night", help="what lights the picture (default %(default)s)")
    options = parser.parse_args()
    try:
        ending = checked_output(options, (".png", ".webp", ".ply", ".obj"))
        run = Run(options.run)
        options.spacing = options.spacing or run.spacing
        numbers = run.chosen(options)
        if ending in (".ply", ".obj"):
            write_mesh(water_of(run, numbers[0], options.spacing)[0], options.output)
            return 0
        view = view_of(run, numbers, options)
        waters = ((number, *water_of(run, number, options.spacing, view)) for number in numbers)
        save((scene_of(run, *one, view, options) for one in waters), options.output, run.milliseconds(numbers, options))
    except (BadInput, OSError) as error:
        print(f"surface.py: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
