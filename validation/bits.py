"""What of a run must have the same bytes as another one: rows, fields, their list, the arrays of the last checkpoint."""
import os
import zipfile


def content(directory):
    found = {}
    for folder, _, files in os.walk(directory):
        for name in files:
            path = os.path.join(folder, name)
            if name in ("history.csv", "fields.pvd", "case.toml") or name.endswith(".vtu"):
                with open(path, "rb") as file:
                    found[os.path.relpath(path, directory)] = file.read()
    last = sorted(os.listdir(os.path.join(directory, "checkpoints")))[-1]
    with zipfile.ZipFile(os.path.join(directory, "checkpoints", last)) as archive:
        for member in archive.namelist():
            if member.endswith(".npy"):
                found[last + " " + member] = archive.read(member)
    return found


def differing(one, two):
    """Names that are not the same in two runs, and how many were compared."""
    one, two = content(one), content(two)
    return sorted(name for name in one.keys() | two.keys() if one.get(name) != two.get(name)), len(one)
