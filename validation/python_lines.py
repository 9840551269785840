"""Runs the Python lines of documents, those of one document in one namespace and in an empty directory:

    python validation/python_lines.py DIR README.md docs/python.md
"""

import os
import re
import sys


def main(directory, *documents):
    for document in documents:
        with open(document, encoding="utf-8") as file:
            text = file.read()
        blocks = [(m.start(1), m.group(1)) for m in re.finditer(r"^```python\n(.*?)^```$", text, re.M | re.S)]
        if not blocks:
            sys.exit(f"{document}: no Python lines")
        place = os.path.join(directory, os.path.basename(document))
        os.makedirs(place)
        here = os.getcwd()
        os.chdir(place)
        namespace = {"__name__": "lines"}
        for start, block in blocks:
            # Messages name the line of the document.
            lines = "\n" * text.count("\n", 0, start) + block
            exec(compile(lines, document, "exec"), namespace)
        os.chdir(here)
        print(f"{document}: {len(blocks)} pieces of Python ran")


main(*sys.argv[1:])
