"""Points tables made by others go through the Rust reader and writer unharmed."""

import datetime

import contract
import duckdb
import numpy as np
import polars as pl
import pyarrow as pa
import pyarrow.feather as feather
import pyarrow.ipc as ipc
import pyarrow.parquet as pq
import pytest

GEOMETRY = [column["name"] for column in contract.load("points")["column"]]
ADDED = [column["name"] for column in contract.load("truth")["column"]][12:]
ROWS = 3000


def unit(x):
    return x / np.linalg.norm(x, axis=1, keepdims=True)


def geometry(kind=np.float32):
    random = np.random.default_rng(7)
    n = unit(random.normal(size=(ROWS, 3)))
    v = unit(n + 0.9 * unit(random.normal(size=(ROWS, 3))))
    p, l = random.uniform(-1, 1, (2, ROWS, 3))
    return dict(zip(GEOMETRY, np.concatenate([p, n, v, l], 1).T.astype(kind)))


def table(kind=np.float32):
    """Geometry among columns of every type that people keep in tables."""
    number = range(ROWS)
    words = pa.array([f"wall {i % 5}" for i in number])
    others = {
        "material": words,
        "dictionary": words.dictionary_encode(),
        "note": pa.array([None if i % 3 else f"row {i}" for i in number]),
        "list": pa.array([[i] * (i % 4) for i in number], pa.list_(pa.int32())),
        "struct": pa.array([{"a": i, "b": str(i)} for i in number]),
        "time": pa.array([datetime.datetime(2024, 1, 1)] * ROWS, pa.timestamp("us")),
        "flag": pa.array([i % 2 == 0 for i in number]),
        "decimal": pa.array([i for i in number], pa.int64()).cast(pa.decimal128(21, 2)),
        "half": pa.array(np.arange(ROWS, dtype=np.float16)),
        "bytes": pa.array([bytes([i % 256]) for i in number], pa.binary(1)),
        "nothing": pa.nulls(ROWS),
    }
    return pa.table({**geometry(kind), **others})


def save(source, path, **options):
    if path.suffix == ".parquet":
        pq.write_table(source, path, **options)
    elif options.get("feather"):
        feather.write_feather(source, path, compression=options["feather"], chunksize=700)
    else:
        with ipc.new_file(path, source.schema) as file:
            file.write_table(source, max_chunksize=options.get("rows", ROWS))


def load(path):
    return pq.read_table(path) if path.suffix == ".parquet" else feather.read_table(path)


def check(echo, source, path, target):
    done = echo(path, target)
    assert done.returncode == 0, done.stderr
    assert done.stdout == f"{ROWS} rows, 0 rescaled\n"
    result = load(target)
    assert result.column_names == source.column_names + ADDED
    for name in source.column_names:
        assert result[name].combine_chunks().equals(source[name].combine_chunks()), name
    assert all(set(result[name].to_pylist()) == {0.0} for name in ADDED)


@pytest.mark.parametrize(
    "options",
    [
        dict(compression="none"),
        dict(compression="snappy"),
        dict(compression="gzip"),
        dict(compression="lz4"),
        dict(compression="zstd", row_group_size=100),
        dict(use_dictionary=False, data_page_version="2.0", write_page_index=True),
        dict(data_page_size=512, write_statistics=False, write_page_checksum=True),
        dict(version="1.0", store_schema=True),
        dict(use_byte_stream_split=GEOMETRY, use_dictionary=False),
    ],
    ids=str,
)
def test_pyarrow_parquet(echo, tmp_path, options):
    source = table()
    if options.get("version") == "1.0":
        source = source.drop_columns(["time"])
    save(source, tmp_path / "in.parquet", **options)
    check(echo, pq.read_table(tmp_path / "in.parquet"), tmp_path / "in.parquet", tmp_path / "out.parquet")


@pytest.mark.parametrize("options", [dict(), dict(rows=100), *(dict(feather=c) for c in ("zstd", "lz4"))], ids=str)
def test_pyarrow_arrow(echo, tmp_path, options):
    source = table()
    save(source, tmp_path / "in.arrow", **options)
    check(echo, source, tmp_path / "in.arrow", tmp_path / "out.arrow")


@pytest.mark.parametrize("name", ["in.parquet", "in.arrow"])
def test_polars(echo, tmp_path, name):
    frame = pl.DataFrame({**geometry(), "name": ["é" * (i % 3) for i in range(ROWS)]})
    path = tmp_path / name
    frame.write_parquet(path) if path.suffix == ".parquet" else frame.write_ipc(path)
    done = echo(path, tmp_path / "out.parquet")
    assert done.returncode == 0, done.stderr
    result = pl.read_parquet(tmp_path / "out.parquet")
    assert result.select(frame.columns).equals(frame) and result.columns[-6:] == ADDED


def test_duckdb(echo, tmp_path):
    source = pa.table({**geometry(), "id": pa.array(range(ROWS), pa.int64())})
    duckdb.sql(f"copy (from source) to '{tmp_path}/in.parquet'")
    source = pq.read_table(tmp_path / "in.parquet")
    check(echo, source, tmp_path / "in.parquet", tmp_path / "out.parquet")


def test_float64_in_any_order(echo, tmp_path):
    """Pandas' default type; the file's own columns stay float64."""
    source = table(np.float64)
    source = source.select(source.column_names[::-1])
    save(source, tmp_path / "in.parquet")
    source = pq.read_table(tmp_path / "in.parquet")
    check(echo, source, tmp_path / "in.parquet", tmp_path / "out.arrow")


def test_what_is_wrong_is_said(echo, tmp_path):
    good = table()
    spoil = {
        "column vx, row 17": ("vx vy vz", 17, -1),
        "column nx, row 2000: a direction of length zero": ("nx ny nz", 2000, 0),
        "column ly, row 5: not a finite": ("ly", 5, np.nan),
    }
    for wanted, (names, row, factor) in spoil.items():
        source = good
        for name in names.split():
            values = good[name].to_numpy().copy()
            values[row] *= factor
            place = source.column_names.index(name)
            source = source.set_column(place, name, pa.array(values))
        save(source, tmp_path / "in.parquet")
        done = echo(tmp_path / "in.parquet", tmp_path / "out.parquet")
        assert done.returncode != 0 and wanted in done.stderr, done.stderr
        assert not (tmp_path / "out.parquet").exists()
