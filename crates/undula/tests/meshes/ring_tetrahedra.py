"""Writes the meshes beside it: the ring of `ring.py` in tetrahedra, without structure. Needs gmsh (pip)."""

import gmsh

gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 2)
geo = gmsh.model.geo
centre = geo.addPoint(0, 0, 0)
rays = [[geo.addPoint(r * x, r * y, 0) for r in (0.5, 1.0, 1.2)] for x, y in ((1, 0), (0, 1))]
arcs = [geo.addCircleArc(a, centre, b) for a, b in zip(*rays)]
lines = [[geo.addLine(ray[i], ray[i + 1]) for i in range(2)] for ray in rays]
names = {}
for i, region in enumerate(("fluid", "solid")):
    loop = geo.addCurveLoop([lines[0][i], arcs[i + 1], -lines[1][i], -arcs[i]])
    surface = geo.addPlaneSurface([loop])
    back, volume, right, outer, left, inner = geo.extrude([(2, surface)], 0, 0, 0.6)
    names.setdefault("front", []).append(surface)
    for name, side in (("back", back), ("bottom", right), ("left", left), ("inner", inner), ("outside", outer)):
        names.setdefault(name, []).append(side[1])
    names[region] = [volume[1]]
names["interface"] = [names["outside"].pop(0)]
assert names["interface"] == [names["inner"].pop(1)]
geo.synchronize()
for name, tags in names.items():
    dimension = 3 if name in ("fluid", "solid") else 2
    gmsh.model.setPhysicalName(dimension, gmsh.model.addPhysicalGroup(dimension, tags), name)
gmsh.option.setNumber("Mesh.MeshSizeMin", 0.6)
gmsh.option.setNumber("Mesh.MeshSizeMax", 0.6)
gmsh.model.mesh.generate(3)
for order in (1, 2):
    gmsh.model.mesh.setOrder(order)
    print(order, [len(tags) for tags in gmsh.model.mesh.getElements(3)[1]])
    for version in (2.2, 4.1):
        for binary in (0, 1):
            gmsh.option.setNumber("Mesh.MshFileVersion", version)
            gmsh.option.setNumber("Mesh.Binary", binary)
            gmsh.write(f"ring_tetrahedra_{order}_v{version}{'_binary' if binary else ''}.msh")
