"""The models of model/weights.arrow in numpy, as schemas/weights.toml describes them."""

import contract
import numpy as np


def reciprocal(x):
    return np.divide(1, x, out=np.zeros_like(x), where=x > 0)


class Inputs(dict):
    """Every input that a net can name, by name, computed when asked for; rows is a table with the raw
    columns, numbers are float64."""

    formulas = {entry["name"]: entry["formula"] for entry in contract.inputs() if "formula" in entry}
    functions = {"sqrt": np.sqrt, "reciprocal": reciprocal}

    def __init__(self, rows):
        names = (name for name in rows.column_names if name != "cell_id")
        super().__init__({name: np.asarray(rows[name], float) for name in names})

    def __missing__(self, name):
        self[name] = eval(self.formulas[name], self.functions, self)
        return self[name]


inputs = Inputs


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


def net_outputs(net, h):
    w, layers = np.array(net["weights"]), net["layers"]
    for k, (a, b) in enumerate(zip(layers, layers[1:])):
        layer, w = w[: b * (a + 1)].reshape(b, a + 1), w[b * (a + 1) :]
        h = layer[:, 0] + h @ layer[:, 1:].T
        h = np.tanh(h) if k + 2 < len(layers) else h
    return np.exp(np.minimum(h, 12)) if net["exponential"] else h


def quadratic_outputs(net, h):
    pairs = [h[:, i] * h[:, j] for i in range(h.shape[1]) for j in range(i, h.shape[1])]
    terms = np.stack([np.ones(len(h)), *h.T, *pairs], 1)
    return terms @ np.reshape(net["weights"], (3, -1)).T


def nearest_outputs(net, h, neighbours=8):
    inputs, rows, _ = net["layers"]
    points, values = np.split(np.array(net["weights"], np.float32), [inputs * rows])
    points, values = points.reshape(rows, inputs).astype(float), values.reshape(rows, 3).astype(float)
    found = np.zeros((len(h), 3))
    for at, x in enumerate(h):
        square = ((points - x) ** 2).sum(1)
        order = np.argsort(square, kind="stable")[:neighbours]
        on_it = order[square[order] == 0]
        weight = 1 / square[order] if len(on_it) == 0 else np.ones(len(on_it))
        order = order if len(on_it) == 0 else on_it
        found[at] = weight @ values[order] / weight.sum()
    return found


def harmonics(n):
    """Real spherical harmonics up to the second order, orthonormal over the sphere, [rows, 9]."""
    x, y, z = n.T
    one, two = np.sqrt(3 / (4 * np.pi)), np.sqrt(15 / (4 * np.pi))
    first = [x * 0 + 1 / np.sqrt(4 * np.pi), one * y, one * z, one * x]
    zonal = np.sqrt(5 / (16 * np.pi)) * (3 * z * z - 1)
    return np.stack([*first, two * x * y, two * y * z, zonal, two * x * z, two / 2 * (x * x - y * y)], 1)


def hats(h, count):
    """What each point of a grid weighs at each place: products of hat functions, [rows, count ** 3]."""
    h = np.clip(h, 0, count - 1)
    x, y, z = (np.maximum(0, 1 - np.abs(h[:, [axis]] - np.arange(count))) for axis in range(3))
    return np.einsum("ri,rj,rk->rijk", x, y, z).reshape(len(h), -1)


def probes_outputs(net, h):
    _, places, lights, _ = net["layers"]
    weights = np.reshape(net["weights"], (places**3, lights**3, 9, 3))
    at = (hats(h[:, :3], places), hats(h[:, 6:], lights), harmonics(h[:, 3:6]))
    return np.einsum("rp,rl,rh,plhc->rc", *at, weights, optimize=True)


OUTPUTS = {
    "net": net_outputs,
    "quadratic": quadratic_outputs,
    "nearest": nearest_outputs,
    "probes": probes_outputs,
}


def evaluate(net, rows):
    """Indirect radiance, shape [rows, 3]; net is one row of weights.arrow as a dict."""
    if net["kind"] not in OUTPUTS:
        raise ValueError(f"cell {net['cell_id']}: no evaluation of kind {net['kind']!r} here")
    known = inputs(rows)
    h = np.reshape([known[name] for name in net["inputs"]], (len(net["inputs"]), rows.num_rows)).T
    # which rows are nearest hangs on roundings: as Rust rounds
    number = float if net["kind"] == "net" else np.float32
    h = (h.astype(number) - np.array(net["input_offset"], number)) * np.array(net["input_scale"], number)
    y = OUTPUTS[net["kind"]](net, h.astype(float)) * net["output_scale"] + net["output_offset"]
    base = np.stack([known["base_" + c] for c in "rgb"], 1)
    return y * base if net["divide_base"] else y
