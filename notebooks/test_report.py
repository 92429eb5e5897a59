"""What rrf-report does: sweep, chart, report, through the program `rrf`; inspect is tested in
tests/python."""

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
method = ["nets"]
preset = ["preview"]
rows = [2000, 4000]
cells = [2]
paths = [8]
[trace]
spp = [2, 8]
"""


# anything that a browser would fetch
OUTSIDE = r'<(script|img|link|iframe)[^>]*\s(src|href)="(?!data:)'


def call(*arguments):
    """Exit code, standard output, standard error."""
    done = subprocess.run([rt.program(), *map(str, arguments)], capture_output=True, text=True)
    return done.returncode, done.stdout, done.stderr


def sweeping(folder, grid=GRID):
    """The command of a sweep into FOLDER/out."""
    folder.mkdir(exist_ok=True)
    (folder / "grid.toml").write_text(grid)
    return ["sweep", SCENE, "-o", folder / "out", "--grid", folder / "grid.toml"]


@pytest.fixture(scope="module")
def sweep(tmp_path_factory):
    """A sweep that was killed (SIGKILL) after its first run, in the middle of another, and went on."""
    folder = tmp_path_factory.mktemp("sweep")
    command = sweeping(folder)
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
    assert runs.height == 4 and sorted(runs["method"].to_list()) == ["nets"] * 2 + ["path tracing"] * 2
    assert runs.filter(pl.col("method") == "nets").select(pl.col("model_bytes", "bake_seconds") > 0).min().row(0) == (True, True)
    assert sorted(runs["rows"].drop_nulls().to_list()) == pytest.approx([2000, 4000], rel=0.1)  # a thousand a cell at least


def test_a_killed_sweep_has_the_table_of_one_that_was_not(sweep, tmp_path):
    """But for the times, which are of different processes."""
    rt.rrf(*sweeping(tmp_path / "whole"))
    killed, whole = (pl.read_parquet(p / "results.parquet").drop(pl.selectors.ends_with("seconds"))
                     for p in (sweep, tmp_path / "whole/out"))
    assert killed.width >= 15 and killed.equals(whole, null_equal=True)


def test_times_are_of_the_runs(sweep):
    """CPU time is no more than wall time on every core; a bake takes more of it than a frame."""
    runs, cores = pl.read_parquet(sweep / "results.parquet"), os.cpu_count()
    assert (runs["frame_cpu_seconds"] > 0).all()
    assert (runs["frame_cpu_seconds"] < cores * runs["frame_seconds"] + 0.05).all()
    bakes = runs.drop_nulls("bake_seconds")
    assert (bakes["bake_cpu_seconds"] < cores * bakes["bake_seconds"] + 0.05).all()
    assert (bakes["bake_cpu_seconds"] > bakes["frame_cpu_seconds"]).all()


def test_charts_need_nothing_from_outside(sweep, tmp_path):
    rt.rrf("chart", sweep, "-o", tmp_path)
    assert (tmp_path / "frontier.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"
    svg, page = ((tmp_path / f"frontier.{kind}").read_text() for kind in ("svg", "html"))
    # four runs in the panel of frame times, the two bakes in each of the others; the legend's two
    assert svg.count("<circle") == 4 + 2 + 2 + 2 and "path tracing" in svg
    assert not re.search(OUTSIDE, page)
    assert page.count("Plotly.newPlot") >= 3


def test_rounds_of_runs(tmp_path):
    """The chart of a run of two rounds beside the demo's: a point a round, time and target."""
    run = tmp_path / "two rounds"
    box = "-0.6,1.3,-0.6,0.6,1.8,0.6"
    sizes = ["--method", "nets", "--preset", "preview", "--rows", 4000, "--paths", 8, "--cells", 2, "--rounds", 2, "--target", 0.01]
    rt.rrf("bake", SCENE, "-o", run, "--light-box", box, *sizes)
    rt.rrf("chart", run, rt.demo() / "run", "-o", tmp_path / "charts")
    svg, page = ((tmp_path / f"charts/rounds.{kind}").read_text() for kind in ("svg", "html"))
    judged = [json.loads(path.read_text()) for path in sorted(run.glob("rounds/*/judged.json"))]
    assert [j["round"] for j in judged] == [0, 1]
    # three panels (time, rows, weights) with the rounds of both runs, and the legend
    marks = [circle for circle in re.findall("<circle[^>]*>", svg) if 'r="6"' in circle]
    assert len(marks) == 3 * 3 + 2 and "two rounds" in svg
    for j in judged:
        assert f"{100 * j['judgement']['test']['relative_error']:.2f} ±" in page
    seconds = [json.loads(path.read_text()) for path in sorted(run.glob("rounds/*/seconds.json"))]
    assert len(seconds) == 2 and all(s["extract"] > 0 and s["train"] > 0 and s["judge"] > 0 for s in seconds)
    assert not re.search(OUTSIDE, page)
    rt.rrf("report", run, "-o", tmp_path / "run.html", "--size", "32x32", "--spp", 4)
    text = (tmp_path / "run.html").read_text()
    assert text.count("<svg") == 3  # rounds, two sets of training curves
    assert f"{seconds[0]['extract']:.1f}</td>" in text


def test_page_of_a_run(tmp_path):
    page = tmp_path / "run.html"
    rt.rrf("report", rt.demo() / "run", "-o", page, "--size", "64x64", "--spp", 16)
    text = page.read_text()
    assert text.count("data:image/png;base64,") == 5
    manifest = json.loads((rt.demo() / "run/run.json").read_text())
    for wanted in (manifest["scene_hash"], manifest["created_by"], "FLIP", "ΔE2000", "Error by cell",
                   "Error by light position", "Training curves", "extraction [s]", "maxdepth", "not trusted"):
        assert wanted in text, wanted
    # a line a cell in each of the two charts of training curves, but for the axes' own
    cells = len(rt.read_arrow(rt.demo() / "run/model/metrics.arrow"))
    assert text.count("<svg") == 2 and text.count("<polyline") >= 2 * cells
    assert not re.search(OUTSIDE, text)


def test_light_bins_hold_the_rows_held_out(tmp_path):
    """Every row held out is in one bin of each axis."""
    page = tmp_path / "run.html"
    rt.rrf("report", rt.demo() / "run", "-o", page, "--size", "16x16", "--spp", 2)
    text = page.read_text()
    section = text[text.index("Error by light position"):text.index("What was approximated")]
    rows = [int(n) for n in re.findall(r'<td class="n">(\d+)</td><td class="n">[\d.]+ ±', section)]
    held_out = sum(rt.read_arrow(rt.demo() / "run/model/metrics.arrow")["validation_rows"].to_pylist())
    assert len(rows) == 18 and [sum(rows[i:i + 6]) for i in (0, 6, 12)] == [held_out] * 3


@pytest.mark.parametrize("arguments", [
    ("chart", rt.ROOT, "-o", "out/never"),
    ("sweep", SCENE, "-o", "out/never", "--grid", rt.ROOT / "Cargo.toml"),
    ("report", rt.ROOT, "-o", "out/never.html"),
], ids=str)
def test_bad_input_is_2_and_says_why(arguments):
    code, _, error = call(*arguments)
    assert code == 2 and error.startswith("rrf: ") and "panicked" not in error
