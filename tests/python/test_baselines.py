"""Bakes by what nets are compared with: their tables, evaluated in numpy as schemas/weights.toml says,
give what `rrf query` gives."""

import numpy as np
import pyarrow.parquet as pq
import pytest
from test_run import ORACLE, SCENE, read_arrow, rrf, walk, with_material

import contract
import nets

METHODS = {"quadratic-regression": "quadratic", "nearest": "nearest", "probes": "probes"}


@pytest.fixture(scope="module", params=METHODS)
def baked(request, tmp_path_factory):
    """The Cornell box by each method."""
    run = tmp_path_factory.mktemp("baseline") / "run"
    box = "-0.6,1.3,-0.6,0.6,1.8,0.6"
    sizes = ["--rows", 6000, "--paths", 8, "--method", request.param]
    if request.param == "quadratic-regression":
        sizes += ["--cells", 3]
    rrf("bake", SCENE, "-o", run, "--light-box", box, *sizes)
    return run, METHODS[request.param]


def test_numpy_evaluates_the_model(baked):
    run, kind = baked
    out = run.parent / "answers.parquet"
    rrf("query", run, "--points", ORACLE, "-o", out)
    answers = pq.read_table(out)
    tables = {name: read_arrow(run / f"model/{name}.arrow") for name in ("tree", "weights", "metrics")}
    for name, table in tables.items():
        assert contract.differences(contract.load(name), table.schema) == []
    models = tables["weights"].to_pylist()
    assert {model["kind"] for model in models} == {kind}
    rows = with_material(answers, run)
    tree = tables["tree"].to_pylist()
    leaf = np.array([walk(tree, row) for row in rows.to_pylist()])
    assert np.array_equal(leaf, answers["cell_id"].to_numpy())
    found = np.stack([answers[c].to_numpy() for c in "rgb"], 1).astype(float)
    for model in models:
        # points that are sealed under a box are black by geometry, not by the model
        here = (leaf == model["cell_id"]) & (found != 0).any(axis=1)
        wanted = nets.evaluate(model, rows.filter(here))
        assert here.any()
        # inputs are rounded to float32, 6e-8 of a few units, and sums of a hundred such terms
        scale = np.abs(model["output_scale"]) + np.abs(wanted)
        assert (np.abs(wanted - found[here]) / scale).max() < 1e-5


def test_metrics_have_its_errors(baked):
    """One row a cell: solved, rows held out that were not trained on, an error with its own error."""
    run, kind = baked
    for row in read_arrow(run / "model/metrics.arrow").to_pylist():
        assert row["stop_reason"] == "solved" and row["validation_rows"] > 0
        assert row["train_rows"] + row["validation_rows"] + row["quarantined_rows"] == row["rows"]
        assert 0.05 < row["relative_error_validation"] < 1
        assert 0 < row["relative_square_error_validation_se"] < row["relative_square_error_validation"]
