"""Meshes from arrays or meshio, as files that cases read."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

#: Type of Gmsh and dimension by number of points, for cells of the plane and of space.
_CELLS = {(2, 3): 2, (2, 4): 3, (2, 6): 9, (2, 8): 16, (2, 9): 10, (3, 4): 4, (3, 8): 5, (3, 10): 11, (3, 27): 12}
_FACETS = {(2, 2): 1, (2, 3): 8, (3, 3): 2, (3, 4): 3, (3, 6): 9, (3, 9): 10}


def write_mesh(
    path: str | os.PathLike[str],
    points: Any,
    cells: Mapping[str, Any] | None = None,
    boundaries: Mapping[str, Any] | None = None,
) -> str:
    """Writes a mesh as a Gmsh file (2.2, text) for ``case["mesh.file"]``, and returns its path.

    ``points`` has the shape (n, 2) or (n, 3) [m]. ``cells`` maps names of regions, such as ``"fluid"`` and ``"solid"``,
    to arrays (m, k) of points of cells: triangles (k = 3 or 6), quadrilaterals (4, 8 or 9), tetrahedra (4 or 10),
    hexahedra (8 or 27), counted from 0 in the order of Gmsh. ``boundaries`` maps names to the points (m, 2) of edges, in
    space to those of faces.

    ``points`` may also be a mesh of meshio that was read from a Gmsh file with named physical groups; nothing else is
    given then. What is wrong with a mesh is told by the case that reads it.
    """
    if cells is None:
        points, cells, boundaries = _of_meshio(points)
    points = np.asarray(points, dtype=float)
    if points.ndim != 2 or points.shape[1] not in (2, 3):
        raise ValueError(f"points: expected the shape (n, 2) or (n, 3), not {points.shape}")
    dimension = 3 if points.shape[1] == 3 and np.ptp(points[:, 2]) > 0 else 2
    groups = [(dimension, name, _CELLS, of) for name, of in cells.items()]
    groups += [(dimension - 1, name, _FACETS, of) for name, of in (boundaries or {}).items()]
    names, elements = [], []
    for number, (of, name, types, connectivity) in enumerate(groups, start=1):
        array = np.asarray(connectivity, dtype=np.int64)
        kind = types.get((dimension, array.shape[1])) if array.ndim == 2 else None
        if kind is None:
            raise ValueError(f"{name}: expected rows of the points of a cell or facet, not the shape {array.shape}")
        if array.size and not (0 <= array.min() and array.max() < len(points)):
            raise ValueError(f"{name}: expected numbers of points from 0 to {len(points) - 1}")
        names.append(f'{of} {number} "{name}"')
        elements += [f"{kind} 2 {number} {number} " + " ".join(map(str, row)) for row in (array + 1).tolist()]
    rows = np.zeros((len(points), 3))
    rows[:, : points.shape[1]] = points
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(names)), *names]
    lines += ["$EndPhysicalNames", "$Nodes", str(len(points))]
    lines += [f"{n} {x!r} {y!r} {z!r}" for n, (x, y, z) in enumerate(rows.tolist(), start=1)]
    lines += ["$EndNodes", "$Elements", str(len(elements))]
    lines += [f"{n} {element}" for n, element in enumerate(elements, start=1)]
    lines += ["$EndElements", ""]
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(lines))
    return os.fspath(path)


def _of_meshio(mesh: Any) -> tuple[Any, dict[str, Any], dict[str, Any]]:
    """Points, regions and boundaries of a mesh of meshio with the groups of Gmsh."""
    groups = mesh.cell_data.get("gmsh:physical")
    if groups is None or not mesh.field_data:
        raise ValueError("expected a mesh of meshio with named physical groups (`field_data`, `gmsh:physical`)")
    known = {(int(number), int(of)): name for name, (number, of) in mesh.field_data.items()}
    found: dict[int, dict[str, list[Any]]] = {1: {}, 2: {}, 3: {}}
    of_cells = max(block.dim for block in mesh.cells)
    for block, numbers in zip(mesh.cells, groups):
        for number in np.unique(numbers):
            name = known.get((int(number), block.dim))
            if name is None and block.dim == of_cells:
                raise ValueError(f"cells of {block.type} in group {number}, which has no name: expected a named region")
            if name is not None:
                found[block.dim].setdefault(name, []).append(np.asarray(block.data)[np.asarray(numbers) == number])
    highest = max(of for of, names in found.items() if names)
    joined = {of: {name: _joined(name, parts) for name, parts in names.items()} for of, names in found.items()}
    return mesh.points, joined[highest], joined.get(highest - 1, {})


def _joined(name: str, parts: Sequence[np.ndarray]) -> np.ndarray:
    if len({part.shape[1] for part in parts}) != 1:
        raise ValueError(f"{name}: expected one type of cells")
    return np.concatenate(parts)
