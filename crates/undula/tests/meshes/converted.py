"""Writes the VTU files and meshio's Gmsh files beside it from those of `ring.py`. Needs meshio and vtk (pip)."""

import meshio
import vtk

for kind in ("ring_2", "ring_tetrahedra_2"):
    mesh = meshio.read(f"{kind}_v4.1.msh")
    # What meshio makes of it: numbers, and all sets in one array. It stops at the set that it adds itself.
    mesh.cell_sets.pop("gmsh:bounding_entities")
    meshio.write(f"{kind}_meshio.vtu", mesh)
    meshio.write(f"{kind}_meshio22.msh", mesh, file_format="gmsh22")
    meshio.write(f"{kind}_meshio41.msh", mesh, file_format="gmsh")
    # Without names, as scripts do that know cells and numbers only.
    cells = [(block.type, block.data) for block in mesh.cells]
    physical = {"gmsh:physical": mesh.cell_data["gmsh:physical"]}
    meshio.write(f"{kind}_numbers22.msh", meshio.Mesh(mesh.points, cells, cell_data=physical), file_format="gmsh22")
    # VTK: words in `name`, and an array of 0 and 1 for each group.
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(f"{kind}_meshio.vtu")
    reader.Update()
    for words in (True, False):
        grid = vtk.vtkUnstructuredGrid()
        grid.DeepCopy(reader.GetOutput())
        data = grid.GetCellData()
        physical = data.GetArray("gmsh:physical")
        names = {(int(dim), int(tag)): name for name, (tag, dim) in mesh.field_data.items()}
        of = [
            names[grid.GetCell(i).GetCellDimension(), int(physical.GetTuple1(i))] for i in range(grid.GetNumberOfCells())
        ]
        while data.GetNumberOfArrays():
            data.RemoveArray(0)
        if words:
            array = vtk.vtkStringArray()
            array.SetName("name")
            for name in of:
                array.InsertNextValue(name)
            data.AddArray(array)
        else:
            for name in sorted(set(of)):
                array = vtk.vtkUnsignedCharArray()
                array.SetName(name)
                for other in of:
                    array.InsertNextValue(int(other == name))
                data.AddArray(array)
        writer = vtk.vtkXMLUnstructuredGridWriter()
        writer.SetInputData(grid)
        writer.SetFileName(f"{kind}_{'words' if words else 'marks'}.vtu")
        if words:
            writer.SetDataModeToAppended()
            writer.EncodeAppendedDataOff()
        else:
            writer.SetDataModeToAppended()
            writer.EncodeAppendedDataOn()
            writer.SetCompressorTypeToNone()
            writer.SetHeaderTypeToUInt32()
        writer.Write()
