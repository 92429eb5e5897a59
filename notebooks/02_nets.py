# ---
# jupyter:
#   jupytext:
#     formats: ipynb,py:percent
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Nets
# The model read with pyarrow: a net evaluated in ten lines of numpy is what `rrf query` gives; how
# saturated the units are, how many parameters the data determine, and how far the model is from a
# table made by another renderer.

# %%
import math
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import onnxruntime
import pyarrow.parquet as pq
from safetensors.numpy import load_file

import rrf_tables as rt

run = rt.demo() / "run"
tree, weights, metrics = (rt.read_arrow(run / f"model/{name}.arrow") for name in ("tree", "weights", "metrics"))
for name, table in (("tree", tree), ("weights", weights), ("metrics", metrics)):
    assert rt.contract.differences(rt.contract.load(name), table.schema) == [], name
# the units that the formulas below are written for
radiance = "W/(sr m^2)"
rt.expect_units("tree", {"unit of the column axis_name": "threshold", "unit of each raw column": "domain_min domain_max"})
rt.expect_units("weights", {"unit of each input": "input_offset", "1 / unit of each input": "input_scale",
                            radiance: "output_scale output_offset"})
rt.expect_units("metrics", {})
rt.expect_units("steps", {})
rt.expect_units("points", {"m": "px py pz lx ly lz"})
rt.expect_units("answers", {"m": "px py pz lx ly lz", radiance: "r g b"})
rt.expect_units("truth", {"m": "px py pz lx ly lz", radiance: "r g b r_se g_se b_se"})

scratch = Path(tempfile.mkdtemp())
oracle = rt.ORACLE / "cornell_overhead.parquet"
rt.rrf("query", run, "--points", oracle, "-o", scratch / "answers.parquet")
answers = pq.read_table(scratch / "answers.parquet")
truth = pq.read_table(oracle)
rows = rt.with_material(answers, run)
answered = rt.stack(answers, rt.RGB)
print(answers.num_rows, "points,", len(weights), "nets,", sum(len(w) for w in weights["weights"].to_pylist()), "weights")

# %% [markdown]
# ## One net in ten lines
# `h = (x - offset) * scale`, a matrix a layer with the bias in front, `tanh` between.

# %%
def evaluate(net, rows):
    known = rt.nets.inputs(rows)  # raw columns, and the derived ones of schemas/inputs.toml
    h = np.reshape([known[name] for name in net["inputs"]], (len(net["inputs"]), rows.num_rows)).T
    h = (h - net["input_offset"]) * net["input_scale"]
    flat, layers = np.array(net["weights"]), net["layers"]
    for k, (fan_in, units) in enumerate(zip(layers, layers[1:])):
        w, flat = flat[: units * (fan_in + 1)].reshape(units, -1), flat[units * (fan_in + 1) :]
        h = w[:, 0] + h @ w[:, 1:].T
        h = np.tanh(h) if k + 2 < len(layers) else h
    h = np.exp(np.minimum(h, 12)) if net["exponential"] else h
    y = h * net["output_scale"] + net["output_offset"]
    return y * rt.stack(rows, ("base_r", "base_g", "base_b")) if net["divide_base"] else y


leaf = rt.leaf(tree, rows)
assert (leaf == answers["cell_id"].to_numpy()).all(), "the kd-tree leads elsewhere"
mine, scale = np.zeros_like(answered), np.zeros_like(answered)
for net in weights.to_pylist():
    here = leaf == net["cell_id"]
    mine[here] = evaluate(net, rows)[here]
    # what an error of 1 before the output becomes: y itself where exponential, else the output scale
    scale[here] = abs(mine[here]) if net["exponential"] else net["output_scale"]
# points sealed under a box are exactly black, which no net says
sealed = (answered == 0).all(1)
error = (abs(mine - answered) / scale)[~sealed]
print(f"numpy against rrf query: largest difference {error.max():.1e}, in units of the last layer's; {sealed.sum()} sealed points")
# float32 with rational tanh and exp against float64: some 2^-24 a sum of up to 30 terms, two layers
assert error.max() < 1e-5 and sealed.mean() < 0.02

# %% [markdown]
# ## The same from the exported file
# `rrf export --safetensors`: what an engine would load. Nothing of rrf but the file is used below.

# %%
rt.rrf("export", run, "--safetensors", scratch / "nets.safetensors", "--onnx", scratch / "nets.onnx")
tensors = load_file(scratch / "nets.safetensors")
known = rt.nets.inputs(rows)
x = np.stack([known[entry["name"]] for entry in rt.contract.inputs()], 1)
node = np.zeros(len(x), int)
while (inner := tensors["tree.axis"][node] >= 0).any():
    axis = np.maximum(tensors["tree.axis"][node], 0)
    right = x[np.arange(len(x)), axis].astype(np.float32) >= tensors["tree.threshold"][node]
    node = np.where(inner, tensors["tree.left"][node] + right, node)
cell = tensors["tree.cell"][node]
assert (cell == leaf).all()
outside = np.zeros_like(answered)
for k in np.unique(cell):
    get = lambda name: tensors[f"cell.{k}.{name}"]
    h = (x[cell == k][:, get("inputs")] - get("input_offset")) * get("input_scale")
    layers = sum(name.startswith(f"cell.{k}.layer.") for name in tensors) // 2
    for i in range(layers):
        h = h @ get(f"layer.{i}.weight").T.astype(float) + get(f"layer.{i}.bias")
        h = np.tanh(h) if i + 1 < layers else h
    h = np.exp(np.minimum(h, 12)) if get("exponential")[0] else h
    y = h * get("output_scale") + get("output_offset")
    outside[cell == k] = y * x[cell == k][:, 12:15] if get("divide_base")[0] else y
assert np.allclose(outside, mine, rtol=1e-12, atol=1e-12 * scale.max())

# %% [markdown]
# ## The whole model by ONNX Runtime
# `rrf export --onnx`: kd-tree, derived inputs and nets as one graph from the 18 raw columns to r, g,
# b; float32 throughout, as in the renderer.

# %%
session = onnxruntime.InferenceSession(scratch / "nets.onnx")
raw = rt.stack(rows, rt.contract_names()).astype(np.float32)
by_onnx, cell_by_onnx = session.run(["rgb", "cell"], {"raw": raw})
assert (cell_by_onnx == leaf).all()
error = (abs(by_onnx - answered) / scale)[~sealed]
print(f"ONNX Runtime against rrf query: largest difference {error.max():.1e}")
assert error.max() < 2e-5  # both in float32: twice the bound above

# %% [markdown]
# ## Saturation
# A unit whose output is beyond ±0.99 on most rows has stopped listening: a fit that failed. Weights
# of a thousand are the same illness.

# %%
saturated, largest = [], []
for net in weights.to_pylist():
    here = leaf == net["cell_id"]
    part = rows.filter(here)
    known = rt.nets.inputs(part)
    h = np.reshape([known[n] for n in net["inputs"]], (len(net["inputs"]), part.num_rows)).T
    h = (h - net["input_offset"]) * net["input_scale"]
    flat, layers = np.array(net["weights"]), net["layers"]
    largest.append(abs(flat).max())
    for fan_in, units in zip(layers[:-2], layers[1:-1]):
        w, flat = flat[: units * (fan_in + 1)].reshape(units, -1), flat[units * (fan_in + 1) :]
        h = np.tanh(w[:, 0] + h @ w[:, 1:].T)
        saturated.append((abs(h) > 0.99).mean())
print(f"saturated: {100 * np.mean(saturated):.1f} % of the units' outputs, worst layer {100 * max(saturated):.0f} %;",
      f"largest weight {max(largest):.0f}")
assert np.mean(saturated) < 0.2 and max(saturated) < 0.6 and max(largest) < 300

# %% [markdown]
# ## How the fits went
# Every fit writes its accepted steps down. There are as many as the metrics say, the damping is
# positive, every step kept its linearisation's promise in part, and more cells end with a smaller
# error on the rows that choose the weights than they had after the first step than would by chance.

# %%
figure, ax = plt.subplots(figsize=(6, 3.2))
fell = []
for fit in metrics.to_pylist():
    steps = rt.read_arrow(run / f"rounds/{fit['round']:03d}/fits/cell={fit['cell_id']:06d}/steps.arrow")
    assert rt.contract.differences(rt.contract.load("steps"), steps.schema) == []
    assert steps["step"].to_pylist() == list(range(1, fit["iterations"] + 1))
    if not fit["iterations"]:
        continue  # a constant was enough
    assert min(steps["damping"].to_pylist()) > 0 and min(steps["gain"].to_pylist()) > 0
    error = np.maximum(steps["relative_square_error"].to_numpy(), 0) ** 0.5
    ax.plot(steps["step"], 100 * np.where(error > 0, error, np.nan), lw=1)
    fell.append(error[-1] < error[0])
ax.set(yscale="log", xlabel="step", ylabel="held-out error [%]")
# by chance half of the cells would: an exact sign test at one in a hundred
print(f"the error fell in {sum(fell)} of {len(fell)} cells")
assert sum(math.comb(len(fell), k) for k in range(sum(fell), len(fell) + 1)) < 0.01 * 2 ** len(fell)

# %% [markdown]
# ## Effective parameters
# tr J (JᵀJ + αI)⁻¹ Jᵀ: how many of a net's weights the data determine. Between the output layer's
# biases (3) and all of them.

# %%
effective = np.array(metrics["effective_parameters"].to_pylist(), float)
total = np.array(metrics["weights"].to_pylist())
held_out = np.array(metrics["relative_error_validation"].to_pylist(), float)
figure, axes = plt.subplots(1, 2, figsize=(10, 3.2))
axes[0].bar(range(len(total)), total, color="lightgrey", label="weights")
axes[0].bar(range(len(total)), effective, label="effective")
axes[0].set(xlabel="cell")
axes[0].legend()
axes[1].bar(range(len(total)), 100 * held_out)
axes[1].set(xlabel="cell", ylabel="held-out relative error [%]")
figure.tight_layout()
known = np.isfinite(effective)
assert (effective[known] > 3).all() and (effective[known] <= total[known] * (1 + 1e-9)).all()

# %% [markdown]
# ## Against another renderer
# The table was made by Mitsuba 3. The model's error there, noise taken out, agrees with its own
# held-out error within what a different distribution of points explains: the two are printed, and
# the model's mean is held to the table's within 2 %.

# %%
m, se = rt.stack(truth, rt.RGB), rt.stack(truth, [c + "_se" for c in rt.RGB])
error, error_se = rt.truth.relative_error(answered, m, se)
square = metrics["relative_square_error_validation"].to_numpy()
count = metrics["validation_rows"].to_numpy()
own = max((square * count).sum() / count.sum(), 0) ** 0.5
print(f"relative error against Mitsuba {100 * error:.1f} % ± {100 * error_se:.1f} %, on held-out rows about {100 * own:.1f} %")
assert abs(answered.mean() / m.mean() - 1) < 0.02
assert error < 2 * own + 5 * error_se
