"""Fixtures: the contract in schemas/, and a small run written by the Rust code."""

import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


@pytest.fixture(scope="session")
def fixture_folder(tmp_path_factory):
    """Tables written by `rrf-store`'s example `fixture`; RRF_FIXTURE names a folder of them
    that exists already."""
    if given := os.environ.get("RRF_FIXTURE"):
        return pathlib.Path(given)
    folder = tmp_path_factory.mktemp("fixture")
    command = ["cargo", "run", "--quiet", "--release", "--locked", "-p", "rrf-store"]
    command += ["--example", "fixture", "--", str(folder)]
    subprocess.run(command, cwd=ROOT, check=True)
    return folder


@pytest.fixture(scope="session")
def run(fixture_folder):
    """A run folder of three cells with 1,000 samples each."""
    return fixture_folder / "run"
