"""Fixtures: the contract in schemas/, and a small run written by the Rust code."""

import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]


def example(name):
    """The command that runs one of `rrf-store`'s examples; RRF_EXAMPLES names a folder of
    them, built before."""
    if built := os.environ.get("RRF_EXAMPLES"):
        return [str(pathlib.Path(built) / name)]
    cargo = ["cargo", "run", "--quiet", "--release", "--locked", "-p", "rrf-store"]
    return [*cargo, "--example", name, "--"]


@pytest.fixture(scope="session")
def fixture_folder(tmp_path_factory):
    """Tables written by the example `fixture`."""
    folder = tmp_path_factory.mktemp("fixture")
    subprocess.run([*example("fixture"), str(folder)], cwd=ROOT, check=True)
    return folder


@pytest.fixture(scope="session")
def run(fixture_folder):
    """A run folder of three cells with 1,000 samples each."""
    return fixture_folder / "run"


@pytest.fixture(scope="session")
def echo():
    """Sends a points table through Rust's reader and writer; returns the finished process."""

    def call(source, target):
        command = [*example("echo_points"), str(source), str(target)]
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True)

    return call
