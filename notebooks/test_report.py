"""What rrf-report does: inspect, sweep, chart, report, through the program `rrf`."""

import json
import os
import re
import signal
import subprocess
import time

import polars as pl
import pyarrow.parquet as pq
import pytest

import rrf_tables as rt

SCENE = rt.SCENES / "cornell-box/scene.pbrt"
GRID = """
seeds = [1]
light_box = [-0.6, 1.3, -0.6, 0.6, 1.8, 0.6]
[frame]
light = "0.1,1.6,0.2,4,4,4"
size = "32x32"
reference_spp = 64
[[bake]]
preset = ["preview"]
rows = [2000, 4000]
cells = [2]
paths = [8]
[trace]
spp = [2, 8]
"""


def call(*arguments):
    """Exit code, standard output, standard error."""
    done = subprocess.run([rt.program(), *map(str, arguments)], capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    """A sweep that was killed after its first run and went on."""
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "grid.toml").write_text(GRID)
    command = ["sweep", SCENE, "-o", folder / "out", "--grid", folder / "grid.toml"]
    process = subprocess.Popen([rt.program(), *map(str, command)], start_new_session=True)
    end = time.monotonic() + 300
    while not list((folder / "out").glob("rows/*.json")):
        assert process.poll() is None and time.monotonic() < end
        time.sleep(0.02)
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    first = {p: p.read_bytes() for p in (folder / "out").glob("rows/*.json")}
    assert 1 <= len(first) < 4
    rt.rrf(*command)
    assert all(p.read_bytes() == text for p, text in first.items()), "a finished run was made again"
    return folder / "out"


def test_a_killed_sweep_goes_on(sweep):
    path = sweep / "results.parquet"
    assert rt.contract.differences(rt.contract.load("results"), pq.read_schema(path)) == []
    runs = pl.read_parquet(path)
    assert runs.height == 4 and sorted(runs["method"].to_list()) == ["cells"] * 2 + ["path tracing"] * 2
    assert runs.filter(pl.col("method") == "cells").select(pl.col("model_bytes", "bake_seconds") > 0).min().row(0) == (True, True)
    assert sorted(runs["rows"].drop_nulls().to_list()) == pytest.approx([2000, 4000], rel=0.1)  # a thousand a cell at least


def test_charts_need_nothing_from_outside(sweep, tmp_path):
    rt.rrf("chart", sweep, "-o", tmp_path)
    assert (tmp_path / "frontier.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    svg, page = ((tmp_path / f"frontier.{kind}").read_text() for kind in ("svg", "html"))
    assert svg.count("<circle") >= 4 + 4 and "path tracing" in svg
    assert not re.search(r'<(script|img|link|iframe)[^>]*\s(src|href)="(?!data:)', page)
    assert page.count("Plotly.newPlot") >= 3


def test_page_of_a_run(tmp_path):
    page = tmp_path / "run.html"
    rt.rrf("report", rt.demo() / "run", "-o", page, "--size", "64x64", "--spp", 16)
    text = page.read_text()
    assert text.count("data:image/png;base64,") == 5
    manifest = json.loads((rt.demo() / "run/run.json").read_text())
    for wanted in (manifest["scene_hash"], "Error by cell", "Error by light position", "maxdepth", "not trusted"):
        assert wanted in text, wanted
    assert not re.search(r'<(script|img|link)[^>]*\s(src|href)="(?!data:)', text)


def test_inspect_counts_what_is_there():
    run = rt.demo() / "run"
    code, out, _ = call("inspect", run, "--sql", "select count(*) as n, max(px) as x from samples", "--json")
    rows = rt.samples(run, ["px"])
    assert code == 0
    assert json.loads(out) == [{"n": rows.num_rows, "x": pytest.approx(max(rows["px"].to_pylist()))}]
    code, out, _ = call("inspect", run, "--json")
    sections = json.loads(out)["sections"]
    assert code == 0 and any(title.startswith(f"samples: {rows.num_rows} rows") for title in sections)
    code, out, _ = call("inspect", run / "model/metrics.arrow", "--sql", "select sum(rows) as n from self", "--json")
    assert code == 0 and json.loads(out) == [{"n": rows.num_rows}]
    assert call("inspect", run)[0] == 0


@pytest.mark.parametrize("arguments", [
    ("inspect", "no/such/place"),
    ("inspect", rt.ROOT / "Cargo.toml"),
    ("inspect", rt.ORACLE / "cornell_overhead.parquet", "--sql", "select nothing from nowhere"),
    ("chart", rt.ROOT, "-o", "out/never"),
    ("sweep", SCENE, "-o", "out/never", "--grid", rt.ROOT / "Cargo.toml"),
    ("report", rt.ROOT, "-o", "out/never.html"),
], ids=str)
def test_bad_input_is_2_and_says_why(arguments):
    code, _, error = call(*arguments)
    assert code == 2 and error.startswith("rrf: ") and "panicked" not in error
