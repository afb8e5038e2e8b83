"""Colours of what stands and floats in a picture. No program of its own.

A mesh of a PLY file whose points have the properties red, green and blue has them in pictures. Other bodies are of
wood; what stands and moves otherwise is of stone, as the picture has it.
"""

from pathlib import Path

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkIOPLY import vtkPLYReader

import trevi_run

WOOD = (150, 104, 62)


def coloured_solids(surface, run):
    """`surface`, of Frame.solids_to_vtk(), with an array rgb of its triangles; black stands for no colour."""
    number = vtk_to_numpy(surface.GetCellData().GetArray("obstacle"))
    rgb = np.zeros((len(number), 3), np.uint8)
    for solid, colours in _colours(run):
        mine = np.flatnonzero(number == solid)
        if colours.ndim == 1 or len(colours) == len(mine):
            rgb[mine] = np.maximum(colours, 1)
    array = numpy_to_vtk(rgb, deep=True)
    array.SetName("rgb")
    surface.GetCellData().AddArray(array)
    return surface


def _colours(run):
    """Numbers of solids, and a colour for each or for each of its triangles."""
    try:
        scene, folder = run.scene, Path(run.report["scene"]).parent
    except (trevi_run.RunError, KeyError):
        return  # of a run that has not ended
    bodies = scene.get("body", [])
    others = [*scene.get("obstacle", []), *scene.get("wavemaker", [])]  # in the order of their numbers
    for number, solid in enumerate([*others, *bodies]):
        path = str(solid.get("path", ""))
        colours = _colours_of_file(folder / path) if path.endswith(".ply") else None
        if colours is not None:
            yield number, colours
        elif number >= len(others):
            yield number, np.array(WOOD, np.uint8)


def _colours_of_file(path):
    """Of each triangle that of its first corner, or None for a file without colours."""
    if not path.exists():
        return None
    reader = vtkPLYReader()
    reader.SetFileName(str(path))
    reader.Update()
    mesh = reader.GetOutput()
    colours = mesh.GetPointData().GetArray("RGB")
    if colours is None or not mesh.GetNumberOfPolys():
        return None
    first = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray())[vtk_to_numpy(mesh.GetPolys().GetOffsetsArray())[:-1]]
    return vtk_to_numpy(colours)[first, :3]
