"""Shows a run's particles in ParaView as balls in their own colours:

  paraview --script=inputs/tutorial/paraview_state.py out/6_duet/particles.pvd
"""

import sys

from paraview import simple

# ParaView opens the file that stands behind the script; started without one, it is asked for here.
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
view.ResetCamera()
simple.Render()
