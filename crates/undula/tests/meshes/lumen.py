"""Writes the meshes beside it: the lumen of a straight tube of radius 1 and length 2 in tetrahedra with 4 and with 10
nodes, for walls to be grown around. Needs gmsh (pip)."""

import gmsh

gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 2)
tube = gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 2, 1)
gmsh.model.occ.synchronize()
names = {"fluid": [tube]}
for _, surface in gmsh.model.getBoundary([(3, tube)], oriented=False):
    z = gmsh.model.occ.getCenterOfMass(2, surface)[2]
    names["inflow" if z < 0.5 else "lumen" if z < 1.5 else "outflow"] = [surface]
for name, tags in names.items():
    dimension = 3 if name == "fluid" else 2
    gmsh.model.setPhysicalName(dimension, gmsh.model.addPhysicalGroup(dimension, tags), name)
gmsh.option.setNumber("Mesh.MeshSizeMin", 0.75)
gmsh.option.setNumber("Mesh.MeshSizeMax", 0.75)
gmsh.option.setNumber("Mesh.Binary", 1)
gmsh.model.mesh.generate(3)
for order in (1, 2):
    gmsh.model.mesh.setOrder(order)
    gmsh.write(f"lumen_{order}.msh")
gmsh.finalize()
