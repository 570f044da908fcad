"""What needs files or the solver: the command phynness, started as a process of its own, with its messages and results."""
from __future__ import annotations

import contextlib
import csv
import html
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import webbrowser
from pathlib import Path as File
from typing import Any, Dict, Iterator, List, NamedTuple, Optional, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._phynness import Error, Model

__all__ = ["Page", "Solution", "precompute", "save", "show", "solve", "train", "validate"]

Path = Union[str, "os.PathLike[str]"]


def __dir__() -> List[str]:
    return sorted(__all__)


class Solution(NamedTuple):
    """Solved states of n displacements; rows that could not be solved are NaN."""

    force: NDArray[np.float64]  # (n, 3) [N]
    energy: NDArray[np.float64]  # (n,) [J]
    status: NDArray[np.int32]  # (n,), 0: solved, others as in formats/database.md
    note: List[str]  # (n,), why there is no solution, or that the state is unstable


def _command() -> str:
    # That of the same installation (PREFIX/lib/pythonX.Y/site-packages/phynness), before another one.
    beside = File(__file__).resolve().parents[4:5]
    places = [os.environ.get("PHYNNESS_COMMAND"), *(str(prefix / "bin/phynness") for prefix in beside), "phynness"]
    for place in places:
        found = place and shutil.which(place)
        if found:
            return found
    raise Error("the command phynness was not found; install it, add its folder to PATH, or set PHYNNESS_COMMAND to its path")


def _run(*arguments: object, ranks: int = 1, progress: Optional[bool] = None) -> None:
    """Runs the command; its messages go to sys.stderr. KeyboardInterrupt ends it as Ctrl-C does: what is finished is kept."""
    if ranks < 1:
        raise Error(f"ranks = {ranks}; at least 1")
    start = [] if ranks == 1 else ["mpirun", "-n", str(ranks), *(["--oversubscribe"] if ranks > (os.cpu_count() or 1) else [])]
    shown = sys.stderr.isatty() if progress is None else progress
    # Open MPI requires both of root, as phynness run sets them.
    as_root = ["OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM"] if ranks > 1 and os.geteuid() == 0 else []
    environment = {**dict.fromkeys(as_root, "1"), **os.environ, **({"PHYNNESS_PROGRESS": "1"} if shown else {})}
    # In a group of its own, so that Ctrl-C of a terminal reaches it once, from here.
    process = subprocess.Popen(
        [*start, _command(), *map(str, arguments)], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE, env=environment, start_new_session=True)
    said: List[str] = []

    def listen() -> int:
        for chunk in iter(lambda: os.read(process.stderr.fileno(), 65536), b""):
            said.append(chunk.decode(errors="replace"))
            if shown:
                sys.stderr.write(said[-1])
                sys.stderr.flush()
        return process.wait()

    try:
        status = listen()
    except BaseException:
        process.send_signal(signal.SIGINT)
        try:
            listen()
        except BaseException:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()
        raise
    finally:
        process.stderr.close()
    text = "".join(said).rpartition("\r")[2] if shown else "".join(said)
    if status == 2:
        raise Error(text.strip())
    if status != 0:
        raise RuntimeError(text.strip() or f"phynness {arguments[0]} ended with status {status}")
    if text and not shown:
        sys.stderr.write(text)


def save(model: Model, path: Path) -> None:
    """Writes a model directory, model.txt and mesh.txt; of a model that was read without a mesh the file model.txt alone."""
    texts = {File(path): model.text}
    if model.mesh_text is not None:
        File(path).mkdir(parents=True, exist_ok=True)
        texts = {File(path) / "model.txt": model.text, File(path) / "mesh.txt": model.mesh_text}
    for file, text in texts.items():
        half = file.with_name(file.name + ".part")  # an interruption leaves what was there
        half.write_bytes(text)
        half.replace(file)


def train(database: Path, *, progress: Optional[bool] = None, **keys: Union[int, float, str]) -> Model:
    """Trains a Model on the database in a file; Model.training are the numbers of `phynness train --json`.

    Other arguments are keys of [training] (formats/scene.md), which replace those of the database's scene, as family="modal".
    Error for impossible values, as in a scene. Ctrl-C ends the training.
    """
    settings = [word for key, value in keys.items() for word in ("--set", f"{key}={json.dumps(getattr(value, 'item', lambda: value)())}")]
    with tempfile.TemporaryDirectory(prefix="phynness-") as folder:
        out, figures = File(folder) / "model", File(folder) / "figures.json"
        _run("train", os.fspath(database), "-o", out, *settings, "--json", figures, progress=progress)
        return Model((out / "model.txt").read_bytes(), (out / "mesh.txt").read_bytes(), json.loads(figures.read_text()))


@contextlib.contextmanager
def _folder(model: Union[Path, Model]) -> Iterator[str]:
    if not isinstance(model, Model):
        yield os.fspath(model)
        return
    with tempfile.TemporaryDirectory(prefix="phynness-") as folder:
        model.save(File(folder) / "model")
        yield os.path.join(folder, "model")


def solve(scene: Path, node: int, d: ArrayLike, *, progress: Optional[bool] = None) -> Solution:
    """Finite element solves of a node of the surface at displacements d, (3,) or (n, 3) [m], each from rest.

    `scene` is the path of a scene, or of a database, whose mesh is then not made anew. Error in words if it is
    refused. About as many solves as increments are needed for each displacement (docs/commands.md, solve).
    """
    rows = np.atleast_2d(np.asarray(d, float))
    if rows.ndim != 2 or rows.shape[1] != 3:
        raise Error(f"d has the shape {np.shape(d)}; displacements have the shape (3,) or (n, 3)")
    with tempfile.TemporaryDirectory(prefix="phynness-") as folder:
        queries, table = File(folder) / "queries.csv", File(folder) / "solved.csv"
        queries.write_text("node,ux_m,uy_m,uz_m\n" + "".join(f"{node},{x!r},{y!r},{z!r}\n" for x, y, z in rows.tolist()))
        _run("solve", os.fspath(scene), "--queries", queries, "-o", table, progress=progress)
        with table.open(newline="") as lines:
            found = list(csv.DictReader(lines))

    def numbers(name: str) -> NDArray[np.float64]:
        return np.array([float(row[name] or "nan") for row in found])

    force = np.stack([numbers(f"f{axis}_N") for axis in "xyz"], axis=1)
    status = np.array([int(row["status"]) for row in found], np.int32)
    return Solution(force, numbers("energy_J"), status, [row["note"] for row in found])


def precompute(scene: Path, out: Path, *, ranks: int = 1, resume: bool = False,
               progress: Optional[bool] = None) -> None:
    """Solves every probe of the scene at `scene` on `ranks` processes and writes the database `out`.

    KeyboardInterrupt keeps what is solved, and `resume` continues it, also a finished database to more points, directions and
    increments of the scene (docs/commands.md, precompute). Progress is shown on terminals, or anywhere with progress=True.
    """
    _run("precompute", os.fspath(scene), "-o", os.fspath(out), *["--resume"] * resume, ranks=ranks, progress=progress)

def validate(scene: Path, model: Union[Path, Model], *, probes: Optional[int] = None, points: Optional[int] = None,
             pairs: Optional[int] = None, seed: Optional[int] = None, report: Optional[Path] = None, ranks: int = 1,
             progress: Optional[bool] = None) -> Dict[str, Any]:
    """The errors of a model against fresh finite element solves: the numbers of `phynness validate --json`.

    `model` is a Model or its folder. The keys are those of formats/validation.md; errors are in %. `points` and `pairs` ask for
    tools between nodes and for two tools; `report` is an HTML file to write.
    """
    with _folder(model) as folder, tempfile.TemporaryDirectory(prefix="phynness-") as results:
        figures = File(results) / "figures.json"
        asked = {"probes": probes, "points": points, "pairs": pairs, "seed": seed, "report": report}
        options = [word for name, value in asked.items() if value is not None for word in (f"--{name}", str(value))]
        _run("validate", os.fspath(scene), folder, *options, "--json", figures, ranks=ranks, progress=progress)
        return json.loads(figures.read_text())


class Page:
    """A page on which a model can be touched, in the file `path`. A notebook shows it in a frame."""

    def __init__(self, path: File) -> None:
        self.path = path

    def _repr_html_(self) -> str:
        text = html.escape(self.path.read_text(encoding="utf-8"))
        return f'<iframe srcdoc="{text}" style="width: 100%; height: 640px; border: 0"></iframe>'


def show(model: Union[Path, Model], out: Optional[Path] = None, *, database: Optional[Path] = None,
         errors: Optional[Path] = None) -> Page:
    """Writes the page of a model, one HTML file that needs no network, and returns it (docs/commands.md, view).

    As the last expression of a notebook's cell it is shown there. Elsewhere, without `out`, the page is a temporary file, which
    the browser opens. `database` adds the stored finite element forces, `errors` (a file of `validate --json`) the errors.
    """
    opened = out is None and "ipykernel" not in sys.modules
    page = File(out or os.path.join(tempfile.mkdtemp(prefix="phynness-"), "model.html"))
    more = [word for name, value in {"database": database, "errors": errors}.items() if value is not None
            for word in (f"--{name}", os.fspath(value))]
    with _folder(model) as folder:
        _run("view", folder, *more, "-o", page)
    if opened:
        webbrowser.open(page.resolve().as_uri())
    return Page(page)
