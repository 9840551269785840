"""Writes hydrofoil.msh: a NACA 0012 foil of chord 1 m in a channel, with a hole at its axis. Needs `pip install gmsh`.

The axis is the origin, 0.35 m behind the leading edge; the foil is turned by 5 degrees, nose up.
"""

import math
import sys

import gmsh

AXIS, HOLE, ANGLE = 0.35, 0.03, math.radians(5)
LOWER, UPPER = (-2, -1.5), (4, 1.5)


def thickness(x):
    """Half the thickness at x of a chord of 1, closed at the trailing edge."""
    return 0.6 * (0.2969 * math.sqrt(x) - 0.1260 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)


def place(x, y):
    """A point of the foil in the channel."""
    x -= AXIS
    s, c = math.sin(-ANGLE), math.cos(ANGLE)
    return gmsh.model.geo.addPoint(c * x - s * y, s * x + c * y, 0)


gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 2)
geo = gmsh.model.geo
xs = [0.5 * (1 - math.cos(math.pi * i / 20)) for i in range(21)]
nose, tail = place(0, 0), place(1, 0)
upper = geo.addSpline([nose] + [place(x, thickness(x)) for x in xs[1:-1]] + [tail])
lower = geo.addSpline([tail] + [place(x, -thickness(x)) for x in xs[-2:0:-1]] + [nose])
centre = geo.addPoint(0, 0, 0)
rim = [geo.addPoint(HOLE * math.cos(a), HOLE * math.sin(a), 0) for a in (0, math.pi / 2, math.pi, 1.5 * math.pi)]
hole = [geo.addCircleArc(rim[i], centre, rim[(i + 1) % 4]) for i in range(4)]
corners = [geo.addPoint(x, y, 0) for x, y in
           ((LOWER[0], LOWER[1]), (UPPER[0], LOWER[1]), (UPPER[0], UPPER[1]), (LOWER[0], UPPER[1]))]
sides = [geo.addLine(corners[i], corners[(i + 1) % 4]) for i in range(4)]
foil, around = geo.addCurveLoop([upper, lower]), geo.addCurveLoop(hole)
solid = geo.addPlaneSurface([foil, around])
fluid = geo.addPlaneSurface([geo.addCurveLoop(sides), foil])
geo.synchronize()

names = {1: {"inflow": [sides[3]], "outflow": [sides[1]], "walls": [sides[0], sides[2]], "hub": hole},
         2: {"fluid": [fluid], "solid": [solid]}}
for dimension, groups in names.items():
    for name, tags in groups.items():
        gmsh.model.setPhysicalName(dimension, gmsh.model.addPhysicalGroup(dimension, tags), name)

field = gmsh.model.mesh.field
for number, (kind, options) in enumerate([
    ("Distance", {"CurvesList": [upper, lower], "Sampling": 200}),
    ("Threshold", {"InField": 1, "SizeMin": 0.07, "SizeMax": 0.5, "DistMin": 0.05, "DistMax": 1.5}),
    ("Distance", {"PointsList": [nose, tail]}),
    ("Threshold", {"InField": 3, "SizeMin": 0.03, "SizeMax": 0.5, "DistMin": 0.02, "DistMax": 0.7}),
    ("Min", {"FieldsList": [2, 4, 6]}),
    ("MathEval", {"F": "0.025 + 0.6*Fabs(Sqrt(x*x + y*y) - 0.03)"}),
], 1):
    field.add(kind, number)
    for key, value in options.items():
        if isinstance(value, list):
            field.setNumbers(number, key, value)
        elif isinstance(value, str):
            field.setString(number, key, value)
        else:
            field.setNumber(number, key, value)
field.setAsBackgroundMesh(5)
for key in ("ExtendFromBoundary", "FromPoints", "FromCurvature"):
    gmsh.option.setNumber("Mesh.MeshSize" + key, 0)
gmsh.option.setNumber("Mesh.ElementOrder", 2)
gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
gmsh.model.mesh.generate(2)
path = sys.argv[1] if len(sys.argv) > 1 else "hydrofoil.msh"
gmsh.write(path)
# Ten digits are enough.
head, nodes, rest = open(path).read().replace("$EndNodes", "$Nodes").split("$Nodes\n")
count, *lines = nodes.splitlines()
rows = [line.split() for line in lines]
short = [" ".join([n, *(f"{round(float(x), 10):.10g}" for x in position)]) for n, *position in rows]
open(path, "w").write("\n".join([head + "$Nodes", count, *short, "$EndNodes", rest]))
