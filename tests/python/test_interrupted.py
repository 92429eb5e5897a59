"""A bake that is killed while it extracts: what lies in samples/ is a dataset all the same."""

import os
import pathlib
import signal
import subprocess
import time

import contract
import duckdb
import polars as pl
import pyarrow.dataset as ds
import pyarrow.parquet as pq
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = ROOT / "scenes/cornell-box/scene.pbrt"


@pytest.fixture(scope="module")
def killed(tmp_path_factory):
    """The run folder, killed after its third part and before its last."""
    run = tmp_path_factory.mktemp("killed") / "run"
    binary = os.environ.get("RRF", ROOT / "target/release/rrf")
    box = "-0.6,1.3,-0.6,0.6,1.8,0.6"
    sizes = ["--method", "nets", "--cells", "32", "--rows", "160000", "--paths", "256"]
    command = [binary, "bake", SCENE, "-o", run, "--light-box", box, *sizes, "--quiet"]
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL)
    try:
        end = time.monotonic() + 300
        while len(list((run / "samples").glob("*/*.parquet"))) < 3:
            assert process.poll() is None and time.monotonic() < end
            time.sleep(0.01)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    assert not (run / "model/weights.arrow").exists()
    return run


def test_every_file_is_whole(killed):
    files = [path for path in (killed / "samples").rglob("*") if path.is_file()]
    assert 3 <= len(files) < 32
    for path in files:
        assert contract.differences(contract.load("samples"), pq.read_schema(path)) == []
        assert pq.read_table(path, partitioning=None).num_rows == pq.read_metadata(path).num_rows > 0


def test_three_readers_agree(killed):
    """Rows and types of pyarrow, polars and DuckDB."""
    data = ds.dataset(killed / "samples", partitioning="hive")
    for column in contract.load("samples")["column"]:
        assert data.schema.field(column["name"]).type == contract.arrow_type(column["type"])
    rows = data.count_rows()
    frame = pl.scan_parquet(killed / "samples", hive_partitioning=True)
    schema = frame.collect_schema()
    assert (schema["cell"], schema["cell_id"], schema["px"]) == (pl.Int64, pl.UInt32, pl.Float32)
    assert frame.select(pl.len()).collect().item() == rows
    files = f"read_parquet('{killed}/samples/*/*.parquet', hive_types = {{'cell': UINTEGER}})"
    described = duckdb.sql(f"select column_name, column_type from (describe from {files})").fetchall()
    assert dict(described)["px"] == "FLOAT" and dict(described)["cell_id"] == "UINTEGER"
    query = f"select count(*), count(distinct cell_id) from {files} where cell = cell_id"
    counted, cells = duckdb.sql(query).fetchall()[0]
    assert counted == rows and cells == len(data.to_table(columns=["cell_id"])["cell_id"].unique())
