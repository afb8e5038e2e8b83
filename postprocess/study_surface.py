#!/usr/bin/python3
"""How well surface.py's surface holds the water: volume, closedness, pieces and time, of known shapes and of a run's frames.

  postprocess/study_surface.py out/fountain_shapes out/musical_fountain --output postprocess/results/surface.csv

Beside it the surface of kernels that are round, of 2 spacings, at 0.2 of the share, smoothed: what surface.py did before 1.0.
"""

import argparse
import csv
import sys
import time
from pathlib import Path

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import (
    vtkFeatureEdges, vtkFlyingEdges3D, vtkPolyDataConnectivityFilter, vtkWindowedSincPolyDataFilter)

from stage import BadInput, Run, cloud_of
from surface import interpolator, surface_of, volume_of

SPACING = 0.1  # m


def lattice(*counts, spacing=SPACING):
    """A block of particles, each moved by up to a tenth of the spacing."""
    places = np.stack(np.meshgrid(*[np.arange(n) for n in counts], indexing="ij"), axis=-1).reshape(-1, 3) * spacing
    return places + np.random.default_rng(1).uniform(-0.1, 0.1, places.shape) * SPACING


def shapes():
    """Name, positions, and the number of pieces that they are."""
    ball = lattice(25, 25, 25)
    yield "block of 20³", lattice(20, 20, 20), 1
    yield "block of 50 x 40 x 25", lattice(50, 40, 25), 1
    yield "ball, 24 wide", ball[np.linalg.norm(ball - 1.2, axis=1) < 1.2], 1
    yield "sheet of two layers", lattice(40, 40, 2), 1
    yield "sheet of one layer", lattice(40, 40, 1), 1
    yield "sheet of one layer, stretched by 1.3", lattice(40, 40, 1, spacing=1.3 * SPACING), 1
    yield "thread", lattice(40, 1, 1), 1
    yield "50 drops of one particle", lattice(50, 1, 1, spacing=1), 50


def round_kernels(position, spacing):
    cloud, grid = cloud_of(position, np.zeros_like(position, np.uint8)), vtkImageData()
    low, cell = position.min(axis=0) - 2.5 * spacing, spacing / 2
    grid.SetOrigin(*low)
    grid.SetSpacing(cell, cell, cell)
    grid.SetDimensions(*(int(n) for n in np.ceil((position.max(axis=0) + 2.5 * spacing - low) / cell) + 1))
    sums, contour, smooth = interpolator(cloud, spacing), vtkFlyingEdges3D(), vtkWindowedSincPolyDataFilter()
    sums.SetInputData(grid)
    sums.ComputeShepardSumOn()
    sums.PassPointArraysOff()
    sums.Update()
    share = sums.GetOutput()
    share.GetPointData().SetActiveScalars(sums.GetShepardSumArrayName())
    contour.SetInputData(share)
    contour.SetValue(0, 0.2)
    smooth.SetInputConnection(contour.GetOutputPort())
    smooth.SetNumberOfIterations(15)
    smooth.SetPassBand(0.1)
    smooth.NormalizeCoordinatesOn()
    smooth.Update()
    return smooth.GetOutput()


def open_edges(mesh):
    edges = vtkFeatureEdges()
    edges.SetInputData(mesh)
    edges.FeatureEdgesOff()
    edges.Update()
    return edges.GetOutput().GetNumberOfCells()


def pieces(mesh):
    """Those of 20 vertices or more: not the odd bubble in a corner."""
    parts = vtkPolyDataConnectivityFilter()
    parts.SetInputData(mesh)
    parts.SetExtractionModeToAllRegions()
    parts.ColorRegionsOn()
    parts.Update()
    return int((np.bincount(vtk_to_numpy(parts.GetOutput().GetPointData().GetArray("RegionId"))) >= 20).sum())


def rows(name, position, spacing, known):
    for method, make in (("round", round_kernels), ("anisotropic", surface_of)):
        from_here = time.perf_counter()
        mesh = make(position, spacing)
        seconds = time.perf_counter() - from_here
        error = 100 * (volume_of(mesh) / (len(position) * spacing**3) - 1)
        yield {"case": name, "method": method, "particles": len(position), "volume_error_percent": f"{error:.2f}",
               "open_edges": open_edges(mesh), "pieces": pieces(mesh), "pieces_known": known, "seconds": f"{seconds:.1f}"}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("runs", nargs="*", help="directories of runs with [output.vtu], of spacing 0.1 m")
    parser.add_argument("--output", type=Path, default="surface.csv")
    options = parser.parse_args()
    try:
        table = [row for case in shapes() for row in rows(*case[:2], SPACING, case[2])]
        for folder in options.runs:
            run = Run(folder)
            for number in (len(run.times) // 4, len(run.times) // 2, len(run.times) - 1):
                name = f"{Path(folder).name}, {run.times[number]:.1f} s"
                table += rows(name, run.read(number)[0], SPACING, "")
        with open(options.output, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, table[0], lineterminator="\n")
            writer.writeheader()
            writer.writerows(table)
    except (BadInput, OSError) as error:
        print(f"study_surface.py: {error}", file=sys.stderr)
        return 2
    print(options.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
