"""What the notebooks share: where things are, and how tables and frames are read."""

import json
import os
import pathlib
import subprocess
import sys

import numpy as np
import OpenEXR
import pyarrow.dataset as ds
import pyarrow.ipc as ipc

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests/python"))

import contract  # noqa: E402, F401 (the schemas, for the notebooks)
import nets  # noqa: E402, F401 (the nets in numpy, for the notebooks)
import rrf_truth as truth  # noqa: E402, F401 (errors and limits, for the notebooks)

ORACLE = ROOT / "tests/data/oracle"
SCENES = ROOT / "scenes"
RGB = ("r", "g", "b")


def demo() -> pathlib.Path:
    """The folder that `make notebooks` leaves: run/, model.exr, traced.exr. RRF_DEMO names another."""
    folder = pathlib.Path(os.environ.get("RRF_DEMO", ROOT / "out/notebooks"))
    if not (folder / "run/run.json").is_file():
        raise FileNotFoundError(f"{folder}: no run; `make notebooks` makes one")
    return folder


def program() -> pathlib.Path:
    """The program, RRF or target/release/rrf."""
    return pathlib.Path(os.environ.get("RRF", ROOT / "target/release/rrf"))


def rrf(*arguments) -> str:
    """Runs the program quietly; its standard output."""
    command = [str(program()), *map(str, arguments), "--quiet"]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{' '.join(command)}: exit code {done.returncode}\n{done.stderr}")
    return done.stdout


def expect_units(name, units):
    """Stops unless every column of schemas/NAME.toml has the unit that a notebook is written for:
    those of `units` (unit to columns), 1 otherwise."""
    wanted = {column: unit for unit, columns in units.items() for column in columns.split()}
    found = {column["name"]: column["unit"] for column in contract.load(name)["column"]}
    assert wanted.keys() <= found.keys(), wanted.keys() - found.keys()
    wrong = {column: unit for column, unit in found.items() if unit != wanted.get(column, "1")}
    assert not wrong, f"schemas/{name}.toml: {wrong}"


def read_arrow(path):
    with ipc.open_file(path) as file:
        return file.read_all()


def samples(run, columns=None):
    """All rows of a run, a pyarrow table in the order of cells."""
    return ds.dataset(run / "samples", partitioning="hive").to_table(columns=columns)


def stack(table, names) -> np.ndarray:
    """Columns side by side as float64, shape [rows, len(names)]."""
    return np.stack([table[name].to_numpy().astype(float) for name in names], 1)


def with_material(table, run):
    """A points table with the six material columns of the nearest sample.

    Right for scenes whose materials differ by place and normal and have no textures."""
    rows = samples(run)
    names = contract_names()[12:18]
    place = stack(rows, ("px", "py", "pz", "nx", "ny", "nz"))
    wanted = stack(table, ("px", "py", "pz", "nx", "ny", "nz"))
    known = {name: rows[name].to_numpy() for name in names}
    nearest = np.array([np.abs(place - row).sum(1).argmin() for row in wanted])
    texts = [f.name for f in table.schema if str(f.type) in ("string", "large_string")]
    table = table.drop_columns(texts)
    for name in names:
        table = table.append_column(name, [known[name][nearest]])
    return table


def contract_names():
    """The 18 raw columns in order."""
    return [column["name"] for column in contract.raw_columns()]


leaf = nets.leaf


def read_exr(path) -> dict[str, np.ndarray]:
    """Layers of a frame: "full", "direct", "indirect" of shape [h, w, 3] and others as they are."""
    with OpenEXR.File(str(path), separate_channels=True) as file:
        channels = {name: np.array(c.pixels) for name, c in file.channels().items()}
    layers = {}
    for name in channels:
        head, _, last = name.rpartition(".")
        if last == "R":
            prefix = f"{head}." if head else ""
            layers[head or "full"] = np.stack([channels[prefix + c] for c in "RGB"], -1).astype(float)
        elif last not in ("G", "B"):
            layers[name] = channels[name]
    return layers


def compare(a, b, layer="full") -> dict:
    """`rrf compare --json` with its measures by name."""
    out = rrf("compare", a, b, "--layer", layer, "--json")
    return json.loads(out) | truth.measures(out)

