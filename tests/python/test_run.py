"""A small run of the program itself (RRF names the binary), as pyarrow, polars, duckdb and numpy
see it."""

import json
import os
import pathlib
import subprocess
import sys

import duckdb
import numpy as np
import polars as pl
import pyarrow as pa
import pyarrow.dataset as ds
import pyarrow.ipc as ipc
import pyarrow.parquet as pq
import pytest

import contract
import nets

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests"))
import seams  # noqa: E402

SCENE = ROOT / "scenes/cornell-box/scene.pbrt"
ORACLE = ROOT / "tests/data/oracle/cornell_overhead.parquet"
CELLS = 3
# eight a weight: a net with hardly more rows than weights amplifies float32's rounding
ROWS = 12_000


def rrf(*arguments):
    binary = os.environ.get("RRF", ROOT / "target/release/rrf")
    subprocess.run([binary, *map(str, arguments)], check=True, capture_output=True)


@pytest.fixture(scope="module")
def baked(tmp_path_factory):
    """The Cornell box in three nets."""
    run = tmp_path_factory.mktemp("rrf") / "run"
    box = "-0.6,1.3,-0.6,0.6,1.8,0.6"
    sizes = ["--method", "nets", "--cells", CELLS, "--rows", ROWS, "--paths", 8, "--rounds", 1]
    rrf("bake", SCENE, "-o", run, "--light-box", box, *sizes)
    return run


@pytest.fixture(scope="module")
def split(tmp_path_factory):
    """The Cornell box with lights anywhere, some of its cells cut in rounds: they meet each other."""
    run = tmp_path_factory.mktemp("rrf") / "run"
    sizes = ["--method", "nets", "--cells", 6, "--rows", 24_000, "--paths", 8, "--rounds", 3]
    rrf("bake", SCENE, "-o", run, "--light-box=-0.8,0.2,-0.8,0.8,1.8,0.8", *sizes)
    return run


@pytest.fixture(scope="module")
def answers(baked):
    """The table of `rrf query` at the oracle's points."""
    out = baked.parent / "answers.parquet"
    rrf("query", baked, "--points", ORACLE, "-o", out)
    return pq.read_table(out)


def read_arrow(path):
    with ipc.open_file(path) as file:
        return file.read_all()


def test_parts_equal_the_contract(baked):
    parts = sorted((baked / "samples").rglob("*"))
    files = [path for path in parts if path.is_file()]
    assert [path.parent.name for path in files] == [f"cell={c:06}" for c in range(CELLS)]
    scene = json.loads((baked / "run.json").read_text())["scene_hash"].encode()
    for path in files:
        assert contract.differences(contract.load("samples"), pq.read_schema(path)) == []
        assert pq.read_metadata(path).metadata[b"rrf.scene_hash"] == scene


@pytest.mark.parametrize("name", ("tree", "weights", "metrics"))
def test_model_equals_the_contract(baked, name):
    path = baked / "model" / f"{name}.arrow"
    table = read_arrow(path)
    assert contract.differences(contract.load(name), table.schema) == []
    assert pl.read_ipc(path).to_dicts() == table.to_pylist()


@pytest.mark.parametrize("kind", ("answers", "truth"))
def test_points_equal_the_contract(baked, answers, kind):
    if kind == "truth":
        out = baked.parent / "truth.parquet"
        rrf("trace", SCENE, "--points", ORACLE, "-o", out, "--spp", 16)
        answers = pq.read_table(out)
    schema, asked = contract.load(kind), pq.read_table(ORACLE)
    given = {column["name"] for column in contract.load("points")["column"]}
    schema["column"] = [c for c in schema["column"] if c["name"] not in given]
    assert contract.differences(schema, answers.schema, others_allowed=True) == []
    # what was asked comes first and untouched, the oracle's own answers are replaced
    for name in [*given, "material"]:
        assert answers[name].equals(asked[name]), name


def test_three_readers_open_the_samples(baked):
    """The partition key in each reader's own type, the columns in the contract's."""
    samples = baked / "samples"
    table = ds.dataset(samples, partitioning="hive").to_table()
    frame = pl.scan_parquet(samples, hive_partitioning=True).collect()
    files = f"read_parquet('{samples}/*/*.parquet', hive_partitioning = true)"
    duck = duckdb.sql(f"from {files}").to_arrow_table()
    assert table.schema.field("cell").type == pa.int32()
    assert frame.schema["cell"] == pl.Int64
    # with its zeros in front, the key is no number to DuckDB
    assert duck.schema.field("cell").type == pa.string()
    order = [("cell_id", "ascending"), ("sample_index", "ascending")]
    table, duck = table.sort_by(order), duck.sort_by(order)
    frame = frame.sort("cell_id", "sample_index")
    assert table.num_rows == frame.height == duck.num_rows >= ROWS
    for column in contract.load("samples")["column"]:
        name, wanted = column["name"], contract.arrow_type(column["type"])
        assert table[name].type == duck[name].type == wanted == frame[name].to_arrow().type
        values = table[name].to_numpy()
        assert np.array_equal(values, frame[name].to_numpy()), name
        assert np.array_equal(values, duck[name].to_numpy()), name
    for cells in (table["cell"], frame["cell"].to_arrow(), duck["cell"]):
        assert [int(cell) for cell in cells.to_pylist()] == table["cell_id"].to_pylist()


def test_samples_mean_what_the_contract_says(baked):
    """Halves are estimates of one radiance: their difference has mean 0, by a z-test at 1e-5."""
    table = ds.dataset(baked / "samples").to_table()
    assert set(table["paths"].to_pylist()) == {8}
    for c in "rgb":
        halves = [table[f"y{half}_{c}"].to_numpy().astype(float) for half in (0, 1)]
        assert min(half.min() for half in halves) >= 0
        difference = halves[0] - halves[1]
        z = difference.mean() / (difference.std(ddof=1) / np.sqrt(len(difference)))
        assert abs(z) < 4.42
    low, high = json.loads((baked / "run.json").read_text())["light_box"][:3], (0.6, 1.8, 0.6)
    for axis, a, b in zip("xyz", low, high):
        light = table["l" + axis].to_numpy()
        assert light.min() >= np.float32(a) and light.max() <= np.float32(b)


def test_numpy_evaluates_the_model(baked, answers):
    """tree.arrow and weights.arrow, walked and evaluated as their schemas say, give what
    `rrf query` gives: within 1e-5 of a net's output scale or, where that is larger, of the value
    itself (exponential outputs turn a rounding of the sum into a relative one) everywhere, and
    within 1e-5 of the value in all but the darkest rows, where float32's rounding of the sum shows."""
    tree = read_arrow(baked / "model/tree.arrow").to_pylist()
    weights = read_arrow(baked / "model/weights.arrow").to_pylist()
    rows = with_material(answers, baked)
    leaf = np.array([walk(tree, row) for row in rows.to_pylist()])
    assert np.array_equal(leaf, answers["cell_id"].to_numpy())
    found = np.stack([answers[c].to_numpy() for c in "rgb"], 1).astype(float)
    mine, scale = np.zeros_like(found), np.zeros_like(found)
    for net in weights:
        here = leaf == net["cell_id"]
        assert here.any(), net["cell_id"]
        mine[here] = nets.evaluate(net, rows)[here]
        scale[here] = net["output_scale"]
    sealed = (found == 0).all(axis=1)
    assert sealed.mean() < 0.02
    error = np.abs(mine - found)[~sealed]
    assert (error / np.maximum(scale, found)[~sealed]).max() < 1e-5
    brightest = found[~sealed].max(axis=1, keepdims=True)
    assert ((error / brightest).max(axis=1) < 1e-5).mean() > 0.99


def test_numpy_finds_the_seams(split):
    """The seam columns of metrics.arrow, computed as their schema says. Answers differ by float32's
    rounding, 1e-5 of a net's output scale or of the value (see above): that bounds by how much
    a row's jump or change can differ, the mean square of that a root mean square, the largest a median."""
    found, metrics = seams.seams(split), read_arrow(split / "model/metrics.arrow").to_pylist()
    wanted = list(seams.columns(found))
    assert [row["cell_id"] for row in metrics] == [row["cell_id"] for row in wanted]
    assert [row["seam_rows"] for row in metrics] == [row["seam_rows"] for row in wanted]
    limit = lambda cells, answers: np.maximum([found.weights[cell]["output_scale"] for cell in cells], answers)
    own, divisor, sizes = found.own[found.at], found.divisor, seams.sizes(found)
    mine, other, inside = limit(own, found.mine), limit(found.beyond, found.other), limit(own, found.inside)
    mean = (mine + other).mean(1) / 2
    shown = 0
    for name, second, size in zip(("seam_jump", "seam_change"), (other, inside), sizes):
        rounding = 1e-5 * (((mine + second) ** 2).mean(1) ** 0.5 + mean * size) / divisor
        for row, again in zip(metrics, wanted):
            here = own == row["cell_id"]
            if not here.any():
                assert row[name] is None and row[f"{name}_median"] is None
                continue
            assert abs(row[name] - again[name]) <= (rounding[here] ** 2).mean() ** 0.5
            assert abs(row[f"{name}_median"] - again[f"{name}_median"]) <= rounding[here].max()
            shown += rounding[here].max() < 0.01 * row[name]
    # cells that meet none, cells whose figures are well above the rounding, rows of several parts
    meet = sum(row["seam_rows"] > 0 for row in metrics)
    assert 2 <= meet < len(metrics) and shown > meet
    parts = [len(list((split / f"samples/cell={row['cell_id']:06}").iterdir())) for row in metrics if row["seam_rows"]]
    assert max(parts) > 1


def test_a_fit_alone_has_no_seams(baked):
    fits = sorted(baked.glob("rounds/000/fits/*/metrics.arrow"))
    assert len(fits) == CELLS
    for path in fits:
        [row] = read_arrow(path).to_pylist()
        assert {row[name] for name in row if name.startswith("seam_")} == {None}


def with_material(table, baked):
    """The queries with the material columns, which `rrf query` takes from the scene: each
    material of the oracle's table has one colour, found at the nearest sample."""
    samples = ds.dataset(baked / "samples").to_table()
    names = ["base_r", "base_g", "base_b", "roughness", "metallic", "specular"]
    known = np.stack([samples[name].to_numpy() for name in names], 1)
    place = np.stack([samples[name].to_numpy() for name in ("px", "py", "pz", "nx", "ny", "nz")], 1)
    material = np.array(table["material"].to_pylist())
    points = np.stack([table[n].to_numpy() for n in ("px", "py", "pz", "nx", "ny", "nz")], 1)
    values = np.zeros((table.num_rows, len(names)), np.float32)
    for name in np.unique(material):
        row = points[material == name][0]
        nearest = np.abs(place - row).sum(axis=1).argmin()
        values[material == name] = known[nearest]
    table = table.drop_columns(["material"])
    for name, column in zip(names, values.T):
        table = table.append_column(name, pa.array(column))
    return table


def walk(tree, row):
    """The cell of a row, as schemas/tree.toml says."""
    node = tree[0]
    while node["axis"] != -1:
        side = "left" if row[node["axis_name"]] < node["threshold"] else "right"
        node = tree[node[side]]
    return node["cell_id"]
