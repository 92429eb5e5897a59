"""Files of a run, opened by others: pyarrow, polars and DuckDB see what schemas/ promises."""

import contract
import duckdb
import nets
import numpy as np
import polars as pl
import pyarrow as pa
import pyarrow.dataset as ds
import pyarrow.feather as feather
import pyarrow.ipc as ipc
import pyarrow.parquet as pq
import pytest

MODEL = ("tree", "weights", "metrics")
RAW = [c["name"] for c in contract.raw_columns()]
HALVES = [f"y{half}_{c}" for half in (0, 1) for c in "rgb"]


def parts(run):
    return sorted((run / "samples").glob("cell=*/part-*.parquet"))


def read_arrow(path):
    with ipc.open_file(path) as file:
        return file.read_all()


# --- the contract itself


@pytest.mark.parametrize("name", contract.names())
def test_schema_is_complete(name):
    schema = contract.load(name)
    assert schema["name"] == name and schema["version"] >= 1 and schema["doc"].strip()
    seen = [column["name"] for column in schema["column"]]
    assert len(seen) == len(set(seen))
    for column in schema["column"]:
        assert set(column) == {"name", "type", "unit", "frame", "nullable", "meaning"}
        assert column["frame"] in ("world", "none") and column["unit"] and column["meaning"]
        contract.arrow_type(column["type"])


def test_raw_columns():
    """A row's raw columns stand side by side in samples; its geometry is a points table."""
    samples = [c["name"] for c in contract.load("samples")["column"]]
    assert samples[2:20] == RAW
    assert [c["name"] for c in contract.load("points")["column"]] == RAW[:12]


def test_formulas_of_inputs():
    """Against numpy's own words, in float64: a light above the mirror direction, and one on the point."""
    rows = {name: np.array([0.3, -0.2]) for name in RAW}
    n, v, to = np.array([0.6, 0.0, 0.8]), np.array([0.0, 0.6, 0.8]), np.array([1.0, -2.0, 2.0])
    for k, axis in enumerate("xyz"):
        rows[f"n{axis}"], rows[f"v{axis}"] = np.full(2, n[k]), np.full(2, v[k])
        rows[f"l{axis}"] = rows[f"p{axis}"] + np.array([to[k], 0.0])
    known = nets.inputs(pa.table(rows))
    d = to / 3
    wanted = {"inv_distance": 1 / 3, "cos_light": n @ d, "cos_view": n @ v}
    wanted |= {"mirror_light": (2 * (n @ v) * n - v) @ d, "dx": d[0], "dy": d[1], "dz": d[2]}
    assert wanted.keys() == nets.Inputs.formulas.keys()
    for name, value in wanted.items():
        dark = value if name == "cos_view" else 0
        assert known[name] == pytest.approx([value, dark], abs=1e-15), name


# --- samples


def test_parts_follow_the_schema(run):
    assert len(parts(run)) == 6
    schema = contract.load("samples")
    for path in parts(run):
        assert contract.differences(schema, pq.read_schema(path)) == []


def test_part_metadata_and_layout(run):
    path = parts(run)[3]
    metadata = pq.read_metadata(path)
    facts = {k.decode(): v.decode() for k, v in metadata.metadata.items()}
    assert facts["rrf.scene_hash"] == "0123456789abcdef" * 4
    assert facts["rrf.seed"] == str(2**64 - 2)
    assert (facts["rrf.cell"], facts["rrf.part"]) == ("1", "1")
    assert len(facts["rrf.content_hash"]) == 64
    assert not any("time" in key or "host" in key for key in facts)
    group = metadata.row_group(0)
    columns = [group.column(c) for c in range(group.num_columns)]
    assert {column.compression for column in columns} == {"ZSTD"}
    assert all(column.statistics.null_count == 0 for column in columns)


def test_statistics_bound_the_values(run):
    """Of every column, as DuckDB reads them: floats' are in IEEE 754 total order, which pyarrow
    passes over so far. Integers' are read by pyarrow too."""
    path = parts(run)[3]
    table = pq.read_table(path, partitioning=None)
    query = "select path_in_schema, stats_min_value, stats_max_value"
    rows = duckdb.sql(f"{query} from parquet_metadata('{path}')").fetchall()
    assert [row[0] for row in rows] == table.column_names
    for name, least, greatest in rows:
        values = table[name].to_numpy()
        bounds = np.array([least, greatest]).astype(values.dtype)
        assert np.array_equal(bounds, [values.min(), values.max()]), name
    statistics = pq.read_metadata(path).row_group(0).column(0).statistics
    assert (statistics.min, statistics.max) == (1, 1)


def check_samples(cells, cell_ids, rows):
    """Partition key and column agree, in whatever types a reader gives them."""
    assert rows == 3000
    assert [int(c) for c in cells] == [int(c) for c in cell_ids]
    assert sorted(set(int(c) for c in cells)) == [0, 1, 2]


def test_samples_in_pyarrow(run):
    data = ds.dataset(run / "samples", partitioning="hive")
    assert data.schema.field("cell").type == pa.int32()
    for column in contract.load("samples")["column"]:
        assert data.schema.field(column["name"]).type == contract.arrow_type(column["type"])
    table = data.to_table()
    check_samples(table["cell"].to_pylist(), table["cell_id"].to_pylist(), table.num_rows)
    one = data.to_table(filter=ds.field("cell") == 1)
    assert set(one["cell_id"].to_pylist()) == {1} and one.num_rows == 1000


def test_samples_in_polars(run):
    frame = pl.scan_parquet(run / "samples", hive_partitioning=True)
    schema = frame.collect_schema()
    assert schema["cell"] == pl.Int64 and schema["cell_id"] == pl.UInt32
    assert schema["sample_index"] == pl.UInt64
    assert all(schema[name] == pl.Float32 for name in RAW + HALVES)
    frame = frame.collect()
    check_samples(frame["cell"].to_list(), frame["cell_id"].to_list(), frame.height)
    one = pl.scan_parquet(run / "samples").filter(pl.col("cell") == 2).collect()
    assert one["cell_id"].unique().to_list() == [2] and one.height == 1000


def test_samples_in_duckdb(run):
    # Leading zeros make DuckDB take the key for text, unless told otherwise; cell_id is a number.
    types = "{'cell': UINTEGER}"
    files = f"read_parquet('{run}/samples/*/*.parquet', hive_types = {types})"
    types = dict(duckdb.sql(f"select column_name, column_type from (describe from {files})").fetchall())
    assert types["cell"] == types["cell_id"] == "UINTEGER"
    assert types["sample_index"] == "UBIGINT"
    assert all(types[name] == "FLOAT" for name in RAW + HALVES)
    rows = duckdb.sql(f"select cell, cell_id from {files}").fetchall()
    check_samples([r[0] for r in rows], [r[1] for r in rows], len(rows))
    query = f"select count(*), min(cell_id), max(cell_id) from {files} where cell = 1"
    assert duckdb.sql(query).fetchall() == [(1000, 1, 1)]


def test_three_readers_agree_on_every_value(run):
    table = ds.dataset(run / "samples", partitioning="hive").to_table().sort_by("sample_index")
    frame = pl.read_parquet(run / "samples").sort("sample_index")
    files = f"read_parquet('{run}/samples/*/*.parquet')"
    duck = duckdb.sql(f"from {files} order by sample_index").fetchnumpy()
    for name in ["sample_index", "material_id", "paths"] + RAW + HALVES:
        values = table[name].to_numpy()
        assert np.array_equal(values, frame[name].to_numpy()), name
        assert np.array_equal(values, np.asarray(duck[name])), name


def test_units_are_true_of_the_values(run):
    """n and v are unit vectors; material parameters and halves are what their units say."""
    table = ds.dataset(run / "samples").to_table()
    for axis in "nv":
        square = sum(table[axis + c].to_numpy().astype(float) ** 2 for c in "xyz")
        assert np.abs(square - 1).max() < 8 * np.finfo(np.float32).eps
    units = {c["name"]: (c["unit"], c["frame"]) for c in contract.load("samples")["column"]}
    for name in ("px", "py", "pz", "lx", "ly", "lz"):
        assert units[name] == ("m", "world")
    for name in ("nx", "ny", "nz", "vx", "vy", "vz"):
        assert units[name] == ("1", "world")
    for name in HALVES:
        assert units[name] == ("W/(sr m^2)", "none")
    for name in RAW[12:]:
        values = table[name].to_numpy()
        assert units[name] == ("1", "none") and values.min() >= 0 and values.max() <= 1


def test_interrupted_writer_leaves_the_dataset_whole(run):
    """The unfinished part is in staging/, and samples/ holds parts only."""
    assert [p.name for p in (run / "staging").iterdir()] == ["cell=000002-part-00002.0.tmp"]
    files = [path for path in (run / "samples").rglob("*") if path.is_file()]
    assert files and sorted(files) == parts(run)
    # A cell whose folder was made and whose part was not: the worst place to be killed.
    empty = run / "samples" / "cell=000099"
    empty.mkdir()
    try:
        assert ds.dataset(run / "samples", partitioning="hive").count_rows() == 3000
        assert pl.read_parquet(run / "samples").height == 3000
        files = f"read_parquet('{run}/samples/*/*.parquet')"
        assert duckdb.sql(f"select count(*) from {files}").fetchall() == [(3000,)]
    finally:
        empty.rmdir()


# --- the model


@pytest.mark.parametrize("name", MODEL)
def test_model_tables_follow_the_schema(run, name):
    path = run / "model" / f"{name}.arrow"
    table = read_arrow(path)
    assert contract.differences(contract.load(name), table.schema) == []
    assert table.schema.metadata[b"rrf.scene_hash"] == b"0123456789abcdef" * 4
    assert feather.read_table(path).equals(table)
    frame = pl.read_ipc(path)
    assert frame.columns == table.column_names
    assert frame.to_dicts() == table.to_pylist()


def test_tree_leads_every_sample_to_its_leaf(fixture_folder, run):
    """The walk that schemas/tree.toml describes ends at the cell that the Rust walk found."""
    tree = read_arrow(run / "model" / "tree.arrow").to_pylist()
    answers = pq.read_table(fixture_folder / "answers.parquet")
    for row in answers.to_pylist():
        node = tree[0]
        while node["axis"] != -1:
            assert RAW[node["axis"]] == node["axis_name"]
            side = "left" if row[node["axis_name"]] < node["threshold"] else "right"
            node = tree[node[side]]
        assert node["cell_id"] == row["cell_id"]
    leaves = [node for node in tree if node["axis"] == -1]
    assert sorted(node["cell_id"] for node in leaves) == [0, 1, 2]
    assert {len(node["domain_min"]) for node in leaves if node["domain_min"]} == {18}


def test_weights_give_the_answers(fixture_folder, run):
    """Ten lines of numpy on weights.arrow are what Rust computes in f64, to float32's rounding."""
    table = read_arrow(run / "model" / "weights.arrow").to_pylist()
    answers = pq.read_table(fixture_folder / "answers.parquet")
    cells = answers["cell_id"].to_numpy()
    assert set(cells) == {0, 1, 2} and {net["divide_base"] for net in table} == {True, False}
    wanted = np.stack([answers[c].to_numpy() for c in "rgb"], 1)
    for net in table:
        mine = nets.evaluate(net, answers)[cells == net["cell_id"]]
        # Derived inputs are computed in float32 by Rust and in float64 here: a few roundings,
        # through two layers whose rows of weights sum to less than 8.
        assert np.abs(mine - wanted[cells == net["cell_id"]]).max() < 64 * np.finfo(np.float32).eps


def test_metrics_are_consistent(run):
    metrics = read_arrow(run / "model" / "metrics.arrow").to_pylist()
    weights = read_arrow(run / "model" / "weights.arrow").to_pylist()
    for row, net in zip(metrics, weights):
        assert (row["cell_id"], row["weights"]) == (net["cell_id"], len(net["weights"]))
        for rows in ("train", "validation"):
            square = row[f"relative_square_error_{rows}"]
            if square is not None:
                error = row[f"relative_error_{rows}"]
                assert error == pytest.approx(max(square, 0) ** 0.5)
    assert metrics[2]["relative_error_validation"] is None
    # with a neighbour, without one, and of a fit that knows none
    seams = [[row[name] for name in row if name.startswith("seam_")] for row in metrics]
    assert seams == [[120, 0.0625, 0.03125, 0.125, 0.0625], [0] + 4 * [None], 5 * [None]]


def test_steps_of_a_fit(run):
    """A batch without a step has no cost; an error may be below zero."""
    table = read_arrow(run / "rounds/000/fits/cell=000000/steps.arrow")
    assert contract.differences(contract.load("steps"), table.schema) == []
    assert table["step"].to_pylist() == [1, 2, 3, 4]
    assert table["cost"].to_pylist() == [1, None, pytest.approx(1 / 3), 0.25]
    errors = table["relative_square_error"].to_pylist()
    assert errors[2] is None and errors[3] == pytest.approx(-0.006)


# --- points


@pytest.mark.parametrize("name", ("answers.parquet", "answers.arrow", "truth.parquet"))
def test_points_tables_follow_the_schema(fixture_folder, name):
    path = fixture_folder / name
    table = read_arrow(path) if path.suffix == ".arrow" else pq.read_table(path)
    schema = contract.load(path.stem)
    assert contract.differences(schema, table.schema, others_allowed=True) == []
    queries = pq.read_table(fixture_folder / "queries.parquet")
    # The queries' columns come first and are untouched, material parameters too.
    assert table.column_names[: queries.num_columns] == queries.column_names
    for column in queries.column_names:
        assert table[column].equals(queries[column])
    frame = pl.read_ipc(path) if path.suffix == ".arrow" else pl.read_parquet(path)
    assert frame["r"].to_list() == table["r"].to_pylist()
