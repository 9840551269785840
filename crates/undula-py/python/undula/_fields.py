"""The solution at one moment."""

from __future__ import annotations

from typing import Any

import numpy as np


class Fields:
    """The fields of one moment on the cells of the velocity.

    ``points`` has the shape (n, 3) [m]: where the points are at that moment, unless the case has ``output.mesh =
    "reference"``; the third coordinate is 0 in the plane. ``cells`` has the shape (m, k): the points of each cell in the
    order of VTK, whose number of the type is ``cell_type``. ``point_data`` and ``cell_data`` have arrays of n or m
    numbers, or of n or m rows of components: ``velocity`` [m/s], ``deformation`` [m], ``pressure`` [Pa], what else
    ``output.fields`` names, and ``solid`` (1 in cells of the solid, else 0).
    """

    def __init__(self, data: dict[str, Any]) -> None:
        #: Time [s].
        self.time: float = data["time"]
        #: 2 or 3.
        self.dimension: int = data["dimension"]
        self.points: np.ndarray = data["points"]
        self.cells: np.ndarray = data["cells"]
        self.cell_type: int = data["cell_type"]
        self.point_data: dict[str, np.ndarray] = data["point_data"]
        self.cell_data: dict[str, np.ndarray] = data["cell_data"]

    def __getitem__(self, name: str) -> np.ndarray:
        """The array called ``name``, at points if there is one there, else in cells."""
        for data in (self.point_data, self.cell_data):
            if name in data:
                return data[name]
        raise KeyError(f"{name}; there are {', '.join([*self.point_data, *self.cell_data])}")

    def to_pyvista(self) -> Any:
        """A ``pyvista.UnstructuredGrid``; needs the package pyvista. Vectors have three components there."""
        import pyvista

        count, width = self.cells.shape
        cells = np.hstack([np.full((count, 1), width, dtype=np.int64), self.cells]).ravel()
        grid = pyvista.UnstructuredGrid(cells, np.full(count, self.cell_type, dtype=np.uint8), self.points)
        for name, values in self.point_data.items():
            grid.point_data[name] = _in_space(values)
        for name, values in self.cell_data.items():
            grid.cell_data[name] = _in_space(values)
        return grid

    def to_meshio(self) -> Any:
        """A ``meshio.Mesh``; needs the package meshio."""
        import meshio

        return meshio.Mesh(
            self.points,
            [(_MESHIO[self.cell_type], self.cells)],
            point_data={name: _in_space(values) for name, values in self.point_data.items()},
            cell_data={name: [values] for name, values in self.cell_data.items()},
        )

    def __repr__(self) -> str:
        names = ", ".join([*self.point_data, *self.cell_data])
        return f"<undula.Fields t = {self.time} s: {len(self.points)} points, {len(self.cells)} cells, {names}>"


#: Names of types of cells of VTK in meshio.
_MESHIO = {
    5: "triangle", 9: "quad", 10: "tetra", 12: "hexahedron", 22: "triangle6", 24: "tetra10", 28: "quad9",
    29: "hexahedron27", 69: "VTK_LAGRANGE_TRIANGLE", 70: "VTK_LAGRANGE_QUADRILATERAL",
    71: "VTK_LAGRANGE_TETRAHEDRON", 72: "VTK_LAGRANGE_HEXAHEDRON",
}


def _in_space(values: np.ndarray) -> np.ndarray:
    """Vectors of the plane with a third component 0."""
    if values.ndim == 2 and values.shape[1] == 2:
        return np.hstack([values, np.zeros((len(values), 1))])
    return values
