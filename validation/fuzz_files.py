"""Small sound files for `fuzz.py`: the same mesh as text and bytes of Gmsh 4.1, text of Gmsh 2.2 and VTU; a table."""
import base64
import struct

# Two by two quadrilaterals, a solid beside a fluid.
NODES = [(x, y) for y in range(3) for x in range(3)]
FACETS = {1: [(1, 4), (4, 7)], 2: [(3, 6), (6, 9)], 3: [(1, 2), (7, 8), (8, 9)], 4: [(2, 3)]}
CELLS = {5: [(1, 2, 5, 4), (4, 5, 8, 7), (5, 6, 9, 8)], 6: [(2, 3, 6, 5)]}
NAMES = {1: "left", 2: "right", 3: "walls", 4: "clamp", 5: "fluid", 6: "solid"}
# Dimension, type of Gmsh, elements.
BLOCKS = [(1, 1, FACETS), (2, 3, CELLS)]


def names():
    lines = ["$PhysicalNames", "6"] + [f'{1 if n < 5 else 2} {n} "{name}"' for n, name in NAMES.items()]
    return lines + ["$EndPhysicalNames"]


def gmsh4():
    lines = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat"] + names() + ["$Entities", "0 4 2 0"]
    lines += [f"{n} 0 0 0 2 2 0 1 {n} 0" for n in NAMES]
    lines += ["$EndEntities", "$Nodes", "1 9 1 9", "2 5 0 9"] + [str(n) for n in range(1, 10)]
    lines += [f"{x} {y} 0" for x, y in NODES] + ["$EndNodes", "$Elements"]
    blocks, tag = [], 0
    for dimension, kind, groups in BLOCKS:
        for entity, elements in groups.items():
            blocks.append(f"{dimension} {entity} {kind} {len(elements)}")
            for nodes in elements:
                tag += 1
                blocks.append(" ".join(map(str, (tag, *nodes))))
    return "\n".join(lines + [f"6 {tag} 1 {tag}"] + blocks + ["$EndElements", ""]).encode()


def gmsh2():
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat"] + names()
    lines += ["$Nodes", "9"] + [f"{n + 1} {x} {y} 0" for n, (x, y) in enumerate(NODES)] + ["$EndNodes"]
    elements = [(kind, group, nodes) for _, kind, groups in BLOCKS for group, list_ in groups.items() for nodes in list_]
    lines += ["$Elements", str(len(elements))]
    lines += [" ".join(map(str, (n + 1, kind, 2, group, group, *nodes))) for n, (kind, group, nodes) in enumerate(elements)]
    return "\n".join(lines + ["$EndElements", ""]).encode()


def gmsh4_bytes():
    out = b"$MeshFormat\n4.1 1 8\n" + struct.pack("<i", 1) + b"\n$EndMeshFormat\n" + "\n".join(names()).encode()
    out += b"\n$Entities\n" + struct.pack("<4Q", 0, 4, 2, 0)
    for n in NAMES:
        out += struct.pack("<i6dQiQ", n, 0, 0, 0, 2, 2, 0, 1, n, 0)
    out += b"\n$EndEntities\n$Nodes\n" + struct.pack("<4Q", 1, 9, 1, 9) + struct.pack("<3iQ", 2, 5, 0, 9)
    out += struct.pack("<9Q", *range(1, 10)) + b"".join(struct.pack("<3d", x, y, 0) for x, y in NODES)
    blocks, tag = b"", 0
    for dimension, kind, groups in BLOCKS:
        for entity, elements in groups.items():
            blocks += struct.pack("<3iQ", dimension, entity, kind, len(elements))
            for nodes in elements:
                tag += 1
                blocks += struct.pack(f"<{1 + len(nodes)}Q", tag, *nodes)
    return out + b"\n$EndNodes\n$Elements\n" + struct.pack("<4Q", 6, tag, 1, tag) + blocks + b"\n$EndElements\n"


def vtu(how):
    """`how` is `ascii`, `binary` (base64) or `raw` (appended)."""
    elements = [(kind, group, nodes) for _, kind, groups in BLOCKS for group, list_ in groups.items() for nodes in list_]
    points = [c for x, y in NODES for c in (x, y, 0)]
    nodes = [n - 1 for _, _, nodes in elements for n in nodes]
    offsets = [sum(len(e[2]) for e in elements[:n + 1]) for n in range(len(elements))]
    types = [3 if kind == 1 else 9 for kind, _, _ in elements]
    appended = b""

    def array(name, kind, code, values, components=1):
        nonlocal appended
        head = f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format="'
        if how == "ascii":
            return f'{head}ascii">{" ".join(map(str, values))}</DataArray>'
        data = struct.pack(f"<{len(values)}{code}", *values)
        data = struct.pack("<I", len(data)) + data
        if how == "binary":
            return f'{head}binary">{base64.b64encode(data).decode()}</DataArray>'
        offset, appended = len(appended), appended + data
        return f'{head}appended" offset="{offset}"/>'

    marks = [array(name, "Int32", "i", [int(group == n) for _, group, _ in elements]) for n, name in NAMES.items()]
    text = ['<?xml version="1.0"?>', '<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian">',
            f'<UnstructuredGrid><Piece NumberOfPoints="9" NumberOfCells="{len(elements)}">',
            "<Points>", array("Points", "Float64", "d", points, 3), "</Points>", "<Cells>",
            array("connectivity", "Int64", "q", nodes), array("offsets", "Int64", "q", offsets),
            array("types", "UInt8", "B", types), "</Cells>", "<CellData>", *marks, "</CellData>",
            "</Piece></UnstructuredGrid>"]
    out = "\n".join(text).encode()
    if how == "raw":
        out += b'\n<AppendedData encoding="raw">\n_' + appended + b"\n</AppendedData>"
    return out + b"\n</VTKFile>\n"


TABLE = b"# t, v\ntime,value\n" + b"".join(b"%g,%g\n" % (0.05 * n, n * (8 - n) / 16) for n in range(9))
