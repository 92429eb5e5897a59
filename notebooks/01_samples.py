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
# # Samples
# A run's training data, opened with pyarrow alone: partitions, the schema against `schemas/`,
# where the rows lie, what they hold, and how noisy they are. Every cell asserts what it shows.

# %%
import json

import matplotlib.pyplot as plt
import numpy as np
import pyarrow.dataset as ds
import pyarrow.parquet as pq

import rrf_tables as rt

run = rt.demo() / "run"
manifest = json.loads((run / "run.json").read_text())
dataset = ds.dataset(run / "samples", partitioning="hive")
table = dataset.to_table()
metrics = rt.read_arrow(run / "model/metrics.arrow")
print(manifest["created_by"], "seed", manifest["seed"], f"{table.num_rows:,} rows,", len(metrics), "cells")

# %% [markdown]
# ## Partitions and schema
# A folder a cell. Each file says its columns' units, frames and meanings; they have to be those of
# `schemas/samples.toml`, word for word: a change on either side stops here. And the units have to be
# those that the formulas below are written for.

# %%
schema = rt.contract.load("samples")
for path in dataset.files:
    assert rt.contract.differences(schema, pq.read_schema(path)) == [], path
rt.expect_units("samples", {"m": "px py pz lx ly lz", "W/(sr m^2)": "y0_r y0_g y0_b y1_r y1_g y1_b"})
rt.expect_units("tasks", {"s": "seconds", "byte": "memory"})
tasks = run / "rounds/000/tasks.parquet"
assert rt.contract.differences(rt.contract.load("tasks"), pq.read_schema(tasks)) == []
assert (table["cell"].to_numpy() == table["cell_id"].to_numpy()).all()
cells, rows = np.unique(table["cell_id"].to_numpy(), return_counts=True)
assert cells.tolist() == metrics["cell_id"].to_pylist()
assert rows.tolist() == metrics["rows"].to_pylist()
keys = np.stack([table["cell_id"].to_numpy(), table["sample_index"].to_numpy()])
assert len(np.unique(keys, axis=1).T) == table.num_rows  # cell and index name a row
assert all(table[name].null_count == 0 for name in table.column_names)

# %% [markdown]
# ## Where the rows lie
# Surface points from above and from the front, coloured by cell, and the lights.

# %%
p, n, v, l = (rt.stack(table, [k + a for a in "xyz"]) for k in "pnvl")
color = plt.cm.prism(table["cell_id"].to_numpy() / cells.max())
figure, axes = plt.subplots(1, 3, figsize=(11, 3.6))
some = np.random.default_rng(1).choice(len(p), 6000, replace=False)
for ax, (i, j), points, title in zip(
    axes, ((0, 2), (0, 1), (0, 1)), (p, p, l), ("points from above", "points from the front", "lights from the front")
):
    ax.scatter(points[some, i], points[some, j], s=1, c=color[some])
    ax.set(title=title, aspect="equal", xlabel="xyz"[i] + " [m]", ylabel="xyz"[j] + " [m]")
figure.tight_layout()

low, high = np.float32(manifest["light_box"][:3]), np.float32(manifest["light_box"][3:])
assert ((l >= low) & (l <= high)).all(), "a light outside the light box"
eps = 8 * np.finfo(np.float32).eps
assert abs((n**2).sum(1) - 1).max() < eps and abs((v**2).sum(1) - 1).max() < eps
assert ((n * v).sum(1) > 0).all(), "normals are on the viewer's side"

# %% [markdown]
# ## Two independent halves
# Each row has two estimates of the same radiance from different paths. Their difference has mean
# zero: a z-test a channel, at 1e-4 over the three.

# %%
halves = np.stack([rt.stack(table, [f"y{half}_{c}" for c in rt.RGB]) for half in (0, 1)])
assert (halves >= 0).all() and np.isfinite(halves).all()
difference = halves[0] - halves[1]
z = difference.mean(0) / (difference.std(0, ddof=1) / len(difference) ** 0.5)
print("z of the halves' difference", z.round(2), "limit", round(rt.truth.z_limit(3), 2))
assert abs(z).max() < rt.truth.z_limit(3)

# %% [markdown]
# ## Noise, from the halves
# The standard error of a row's mean is estimated by half the difference of its halves. Relative to
# max(c, ε), c the channel mean, root mean square over a cell, it is the column `noise` of the metrics, recomputed here.
# The bake's ε is of the scene's mean, where each cell counts by its share of the scene; here rows
# count alike. It matters to the darkest rows alone: 1 % is allowed for it.

# %%
mean = rt.truth.channel_mean(halves.mean(0))
floor = rt.truth.EPSILON_SHARE * mean.mean()
relative = rt.truth.noise_of_halves(halves, rt.truth.level(halves.mean(0)))
ids = table["cell_id"].to_numpy()
noise = np.array([relative[ids == cell].mean() ** 0.5 for cell in cells])
stated = np.array(metrics["noise"].to_pylist())
print(f"noise of the cells {noise.min():.3f} to {noise.max():.3f}; stated and recomputed differ by at most",
      f"{abs(noise / stated - 1).max():.1e}")
assert np.allclose(noise, stated, rtol=1e-2)

figure, axes = plt.subplots(1, 2, figsize=(10, 3.2))
axes[0].hist(np.log10(np.maximum(mean, 1e-6)), bins=80)
axes[0].axvline(np.log10(floor), color="k", lw=1, label="ε = 5 % of the mean")
axes[0].set(xlabel="log10 of the channel mean [W/(sr m²)]", ylabel="rows")
axes[0].legend()
axes[1].bar(cells, 100 * noise)
axes[1].set(xlabel="cell", ylabel="noise of a row [%]")
figure.tight_layout()

# %% [markdown]
# ## The same from less
# Noise falls with the square root of the paths: one half alone has √2 of the noise of both, so the
# variance of (y₀ − y₁) is four times that of the mean — and a sum over the rows estimates the whole
# room's light far better than any row. The bootstrap over rows gives the spread of that sum.

# %%
rng = np.random.default_rng(2)
draws = [mean[rng.integers(0, len(mean), len(mean))].mean() for _ in range(400)]
analytic = mean.std(ddof=1) / len(mean) ** 0.5
print(f"mean radiance {mean.mean():.5f} ± {analytic:.5f} W/(sr m²); bootstrap says ± {np.std(draws):.5f}")
# the sample deviation of 400 draws: relative standard error 1/sqrt(2 * 399) = 3.5 %; 4.9 of them
# are 1e-6 two-sided
assert abs(np.std(draws, ddof=1) / analytic - 1) < 4.9 / (2 * 399) ** 0.5
