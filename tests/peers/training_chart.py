"""Draws what training.py measured.

    training_chart.py IN.json OUT.png [OUT.svg]
"""

import json
import sys

import matplotlib

matplotlib.use("Agg")
matplotlib.rcParams["svg.hashsalt"] = "rrf"
import matplotlib.pyplot as plt  # noqa: E402


# programs of others: dashed
OTHERS = ("numpy", "scipy", "jax")


def main(source: str, *pictures: str) -> None:
    measured = json.load(open(source))
    figure, axes = plt.subplots(1, 2, figsize=(11, 4.4), sharey=True)
    colors = iter(plt.get_cmap("tab20").colors)
    for name, rows in measured["medians"].items():
        color = next(colors)
        seconds = [max(row[0], 1e-3) for row in rows]
        for axis, column in zip(axes, (1, 2)):
            width = 2.4 if name == "ours" else 1.4
            line = "--" if name.startswith(OTHERS) else "-"
            axis.plot(seconds[1:], [100 * row[column] for row in rows[1:]], label=name, linewidth=width, color=color, linestyle=line)
    for axis, title in zip(axes, ("rows trained on", "rows kept back")):
        axis.set(xscale="log", yscale="log", xlabel="CPU seconds, one core", title=title, xlim=(5e-3, 8))
        for ticks in (axis.xaxis, axis.yaxis):
            ticks.set_major_formatter("{x:g}")
        axis.yaxis.set_minor_formatter("{x:g}")
        axis.grid(True, which="both", alpha=0.25)
    axes[0].set_ylabel("relative RMS error [%]")
    axes[1].legend(bbox_to_anchor=(1.02, 1), loc="upper left")
    figure.suptitle(f"One cell, {measured['rows']} rows, 20-10 net, {measured['weights']} weights")
    figure.tight_layout()
    for picture in pictures:
        figure.savefig(picture, dpi=110, metadata={"Date": None} if picture.endswith("svg") else None)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
