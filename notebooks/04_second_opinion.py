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
# # A second opinion
# Mitsuba 3 renders the scenes that `rrf export --mitsuba` writes: the Cornell box under a point
# light and under its own lamp, the glossy room, and a room with textures and smooth normals. Both
# programs estimate the same numbers, so their difference is noise: shown as an image of z-scores and
# tested, corrected for the number of tests.

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy import stats

import mitsuba_frames
import rrf_tables as rt

SIZE, RUNS, PATHS, BLOCK = 64, 24, 64, 8
view = ["--eye", "0.13,1.07,6.1", "--look-at", "0.02,0.96,0", "--fov", 22]
light = ["--light", "0.1,1.6,0.2,4,4,4"]
scenes = {
    "Cornell box": [rt.SCENES / "cornell-box/scene.pbrt", *view, *light],
    "Cornell box, its own lamp": [rt.SCENES / "cornell-box/scene.pbrt", *view],
    "glossy room": [rt.SCENES / "cornell-glossy/cornell-glossy.glb", *view, *light],
    "textured room": [rt.ROOT / "tests/data/textured/textured-room.glb",
                      "--eye", "0.11,0.83,2.6", "--look-at", "0.02,0.76,0", "--fov", 44],
}
scratch = Path(tempfile.mkdtemp())


def both(name):
    """Independent frames by both programs, each of shape [runs, size, size, 3]."""
    scene, *rest = scenes[name]
    folder = scratch / name.replace(" ", "-").replace(",", "")
    rest = [*rest, "--size", f"{SIZE}x{SIZE}"]
    rt.rrf("export", scene, "--mitsuba", folder, *rest)
    theirs = mitsuba_frames.render(folder, RUNS, PATHS)
    ours = []
    for seed in range(RUNS):
        rt.rrf("trace", scene, "-o", folder / "frame.exr", "--spp", PATHS, "--seed", seed, *rest)
        ours.append(rt.read_exr(folder / "frame.exr")["full"])
    return np.array(ours), theirs


frames = {name: both(name) for name in scenes}

# %% [markdown]
# ## z-scores
# Means over blocks of 8 × 8 pixels (single pixels with few paths are too skewed for a normal limit),
# each with the spread of its own runs: Welch's t, turned into a normal score. A ray along an edge
# between two surfaces can go either way by rounding; such a pixel is black in one program and lit in
# the other, in every run. They are counted, allowed at most one in a thousand, and left out.

# %%
def scores(ours, theirs):
    edge = ((ours == 0).all((0, 3)) != (theirs == 0).all((0, 3)))
    edge |= flips(ours, theirs)
    keep = ~edge[None, :, :, None]
    count = edge.size // BLOCK**2
    a, b = ((frames * keep).reshape(RUNS, SIZE // BLOCK, BLOCK, SIZE // BLOCK, BLOCK, 3).mean((2, 4))
            for frames in (ours, theirs))
    test = stats.ttest_ind(a, b, axis=0, equal_var=False)
    z = np.sign(test.statistic) * stats.norm.isf(test.pvalue / 2)
    return np.nan_to_num(z), edge.sum(), count


def flips(ours, theirs):
    """Pixels whose direct light differs by a step: the difference is beyond 30 standard errors and
    a tenth of the value, which noise cannot do and an edge of a shadow or surface does."""
    difference = abs(ours.mean(0) - theirs.mean(0))
    error = ((ours.var(0, ddof=1) + theirs.var(0, ddof=1)) / RUNS) ** 0.5
    return ((difference > 30 * error) & (difference > 0.1 * theirs.mean(0))).any(-1)


figure, axes = plt.subplots(3, len(frames), figsize=(3 * len(frames), 8.6))
for column, (name, (ours, theirs)) in zip(axes.T, frames.items()):
    z, edges, blocks = scores(ours, theirs)
    limit = rt.truth.z_limit(z.size)
    bias = ours.mean() / theirs.mean() - 1
    whole = stats.ttest_ind(ours.mean((1, 2, 3)), theirs.mean((1, 2, 3)), equal_var=False)
    print(f"{name:<26} bias {100 * bias:+.2f} %, whole p {whole.pvalue:.3f}; {z.size} tests, largest |z| "
          f"{abs(z).max():.2f}, limit {limit:.2f}; {edges} edge pixels")
    assert edges <= SIZE * SIZE / 1000 + 1
    assert abs(z).max() < limit and whole.pvalue > 1e-4
    for ax, picture in zip(column, (ours, theirs)):
        stops = np.log2(0.8 / np.quantile(theirs.mean(0), 0.95))
        ax.imshow(rt.truth.srgb(rt.truth.shown(picture.mean(0), stops)))
    column[0].set_title(name, fontsize=9)
    shown = column[2].imshow(z[..., 1], cmap="coolwarm", vmin=-limit, vmax=limit)
for ax, label in zip(axes[:, 0], ("rrf trace", "Mitsuba 3", "z, green channel")):
    ax.set_ylabel(label)
for ax in axes.flat:
    ax.set(xticks=[], yticks=[])
figure.colorbar(shown, ax=axes[2], shrink=0.8)

# %% [markdown]
# ## Would it see an error?
# The same test with 3 % more light in one program's red channel fails on every scene: the limit is
# not so wide that anything passes.

# %%
for name, (ours, theirs) in frames.items():
    z, _, _ = scores(ours * [1.03, 1, 1], theirs)
    whole = stats.ttest_ind(1.03 * ours[..., 0].mean((1, 2)), theirs[..., 0].mean((1, 2)), equal_var=False)
    print(f"{name:<26} largest |z| {abs(z).max():.1f}, whole p {whole.pvalue:.1e}")
    assert abs(z).max() > rt.truth.z_limit(z.size) or whole.pvalue < 1e-4

# %% [markdown]
# ## The camera of the file
# pbrt scenes often mirror the picture. Exported with the scene's own camera, both frames show the same
# way round: the correlation of the two is higher than with either of them mirrored.

# %%
folder = scratch / "own-camera"
own = [rt.SCENES / "cornell-box/scene.pbrt", "--size", f"{SIZE}x{SIZE}", *light]
rt.rrf("export", *own[:1], "--mitsuba", folder, *own[1:])
theirs = mitsuba_frames.render(folder, 1, PATHS)[0]
rt.rrf("trace", *own, "-o", folder / "frame.exr", "--spp", PATHS)
ours = rt.read_exr(folder / "frame.exr")["full"]
correlate = lambda a, b: np.corrcoef(np.clip(a, 0, 2).ravel(), np.clip(b, 0, 2).ravel())[0, 1]
same, mirrored = correlate(ours, theirs), correlate(ours, theirs[:, ::-1])
print(f"correlation {same:.4f}, mirrored {mirrored:.4f}")
assert same > 0.95 and same > mirrored + 0.05
