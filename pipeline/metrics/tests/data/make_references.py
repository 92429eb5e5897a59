"""Makes the reference tables and pictures beside this file.

    python3 -m venv venv && venv/bin/pip install colour-science==0.4.7 flip-evaluator==1.7 pillow
    venv/bin/python make_references.py
"""
import pathlib
import colour
import flip_evaluator
import numpy as np
from PIL import Image

here = pathlib.Path(__file__).parent
rng = np.random.default_rng(20050113)

# The published table, checked by a second implementation.
table = np.loadtxt(here / "ciede2000_sharma.tsv")
assert np.abs(colour.delta_E(table[:, :3], table[:, 3:6], method="CIE 2000") - table[:, 6]).max() < 5.1e-5

# Linear sRGB to CIELAB under D65, and colour differences of pairs.
space = colour.RGB_COLOURSPACES["sRGB"]
to_xyz = colour.models.rgb.rgb_colourspace.normalised_primary_matrix(space.primaries, space.whitepoint)
rgb = rng.random((40, 6)) ** 2.2
rgb[:4] = [[0, 0, 0, 1, 1, 1], [0.5, 0.5, 0.5, 0.5, 0.5, 0.5], [0.001, 0.002, 0.0005, 0, 0, 0], [1, 0, 0, 0, 0, 1]]
lab = [colour.XYZ_to_Lab(part @ to_xyz.T, space.whitepoint) for part in (rgb[:, :3], rgb[:, 3:])]
delta = [colour.delta_E(*lab, method=m) for m in ("CIE 1976", "CIE 2000")]
np.savetxt(
    here / "colour_science.tsv",
    np.column_stack([rgb, *lab, *delta]),
    fmt="%.9g",
    header="r1 g1 b1 r2 g2 b2 (linear sRGB) L1 a1 b1 L2 a2 b2 (D65) dE76 dE00; colour-science " + colour.__version__,
)


def picture(width, height, shift, noise):
    """Discs, stripes and ramps; `shift` moves the discs, `noise` is added."""
    y, x = np.mgrid[0:height, 0:width].astype(float)
    out = np.stack([x / width, y / height, 0.5 + 0.5 * np.sin(x * 0.9)], axis=2)
    for k in range(6):
        cx, cy, radius = rng_discs[k, :3] * [width, height, 0.25 * height]
        inside = (x - cx - shift) ** 2 + (y - cy) ** 2 < radius**2
        out[inside] = rng_discs[k, 3:6]
    return np.clip(out + noise * rng.standard_normal(out.shape), 0, 1)


rng_discs = rng.random((6, 6))
rows = []
for name, shift, noise in (("same", 0, 0.0), ("noisy", 0, 0.08), ("shifted", 3, 0.0)):
    for side, (s, n) in (("reference", (0, 0.0)), ("test", (shift, noise))):
        image = np.round(255 * picture(72, 48, s, n)).astype(np.uint8)
        Image.fromarray(image).save(here / f"flip_{name}_{side}.png")
    pair = [
        np.asarray(Image.open(here / f"flip_{name}_{side}.png"), np.float32) / np.float32(255)
        for side in ("reference", "test")
    ]
    error, mean, parameters = flip_evaluator.evaluate(
        pair[0], pair[1], "LDR", applyMagma=False, parameters={"ppd": 0.7 * 3840 / 0.7 * np.pi / 180}
    )
    error = np.asarray(error).reshape(48, 72, -1)[:, :, 0]
    np.savetxt(
        here / f"flip_{name}.tsv",
        error,
        fmt="%.6f",
        header=f"LDR-FLIP of flip_{name}_reference.png and flip_{name}_test.png, flip-evaluator 1.7, {parameters}",
    )
    print(name, mean, error.mean())
