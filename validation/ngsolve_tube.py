#!/usr/bin/env python3
"""What a residual, a Jacobian and a step of the case `tube` cost in NGSolve.

    pip install ngsolve==6.2.2608 numpy scipy pypardiso     # a C++ compiler for compiled expressions
    OMP_NUM_THREADS=1 python3 validation/ngsolve_tube.py --h 0.0018 --solver pardiso

The same equations on P2-P1 tetrahedra, curved, with the default quadrature: flow in ALE coordinates in the lumen,
linear elasticity in the wall, harmonic extension, all in one system [v, u, p]. Implicit Euler, so that a step has no explicit
part. The extension has a small factor, which takes the place of test functions that vanish at the interface.
Prints JSON.
"""

import argparse
import json
import statistics
import time

import ngsolve as ng
from netgen.occ import Cylinder, Glue, OCCGeometry, Pnt, Z
from ngsolve import Det, Grad, Id, InnerProduct, Inv, Sym, Trace, ds, dx

RHO, NU, RHO_S, YOUNG, POISSON = 1000.0, 3e-6, 1200.0, 3e5, 0.3
RADII, LENGTH, PRESSURE, STEP, EXTENSION = (0.005, 0.006), 0.05, 1333.2, 1e-4, 1e-8


def tube(h):
    """The lumen and the wall, of cells of size h."""
    lumen = Cylinder(Pnt(0, 0, 0), Z, RADII[0], LENGTH)
    wall = Cylinder(Pnt(0, 0, 0), Z, RADII[1], LENGTH) - lumen
    lumen.mat("fluid")
    wall.mat("solid")
    lumen.faces.Min(Z).name = "inflow"
    lumen.faces.Max(Z).name = "outflow"
    for end in (wall.faces.Min(Z), wall.faces.Max(Z)):
        end.name = "clamp"
    mesh = ng.Mesh(OCCGeometry(Glue([lumen, wall])).GenerateMesh(maxh=h))
    mesh.Curve(2)
    return mesh


def forms(fluid, solid, old, compiled):
    """Residual of a step; `fluid` and `solid` are the integrals over the two."""
    (v, u, p), (phi, psi, xi) = old.space.TnT()
    (v_old, u_old, _) = old.components
    F = Id(3) + Grad(u)
    J, F_inv = Det(F), Inv(F)
    grad_v = Grad(v) * F_inv
    stress = RHO * NU * (grad_v + grad_v.trans) - p * Id(3)
    flow = RHO * J * InnerProduct((v - v_old) / STEP + grad_v * (v - (u - u_old) / STEP), phi)
    flow += J * InnerProduct(stress * F_inv.trans, Grad(phi)) + J * Trace(grad_v) * xi
    flow += EXTENSION * InnerProduct(Grad(u), Grad(psi))
    mu, lame = YOUNG / (2 * (1 + POISSON)), YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
    strain = Sym(Grad(u))
    body = RHO_S / STEP * InnerProduct(v - v_old, phi) + InnerProduct((u - u_old) / STEP - v, psi)
    body += InnerProduct(2 * mu * strain + lame * Trace(strain) * Id(3), Grad(phi))
    if compiled:
        flow, body = (x.Compile(True, wait=True) for x in (flow, body))
    a = ng.BilinearForm(old.space)
    a += flow * fluid
    a += body * solid
    return a


def median_time(work, repeat):
    """Seconds of a call, the median of `repeat`."""
    times = []
    for _ in range(repeat):
        begun = time.perf_counter()
        work()
        times.append(time.perf_counter() - begun)
    return statistics.median(times)


class Umfpack:
    """The solver of NGSolve."""

    def __init__(self, matrix, free):
        self.inverse = matrix.Inverse(free, inverse="umfpack")

    def solve(self, r):
        x = r.CreateVector()
        x.data = self.inverse * r
        return x


class Pardiso:
    """PARDISO of MKL, analysed once for a pattern."""

    analysed = None

    def __init__(self, matrix, free):
        import numpy as np
        import scipy.sparse as sp
        from pypardiso import PyPardisoSolver

        self.free = np.flatnonzero(np.array(list(free)))
        values, columns, rows = matrix.CSR()
        whole = sp.csr_matrix((np.array(values), np.array(columns), np.array(rows)), shape=(matrix.height,) * 2)
        self.matrix = whole[self.free][:, self.free].tocsr()
        self.matrix.sort_indices()
        self.solver = Pardiso.analysed or PyPardisoSolver(mtype=11)
        b = np.zeros(len(self.free))
        if Pardiso.analysed is None:
            self.solver.set_phase(11)
            self.solver._call_pardiso(self.matrix, b)
            Pardiso.analysed = self.solver
        begun = time.perf_counter()
        self.solver.set_phase(22)
        self.solver._call_pardiso(self.matrix, b)
        self.factor_seconds = time.perf_counter() - begun

    def solve(self, r):
        self.solver.set_phase(33)
        x = r.CreateVector()
        x[:] = 0.0
        x.FV().NumPy()[self.free] = self.solver._call_pardiso(self.matrix, r.FV().NumPy()[self.free])
        return x


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--h", type=float, default=0.0018)
    parser.add_argument("--steps", type=int, default=4)
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--solver", choices=["umfpack", "pardiso"], default="umfpack")
    parser.add_argument("--plain", action="store_true", help="expressions as they are, not compiled")
    args = parser.parse_args()

    ng.SetNumThreads(1)
    mesh = tube(args.h)
    V = ng.VectorH1(mesh, order=2, dirichlet="clamp")
    U = ng.VectorH1(mesh, order=2, dirichlet="clamp|inflow|outflow")
    Q = ng.Compress(ng.H1(mesh, order=1, definedon="fluid"))
    space = V * U * Q
    old, new = ng.GridFunction(space), ng.GridFunction(space)
    a = forms(dx("fluid"), dx("solid"), old, not args.plain)
    load = ng.LinearForm(space)
    load += -PRESSURE * ng.specialcf.normal(3) * space.TestFunction()[0] * ds("inflow")
    load.Assemble()
    free = space.FreeDofs()
    r = new.vec.CreateVector()
    kind = {"umfpack": Umfpack, "pardiso": Pardiso}[args.solver]

    def residual():
        a.Apply(new.vec, r)
        r.data -= load.vec
        projector.Project(r)

    projector = ng.Projector(free, True)
    report = {"version": ng.__version__, "cells": mesh.ne, "unknowns": space.ndof, "free": sum(free), "steps": []}
    report["unknowns"] = space.ndof
    for _ in range(args.steps):
        old.vec.data = new.vec
        residual()
        first, seconds = r.Norm(), {"residual": 0.0, "jacobian": 0.0, "factor": 0.0, "solve": 0.0}
        iterations, begun = 0, time.perf_counter()
        while r.Norm() > 1e-8 * first:
            at = time.perf_counter()
            a.AssembleLinearization(new.vec)
            seconds["jacobian"] += time.perf_counter() - at
            at = time.perf_counter()
            factors = kind(a.mat, free)
            seconds["factor"] += getattr(factors, "factor_seconds", time.perf_counter() - at)
            at = time.perf_counter()
            new.vec.data -= factors.solve(r)
            seconds["solve"] += time.perf_counter() - at
            at = time.perf_counter()
            residual()
            seconds["residual"] += time.perf_counter() - at
            iterations += 1
        report["steps"].append({"seconds": time.perf_counter() - begun, "iterations": iterations, "parts": seconds})
    # In the deformed state, all cells: one thread.
    report["residual"] = median_time(lambda: a.Apply(new.vec, r), args.repeat)
    report["jacobian"] = median_time(lambda: a.AssembleLinearization(new.vec), args.repeat)
    u = new.components[1]
    report["u_max"] = max(abs(u(mesh(RADII[0] * 0.999, 0, z * LENGTH))[0]) for z in (0.01, 0.02, 0.1, 0.5))
    print(json.dumps(report, indent=1))


if __name__ == "__main__":
    main()
