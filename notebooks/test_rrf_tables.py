"""The helpers against something dumber, and the notebooks against their pairs."""

import copy
import re

import numpy as np
import jupytext
import pyarrow as pa
import pytest

import rrf_tables as rt

FOLDER = rt.ROOT / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_pairs_say_the_same(path):
    """The ipynb is what jupytext makes of the py."""
    cells = [[(c.cell_type, c.source) for c in jupytext.read(p).cells] for p in (path, path.with_suffix(".py"))]
    assert cells[0] == cells[1] and len(cells[0]) > 4


def test_there_is_something_to_check():
    assert len(NOTEBOOKS) >= 4


# no notebook opens a transfer's tables yet
OPENED = [name for name in rt.contract.names() if not name.startswith("transfer")]


@pytest.mark.parametrize("name", OPENED)
def test_a_changed_unit_stops_a_notebook(name, monkeypatch):
    """A notebook names the units of every table; one column's, changed alone, is found."""
    texts = [path.read_text() for path in FOLDER.glob("0*.py")]
    calls = [line for text in texts for line in re.findall(rf'rt\.expect_units\("{name}", .*?\}}\)', text, re.S)]
    assert len(calls) == 1, name
    known = {"rt": rt, "radiance": "W/(sr m^2)"}
    exec(calls[0], known)
    load = rt.contract.load
    columns = len(load(name)["column"])
    assert columns
    for place in range(columns):
        schema = copy.deepcopy(load(name))
        schema["column"][place]["unit"] += "/s"
        monkeypatch.setattr(rt.contract, "load", lambda _, schema=schema: schema)
        with pytest.raises(AssertionError):
            exec(calls[0], known)
        monkeypatch.setattr(rt.contract, "load", load)


def test_leaf_is_the_walk():
    """Against a row-by-row walk of a tree of three leaves."""
    tree = pa.table({
        "axis_name": ["px", "ly", None, None, None], "threshold": [0.5, 0.25, None, None, None],
        "left": [1, 3, None, None, None], "cell_id": [None, None, 0, 1, 2],
    })
    tree = tree.set_column(2, "left", pa.array([1, 3, None, None, None], pa.uint32()))
    rng = np.random.default_rng(8)
    rows = pa.table({name: rng.uniform(size=500).astype(np.float32) for name in rt.contract_names()})
    wanted = []
    for row in rows.to_pylist():
        node = 0
        while (name := tree["axis_name"][node].as_py()) is not None:
            node = tree["left"][node].as_py() + (row[name] >= tree["threshold"][node].as_py())
        wanted.append(tree["cell_id"][node].as_py())
    assert rt.leaf(tree, rows).tolist() == wanted and len(set(wanted)) == 3
