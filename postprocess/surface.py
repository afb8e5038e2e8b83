#!/usr/bin/python3
"""Reconstructs the water surface of a frame and renders it as water at night.

  jobs/render.sh surface.py out/musical_fountain --time 3.5 --output water.png

Surface: the share of each place that is water, sum of W V over the particles (cubic spline, kernel radius 2 spacings)
on a grid of half the spacing, its contour, smoothed by a windowed sinc filter. Picture: each pixel's ray is refracted,
reflected and absorbed (water.py). --tint mixes in the particles' own colours, for a fountain lit by coloured lamps.
"""

import argparse
import sys
from collections import namedtuple

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData, vtkStaticPointLocator
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D, vtkPolyDataNormals, vtkWindowedSincPolyDataFilter
from vtkmodules.vtkFiltersPoints import vtkSPHCubicKernel, vtkSPHInterpolator
from vtkmodules.vtkRenderingCore import vtkActor, vtkPolyDataMapper

from stage import BadInput, Run, add_options, camera_for, cloud_of, pixels, save, window_for
from water import Ground, developed, normalised, smoothstep, water

CONTOUR = 0.2  # a lone particle becomes a drop of its own volume, radius 0.6 spacings
FOAM_WHITE = np.array([0.80, 0.86, 0.92], np.float32)
# x and y of the normal in the camera's axes, 12 bits each; z follows, as what is seen faces the camera.
PACKED_NORMAL = """//VTK::Light::Impl
  ivec2 n = ivec2(round((normalVCVSOutput.xy * 0.5 + 0.5) * 4095.0));
  fragOutput0 = vec4(vec3(n.x >> 4, (n.x & 15) << 4 | n.y >> 8, n.y & 255) / 255.0, 1.0);
"""
Hit = namedtuple("Hit", "point normal direction depth")


def interpolator(position, spacing):
    kernel, result = vtkSPHCubicKernel(), vtkSPHInterpolator()
    kernel.SetSpatialStep(spacing)
    result.SetKernel(kernel)
    result.SetLocator(vtkStaticPointLocator())
    result.SetSourceData(position)
    result.PassFieldArraysOff()
    return result


def share_of_water(cloud, spacing):
    """The field whose contour is the surface, on a grid around all particles."""
    bounds = np.array(cloud.GetBounds()).reshape(3, 2)
    low, cell = bounds[:, 0] - 2.5 * spacing, spacing / 2
    grid = vtkImageData()
    grid.SetOrigin(*low)
    grid.SetSpacing(cell, cell, cell)
    grid.SetDimensions(*(int(n) for n in np.ceil((bounds[:, 1] + 2.5 * spacing - low) / cell) + 1))
    sums = interpolator(cloud, spacing)
    sums.SetInputData(grid)
    sums.ComputeShepardSumOn()
    sums.PassPointArraysOff()
    sums.Update()
    result = sums.GetOutput()
    result.GetPointData().SetActiveScalars(sums.GetShepardSumArrayName())
    return result


def surface_of(cloud, spacing, smoothing):
    """Triangles with normals and the array rgb."""
    contour, smooth, normals = vtkFlyingEdges3D(), vtkWindowedSincPolyDataFilter(), vtkPolyDataNormals()
    contour.SetInputData(share_of_water(cloud, spacing))
    contour.SetValue(0, CONTOUR)
    contour.ComputeNormalsOff()
    contour.ComputeScalarsOff()
    smooth.SetInputConnection(contour.GetOutputPort())
    smooth.SetNumberOfIterations(smoothing)
    smooth.SetPassBand(0.1)
    smooth.NormalizeCoordinatesOn()
    normals.SetInputConnection(smooth.GetOutputPort())
    normals.SplittingOff()
    colours = interpolator(cloud, spacing)
    colours.SetInputConnection(normals.GetOutputPort())
    colours.ComputeShepardSumOn()
    colours.Update()
    mesh = colours.GetOutput()
    rgb = vtk_to_numpy(mesh.GetPointData().GetArray("rgb"))
    total = vtk_to_numpy(mesh.GetPointData().GetArray(colours.GetShepardSumArrayName()))
    mean = numpy_to_vtk((rgb / np.maximum(total, 1e-6)[:, None]).clip(0, 255).astype(np.uint8), deep=1)
    mean.SetName("rgb")
    mesh.GetPointData().AddArray(mean)
    return mesh


def actor_of(mesh):
    actor, mapper = vtkActor(), vtkPolyDataMapper()
    mapper.SetInputData(mesh)
    mapper.ScalarVisibilityOff()
    actor.SetMapper(mapper)
    return actor


def buffers(mesh, camera, size):
    """Of each pixel, by VTK: normal in the camera's axes, colour, and depth buffers of the front and back sides."""
    window, renderer = window_for(size)
    actor = actor_of(mesh)
    renderer.AddActor(actor)
    renderer.SetActiveCamera(camera)
    renderer.ResetCameraClippingRange()
    actor.GetShaderProperty().AddFragmentShaderReplacement("//VTK::Light::Impl", True, PACKED_NORMAL, False)
    window.Render()
    r, g, b = np.moveaxis(pixels(window).astype(np.int32), -1, 0)
    x, y = (r << 4 | g >> 4) / 2047.5 - 1, ((g & 15) << 8 | b) / 2047.5 - 1
    normal = np.stack([x, y, np.sqrt(np.clip(1 - x * x - y * y, 0, 1))], axis=-1).astype(np.float32)
    front = pixels(window, depth=True)[..., 0].copy()
    actor.GetShaderProperty().ClearAllFragmentShaderReplacements()
    mapper = actor.GetMapper()
    mapper.ScalarVisibilityOn()
    mapper.SetScalarModeToUsePointFieldData()
    mapper.SelectColorArray("rgb")
    mapper.SetColorModeToDirectScalars()
    actor.GetProperty().LightingOff()
    window.Render()
    colour = pixels(window).astype(np.float32) / 255
    actor.GetProperty().FrontfaceCullingOn()
    window.Render()
    back = pixels(window, depth=True)[..., 0].copy()
    return normal, colour, front, back


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


def picture(mesh, camera, size, low, high, options):
    normal, colour, front, back = (layer.reshape(size[0] * size[1], -1) for layer in buffers(mesh, camera, size))
    eye, plane, axes = rays(camera, size)
    direction, ground = normalised(plane), Ground(low, high)
    result = ground.seen(np.broadcast_to(eye, plane.shape), direction)
    wet = np.flatnonzero(front[:, 0] < 1)
    nearest, behind = distance_of(front[wet], camera), distance_of(back[wet], camera)
    slant = np.linalg.norm(plane[wet], axis=1, keepdims=True)
    hit = Hit(eye + plane[wet] * nearest, normalised(normal[wet] @ axes), direction[wet],
              np.clip(behind - nearest, 0.02, 20) * slant)
    pool = options.pool if options.pool is not None else low[2]
    airborne = smoothstep(pool, pool + 0.6, hit.point[:, 2:])
    tint = FOAM_WHITE + options.tint * (colour[wet] ** 2.2 - FOAM_WHITE)
    foam = 0.03 + 0.12 * options.tint + (options.foam - 0.03) * airborne
    result[wet] = water(ground, hit, tint, foam)
    return developed(result.reshape(size[1], size[0], 3))


def halved(image):
    """Each pixel the mean of 2 x 2."""
    height, width, _ = image.shape
    return image.reshape(height // 2, 2, width // 2, 2, 3).mean(axis=(1, 3)).round().astype(np.uint8)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    add_options(parser)
    parser.add_argument("--spacing", type=float, default=0.1, help="of the run's lattice, m (default %(default)s)")
    parser.add_argument("--smoothing", type=int, default=15, help="iterations of the filter (default %(default)s)")
    parser.add_argument("--tint", type=float, default=0, help="share of the particles' colours, 0 to 1 (default 0)")
    parser.add_argument("--foam", type=float, default=0.35, help="white of water in the air, 0 to 1 (default 0.35)")
    parser.add_argument("--pool", type=float, help="level above which water is in the air, m (default: the floor)")
    options = parser.parse_args()
    try:
        run = Run(options.run)
        number = run.nearest(options.time)
        position, rgb, _ = run.read(number)
        mesh = surface_of(cloud_of(position, rgb.astype(np.float32)), options.spacing, options.smoothing)
        low, high = run.bounds([number])
        size = [2 * n for n in options.size]
        image = picture(mesh, camera_for(low - 0.3, high + 0.3, options), size, low, high, options)
        save(halved(image), options.output)
    except (BadInput, OSError) as error:
        print(f"surface.py: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
