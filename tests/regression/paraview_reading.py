#!/usr/bin/python3
"""What ParaView itself reads of the files that are named, as JSON: pvbatch paraview_reading.py FILE... > READINGS.

For each file its times, and for each of them what water is there.
"""

import json
import sys

from paraview import servermanager, simple
from vtkmodules.util.numpy_support import vtk_to_numpy


def water_of(reader):
    grid = servermanager.Fetch(reader)
    data = grid.GetPointData()
    ids = vtk_to_numpy(data.GetArray("id"))
    heights = vtk_to_numpy(grid.GetPoints().GetData())[:, 2] if len(ids) else []
    return {"cells": grid.GetNumberOfCells(), "arrays": [data.GetArrayName(k) for k in range(data.GetNumberOfArrays())],
            "ids": sorted(map(int, ids)), "heights": sorted(map(float, heights))}


def reading_of(path):
    reader = simple.OpenDataFile(path)
    if reader is None:
        return None
    times = [float(time) for time in getattr(reader, "TimestepValues", None) or []]
    frames = []
    for time in times or [0.0]:
        reader.UpdatePipeline(time)
        frames.append(water_of(reader))
    return {"times": times, "frames": frames}


print(json.dumps({path: reading_of(path) for path in sys.argv[1:]}))
