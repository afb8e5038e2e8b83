#!/usr/bin/python3
"""Runs the code of a notebook without Jupyter, in its folder, and prints what it prints.

  PYTHONPATH=build/release/python postprocess/run_notebook.py python/notebooks/music.ipynb
  PYTHONPATH=build/release/python postprocess/run_notebook.py python/notebooks/music.ipynb --output python/notebooks/music.ipynb

With --output the notebook is written with what its cells print and draw, pictures as small PNG files. Needs matplotlib.
"""

import argparse
import base64
import contextlib
import io
import json
import os
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

DOTS = 72  # per inch, of the pictures that a notebook keeps


def lines_of(text):
    """A text as notebooks keep it."""
    return text.splitlines(keepends=True)


def drawn():
    """The open figures as outputs of a cell, in the order in which they were made; they are closed."""
    found = []
    for number in plt.get_fignums():
        picture = io.BytesIO()
        plt.figure(number).savefig(picture, format="png", dpi=DOTS, bbox_inches="tight")
        plt.close(number)
        data = {"image/png": base64.b64encode(picture.getvalue()).decode() + "\n", "text/plain": ["<Figure>"]}
        found.append({"output_type": "display_data", "metadata": {}, "data": data})
    return found


def run_cells(cells):
    """Runs the cells of code in turn, in one namespace, and gives each its outputs and number."""
    names, count = {"__name__": "__main__"}, 0
    for cell in cells:
        if cell["cell_type"] != "code":
            continue
        count += 1
        told = io.StringIO()
        with contextlib.redirect_stdout(told):
            exec(compile("".join(cell["source"]), f"cell {count}", "exec"), names)  # pylint: disable=exec-used
        text = [{"name": "stdout", "output_type": "stream", "text": lines_of(told.getvalue())}] if told.getvalue() else []
        cell["outputs"], cell["execution_count"] = text + drawn(), count
        print(told.getvalue(), end="")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("notebook", type=Path)
    parser.add_argument("--output", type=Path, help="the notebook with its outputs; may be the same file")
    options = parser.parse_args()
    notebook = json.loads(options.notebook.read_text(encoding="utf-8"))
    output = options.output and options.output.resolve()
    os.chdir(options.notebook.resolve().parent)
    sys.path.insert(0, ".")
    run_cells(notebook["cells"])
    if output:
        output.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
