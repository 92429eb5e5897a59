"""What the command line tells shells, scripts and people, beside its work (RRF names the binary)."""

import json
import os
import pathlib
import subprocess

import pyarrow.ipc as ipc
import pyarrow.parquet as pq
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = ROOT / "scenes/cornell-box/scene.pbrt"
BOX = "--light-box=-0.6,1.3,-0.6,0.6,1.8,0.6"
SMALL = [BOX, "--method", "nets", "--rows", 4000, "--cells", 2, "--most-cells", 2, "--paths", 8, "--rounds", 1]


def rrf(*arguments, code=0):
    binary = os.environ.get("RRF", ROOT / "target/release/rrf")
    done = subprocess.run([binary, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == code, done.stderr
    return done


@pytest.fixture(scope="module")
def baked(tmp_path_factory):
    run = tmp_path_factory.mktemp("command-line") / "run"
    rrf("bake", SCENE, "-o", run, *SMALL)
    return run


def test_a_missed_target_is_exit_code_3_where_it_is_required(baked, tmp_path):
    again = ["bake", SCENE, "-o", baked, "--resume", *SMALL]
    assert rrf(*again).returncode == 0
    told = json.loads(rrf(*again, "--json").stdout)
    assert told["target_met"] is False and told["relative_error"] > told["target"]
    missed = rrf(*again, "--require-target", code=3)
    assert "the target of 5.00 % is missed" in missed.stderr
    met = ["bake", SCENE, "-o", tmp_path / "run", *SMALL, "--target", "90%", "--require-target"]
    assert "target 90.00 %" in rrf(*met).stdout


@pytest.mark.parametrize("target", ["0%", "-5%", "nan%", "%", "5%%", "0"])
def test_what_is_no_target_is_refused(target, tmp_path):
    done = rrf("bake", SCENE, "-o", tmp_path / "run", f"--target={target}", code=2)
    assert "--target" in done.stderr and not (tmp_path / "run").exists()


@pytest.mark.parametrize("command", ["render", "view", "query", "verify", "train", "commit"])
def test_a_scene_in_a_runs_place_is_told(command, tmp_path):
    more = {"render": ["-o", tmp_path / "a.png"], "query": ["--points", "p.parquet", "-o", "o.parquet"]}
    done = rrf(command, SCENE, *more.get(command, []), code=2)
    assert "this is a scene: bake it first (rrf bake" in done.stderr


def test_parquet_copies_hold_the_models_tables(baked, tmp_path):
    folder = tmp_path / "copies"
    named = rrf("export", baked, "--parquet", folder).stdout.split()
    names = ["tree", "weights", "metrics"]
    assert named == [str(folder / f"{name}.parquet") for name in names]
    for name in names:
        with ipc.open_file(baked / f"model/{name}.arrow") as file:
            own = file.read_all()
        copy = pq.read_table(folder / f"{name}.parquet")
        assert copy.equals(own), name
        assert own.schema.metadata and own.schema.metadata.items() <= copy.schema.metadata.items()


def test_kernels_are_recorded_and_told(baked):
    told = json.loads(rrf("doctor", "--json").stdout)
    kernels = json.loads((baked / "run.json").read_text())["kernels"]
    assert kernels == {name: told[name] for name in ("linear_algebra", "vectors")}
    assert "OpenBLAS" in kernels["linear_algebra"] and "kernels" in kernels["linear_algebra"]
    text = rrf("doctor").stdout
    assert kernels["linear_algebra"] in text and kernels["vectors"] in text


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish", "powershell", "elvish"])
def test_shells_complete_commands_and_options(shell):
    script = rrf("completions", shell).stdout
    assert "require-target" in script and "completions" in script


def test_every_command_has_a_man_page(tmp_path):
    rrf("man", tmp_path)
    pages = {page.name for page in tmp_path.iterdir()}
    help_text = rrf("--help").stdout
    listed = [line.split()[0] for line in help_text.splitlines() if line.startswith("  ")]
    commands = [name for name in listed if not name.startswith("-") and name != "help"]
    assert len(commands) > 20
    assert pages == {"rrf.1", *(f"rrf-{name}.1" for name in commands)}
    assert "--require\\-target" in (tmp_path / "rrf-bake.1").read_text().replace("\\-\\-", "--")
