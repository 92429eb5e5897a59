"""The Kubernetes manifest: its fields by the published schemas, its command by the program."""

import os
import pathlib
import subprocess

import kubernetes_validate
import pytest
import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
RRF = os.environ.get("RRF", str(ROOT / "target/release/rrf"))
MANIFEST = ROOT / "pipeline/engines/kubernetes.yaml"


@pytest.fixture
def job():
    return yaml.safe_load(MANIFEST.read_text())


def test_the_manifest_has_the_fields_of_the_schema(job):
    kubernetes_validate.validate(job, "1.37", strict=True)
    job["spec"]["completionMod"] = job["spec"].pop("completionMode")
    with pytest.raises(kubernetes_validate.ValidationError):
        kubernetes_validate.validate(job, "1.37", strict=True)


def test_the_command_is_one_of_the_program(job):
    (container,) = job["spec"]["template"]["spec"]["containers"]
    words = [*container["command"], *container["args"]]
    assert words[0] == "rrf"
    environment = {**os.environ, "JOB_COMPLETION_INDEX": "0"}
    done = subprocess.run([RRF, *words[1:]], capture_output=True, text=True, env=environment)
    # it gets as far as the plan, which is not here
    assert "/runs/room/rounds/000/tasks.parquet" in done.stderr and "Usage" not in done.stderr, done.stderr
    assert done.returncode in (1, 2)
