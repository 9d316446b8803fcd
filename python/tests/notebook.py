"""Executes a notebook and writes it with its outputs: python tests/notebook.py IN.ipynb OUT.ipynb."""

import sys

import nbclient
import nbformat


def main(source: str, target: str) -> None:
    notebook = nbformat.read(source, as_version=4)
    nbclient.NotebookClient(notebook, timeout=300, kernel_name="python3").execute()
    nbformat.write(notebook, target)
    pictures = sum(
        "image/png" in output.get("data", {}) for cell in notebook.cells for output in cell.get("outputs", [])
    )
    print(f"{source}: {len(notebook.cells)} cells, {pictures} pictures")
    if pictures == 0:
        sys.exit(f"{source}: no cell drew a picture")


if __name__ == "__main__":
    main(*sys.argv[1:])
