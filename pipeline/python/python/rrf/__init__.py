"""Bakes a static scene's indirect light into small neural nets, and asks them.

    import rrf

    rrf.bake("room.glb", "out/room", target=0.05, progress=print)
    run = rrf.open("out/room")
    answers = run.query(points)           # anything with __arrow_c_stream__: pyarrow, polars, DuckDB
    picture = run.render(eye=(0, 1, 3), look_at=(0, 1, 0), light=[(0, 1.6, 0, 4, 4, 4)])

Keyword arguments are the options of the commands, with _ in place of -: `light_box=(x0, y0, z0, x1, y1, z1)` is
`--light-box x0,y0,z0,x1,y1,z1`. A list of tuples gives an option several times. The reference of the command line lists
them. Lengths are metres, radiance is W/(sr m²), frames are linear sRGB.
"""

import builtins
import json
import os
import sys

import numpy as np

from ._kernels import fixed_kernels

with fixed_kernels():
    from . import _native
from ._native import BadInput, RrfError, Table, __version__

__all__ = ["BadInput", "RrfError", "Run", "Table", "__version__", "bake", "open"]


def _text(value):
    if isinstance(value, (tuple, list)):
        return ",".join(map(_text, value))
    if isinstance(value, (float, np.floating)):
        # the shortest text that means the same number
        return repr(float(value))
    return os.fspath(value) if isinstance(value, os.PathLike) else str(value)


def _words(options):
    """Keyword arguments as words of the command line."""
    words = []
    for name, value in options.items():
        option = "--" + name.rstrip("_").replace("_", "-")
        if value is None or value is False:
            continue
        if value is True:
            words.append(option)
            continue
        several = isinstance(value, list) and not all(isinstance(one, (int, float, np.number)) for one in value)
        words += [f"{option}={_text(one)}" for one in (value if several else [value])]
    return words


def bake(scene, run, *, progress=None, **settings):
    """Bakes a scene file into the folder `run`.

    Args:
        scene: scene file (.pbrt, .gltf, .glb, .obj).
        run: folder to make; with `resume=True` an interrupted one goes on.
        progress: called on this thread with a dictionary: `stage`, `done` and `total` steps, and after a round `round`,
            `cells`, `relative_error` and `relative_error_se`. An exception that it raises stops the bake.
        settings: options of `rrf bake`, such as `target=0.05`, `preset="preview"`, `light_box=(...)`, `seed=1`.

    Returns:
        The result as a dictionary: run, method, target, target_met, seconds, processor_seconds and more.

    Raises:
        BadInput: a scene or an option is not what `rrf bake` takes.
        RrfError: something failed that could succeed if tried again.
        KeyboardInterrupt: Ctrl-C; what is finished stays, and `resume=True` goes on.
    """
    words = ["bake", os.fspath(scene), "-o", os.fspath(run), *_words(settings)]
    return json.loads(_native.bake(words, progress))


def open(run, *, trust_error=0.5):  # noqa: A001 (as gzip.open and others)
    """Opens a baked run. Cells whose error is above `trust_error` by two standard errors are not trusted."""
    return Run(run, trust_error)


class Run:
    """A baked run, held open: its model, its scene, its tables."""

    def __init__(self, run, trust_error=0.5):
        self.path = os.path.abspath(os.fspath(run))
        self._run = _native.Run(self.path, trust_error)

    def __repr__(self):
        return f"<rrf.Run {self.path}>"

    @property
    def manifest(self):
        """`run.json` as a dictionary: scene, seed, settings."""
        return json.loads(self._run.manifest())

    @property
    def cells(self):
        """The tree of cells as a `Table`: `model/tree.arrow`, of a transfer `model/transfer_tree.arrow`."""
        return self._table("tree", "transfer_tree")

    @property
    def metrics(self):
        """How each cell's fit went as a `Table`: `model/metrics.arrow`, of a transfer `model/transfer_cells.arrow`."""
        return self._table("metrics", "transfer_cells")

    def _table(self, *names):
        paths = [os.path.join(self.path, "model", f"{name}.arrow") for name in names]
        return _native.read_table(next(filter(os.path.exists, paths), paths[0]))

    def query(self, table, *, blend=False):
        """The model's indirect radiance at the rows of a points table.

        Args:
            table: anything with `__arrow_c_stream__`; columns `px py pz nx ny nz vx vy vz lx ly lz`, perhaps `light`. A table
                of one batch is read where it is.
            blend: blend neighbouring nets where they meet and agree.

        Returns:
            A `Table`: the rows with `r g b cell_id trusted` appended, radiance in W/(sr m²). pyarrow, polars and DuckDB take
            it: `pyarrow.table(answers)`, `polars.DataFrame(answers)`.
        """
        return self._run.query(table, blend)

    def trace(self, table, *, spp=256, **options):
        """The truth at the rows of a points table, path traced in the run's scene.

        Args:
            table: as for `query`.
            spp: paths a row, a multiple of 16.
            options: of `rrf trace --points`: `seed`, `estimator`.

        Returns:
            A `Table`: the rows with `r g b r_se g_se b_se` appended, mean and standard error in W/(sr m²).
        """
        scene = self.manifest["scene"]
        words = ["trace", scene, "-o", "table.arrow", "--points=table.arrow", f"--spp={spp}", *_words(options)]
        return self._run.trace(table, words)

    def render(self, **options):
        """A frame of the run.

        Args:
            options: of `rrf render`: `eye`, `look_at`, `up`, `fov`, `size=(w, h)`, `light=[(x, y, z, r, g, b), ...]`,
                `sun=[(azimuth, elevation)]`, `part="indirect"`, `aa` and others. What is not given comes from the scene.

        Returns:
            numpy.ndarray: shape [height, width, 3], float32, radiance in W/(sr m²), linear sRGB, row 0 at the top.
        """
        if isinstance(size := options.get("size"), (tuple, builtins.list)):
            options["size"] = "x".join(map(str, size))
        words = ["render", self.path, "-o", "frame.exr", *_words(options)]
        height, width, pixels = self._run.render(words)
        return np.frombuffer(pixels, dtype="<f4").reshape(height, width, 3)


def _command():
    """The program `rrf`."""
    sys.exit(_native.command(["rrf", *sys.argv[1:]]))
