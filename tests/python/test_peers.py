"""The comparison with other programs: its measure and its reader, without the other programs."""

import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/peers"))

from efficiency import Points, agreement, ratio_interval, relative_variance  # noqa: E402
from pbrt_room import read_room  # noqa: E402

ORACLE = ROOT / "tests/data/oracle"


@pytest.fixture(scope="module")
def room():
    return read_room(ROOT / "scenes/cornell-box/scene.pbrt")


def test_lamp_is_left_out(room):
    # the file's 36 triangles: five walls of 2, two boxes of 12, a lamp of 2
    assert sum(len(triangles) for _, triangles, _ in room.meshes) == 5 * 2 + 2 * 12
    assert all(name != "Light" for name, _, _ in room.meshes)


@pytest.mark.parametrize("table", ["cornell_overhead", "cornell_free"])
def test_points_lie_on_their_material(room, table):
    """Each point of the table is in a triangle of the material that the table names."""
    points = Points.read(ORACLE / f"{table}.parquet")
    for name in np.unique(points.material):
        (triangles, positions), = [(t, p) for n, t, p in room.meshes if n == name]
        a, b, c = (positions[triangles[:, k]].astype(float) for k in range(3))
        p = points.position[points.material == name].astype(float)[:, None]
        normal = np.cross(b - a, c - a)
        normal /= np.linalg.norm(normal, axis=1, keepdims=True)
        # the file's corners have six digits, so 5e-7 an axis; float32 adds at most 1.2e-7; a
        # corner's error, a neighbour's and the point's own, over three axes, times an edge of 2
        near = np.abs(((p - a) * normal).sum(-1)) < 4e-6
        inside = [
            (np.cross(v - u, p - u) * normal).sum(-1) > -4e-6 for u, v in ((a, b), (b, c), (c, a))
        ]
        assert (near & np.all(inside, axis=0)).any(axis=1).all(), name


def test_unknown_words_are_errors(tmp_path):
    scene = tmp_path / "scene.pbrt"
    scene.write_text('WorldBegin\nShape "sphere" "float radius" [ 1 ]\nWorldEnd\n')
    with pytest.raises(ValueError, match="sphere"):
        read_room(scene)


def test_relative_variance_is_unbiased():
    """Normal estimates of known variance: the mean over rows within 5 standard errors."""
    rng = np.random.default_rng(7)
    runs, rows = 6, 20_000
    sigma = rng.uniform(0.1, 2.0, (rows, 3))
    scale = rng.uniform(0.5, 3.0, (rows, 1))
    estimates = rng.normal(3.0, sigma, (runs, rows, 3))
    found = relative_variance(estimates, scale).mean()
    truth = sigma**2 / scale**2
    # Var of a sample variance of normals: 2 sigma^4 / (R - 1)
    error = np.sqrt((2 * truth**2 / (runs - 1)).sum()) / truth.size
    assert abs(found - truth.mean()) < 5 * error


def test_ratio_interval_covers_the_truth():
    """95 % intervals of a known ratio (2/3 of the variance, half the time) cover it, binomially."""
    rng = np.random.default_rng(11)
    tries, hits = 100, 0
    for _ in range(tries):
        ours, theirs = 2 * rng.standard_exponential(500), 3 * rng.standard_exponential(500)
        low, high = ratio_interval(ours, theirs, ([1.0] * 5, [2.0] * 5), draws=200)
        hits += low < 1 / 3 < high
    # P(Binomial(100, 0.95) < 84) = 1e-5
    assert hits >= 84


def test_agreement_sees_a_small_bias():
    """Normal runs about the table's values pass; 2 % less in one material does not."""
    points = Points.read(ORACLE / "cornell_overhead.parquet")
    rng = np.random.default_rng(13)
    truth = points.reference - rng.normal(0, points.reference_error)
    sigma = points.reference_error * np.sqrt(8)
    runs = rng.normal(truth, sigma, (8, *truth.shape))
    assert agreement(runs, points)["passes"]
    dimmed = runs * np.where(points.material == "Floor", 0.98, 1.0)[None, :, None]
    assert not agreement(dimmed, points)["passes"]
