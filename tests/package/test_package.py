"""The Python package as a user has it: installed from its wheel, beside the program `rrf`."""

import os
import pathlib
import signal
import subprocess
import sys
import textwrap

import duckdb
import numpy as np
import polars as pl
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import rrf

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = ROOT / "scenes/cornell-box/scene.pbrt"
ORACLE = ROOT / "tests/data/oracle/cornell_overhead.parquet"
BINARY = os.environ.get("RRF", str(ROOT / "target/release/rrf"))
SMALL = dict(rows=4000, paths=32, rounds=1, cells=4, light_box=(-0.6, 1.3, -0.6, 0.6, 1.8, 0.6))


@pytest.fixture(scope="module")
def baked(tmp_path_factory):
    folder = tmp_path_factory.mktemp("package") / "run"
    heard = []
    result = rrf.bake(SCENE, folder, method="nets", progress=heard.append, **SMALL)
    return folder, result, heard


@pytest.fixture(scope="module")
def run(baked):
    return rrf.open(baked[0])


def test_a_bake_tells_how_it_went(baked):
    folder, result, heard = baked
    assert result["method"] == "nets" and result["cells"] == 4 and 0 < result["relative_error"] < 1
    stages = {event["stage"] for event in heard}
    assert {"extract 0", "train 0"} <= stages
    assert all(event["done"] <= event["total"] for event in heard)
    (last,) = [event for event in heard if "round" in event]
    assert last["relative_error"] == result["relative_error"]


def test_a_bake_has_the_commands_bytes(baked, tmp_path):
    words = ["--light-box=-0.6,1.3,-0.6,0.6,1.8,0.6", "--rows=4000", "--paths=32", "--rounds=1", "--cells=4"]
    subprocess.run([BINARY, "bake", "-q", SCENE, "-o", tmp_path / "run", "--method=nets", *words], check=True, capture_output=True)
    for name in ("tree", "weights", "metrics"):
        file = f"model/{name}.arrow"
        assert (tmp_path / "run" / file).read_bytes() == (baked[0] / file).read_bytes(), name


@pytest.fixture(scope="module")
def commanded(baked, tmp_path_factory):
    """What the command says at the oracle's points."""
    out = tmp_path_factory.mktemp("commanded") / "out.parquet"
    subprocess.run([BINARY, "query", baked[0], "--points", ORACLE, "-o", out], check=True, capture_output=True)
    return pq.read_table(out)


@pytest.mark.parametrize("kind", ["pyarrow", "polars", "duckdb"])
def test_queries_take_any_table_and_have_the_commands_bits(run, commanded, kind):
    points = {
        "pyarrow": lambda: pq.read_table(ORACLE),
        "polars": lambda: pl.read_parquet(ORACLE),
        "duckdb": lambda: duckdb.sql(f"SELECT * FROM '{ORACLE}'"),
    }[kind]()
    answers = pa.table(run.query(points))
    assert answers.num_rows == commanded.num_rows
    for name in ("r", "g", "b", "cell_id", "trusted"):
        assert answers[name].combine_chunks().equals(commanded[name].combine_chunks()), name


def test_answers_go_to_polars_and_duckdb(run):
    answers = run.query(pq.read_table(ORACLE))
    frame = pl.DataFrame(answers)
    assert frame["r"].min() > -1 and len(frame) == len(answers)
    ((count,),) = duckdb.sql("SELECT count(*) FROM answers").fetchall()
    assert count == len(answers)


def test_the_truth_is_traced(run):
    points = pq.read_table(ORACLE).slice(0, 64)
    truth = pa.table(run.trace(points, spp=64, seed=3))
    assert (truth["r_se"].to_numpy() > 0).all()
    # within noise of the oracle: Sidak-corrected z over 64 rows
    z = (truth["g"].to_numpy() - points["g"].to_numpy()) / np.hypot(truth["g_se"].to_numpy(), points["g_se"].to_numpy())
    assert np.median(np.abs(z)) < 1.5


def test_frames_are_arrays(run, baked, tmp_path):
    view = dict(eye=(0, 1, 6.8), look_at=(0, 1, 0), fov=20, size=(48, 32), light=[(0.1, 1.6, 0.2, 4, 4, 4)])
    picture = run.render(**view)
    assert picture.shape == (32, 48, 3) and picture.dtype == np.float32 and picture.max() > 0.1
    dark = run.render(**{**view, "light": [(0.1, 1.6, 0.2, 2, 2, 2)]})
    assert np.allclose(dark, picture / 2, rtol=1e-4, atol=1e-6)
    indirect = run.render(part="indirect", **view)
    assert 0 < indirect.mean() < picture.mean()


def test_tables_of_the_run(run):
    assert "cell_id" in pa.table(run.metrics).column_names
    assert pa.table(run.cells).num_rows >= 4
    assert run.manifest["seed"] == 1


def test_failures_are_exceptions_in_the_commands_words(run, tmp_path):
    with pytest.raises(rrf.BadInput, match="--target"):
        rrf.bake(SCENE, tmp_path / "run", target=-1)
    with pytest.raises(rrf.BadInput, match="nowhere.pbrt"):
        rrf.bake("nowhere.pbrt", tmp_path / "run")
    with pytest.raises(rrf.BadInput, match="px"):
        run.query(pa.table({"py": [1.0]}))
    with pytest.raises(TypeError, match="__arrow_c_stream__"):
        run.query([1, 2, 3])
    with pytest.raises(rrf.RrfError):
        rrf.open(tmp_path / "none")


def test_an_exception_of_the_callback_stops_the_bake(tmp_path):
    def enough(event):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        rrf.bake(SCENE, tmp_path / "run", method="nets", progress=enough, **{**SMALL, "rows": 200_000})


def test_ctrl_c_stops_a_bake_that_goes_on_later(tmp_path):
    program = textwrap.dedent(
        f"""
        import rrf
        print("ready", flush=True)
        try:
            rrf.bake({str(SCENE)!r}, {str(tmp_path / 'run')!r}, method="nets", rows=2_000_000, paths=512, cells=64, rounds=1)
        except KeyboardInterrupt:
            print("stopped", flush=True)
        """
    )
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    with pytest.raises(subprocess.TimeoutExpired):
        process.wait(timeout=5)
    process.send_signal(signal.SIGINT)
    out, _ = process.communicate(timeout=60)
    assert out == "stopped\n"
    assert (tmp_path / "run/run.json").exists()


def test_a_million_rows_are_not_copied(run, tmp_path):
    """The peak of a query of 2^20 rows in one polars batch, in a process of its own, above that of the table alone."""
    program = textwrap.dedent(
        f"""
        import resource
        import polars as pl
        import rrf
        points = pl.read_parquet({str(ORACLE)!r}).select(
            "px", "py", "pz", "nx", "ny", "nz", "vx", "vy", "vz", "lx", "ly", "lz")
        points = pl.concat([points] * 700).head(1 << 20).rechunk()
        # payload that the query has no use for, and that a copy would double
        points = points.with_columns(*[pl.col("px").alias(f"extra{{i}}") for i in range(200)])
        run = rrf.open({str(run.path)!r})
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        answers = run.query(points)
        after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        print(len(answers), points.estimated_size(), 1024 * (after - before))
        """
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    rows, held, more = map(int, done.stdout.split())
    assert rows == 1 << 20 and held > 800e6
    assert more < held / 2, (held, more)


def test_the_wheel_has_the_program():
    name = pathlib.Path(sys.executable).parent / "rrf"
    done = subprocess.run([name, "--version"], capture_output=True, text=True)
    assert (done.returncode, done.stdout.split()[0]) == (0, "rrf")
    assert subprocess.run([name, "scene", "nowhere.pbrt"], capture_output=True).returncode == 2
