#!/usr/bin/env python3
"""Reads a ParaView collection (or VTU files) with VTK itself and checks what is in it.

    pip install vtk numpy
    read_vtu.py out/fsi3/fields.pvd
    read_vtu.py fields.pvd --size 2.356194 --expect "pressure=x*x-y*y+x*y" --expect "velocity=-y,x,x*y"

Checked for every file: the collection's time is that of the file, all values are finite but those of one body where it
is not, all cells have one type that Undula writes, every point belongs to a cell, and the Jacobian of every cell map, by
VTK's own shape functions, is positive at 5 Gauss points per direction: with nodes in a wrong order it is not. --size
compares the area or the volume so integrated; --expect compares point data with expressions of x, y, z at the points,
and inside the cells the interpolation by VTK's shape functions. The exit code is 1 if anything is wrong.
"""
import argparse
import os
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy


def files_of(path):
    """Pairs (time or None, file)."""
    if not path.endswith(".pvd"):
        return [(None, path)]
    entries = ElementTree.parse(path).getroot().iter("DataSet")
    return [(float(e.get("timestep")), os.path.join(os.path.dirname(path), e.get("file"))) for e in entries]


def arrays_of(data):
    return {data.GetArrayName(i): vtk_to_numpy(data.GetArray(i)) for i in range(data.GetNumberOfArrays())}


# Cells that Undula writes: quadrilaterals and hexahedra of degree 1, 2, above, triangles and tetrahedra of degree 1, 2, 3.
QUADRILATERALS = {vtk.VTK_QUAD, vtk.VTK_BIQUADRATIC_QUAD, vtk.VTK_LAGRANGE_QUADRILATERAL}
TRIANGLES = {vtk.VTK_TRIANGLE, vtk.VTK_QUADRATIC_TRIANGLE, vtk.VTK_LAGRANGE_TRIANGLE}
TETRAHEDRA = {vtk.VTK_TETRA, vtk.VTK_QUADRATIC_TETRA, vtk.VTK_LAGRANGE_TETRAHEDRON}
HEXAHEDRA = {vtk.VTK_HEXAHEDRON, vtk.VTK_TRIQUADRATIC_HEXAHEDRON, vtk.VTK_LAGRANGE_HEXAHEDRON}


def gauss(cell):
    """Points and weights on the reference cell; on simplices those of a square or cube collapsed."""
    at, weight = np.polynomial.legendre.leggauss(5)
    line = list(zip(0.5 * (at + 1), 0.5 * weight))
    for s, of_s in line:
        side = 1 - s if cell.GetCellType() in TRIANGLES else 1
        for r, of_r in line:
            if cell.GetCellType() in TETRAHEDRA:
                yield from (((r * (1 - s) * (1 - t), s * (1 - t), t), of_r * of_s * of_t * (1 - s) * (1 - t) ** 2)
                            for t, of_t in line)
            elif cell.GetCellDimension() == 2:
                yield (r * side, s, 0.0), of_r * of_s * side
            else:
                yield from (((r, s, t), of_r * of_s * of_t) for t, of_t in line)


def derivatives_of(cell, at):
    """Derivatives of the shape functions [dimension, n]. VTK stores them in one order for some cells and in another one
    for others: the right one maps the parametric coordinates of the nodes to the unit matrix."""
    n, dimension = cell.GetNumberOfPoints(), cell.GetCellDimension()
    flat, coordinates = [0.0] * (dimension * n), np.reshape([cell.GetParametricCoords()[i] for i in range(3 * n)], (n, 3))
    cell.InterpolateDerivs(at, flat)
    for candidate in (np.reshape(flat, (dimension, n)), np.reshape(flat, (n, dimension)).T):
        if np.allclose(candidate @ coordinates[:, :dimension], np.eye(dimension), atol=1e-9):
            return candidate
    raise ValueError(f"derivatives of {cell.GetClassName()} in an order that is not known")


def tables(cell):
    """Weights, shape functions and their derivatives at Gauss points, by the cell's own class."""
    weights, values, derivatives = [], [], []
    for at, weight in gauss(cell):
        phi = [0.0] * cell.GetNumberOfPoints()
        cell.InterpolateFunctions(at, phi)
        weights.append(weight)
        values.append(phi)
        derivatives.append(derivatives_of(cell, at))
    return np.array(weights), np.array(values), np.array(derivatives)


def check(time, path, args):
    wrong = []
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(path)
    reader.Update()
    if reader.GetErrorCode():
        return [f"VTK error {reader.GetErrorCode()}"]
    grid = reader.GetOutput()
    points = vtk_to_numpy(grid.GetPoints().GetData())
    types = {grid.GetCellType(c): grid.GetCell(c).GetClassName() for c in range(grid.GetNumberOfCells())}
    stored = grid.GetFieldData().GetArray("TimeValue")
    stored = None if stored is None else stored.GetValue(0)
    print(f"{path}: t = {stored}, {len(points)} points, {grid.GetNumberOfCells()} cells of {types}")
    if time is not None and stored != time:
        wrong.append(f"time {stored} in the file, {time} in the collection")
    if len(types) != 1:
        return wrong + [f"{len(types)} cell types"]
    if not types.keys() <= QUADRILATERALS | TRIANGLES | TETRAHEDRA | HEXAHEDRA:
        return wrong + [f"cells that Undula does not write: {types}"]

    nodes = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(grid.GetNumberOfCells(), -1)
    if len(np.unique(nodes)) != len(points):
        wrong.append(f"{len(points) - len(np.unique(nodes))} points in no cell")
    weights, phi, d_phi = tables(grid.GetCell(0))
    jacobian = np.linalg.det(np.einsum("qrn,cnd->cqrd", d_phi, points[nodes][:, :, :d_phi.shape[1]]))
    size = float((jacobian @ weights).sum())
    print(f"  area or volume {size:.12g}, Jacobian of the cell maps {jacobian.min():.3e} .. {jacobian.max():.3e}")
    if jacobian.min() <= 0:
        wrong.append(f"{(jacobian.min(axis=1) <= 0).sum()} cells with a Jacobian that is not positive")
    if args.size is not None and abs(size - args.size) > args.tolerance * abs(args.size):
        wrong.append(f"area or volume {size:.12g}, expected {args.size:.12g}")

    at_points, in_cells = arrays_of(grid.GetPointData()), arrays_of(grid.GetCellData())
    for kind, arrays in (("points", at_points), ("cells", in_cells), ("points", {"(position)": points})):
        for name, array in arrays.items():
            print(f"  {kind} {name} {array.dtype} x {array[0].size}: {array.min():.6g} .. {array.max():.6g}")
            if not np.isfinite(array).all() and not name.startswith(("fluid-", "solid-")):
                wrong.append(f"{name}: {(~np.isfinite(array)).sum()} values are not finite")
    inside = np.einsum("qn,cnd->cqd", phi, points[nodes])
    for name, expression in (e.split("=", 1) for e in args.expect):
        if name not in at_points:
            wrong.append(f"{name} is missing")
            continue
        columns = at_points[name].reshape(len(points), -1)
        interpolated = np.einsum("qn,cnd->cqd", phi, columns[nodes])
        for d, component in enumerate(expression.split(",")):
            at = lambda x: eval(component, vars(np) | {"x": x[..., 0], "y": x[..., 1], "z": x[..., 2]})  # noqa: B023
            error = np.abs(columns[:, d] - at(points)).max(), np.abs(interpolated[..., d] - at(inside)).max()
            print(f"  {name}[{d}] - ({component}): {error[0]:.2e} at points, {error[1]:.2e} inside cells")
            if error[0] > args.tolerance or error[1] > args.inside:
                wrong.append(f"{name}[{d}] is not {component}")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("path", nargs="+", help=".pvd or .vtu")
    parser.add_argument("--size", type=float, help="of the deformed domain [m2 or m3]")
    parser.add_argument("--expect", action="append", default=[], metavar="NAME=EXPR[,EXPR..]")
    parser.add_argument("--tolerance", type=float, default=1e-6, help="at points; relative for the size")
    parser.add_argument("--inside", type=float, default=1e-2, help="inside cells, where interpolation errs")
    args = parser.parse_args()
    n_wrong = 0
    for path in args.path:
        for time, file in files_of(path):
            for message in check(time, file, args):
                n_wrong += 1
                print(f"  WRONG: {message}")
    print("all is well" if n_wrong == 0 else f"{n_wrong} things are wrong")
    sys.exit(n_wrong > 0)


if __name__ == "__main__":
    main()
