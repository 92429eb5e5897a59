"""Fixtures: the contract in schemas/, a small run written by the Rust code, and a page in a browser.

The browser is Debian's chromium (tests/setup.sh). Without RRF_CHROMIUM the tests look for `chromium` on the path.
"""

import os
import pathlib
import shutil
import subprocess

import pytest
from playwright.sync_api import sync_playwright
from viewer import Viewer, bake, served

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


@pytest.fixture(scope="session")
def browser():
    chromium = os.environ.get("RRF_CHROMIUM") or shutil.which("chromium")
    assert chromium, "no chromium: run tests/setup.sh"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=chromium,
            # CI runs as root, where Chromium's sandbox does not start
            args=["--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"],
        )
        yield browser
        browser.close()


@pytest.fixture(scope="session")
def baked(tmp_path_factory):
    """The Cornell box with the smallest bake, or the run that RRF_RUN names."""
    run = tmp_path_factory.mktemp("view") / "run"
    return os.environ.get("RRF_RUN") or bake(ROOT / "scenes/cornell-box/scene.pbrt", run)


@pytest.fixture
def server(baked):
    """The URL of a page on that run."""
    with served(baked) as url:
        yield url


@pytest.fixture
def viewer(browser, server):
    viewer = Viewer(browser, server)
    yield viewer
    viewer.clean(server)
    viewer.page.close()
