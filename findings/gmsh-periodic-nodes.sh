#!/usr/bin/env bash
# Gmsh 4.15.2 (PyPI): nodes on periodic curves of the built-in kernel are not translations of each other to rounding.
#
# One would guess: with setPeriodic and a translation, the nodes of the second curve are those of the first one plus the
# translation, to about 1e-15, at least where both curves are exact copies of each other; a program may then match them by
# a tolerance of 1e-10.
#
# Seen, on a square of side 1 with two sides that are copies of each other (largest deviation of a pair that
# getPeriodicNodes names): straight lines 1e-12, circular arcs 2e-9 to 5e-9, splines, B-splines and Bezier curves 1e-8,
# on coarse and fine meshes alike. The same B-splines of the OpenCASCADE kernel: 2e-16 to 5e-16.
#
# So periodic nodes of curved sides are to be matched by a tolerance that follows the mesh, not by rounding.
set -euo pipefail
directory=$(mktemp -d)
trap 'rm -rf "$directory"' EXIT
python3 -m venv "$directory/venv"
"$directory/venv/bin/pip" install --quiet gmsh==4.15.2 numpy==2.3.5
cat > "$directory/periodic.py" <<'PY'
import gmsh
import numpy as np

gmsh.initialize()
gmsh.option.setNumber("General.Terminal", 0)
print("Gmsh", gmsh.option.getString("General.Version"))


def deviation(kind, size):
    """The largest distance of a node of the right side from that of the left one plus (1, 0)."""
    gmsh.clear()
    kernel = gmsh.model.occ if kind == "OpenCASCADE B-spline" else gmsh.model.geo
    corners = [kernel.addPoint(x, y, 0, size) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]

    def side(x, below, above):
        if kind == "line":
            return kernel.addLine(below, above)
        if kind == "arc":
            return kernel.addCircleArc(below, kernel.addPoint(x - 0.5, 0.5, 0), above)
        inner = [kernel.addPoint(x + 0.15, 0.3, 0), kernel.addPoint(x - 0.15, 0.7, 0)]
        add = {"spline": kernel.addSpline, "Bezier": kernel.addBezier}.get(kind, kernel.addBSpline)
        return add([below, *inner, above])

    bottom, right = kernel.addLine(corners[0], corners[1]), side(1, corners[1], corners[2])
    top, left = kernel.addLine(corners[2], corners[3]), side(0, corners[0], corners[3])
    kernel.addPlaneSurface([kernel.addCurveLoop([bottom, right, top, -left])])
    kernel.synchronize()
    shift = [1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]
    gmsh.model.mesh.setPeriodic(1, [right], [left], shift)
    gmsh.model.mesh.generate(2)
    _, here, there, _ = gmsh.model.mesh.getPeriodicNodes(1, right)
    at = lambda tag: np.array(gmsh.model.mesh.getNode(tag)[0])
    return max(np.abs(at(a) - at(b) - [1, 0, 0]).max() for a, b in zip(here, there))


expected = {
    "line": (1e-13, 1e-11),
    "arc": (1e-10, 1e-7),
    "spline": (1e-9, 1e-7),
    "B-spline": (1e-9, 1e-7),
    "Bezier": (1e-9, 1e-7),
    "OpenCASCADE B-spline": (0.0, 1e-14),
}
changed = []
for kind, (low, high) in expected.items():
    found = [deviation(kind, size) for size in (0.2, 0.05)]
    print(f"{kind:22} {found[0]:.1e} {found[1]:.1e}")
    if not all(low <= x <= high for x in found):
        changed.append(kind)
if changed:
    raise SystemExit(f"changed: {', '.join(changed)}")
PY
"$directory/venv/bin/python" "$directory/periodic.py"
