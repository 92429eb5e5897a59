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
# # Error against time
# A sweep's table by polars: which settings nothing beats, what a bake buys over path tracing in the
# time of its frame, and whether the error that a run states for itself can be believed.

# %%
import json
import os
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import polars as pl
import pyarrow.parquet as pq

import rrf_tables as rt

sweep = Path(os.environ.get("RRF_SWEEP", rt.demo() / "sweep"))
if not (sweep / "results.parquet").exists():
    rt.rrf("sweep", rt.SCENES / "cornell-box/scene.pbrt", "-o", sweep, "--grid", rt.ROOT / "notebooks/small-grid.toml")
rt.expect_units("results", {"s": "bake_seconds bake_cpu_seconds frame_seconds frame_cpu_seconds", "byte": "model_bytes"})
assert rt.contract.differences(rt.contract.load("results"), pq.read_schema(sweep / "results.parquet")) == []
runs = pl.read_parquet(sweep / "results.parquet")
print(runs.select("method", "setting", "seed", "bake_cpu_seconds", "frame_cpu_seconds", "held_out_error", "frame_error"))

# %% [markdown]
# ## Settings over their seeds

# %%
settings = (
    runs.group_by("method", "setting")
    .agg(
        pl.len().alias("seeds"),
        pl.col("bake_cpu_seconds", "frame_cpu_seconds", "model_bytes", "frame_error", "held_out_error").mean(),
        (pl.col("frame_error").std() / pl.len().sqrt()).fill_null(0).alias("se"),
    )
    .sort("frame_error")
)
assert settings["seeds"].n_unique() == 1, "a run is missing"
assert runs.select("method", "setting", "seed").is_unique().all()


def front(table, cost):
    """Rows that no other beats in both cost and error, ascending in cost."""
    table = table.drop_nulls(cost).sort(cost, "frame_error")
    best = table["frame_error"].cum_min().shift(1)
    return table.filter(best.is_null() | (table["frame_error"] < best))


figure, axes = plt.subplots(1, 3, figsize=(13, 3.8))
for ax, cost in zip(axes, ("bake_cpu_seconds", "frame_cpu_seconds", "model_bytes")):
    for method, group in settings.drop_nulls(cost).group_by("method"):
        ax.errorbar(group[cost], 100 * group["frame_error"], 100 * group["se"], fmt="o", label=method[0])
    line = front(settings, cost)
    ax.plot(line[cost], 100 * line["frame_error"], color="grey", zorder=0)
    ax.set(xscale="log", yscale="log", xlabel=cost, ylabel="frame error [%]")
    errors = line["frame_error"].to_numpy()
    assert (np.diff(errors) < 0).all(), "along a front the error falls"
axes[1].legend()
figure.tight_layout()

# %% [markdown]
# ## Path tracing's own slope
# With independent paths noise falls with the square root of their number: the slope of log error over
# log paths is -1/2. Stratified ones, as here, gain a little more; no unbiased tracer loses.

# %%
traced = runs.filter(pl.col("method") == "path tracing")
x, y = np.log(traced["paths"].to_numpy().astype(float)), np.log(traced["frame_error"].to_numpy())
(slope, _), covariance = np.polyfit(x, y, 1, cov=True)
se = covariance[0, 0] ** 0.5
print(f"slope {slope:.3f} ± {se:.3f}")
assert -1 < slope < -0.5 + 5 * se

# %% [markdown]
# ## Can the stated error be believed?
# The error on rows held out and the error of the frame are of different points and views of one room;
# over the settings they rank alike.

# %%
baked = settings.drop_nulls("held_out_error")
rank = lambda column: baked[column].rank().to_numpy()
correlation = np.corrcoef(rank("held_out_error"), rank("frame_error"))[0, 1] if baked.height > 2 else float("nan")
print(f"rank correlation {correlation:.2f} over {baked.height} settings")
ratio = (baked["frame_error"] / baked["held_out_error"]).to_numpy()
print("frame over held-out error", ratio.round(2))
assert (ratio > 0.2).all() and (ratio < 5).all()

# %% [markdown]
# ## Equal time
# Path tracing interpolated at the CPU time in which the nets make a frame (where that is less than its
# fewest paths take: at those, which only helps it). The nets are nearer to the reference.

# %%
by_time = settings.filter(pl.col("method") == "path tracing").sort("frame_cpu_seconds")
best = baked.sort("frame_error").head(1)
at = np.exp(np.interp(np.log(best["frame_cpu_seconds"][0]), np.log(by_time["frame_cpu_seconds"].to_numpy()),
                      np.log(by_time["frame_error"].to_numpy())))
print(f"nets {100 * best['frame_error'][0]:.1f} % in {best['frame_cpu_seconds'][0]:.2f} CPU s, "
      f"path tracing in that time about {100 * at:.1f} %")
assert 0 < best["frame_error"][0] < at
