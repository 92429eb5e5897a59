"""`rrf inspect` (polars) against what pyarrow and numpy make of the same files."""

import json
import os
import pathlib
import subprocess

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.dataset as ds
import pyarrow.ipc as ipc
import pyarrow.parquet as pq
import pytest

import contract

ROOT = pathlib.Path(__file__).resolve().parents[2]
ORACLE = ROOT / "tests/data/oracle/cornell_overhead.parquet"


def call(*arguments):
    """Exit code, standard output, standard error."""
    binary = os.environ.get("RRF", ROOT / "target/release/rrf")
    words = [binary, "inspect", *map(str, arguments)]
    done = subprocess.run(words, capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


def sections(path):
    code, out, error = call(path, "--json")
    assert (code, error) == (0, "")
    page = json.loads(out)
    assert page["path"] == str(path)
    return page["sections"]


def sql(path, query):
    code, out, error = call(path, "--sql", query, "--json")
    assert (code, error) == (0, "")
    return json.loads(out)


def samples(run):
    return ds.dataset(run / "samples", partitioning="hive").to_table()


def read_arrow(path):
    with ipc.open_file(path) as file:
        return file.read_all()


def check_columns(section, table):
    """Every column's range, mean, nulls and NaNs as pyarrow and numpy say."""
    rows = {row["column"]: row for row in section}
    assert set(rows) == set(table.column_names)
    for name in table.column_names:
        column, row = table[name].combine_chunks(), rows[name]
        assert row["nulls"] == column.null_count, name
        numeric = pa.types.is_floating(column.type) or pa.types.is_integer(column.type)
        if not numeric:
            assert row["least"] is None and row["nans"] == 0, name
            continue
        values = column.drop_null().to_numpy(zero_copy_only=False).astype(float)
        assert row["nans"] == np.isnan(values).sum(), name
        if len(values):
            found = [row["least"], row["mean"], row["greatest"]]
            wanted = [values.min(), values.mean(), values.max()]
            assert np.allclose(found, wanted, rtol=1e-9, atol=1e-12 * abs(values).max()), name


def named(page, start):
    [found] = [section for title, section in page.items() if title.startswith(start)]
    return found


def test_a_run(run):
    page, table = sections(run), samples(run)
    check_columns(named(page, f"samples: {table.num_rows} rows, {table.num_columns} columns"), table)
    for name in ("tree", "weights", "metrics"):
        model = read_arrow(run / f"model/{name}.arrow")
        check_columns(named(page, f"{name}: {model.num_rows} rows, {model.num_columns} columns"), model)
    _, counts = np.unique(table["cell_id"].to_numpy(), return_counts=True)
    wanted = {"cells": len(counts), "rows": table.num_rows, "fewest": min(counts), "most": max(counts)}
    assert named(page, "samples: cells") == [wanted]
    sizes = {row["part"]: row["bytes"] for row in page["bytes"]}
    below = lambda p: sum(f.stat().st_size for f in p.rglob("*") if f.is_file())
    assert sizes["samples"] == below(run / "samples") and sizes["model"] == below(run / "model")


def test_noise_is_that_of_the_halves(run):
    table = samples(run)
    halves = [np.stack([table[f"y{h}_{c}"].to_numpy().astype(float) for c in "rgb"]) for h in (0, 1)]
    [noise] = named(sections(run), "samples: noise of a row")
    # the standard error of a mean of two halves is half their difference
    assert noise["standard_error"] == pytest.approx(np.mean((halves[0] - halves[1]) ** 2) ** 0.5 / 2, rel=1e-6)
    assert noise["mean_radiance"] == pytest.approx(np.mean(halves), rel=1e-6)


def test_how_the_fits_went(run):
    page, metrics = sections(run), read_arrow(run / "model/metrics.arrow")
    [whole] = named(page, "metrics: whole")
    assert (whole["cells"], whole["rows"]) == (len(metrics), pc.sum(metrics["rows"]).as_py())
    square = metrics["relative_square_error_validation"].to_numpy()
    count = metrics["validation_rows"].to_numpy()
    known = ~np.isnan(square)
    error = max(square[known] @ count[known] / count.sum(), 0.0) ** 0.5
    assert whole["held_out_error"] == pytest.approx(error, rel=1e-12)
    worst = [row["relative_error_validation"] for row in named(page, "metrics: worst cells")]
    given = [x for x in worst if x is not None]
    assert given == sorted(given, reverse=True) and given[0] == pc.max(metrics["relative_error_validation"]).as_py()
    stops = {row["stop_reason"]: row["cells"] for row in named(page, "metrics: why fits stopped")}
    assert stops == {r["values"]: r["counts"] for r in pc.value_counts(metrics["stop_reason"]).to_pylist()}
    [meet] = next(rows for title, rows in page.items() if title.startswith("metrics: where cells meet"))
    cells = [row for row in metrics.to_pylist() if row["seam_rows"]]
    assert meet["rows"] == sum(row["seam_rows"] for row in cells)
    for name in ("jump", "change"):
        square = sum(row[f"seam_{name}"] ** 2 * row["seam_rows"] for row in cells)
        assert meet[name] == pytest.approx((square / meet["rows"]) ** 0.5, rel=1e-12)
        medians = [row[f"seam_{name}_median"] for row in cells]
        assert meet[f"{name}_median"] == pytest.approx(np.median(medians), rel=1e-12)


@pytest.mark.parametrize("place", ("samples", "model"))
def test_a_part_of_a_run(run, place):
    page = sections(run / place)
    titles = {title.split(":")[0] for title in page} - {"bytes"}
    assert titles == ({"self"} if place == "samples" else {"tree", "weights", "metrics"})


def test_single_files(run):
    table = pq.read_table(ORACLE)
    check_columns(named(sections(ORACLE), f"self: {table.num_rows} rows"), table)
    weights = run / "model/weights.arrow"
    [row] = sql(weights, "SELECT COUNT(*) AS n, MAX(cell_id) AS last FROM self")
    assert row == {"n": len(read_arrow(weights)), "last": pc.max(read_arrow(weights)["cell_id"]).as_py()}
    part = sorted((run / "samples").rglob("*.parquet"))[0]
    assert sql(part, "SELECT COUNT(*) AS n FROM self") == [{"n": pq.read_metadata(part).num_rows}]


def test_sql_joins_the_tables_of_a_run(run):
    query = "SELECT s.cell_id, COUNT(*) AS n, MAX(m.rows) AS rows FROM samples AS s JOIN metrics AS m " \
            "ON s.cell_id = m.cell_id GROUP BY s.cell_id ORDER BY s.cell_id"
    cells, counts = np.unique(samples(run)["cell_id"].to_numpy(), return_counts=True)
    rows = dict(zip(*(read_arrow(run / "model/metrics.arrow")[n].to_pylist() for n in ("cell_id", "rows"))))
    assert sql(run, query) == [{"cell_id": c, "n": n, "rows": rows[c]} for c, n in zip(cells, counts)]


def test_a_sweep(tmp_path):
    """Two settings over two seeds: means, and the deviation over seeds."""
    values = {"float64": 0.5, "uint64": 2, "utf8": "x"}
    columns = contract.load("results")["column"]
    table = {c["name"]: pa.array([values[c["type"]]] * 4, contract.arrow_type(c["type"])) for c in columns}
    table |= {"setting": pa.array(["a", "a", "b", "b"]), "frame_error": pa.array([0.1, 0.3, 0.5, 0.5])}
    pq.write_table(pa.table(table), tmp_path / "results.parquet")
    rows = named(sections(tmp_path), "results: settings over their seeds")
    assert [(r["setting"], r["seeds"]) for r in rows] == [("a", 2), ("b", 2)]
    assert [r["frame_error"] for r in rows] == pytest.approx([0.2, 0.5])
    assert [r["deviation"] for r in rows] == pytest.approx([0.2 / 2**0.5, 0])


def test_nan_and_null_are_counted(tmp_path):
    path = tmp_path / "odd.parquet"
    pq.write_table(pa.table({"x": pa.array([1.0, float("nan"), None, 4.0])}), path)
    [row] = named(sections(path), "self: 4 rows, 1 columns")
    assert (row["nulls"], row["nans"]) == (1, 1)
    assert sql(path, "SELECT x FROM self") == [{"x": 1.0}, {"x": "NaN"}, {"x": None}, {"x": 4.0}]


def test_for_people(run):
    code, out, _ = call(run)
    assert code == 0 and "why fits stopped" in out and "y0_r" in out
    assert max(map(len, out.splitlines())) < 200


@pytest.mark.parametrize("spoil", (lambda b: b[: len(b) // 2], lambda b: b[:-200] + bytes(200),
                                   lambda b: b[:8], lambda b: b"", lambda b: b"hello, world"))
@pytest.mark.parametrize("name", ("model/metrics.arrow", "samples"))
def test_damaged_files_are_2(run, tmp_path, spoil, name):
    source = run / name
    source = source if source.is_file() else sorted(source.rglob("*.parquet"))[0]
    path = tmp_path / source.name
    path.write_bytes(spoil(source.read_bytes()))
    code, out, error = call(path)
    assert code == 2 and error.startswith("rrf: ") and str(path) in error, error
    assert "panicked" not in error and out == ""


@pytest.mark.parametrize("arguments, says", [
    (["no/such/place"], "no such file"),
    ([ROOT / "Cargo.toml"], "neither a Parquet nor an Arrow"),
    ([ROOT / "scenes"], "neither a run"),
    ([ORACLE, "--sql", "SELECT nothing FROM self"], "nothing"),
    ([ORACLE, "--sql", "SELECT px FROM nowhere"], "tables: self"),
    ([ORACLE, "--sql", "this is no query"], "this is no query"),
], ids=str)
def test_bad_input_is_2_and_says_why(arguments, says):
    code, out, error = call(*arguments)
    assert code == 2 and error.startswith("rrf: ") and says in error and out == "", error
