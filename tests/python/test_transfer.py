"""The default, a transfer, from the command line: its tables, its bytes, and its answers against traced ones."""

import importlib.util
import json
import os
import pathlib
import signal
import subprocess
import time

import contract
import numpy as np
import pyarrow as pa
import pyarrow.ipc
import pyarrow.parquet as pq
import pytest
import rrf_truth

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = ROOT / "scenes/cornell-box/scene.pbrt"
TABLES = ["transfer", "transfer_tree", "transfer_cells", "transfer_parts"]
SMALL = ["--preset", "preview", "--rows", "3000", "--paths", "64", "--quiet"]
# A preview of this size was 11.7 % ± 1.1 % off on these rows; the test fails where the error is above the bound at the
# 1 % level, by its standard error over rows.
BOUND, CERTAIN = 0.15, 2.33


def rrf(*words, check=True, **more):
    binary = os.environ.get("RRF", ROOT / "target/release/rrf")
    command = [str(word) for word in (binary, *words)]
    return subprocess.run(command, check=check, capture_output=True, text=True, **more)


def tables(run):
    return {name: (run / f"model/{name}.arrow").read_bytes() for name in TABLES}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("transfer") / "run"
    rrf("bake", SCENE, "-o", folder, *SMALL)
    return folder


def test_tables_are_as_described(run):
    for name in TABLES:
        with pa.ipc.open_file(run / f"model/{name}.arrow") as file:
            assert contract.differences(contract.load(name), file.schema) == []
            assert file.read_all().num_rows > 0


def test_runs_are_whole_and_resumed_at_once(run):
    before = {path: path.stat().st_mtime_ns for path in run.rglob("*") if path.name != "lock"}
    assert "whole" in rrf("verify", run).stdout
    told = rrf("bake", SCENE, "-o", run, *SMALL, "--resume").stdout
    assert "finished before" in told
    assert before == {path: path.stat().st_mtime_ns for path in run.rglob("*") if path.name != "lock"}


def test_bytes_depend_on_neither_threads_nor_kills(run, tmp_path):
    expected = tables(run)
    words = ["bake", SCENE, *SMALL]
    for threads in (1, 7):
        rrf(*words, "-o", tmp_path / f"{threads}", "--threads", threads)
        assert tables(tmp_path / f"{threads}") == expected
    stopped = 0
    # quick machines are done where slow ones have just begun
    for how, wait in [(how, wait) for how in (signal.SIGKILL, signal.SIGTERM) for wait in (0.1, 0.2, 0.4, 0.8)]:
        killed = tmp_path / f"{how.name}-{wait}"
        binary = os.environ.get("RRF", ROOT / "target/release/rrf")
        process = subprocess.Popen([str(w) for w in (binary, *words, "-o", killed)], stderr=subprocess.PIPE)
        time.sleep(wait)
        process.send_signal(how)
        process.wait(timeout=30)
        if not (killed / "run.json").exists():
            continue
        assert process.returncode in (0, 1, -signal.SIGKILL)
        stopped += process.returncode != 0
        rrf(*words, "-o", killed, "--resume")
        assert tables(killed) == expected
    assert stopped > 0


def test_damage_is_told_and_made_good(run, tmp_path):
    copy = tmp_path / "run"
    subprocess.run(["cp", "-r", run, copy], check=True)
    file = copy / "model/transfer_parts.arrow"
    whole = file.read_bytes()
    values = bytearray(whole)
    values[len(whole) // 2] ^= 1
    file.write_bytes(values)
    for words in (["verify", copy], ["render", copy, "-o", tmp_path / "a.png", "--size", "16x16"]):
        refused = rrf(*words, check=False)
        assert refused.returncode == 2 and "transfer_parts.arrow" in refused.stdout + refused.stderr
    rrf("bake", SCENE, "-o", copy, *SMALL, "--resume")
    assert file.read_bytes() == whole


def points(count):
    """Rows on the back wall and the floor, each under its own light: points, suns through the open front, the lamp."""
    numbers = np.random.default_rng(7)
    draw = lambda low, high: numbers.uniform(low, high, (count, len(low))).astype(np.float32)
    on_wall = np.arange(count) % 2 == 0
    wall = np.c_[draw([-0.9, 0.3], [0.9, 1.9]), np.full(count, -1, np.float32)]
    floor = np.c_[draw([-0.9], [0.9]), np.zeros(count, np.float32), draw([0.85], [0.97])]
    p = np.where(on_wall[:, None], wall, floor)
    n = np.where(on_wall[:, None], [0, 0, 1], [0, 1, 0]).astype(np.float32)
    v = draw([-0.5, 0.8, 0.2], [0.5, 1.2, 0.9]) - p
    light = np.array(["point", "point", "sun", "light0"])[np.arange(count) // 2 % 4]
    toward = draw([-0.3, 0.1, 1.0], [0.3, 0.5, 1.0])
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    place = draw([-0.6, 1.3, -0.6], [0.6, 1.75, 0.6])
    l = np.where((light == "sun")[:, None], toward, place)
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    columns = {f"{k}{a}": x[:, i].astype(np.float32) for k, x in zip("pnvl", (p, n, v, l)) for i, a in enumerate("xyz")}
    return pa.table({**columns, "light": light})


def test_answers_are_near_traced_ones(run, tmp_path):
    asked, truth, answers = (tmp_path / f"{name}.parquet" for name in ("asked", "truth", "answers"))
    pq.write_table(points(240), asked)
    rrf("trace", SCENE, "--points", asked, "-o", truth, "--spp", "1024", "--quiet")
    rrf("query", run, "--points", asked, "-o", answers)
    rgb = lambda table, end="": np.stack([table[c + end].to_numpy() for c in "rgb"], 1).astype(float)
    traced, found = pq.read_table(truth), pq.read_table(answers)
    error, se = rrf_truth.relative_error(rgb(found), rgb(traced), rgb(traced, "_se"))
    assert error - CERTAIN * se < BOUND, (error, se)
    print(f"error {error:.4f} ± {se:.4f}")
    # a place that no cell knows is not trusted: none here
    assert found["cell_id"].to_numpy().max() < 2**32 - 1


def test_what_does_not_fit_into_memory_is_refused(tmp_path):
    refused = rrf("bake", SCENE, "-o", tmp_path / "a", *SMALL, "--memory", "1MiB", check=False)
    assert refused.returncode == 2 and "--memory" in refused.stderr
    assert not list((tmp_path / "a").glob("model/*"))


def test_batches_bake_transfers(run, tmp_path):
    settings = ['preset = "preview"', "rows = 3000", "paths = 64"]
    head = ['output = "runs"', "[[bake]]", 'name = "one"', f"scene = {str(SCENE)!r}", "[bake.settings]"]
    (tmp_path / "batch.toml").write_text("\n".join(head + settings))
    told = rrf("run", tmp_path / "batch.toml", "--json", "--quiet").stdout.splitlines()
    line = json.loads(told[0])
    assert line["run"] == "one-1" and line["round"] == 0 and line["relative_error"] > 0
    assert line["target_met"] == (line["relative_error"] <= line["target"])
    assert tables(tmp_path / "runs/one-1") == tables(run)
    summary = json.loads((tmp_path / "runs/summary.json").read_text())
    assert summary["runs"][0]["relative_error"] == line["relative_error"]


def read(run, name):
    with pa.ipc.open_file(run / f"model/{name}.arrow") as file:
        return file.read_all()


def test_inspect_sums_up_what_the_tables_hold(run):
    sections = json.loads(rrf("inspect", run, "--json").stdout)["sections"]
    titles = {title.split(":")[0] for title in sections} - {"bytes"}
    assert titles == set(TABLES)
    [test] = sections["transfer: error on test rows"]
    whole = read(run, "transfer").to_pylist()[0]
    assert test == {name: whole[name] for name in test} and test["test_rows"] > 0
    cells = read(run, "transfer_cells")
    [told] = sections["transfer_cells: whole"]
    error, judged = (cells[name].to_numpy().astype(float) for name in ("error", "judged"))
    known = ~np.isnan(error)
    assert (told["cells"], told["rows"]) == (len(cells), sum(cells["rows"].to_pylist()))
    assert told["held_out_error"] == pytest.approx((error[known] ** 2 @ judged[known] / judged[known].sum()) ** 0.5, rel=1e-9)
    worst = [row["error"] for row in sections["transfer_cells: worst cells"]]
    assert worst == sorted(worst, reverse=True) and worst[0] == error[known].max()
    parts = read(run, "transfer_parts").to_pylist()
    fits = {(row["part"], row["kind"]): row["cells"] for row in sections["transfer_parts: fits"]}
    assert sum(fits.values()) == len(parts) and set(fits) == {(row["part"], row["kind"]) for row in parts}
    query = "SELECT COUNT(*) AS n FROM transfer_parts AS p JOIN transfer_cells AS c ON p.cell_id = c.cell_id"
    assert json.loads(rrf("inspect", run, "--sql", query, "--json").stdout) == [{"n": len(parts)}]
    assert max(map(len, rrf("inspect", run).stdout.splitlines())) < 200


def test_parquet_copies_hold_the_tables(run, tmp_path):
    named = rrf("export", run, "--parquet", tmp_path / "copies").stdout.split()
    assert sorted(pathlib.Path(name).stem for name in named) == sorted(TABLES)
    for name in TABLES:
        assert pq.read_table(tmp_path / f"copies/{name}.parquet").equals(read(run, name))


def test_numpy_relights_an_exported_transfer(run, tmp_path):
    """`docs/guide/relight.py` has the answers of `rrf query`, for each light and for a blend of both."""
    spec = importlib.util.spec_from_file_location("relight", ROOT / "docs/guide/relight.py")
    relight = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(relight)
    file, place = tmp_path / "room.safetensors", (0.2, 1.5, -0.1)
    rrf("export", run, "--safetensors", file, "--scene-lights", f"--light={','.join(map(str, place))},1,1,1")
    tensors, names = relight.load(file)
    assert names == ["light0", "point0"] and (tensors["light.residual"] < 0.1).all()
    asked = points(400).drop_columns("light")
    for axis, x in zip("xyz", place):
        asked = asked.set_column(asked.column_names.index(f"l{axis}"), f"l{axis}", pa.array(np.full(400, x, np.float32)))
    found = {}
    for name, light in (("light0", "light0"), ("point0", "point")):
        pq.write_table(asked.append_column("light", pa.array([light] * 400)), tmp_path / "asked.parquet")
        rrf("query", run, "--points", tmp_path / "asked.parquet", "-o", tmp_path / f"{name}.parquet", "--fallback", "none")
        answers = pq.read_table(tmp_path / f"{name}.parquet")
        found[name] = np.stack([answers[c].to_numpy() for c in "rgb"], 1).astype(float)
    three = lambda start: np.stack([asked[start + axis].to_numpy() for axis in "xyz"], 1).astype(float)
    position, normal, viewer = three("p"), three("n"), three("v")
    # the surface of each point by the cell that answered: the tree from its root down
    owner = {}
    for *key, root in tensors["tree.surface"].tolist():
        nodes = [root]
        while nodes:
            node = nodes.pop()
            if tensors["tree.axis"][node] < 0:
                owner[tensors["tree.children"][node, 0]] = key
            else:
                nodes += tensors["tree.children"][node].tolist()
    cells = answers["cell_id"].to_numpy()
    surface = np.array([owner[cell] for cell in cells])
    assert (relight.find_cells(tensors, surface, position, normal) == cells).all()
    # the floor and the back wall are white paint
    base_color = np.tile([0.725, 0.71, 0.68], (400, 1))
    irradiance = dict(zip(names, tensors["light.irradiance"]))
    made = lambda light: relight.radiance(tensors, light, surface, position, normal, normal, viewer, base_color)
    level = max(x.mean() for x in found.values())
    for name in names:
        # by the program's rational tanh and 32 bits
        assert abs(made(irradiance[name]) - found[name]).max() < 2e-4 * level
    tint = np.array([0.2, 0.5, 1.5])
    blend = made(3 * irradiance["point0"] + tint * irradiance["light0"])
    assert abs(blend - (3 * found["point0"] + tint * found["light0"])).max() < 2e-3 * level


def test_the_page_of_a_run_tells_its_errors(run, tmp_path):
    rrf("report", run, "-o", tmp_path / "run.html", "--size", "32x32", "--spp", "16")
    text = (tmp_path / "run.html").read_text()
    whole = read(run, "transfer").to_pylist()[0]
    assert f"{100 * whole['relative_error']:.2f} ± {100 * whole['relative_error_se']:.2f} %" in text
    assert text.count("data:image/png;base64,") == 5 and "transfer, " in text and "Error by cell" in text
    assert text.count("<tr><td class=\"n\">") >= len(read(run, "transfer_cells"))


def test_verify_says_what_the_run_is(run):
    assert ", a transfer: whole" in rrf("verify", run).stdout


def test_a_sweep_measures_transfers_beside_nets(tmp_path):
    """The row of a transfer tells of its own tables."""
    grid = ["seeds = [1]", "light_box = [-0.6, 1.3, -0.6, 0.6, 1.8, 0.6]", "[frame]", 'light = "0.1,1.6,0.2,4,4,4"', 'size = "16x16"',
            "reference_spp = 32", "[[bake]]", 'preset = ["preview"]', "rows = [1000]", "paths = [32]", 'method = ["transfer", "nets"]']
    (tmp_path / "grid.toml").write_text("\n".join(grid))
    rrf("sweep", SCENE, "-o", tmp_path / "sweep", "--grid", tmp_path / "grid.toml", "--quiet")
    rows = {row["method"]: row for row in pq.read_table(tmp_path / "sweep/results.parquet").to_pylist()}
    assert set(rows) == {"transfer", "nets"}
    [folder] = (tmp_path / "sweep/runs").glob("method=transfer*")
    cells = read(folder, "transfer_cells")
    row = rows["transfer"]
    assert (row["cells"], row["rows"], row["weights"]) == (len(cells), sum(cells["rows"].to_pylist()), None)
    assert row["model_bytes"] == sum(len(table) for table in tables(folder).values())
    assert all(row["held_out_error"] > 0 and row["frame_error"] > 0 for row in rows.values())


def test_other_commands_say_what_they_need(run, tmp_path):
    for words in (["train", run], ["plan", run], ["commit", run], ["export", run, "--onnx", tmp_path / "a.onnx"]):
        refused = rrf(*words, check=False)
        assert refused.returncode == 2 and "transfer" in refused.stderr and "--method nets" in refused.stderr, refused.stderr
    for words in (["extract", SCENE, "-o", tmp_path / "a"], ["plan", SCENE, "-o", tmp_path / "a"]):
        refused = rrf(*words, check=False)
        assert refused.returncode == 2 and "--method nets" in refused.stderr, refused.stderr
        assert not (tmp_path / "a").exists()
    refused = rrf("chart", run, "-o", tmp_path / "charts", check=False)
    assert refused.returncode == 2 and "no rounds" in refused.stderr
    for option in (["--cells", "3"], ["--inputs", "px"], ["--no-trim"]):
        refused = rrf("bake", SCENE, "-o", tmp_path / "b", *option, check=False)
        assert refused.returncode == 2 and option[0] in refused.stderr and "--method nets" in refused.stderr
        assert not (tmp_path / "b").exists()
