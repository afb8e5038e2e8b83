"""Shows a run's particles in ParaView as balls in their own colours:

  paraview out/6_duet/particles.pvd inputs/tutorial/paraview_state.py
"""

import sys

from paraview import simple

# ParaView has opened the file that stands before the script; pvbatch opens none.
source = simple.GetActiveSource() or simple.PVDReader(FileName=sys.argv[-1])
view = simple.GetActiveViewOrCreate("RenderView")
display = simple.Show(source, view)
display.SetRepresentationType("Point Gaussian")
display.GaussianRadius = 0.05  # m, half the spacing
display.ShaderPreset = "Sphere"
arrays = source.PointData.keys()
if "rgb" in arrays:
    simple.ColorBy(display, ("POINTS", "rgb"))
    display.MapScalars = 0  # they are colours already
else:
    simple.ColorBy(display, ("POINTS", "velocity", "Magnitude"))
view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = [-0.5, -1, 0.4], [0, 0, 0], [0, 0, 1]
view.ResetCamera()
simple.Render()
