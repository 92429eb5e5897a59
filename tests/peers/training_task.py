"""What trainers run against each other on: a cell's rows, a net, its residuals, and a clock of CPU time.

Import it first: it runs the program again with one thread for each library.
"""

import os
import sys
import time
from pathlib import Path

STEPS = 60
ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "MKL_NUM_THREADS": "1",
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
    "JAX_PLATFORMS": "cpu",
}
# a setting for old OpenBLAS builds that slows the one inside numpy
SLOWS_NUMPY = ("OPENBLAS_CORETYPE", "OPENBLAS_L2_SIZE")
if any(os.environ.get(k) != v for k, v in ONE_THREAD.items()) or any(k in os.environ for k in SLOWS_NUMPY):
    environment = {k: v for k, v in os.environ.items() if k not in SLOWS_NUMPY} | ONE_THREAD
    os.execve(sys.executable, [sys.executable, *sys.argv], environment)

import jax  # noqa: E402
import numpy as np  # noqa: E402

jax.config.update("jax_enable_x64", True)
ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/python"))
import rrf_truth  # noqa: E402


# ---- the problem -------------------------------------------------------------------------------


def problem(path: str) -> dict:
    """A cell's rows as scaled inputs, scaled targets and weights of the residuals."""
    rows = np.fromfile(path, "<f4").reshape(-1, 24).astype(float)
    p, light, base = rows[:, 0:3], rows[:, 9:12], rows[:, 12:15]
    y = 0.5 * (rows[:, 18:21] + rows[:, 21:24]) / base
    away = light - p
    distance = np.linalg.norm(away, axis=1, keepdims=True)
    x = np.hstack([p, rows[:, 3:6], light, away / distance, 1 / distance])
    x = x[:, x.std(axis=0) > 1e-5]
    s = base / rrf_truth.level(base * y)[:, None]
    offset = (s**2 * y).sum(axis=0) / (s**2).sum(axis=0)
    scale = np.sqrt((s**2 * (y - offset) ** 2).sum(axis=0) / (s**2).sum(axis=0))
    order = np.random.default_rng(1).permutation(len(x))
    x, y, s = x[order], ((y - offset) / scale)[order], (s * scale)[order]
    train = len(x) * 7 // 10
    x = (x - x[:train].mean(axis=0)) / x[:train].std(axis=0)
    sizes = [x.shape[1], 20, 10, 3]
    random = np.random.default_rng(2)
    layers = [
        np.hstack([random.uniform(-1, 1, (m, 1)), np.sqrt(3 / n) * random.uniform(-1, 1, (m, n))])
        for n, m in zip(sizes, sizes[1:])
    ]
    return dict(x=x, y=y, s=s, train=train, sizes=sizes, w=np.concatenate([l.ravel() for l in layers]))


def write(task: dict, path: Path) -> None:
    """The problem as `examples/race` reads it."""
    rows = len(task["x"])
    head = np.array([task["train"], rows - task["train"], task["x"].shape[1], len(task["w"])], "<i8")
    with open(path, "wb") as file:
        file.write(head.tobytes())
        for array in (task["x"], task["y"], task["s"], task["w"]):
            file.write(np.ascontiguousarray(array, "<f8").tobytes())


def unpack(w, sizes):
    """Layers as (bias, matrix)."""
    at, layers = 0, []
    for n, m in zip(sizes, sizes[1:]):
        layer = w[at : at + m * (n + 1)].reshape(m, n + 1)
        layers.append((layer[:, 0], layer[:, 1:]))
        at += m * (n + 1)
    return layers


def forward(w, x, sizes, np=np):
    """Activations of every layer, the outputs last."""
    values = [x]
    layers = unpack(w, sizes)
    for i, (bias, matrix) in enumerate(layers):
        z = values[-1] @ matrix.T + bias
        values.append(np.tanh(z) if i + 1 < len(layers) else z)
    return values


def residuals(w, task, kept=False):
    part = slice(task["train"], None) if kept else slice(0, task["train"])
    out = forward(w, task["x"][part], task["sizes"])[-1]
    return (task["s"][part] * (out - task["y"][part])).ravel()


def jacobian(w, task):
    """d residual / d weight, [rows * 3, weights], by backpropagation of each channel."""
    part, sizes = slice(0, task["train"]), task["sizes"]
    values = forward(w, task["x"][part], sizes)
    layers, s = unpack(w, sizes), task["s"][part]
    rows = len(s)
    J = np.empty((rows, 3, len(w)))
    for c in range(3):
        g = np.zeros((rows, 3))
        g[:, c] = s[:, c]
        end = len(w)
        for i in reversed(range(len(layers))):
            below, size = values[i], layers[i][1].size + layers[i][0].size
            ext = np.concatenate([np.ones((rows, 1)), below], axis=1)
            J[:, c, end - size : end] = (g[:, :, None] * ext[:, None, :]).reshape(rows, -1)
            end -= size
            if i:
                g = (g @ layers[i][1]) * (1 - below**2)
    return J.reshape(rows * 3, -1)


class Clock:
    """CPU seconds of a program and the errors it reached; judging does not count."""

    most = 5.0  # CPU seconds of a program

    def __init__(self, task):
        self.task, self.spent, self.rows = task, 0.0, []
        self.record(task["w"])
        self.since = time.process_time()

    def record(self, w):
        w = np.asarray(w, float)
        squares = [float(np.sum(residuals(w, self.task, kept) ** 2)) for kept in (False, True)]
        self.rows.append([self.spent, *squares])

    def lap(self, w) -> bool:
        """Notes the weights; False when the time is up."""
        self.spent += time.process_time() - self.since
        self.record(w)
        self.since = time.process_time()
        return self.spent < self.most
