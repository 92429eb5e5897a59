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
# # Frames
# The model's frame beside the path-traced one, judged by colour-science and flip-evaluator: ΔE*ab,
# ΔE2000 and FLIP have to be those that `rrf compare` prints, to 1e-3. Then the colour bleeding,
# as chromaticities.

# %%
import os

os.environ.setdefault("COLOUR_SCIENCE__COLOUR__SHOW_WARNINGS_WITH_TRACEBACK", "0")
import colour
import flip_evaluator
import matplotlib.pyplot as plt
import numpy as np
from scipy import stats

import rrf_tables as rt

demo = rt.demo()
model, traced = rt.read_exr(demo / "model.exr"), rt.read_exr(demo / "traced.exr")
said = rt.compare(demo / "model.exr", demo / "traced.exr")
stops = said["exposure"]["ev"]
pictures = {"nets": rt.truth.shown(model["full"], stops), "path traced": rt.truth.shown(traced["full"], stops)}

# %% [markdown]
# ## ΔE by colour-science
# Linear sRGB to XYZ to CIELAB (D65), the 1976 and the 2000 difference, root mean square over pixels.

# %%
srgb_space = colour.RGB_COLOURSPACES["sRGB"]


def lab(linear):
    xyz = colour.RGB_to_XYZ(linear, srgb_space)
    return colour.XYZ_to_Lab(xyz, srgb_space.whitepoint)


labs = {name: lab(picture) for name, picture in pictures.items()}
maps = {
    "delta_e_ab": colour.delta_E(labs["nets"], labs["path traced"], method="CIE 1976"),
    "delta_e_2000": colour.delta_E(labs["path traced"], labs["nets"], method="CIE 2000"),
}
for name, values in maps.items():
    rms = np.mean(values**2) ** 0.5
    print(f"{name}: colour-science {rms:.6f}, rrf compare {said[name]:.6f}")
    assert abs(rms - said[name]) < 1e-3

# %% [markdown]
# ## FLIP by flip-evaluator

# %%
encoded = {name: rt.truth.srgb(picture).astype(np.float32) for name, picture in pictures.items()}
flip_map, mean_flip, parameters = flip_evaluator.evaluate(
    encoded["path traced"], encoded["nets"], "LDR", inputsRGB=True, applyMagma=False, computeMeanError=True
)
print(f"FLIP: flip-evaluator {mean_flip:.6f}, rrf compare {said['flip']:.6f} ({parameters})")
assert abs(mean_flip - said["flip"]) < 1e-3

figure, axes = plt.subplots(1, 4, figsize=(13, 3.6))
for ax, (name, picture) in zip(axes, encoded.items()):
    ax.imshow(picture)
    ax.set_title(name)
for ax, (name, values) in zip(axes[2:], (("ΔE2000", maps["delta_e_2000"]), ("FLIP", flip_map.squeeze()))):
    figure.colorbar(ax.imshow(values, cmap="magma", vmin=0), ax=ax, shrink=0.75)
    ax.set_title(name)
for ax in axes:
    ax.axis("off")
figure.tight_layout()

# %% [markdown]
# ## Lab histograms
# The two frames share their histograms: half the L1 distance (0 equal, 1 disjoint) over 40 bins
# stays small in L* and in both opponent axes.

# %%
figure, axes = plt.subplots(1, 3, figsize=(11, 3))
for ax, axis, (low, high) in zip(axes, range(3), ((0, 100), (-80, 80), (-80, 80))):
    bins = np.linspace(low, high, 41)
    counts = {name: np.histogram(values[..., axis], bins)[0] for name, values in labs.items()}
    for name, count in counts.items():
        ax.stairs(count, bins, label=name)
    ax.set(xlabel=("L*", "a*", "b*")[axis])
    distance = 0.5 * abs(np.subtract(*counts.values())).sum() / counts["nets"].sum()
    print(("L*", "a*", "b*")[axis], f"distance {distance:.3f}")
    assert distance < 0.15
axes[0].legend()
figure.tight_layout()

# %% [markdown]
# ## Colour bleeding
# Indirect light on the white back wall: near the red wall (left of the picture) its chromaticity x
# is higher, near the green one y is. Both frames say so, by Welch's t at 1e-6, and they agree with
# each other on where the chromaticity lies.

# %%
height, width, _ = model["indirect"].shape
rows = slice(int(0.26 * height), int(0.36 * height))  # the back wall above both boxes


def chromaticity(frame, columns):
    xyz = colour.RGB_to_XYZ(frame["indirect"][rows, columns].reshape(-1, 3), srgb_space)
    return colour.XYZ_to_xy(xyz[xyz.sum(1) > 0])


left, right = slice(int(0.28 * width), int(0.35 * width)), slice(int(0.65 * width), int(0.72 * width))
figure, ax = plt.subplots(figsize=(4.5, 4))
for name, frame, mark in (("nets", model, "o"), ("path traced", traced, "x")):
    near_red, near_green = chromaticity(frame, left), chromaticity(frame, right)
    red_x = stats.ttest_ind(near_red[:, 0], near_green[:, 0], equal_var=False)
    green_y = stats.ttest_ind(near_red[:, 1], near_green[:, 1], equal_var=False)
    print(f"{name}: x {near_red[:, 0].mean():.4f} near red, {near_green[:, 0].mean():.4f} near green")
    assert red_x.statistic > 0 and red_x.pvalue < 1e-6
    assert green_y.statistic < 0 and green_y.pvalue < 1e-6
    for side, color in ((near_red, "firebrick"), (near_green, "green")):
        ax.plot(*side[::7].T, mark, ms=2, color=color, alpha=0.4, label=name if side is near_red else None)
ax.set(xlabel="x", ylabel="y")
ax.legend()
for columns in (left, right):
    apart = abs(chromaticity(model, columns).mean(0) - chromaticity(traced, columns).mean(0)).max()
    # MacAdam's ellipses span some 0.002 to 0.01 in x and y
    assert apart < 0.01, apart
