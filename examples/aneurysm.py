"""Writes aneurysm.msh: the lumen of a bent artery with a bulge, tetrahedra of second order. Needs `pip install gmsh`.

A cylinder is meshed, and its nodes are moved: outwards by a bulge, then to an arc between two straight pieces [mm].
"""

import math
import sys

import gmsh

RADIUS, BEND, STRAIGHT = 2.0, 8.0, 4.0  # of the artery, of its axis, and the length of the straight pieces
RISE, WIDER, HALF = 5.0, 1.2, 3.0  # height of the bulge, how much wider it is, and half of its length
ARC = 0.5 * math.pi * BEND
LENGTH = ARC + 2 * STRAIGHT


def bulged(x, y, s):
    """The section at s: its outer side rises by the bulge; the inner one stays."""
    here = math.exp(-(((s - 0.5 * LENGTH) / HALF) ** 2))
    outer = 0.5 * (1 + x / RADIUS)
    return x + RISE * here * outer**2, y * (1 + WIDER * here * outer)


def bent(x, y, s):
    """From the straight axis to a quarter of a circle between two straight pieces, x to its outside."""
    if s < STRAIGHT:
        return -BEND - x, y, s - STRAIGHT
    if s > STRAIGHT + ARC:
        return s - STRAIGHT - ARC, y, BEND + x
    angle = (s - STRAIGHT) / BEND
    return -(BEND + x) * math.cos(angle), y, (BEND + x) * math.sin(angle)


gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 2)
# One thread and one number for the random points: the same mesh each time.
gmsh.option.setNumber("General.NumThreads", 1)
gmsh.option.setNumber("Mesh.RandomSeed", 1)
occ = gmsh.model.occ
tube = occ.addCylinder(0, 0, 0, 0, 0, LENGTH, RADIUS)
occ.synchronize()
gmsh.model.setPhysicalName(3, gmsh.model.addPhysicalGroup(3, [tube]), "fluid")
for _, side in gmsh.model.getEntities(2):
    z = gmsh.model.occ.getCenterOfMass(2, side)[2]
    name = "inflow" if z < 0.1 else "outflow" if z > LENGTH - 0.1 else "lumen"
    gmsh.model.setPhysicalName(2, gmsh.model.addPhysicalGroup(2, [side]), name)

field = gmsh.model.mesh.field
size = 0.85 if len(sys.argv) < 2 else float(sys.argv[1])
field.add("MathEval", 1)
near = f"Exp(0-((z-{0.5 * LENGTH})/{HALF})^2)*(1+x/{RADIUS})/2"
field.setString(1, "F", f"{size}*(1-0.55*{near})")
field.setAsBackgroundMesh(1)
for option in ("FromPoints", "FromCurvature", "ExtendFromBoundary"):
    gmsh.option.setNumber("Mesh.MeshSize" + option, 0)
gmsh.option.setNumber("Mesh.ElementOrder", 2)
gmsh.model.mesh.generate(3)
gmsh.model.mesh.optimize("Netgen")
tags, places, _ = gmsh.model.mesh.getNodes()
for tag, (x, y, z) in zip(tags, places.reshape(-1, 3).tolist()):
    # Few digits make a small file.
    gmsh.model.mesh.setNode(tag, [round(c, 5) for c in bent(*bulged(x, y, z), z)], [])
gmsh.option.setNumber("Mesh.MshFileVersion", 4.1)
gmsh.write("aneurysm.msh")
gmsh.finalize()
