"""Writes the meshes beside it: a quarter of a ring of fluid with a wall of solid around it, extruded, in hexahedra and,
without structure, in tetrahedra. Needs gmsh (pip)."""

import gmsh


def ring(structured):
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 2)
    geo = gmsh.model.geo
    centre = geo.addPoint(0, 0, 0)
    rays = [[geo.addPoint(r * x, r * y, 0) for r in (0.5, 1.0, 1.2)] for x, y in ((1, 0), (0, 1))]
    arcs = [geo.addCircleArc(a, centre, b) for a, b in zip(*rays)]
    lines = [[geo.addLine(ray[i], ray[i + 1]) for i in range(2)] for ray in rays]
    if structured:
        for curve in arcs:
            geo.mesh.setTransfiniteCurve(curve, 3)
        for curve in lines[0] + lines[1]:
            geo.mesh.setTransfiniteCurve(curve, 2)
    names = {}
    for i, region in enumerate(("fluid", "solid")):
        loop = geo.addCurveLoop([lines[0][i], arcs[i + 1], -lines[1][i], -arcs[i]])
        surface = geo.addPlaneSurface([loop])
        if structured:
            geo.mesh.setTransfiniteSurface(surface)
            geo.mesh.setRecombine(2, surface)
        layers = {"numElements": [2], "recombine": True} if structured else {}
        back, volume, right, outer, left, inner = geo.extrude([(2, surface)], 0, 0, 0.6, **layers)
        assert volume[0] == 3
        names.setdefault("front", []).append(surface)
        for name, side in (("back", back), ("bottom", right), ("left", left), ("inner", inner), ("outside", outer)):
            names.setdefault(name, []).append(side[1])
        names[region] = [volume[1]]
    # The outer side of the fluid is the inner one of the solid.
    names["interface"] = [names["outside"].pop(0)]
    assert names["interface"] == [names["inner"].pop(1)]
    geo.synchronize()
    for name, tags in names.items():
        dimension = 3 if name in ("fluid", "solid") else 2
        gmsh.model.setPhysicalName(dimension, gmsh.model.addPhysicalGroup(dimension, tags), name)
    gmsh.option.setNumber("Mesh.SecondOrderIncomplete", 0)
    if not structured:
        gmsh.option.setNumber("Mesh.MeshSizeMin", 0.6)
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.6)
    gmsh.model.mesh.generate(3)
    kind = "ring" if structured else "ring_tetrahedra"
    for order in (1, 2):
        gmsh.model.mesh.setOrder(order)
        for version in (2.2, 4.1):
            for binary in (0, 1):
                gmsh.option.setNumber("Mesh.MshFileVersion", version)
                gmsh.option.setNumber("Mesh.Binary", binary)
                gmsh.write(f"{kind}_{order}_v{version}{'_binary' if binary else ''}.msh")
    gmsh.finalize()


ring(True)
ring(False)
