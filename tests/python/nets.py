"""The nets of model/weights.arrow in numpy, as schemas/weights.toml describes them."""

import numpy as np


def unit(x):
    return x / np.linalg.norm(x, axis=1, keepdims=True)


def inputs(rows):
    """Every input that a net can name, by name; rows is a table with the raw columns."""
    known = {name: np.asarray(rows[name], float) for name in rows.column_names if name != "cell_id"}
    p, n, v, l = (np.stack([known[k + a] for a in "xyz"], 1) for k in "pnvl")
    d = unit(l - p)
    known |= dict(zip(("dx", "dy", "dz"), d.T))
    known["inv_distance"] = 1 / np.linalg.norm(l - p, axis=1)
    known["cos_light"] = (n * d).sum(1)
    known["cos_view"] = (n * v).sum(1)
    known["mirror_light"] = ((2 * known["cos_view"][:, None] * n - v) * d).sum(1)
    return known


def leaf(tree, rows):
    """The cell of every row: the walk that schemas/tree.toml describes. Shape [rows]."""
    axis_name, threshold = tree["axis_name"].to_pylist(), tree["threshold"].to_pylist()
    left, cell = tree["left"].to_pylist(), np.array(tree["cell_id"].to_pylist(), object)
    node = np.zeros(rows.num_rows, int)
    for at, name in enumerate(axis_name):  # children come after their parent
        if name is not None:
            here = node == at
            node[here] = left[at] + (rows[name].to_numpy()[here] >= np.float32(threshold[at]))
    return cell[node].astype(int)


def evaluate(net, rows):
    """Indirect radiance, shape [rows, 3]; net is one row of weights.arrow as a dict."""
    known = inputs(rows)
    h = np.reshape([known[name] for name in net["inputs"]], (len(net["inputs"]), rows.num_rows)).T
    h = (h - net["input_offset"]) * net["input_scale"]
    w, layers = np.array(net["weights"]), net["layers"]
    for k, (a, b) in enumerate(zip(layers, layers[1:])):
        layer, w = w[: b * (a + 1)].reshape(b, a + 1), w[b * (a + 1) :]
        h = layer[:, 0] + h @ layer[:, 1:].T
        h = np.tanh(h) if k + 2 < len(layers) else h
    h = np.exp(np.minimum(h, 12)) if net["exponential"] else h
    y = h * net["output_scale"] + net["output_offset"]
    base = np.stack([known["base_" + c] for c in "rgb"], 1)
    return y * base if net["divide_base"] else y
