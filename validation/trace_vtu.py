#!/usr/bin/env python3
"""Samples and traces a field file of Undula with VTK itself: lines must have no holes, streamlines must not end.

    pip install vtk numpy
    trace_vtu.py out/fsi3/fields.pvd --line 0.05,0.26,2.45,0.26
    trace_vtu.py out/tube/fields.pvd --line 0,0,0,0,0,0.05
    trace_vtu.py out/fsi3/fields.pvd --seeds 0.3,0.22,0.3,0.4 --until 2.4

The last file of the collection is read. --line: 201 points between two places, all of which must lie in a cell.
--seeds: 41 streamlines by RK2 from points between two places, all of which must reach x = --until (a streamline ends
within a step of the outflow; one that begins on the stagnation streamline of an obstacle ends there). --expect compares
velocity along --line with an expression of x, y, z. Places have two or three coordinates. The exit code is 1 if anything is wrong.
"""
import argparse
import os
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
import vtk
from vtk.util.numpy_support import vtk_to_numpy

POINTS, STREAMLINES = 201, 41


def last_file(path):
    if not path.endswith(".pvd"):
        return path
    files = [e.get("file") for e in ElementTree.parse(path).getroot().iter("DataSet")]
    return os.path.join(os.path.dirname(path), files[-1])


def line_of(ends, resolution):
    line = vtk.vtkLineSource()
    half = len(ends) // 2
    line.SetPoint1(*(ends[:half] + [0.0])[:3])
    line.SetPoint2(*(ends[half:] + [0.0])[:3])
    line.SetResolution(resolution)
    line.Update()
    return line.GetOutput()


def sample(grid, ends, expect):
    """Number of points that lie in no cell; the largest error of the velocity where one is expected."""
    probe = vtk.vtkProbeFilter()
    probe.SetInputData(line_of(ends, POINTS - 1))
    probe.SetSourceData(grid)
    probe.Update()
    data = probe.GetOutput().GetPointData()
    valid = vtk_to_numpy(data.GetArray("vtkValidPointMask"))
    error = 0.0
    if expect:
        x, velocity = vtk_to_numpy(probe.GetOutput().GetPoints().GetData()), vtk_to_numpy(data.GetArray("velocity"))
        for d, component in enumerate(expect.split(",")):
            value = eval(component, vars(np) | {"x": x[:, 0], "y": x[:, 1], "z": x[:, 2]})
            error = max(error, float(np.abs(velocity[:, d] - value).max()))
    return int((valid == 0).sum()), error


def trace(grid, ends, until):
    """Number of streamlines that end before x = until."""
    grid.GetPointData().SetActiveVectors("velocity")
    tracer = vtk.vtkStreamTracer()
    tracer.SetInputData(grid)
    tracer.SetSourceData(line_of(ends, STREAMLINES - 1))
    tracer.SetIntegratorTypeToRungeKutta2()
    tracer.SetIntegrationDirectionToForward()
    tracer.SetMaximumPropagation(1000.0)
    tracer.SetMaximumNumberOfSteps(1000000)
    tracer.SetTerminalSpeed(1e-12)
    tracer.SetInitialIntegrationStep(0.2)
    tracer.Update()
    output = tracer.GetOutput()
    x = vtk_to_numpy(output.GetPoints().GetData())[:, 0]
    lines, offsets = (vtk_to_numpy(a) for a in (output.GetLines().GetConnectivityArray(), output.GetLines().GetOffsetsArray()))
    farthest = [x[lines[first:last]].max() for first, last in zip(offsets, offsets[1:])]
    reached = sum(int(end >= until) for end in farthest)
    return STREAMLINES - reached


def main():
    numbers = lambda text: [float(x) for x in text.split(",")]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("path", help=".pvd or .vtu")
    parser.add_argument("--line", type=numbers, metavar="X,Y[,Z],X,Y[,Z]")
    parser.add_argument("--expect", metavar="EXPR,EXPR")
    parser.add_argument("--tolerance", type=float, default=1e-6)
    parser.add_argument("--seeds", type=numbers, metavar="X,Y[,Z],X,Y[,Z]")
    parser.add_argument("--until", type=float, metavar="X")
    args = parser.parse_args()
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(last_file(args.path))
    reader.Update()
    grid = reader.GetOutput()
    wrong = 0
    if args.line:
        holes, error = sample(grid, args.line, args.expect)
        print(f"{holes} of {POINTS} points lie in no cell" + (f", error {error:.2e}" if args.expect else ""))
        wrong += holes > 0 or error > args.tolerance
    if args.seeds:
        lost = trace(grid, args.seeds, args.until)
        print(f"{STREAMLINES - lost} of {STREAMLINES} streamlines reach x = {args.until}")
        wrong += lost > 0
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
