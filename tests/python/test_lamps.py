"""The nets' light of an area lamp against `rrf trace` (RRF names the binary)."""

import os
import pathlib
import statistics
import subprocess

import pytest

import rrf_truth

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = ROOT / "scenes/cornell-box/scene.pbrt"
SIZE = ["--size", "48x48", "--part", "indirect"]
# of the scene file: radiance, and 0.47 m by 0.38 m
RADIANCE, AREA = (17.0, 12.0, 4.0), 0.47 * 0.38


def rrf(*arguments):
    binary = os.environ.get("RRF", ROOT / "target/release/rrf")
    done = subprocess.run([binary, *map(str, arguments)], check=True, capture_output=True, text=True)
    return done.stdout


@pytest.fixture(scope="module")
def errors(tmp_path_factory):
    """Squared relative error of three indirect frames, the references' noise taken out: the
    lamp as the program lights it, a point of the lamp's power in its place, and no light."""
    folder = tmp_path_factory.mktemp("lamps")
    run = folder / "run"
    sizes = ["--method", "nets", "--cells", 12, "--rows", 40_000, "--paths", 16, "--rounds", 1]
    rrf("bake", SCENE, "-o", run, "--light-box", "-0.6,1.3,-0.6,0.6,1.8,0.6", *sizes)
    references = [folder / f"{seed}.exr" for seed in (1, 2)]
    for seed, out in zip((1, 2), references):
        rrf("trace", "-q", SCENE, *SIZE, "--spp", 256, "--seed", seed, "-o", out)

    def square(a, b):
        return rrf_truth.measures(rrf("compare", a, b, "--json"))["relative_error"] ** 2

    noise = square(*references) / 2

    def error(name, *light):
        out = folder / f"{name}.exr"
        rrf("render", run, *SIZE, *light, "-o", out)
        return statistics.mean(square(out, r) for r in references) - noise

    # a Lambert lamp of radiance L sends pi A L; a point of that power has a quarter of A L
    power = ",".join(str(AREA * radiance / 4) for radiance in RADIANCE)
    return {
        "lamp": error("lamp"),
        "point": error("point", f"--light=0,1.79,-0.03,{power}"),
        "none": error("none", "--light=0,1.5,0,1e-12,1e-12,1e-12"),
    }


def test_better_than_a_point_of_its_power(errors):
    """An isotropic point sends half of the power to the ceiling: what standing in is against."""
    assert errors["lamp"] < errors["point"], errors


def test_better_than_no_light(errors):
    """The least that an approximation has to be: nearer to the lamp's light than darkness."""
    assert errors["lamp"] < errors["none"], errors
