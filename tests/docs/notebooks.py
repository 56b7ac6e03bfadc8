"""Executes the notebooks of the documentation, cell by cell in one namespace, as the examples of its pages are.

A kernel would need two dozen packages more, and sockets; the cells are plain Python. `python -m tests.docs.notebooks`
writes the outputs anew.
"""

import ast
import contextlib
import io
import json
import os
import tempfile
from base64 import b64encode
from pathlib import Path
from typing import Any

NOTEBOOKS = sorted((Path(__file__).parents[2] / "docs").glob("*.ipynb"))

Json = dict[str, Any]


def read(path: Path) -> Json:
    content: Json = json.loads(path.read_text(encoding="utf-8"))
    return content


def code_cells(notebook: Json) -> list[Json]:
    return [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def outputs(notebook: Json, name: str) -> list[list[Json]]:
    """What the cells print and show, executed one after the other in the working directory."""
    names: Json = {"__name__": "notebook"}
    return [_executed("".join(cell["source"]), name, i, names) for i, cell in enumerate(code_cells(notebook), 1)]


def _executed(source: str, name: str, count: int, names: Json) -> list[Json]:
    body = ast.parse(source).body
    last = body[-1] if body else None
    shown = ast.Expression(last.value) if isinstance(last, ast.Expr) else None
    body = body[:-1] if shown else body
    value, printed = None, io.StringIO()
    with contextlib.redirect_stdout(printed):
        exec(compile(ast.Module(body, []), name, "exec"), names)
        if shown is not None:
            value = eval(compile(shown, name, "eval"), names)
    found: list[Json] = []
    if printed.getvalue():
        found.append({"output_type": "stream", "name": "stdout", "text": _lines(printed.getvalue())})
    if value is not None:
        data: Json = {"text/plain": _lines(repr(value))}
        if (page := getattr(value, "_repr_html_", lambda: None)()) is not None:
            data["text/html"] = _lines(page)
        if (picture := getattr(value, "_repr_png_", lambda: None)()) is not None:
            data["image/png"] = b64encode(picture).decode("ascii")
        found.append({"output_type": "execute_result", "execution_count": count, "metadata": {}, "data": data})
    return found


def _lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)


def main() -> None:
    for path in NOTEBOOKS:
        notebook, here = read(path), Path.cwd()
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            try:
                found = outputs(notebook, path.name)
            finally:
                os.chdir(here)
        for i, (cell, shown) in enumerate(zip(code_cells(notebook), found, strict=True), 1):
            cell["execution_count"], cell["outputs"] = i, shown
        path.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
