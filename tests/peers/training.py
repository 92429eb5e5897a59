"""Error against CPU seconds: this trainer and other people's on one net, one cell, one start.

    training.py CELL.f32 OUT.json [ROUNDS [PROGRAM,...]]      (a cell from export_cells.py)

A 20-10 net, the cell's rows split 70 : 30, squared errors relative to the target's luminance, the
same first weights for all. Each program runs on one thread, its own CPU time is
counted, without the time for judging and for compiling. Programs take turns, ROUNDS times (3);
the medians are kept, step by step. Every program ends after its steps or SECONDS of CPU.

  ours          examples/race of rrf-train
  accelerated   the same with geodesic acceleration
  warm          the same, its first 12 steps on a quarter of the rows; also with JᵀJ multiplied from f32
  plain; f32    that without acceleration
  matrices kept that with a new matrix each eighth step, conjugate gradients between; also accelerated
  numpy LM      Jacobian by backpropagation, gemm, Cholesky, damping times or over ten
  scipy lm      scipy.optimize.least_squares(method="lm"), MINPACK, the same analytic Jacobian
  jax Adam      float32, batches of 256 in random order, rate 3e-3 falling to 0 as a cosine
  jax L-BFGS    scipy's L-BFGS-B on jax's float64 gradients, 20 pairs
"""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

SECONDS = 5.0
STEPS = 60
ONE_THREAD = {
    "OMP_NUM_THREADS": "1",
    "OPENBLAS_NUM_THREADS": "1",
    "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1",
    "JAX_PLATFORMS": "cpu",
}
# a setting for old OpenBLAS builds that slows the one inside numpy
SLOWS_NUMPY = ("OPENBLAS_CORETYPE", "OPENBLAS_L2_SIZE")
if any(os.environ.get(k) != v for k, v in ONE_THREAD.items()) or any(k in os.environ for k in SLOWS_NUMPY):
    environment = {k: v for k, v in os.environ.items() if k not in SLOWS_NUMPY} | ONE_THREAD
    os.execve(sys.executable, [sys.executable, *sys.argv], environment)

import jax  # noqa: E402
import jax.numpy as jnp  # noqa: E402
import numpy as np  # noqa: E402
import scipy.linalg  # noqa: E402
import scipy.optimize  # noqa: E402

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


# ---- the programs ------------------------------------------------------------------------------


class Clock:
    """CPU seconds of a program and the errors it reached; judging does not count."""

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
        return self.spent < SECONDS


def numpy_lm(task):
    w, mu = task["w"].copy(), 1e-3
    clock = Clock(task)
    r = residuals(w, task)
    for _ in range(STEPS):
        J = jacobian(w, task)
        A, g = J.T @ J, J.T @ r
        if not clock.rows[1:]:
            mu *= A.diagonal().max()
        while True:
            try:
                step = scipy.linalg.cho_solve(scipy.linalg.cho_factor(A + mu * np.eye(len(w))), -g)
            except np.linalg.LinAlgError:
                mu *= 10
                continue
            trial = residuals(w + step, task)
            if trial @ trial < r @ r:
                w, r, mu = w + step, trial, mu / 10
                break
            mu *= 10
        clock.lap(w)
    return clock.rows


class TimeIsUp(Exception):
    pass


def scipy_lm(task):
    clock = Clock(task)
    best = [np.inf]

    def fun(w):
        r = residuals(w, task)
        if r @ r < best[0]:
            best[0] = r @ r
            if not clock.lap(w):
                raise TimeIsUp
        return r

    try:
        scipy.optimize.least_squares(fun, task["w"], jac=lambda w: jacobian(w, task), method="lm")
    except TimeIsUp:
        pass
    return clock.rows


def jax_cost(task, dtype):
    part, sizes = slice(0, task["train"]), task["sizes"]
    x, y, s = (jnp.asarray(task[k][part], dtype) for k in "xys")

    def cost(w, rows=slice(None)):
        out = forward(w, x[rows], sizes, jnp)[-1]
        return jnp.mean((s[rows] * (out - y[rows])) ** 2)

    return cost


def jax_adam(task, batch=256, rate=3e-3, epochs=1200):
    cost, rows = jax_cost(task, jnp.float32), task["train"]
    batches = rows // batch
    gradient = jax.grad(cost)

    def step(state, rows):
        w, m, v, t = state
        g = gradient(w, rows)
        m, v, t = 0.9 * m + 0.1 * g, 0.999 * v + 0.001 * g * g, t + 1
        now = rate * 0.5 * (1 + jnp.cos(jnp.pi * jnp.minimum(t / (epochs * batches), 1)))
        w = w - now * (m / (1 - 0.9**t)) / (jnp.sqrt(v / (1 - 0.999**t)) + 1e-8)
        return (w, m, v, t), None

    @jax.jit
    def epoch(state, key):
        order = jax.random.permutation(key, rows)[: batches * batch].reshape(batches, batch)
        return jax.lax.scan(step, state, order)[0]

    w = jnp.asarray(task["w"], jnp.float32)
    state = (w, jnp.zeros_like(w), jnp.zeros_like(w), jnp.float32(0))
    keys = jax.random.split(jax.random.PRNGKey(3), epochs)
    jax.block_until_ready(epoch(state, keys[0]))
    clock = Clock(task)
    for i in range(0, epochs, 10):
        for key in keys[i : i + 10]:
            state = epoch(state, key)
        jax.block_until_ready(state)
        if not clock.lap(state[0]):
            break
    return clock.rows


def jax_lbfgs(task):
    both = jax.jit(jax.value_and_grad(jax_cost(task, jnp.float64)))
    jax.block_until_ready(both(jnp.asarray(task["w"])))
    clock = Clock(task)
    steps = [0]

    def fun(w):
        value, gradient = both(w)
        return float(value), np.asarray(gradient)

    def callback(w):
        steps[0] += 1
        if steps[0] % 20 == 0 and not clock.lap(w):
            raise TimeIsUp

    options = dict(maxiter=100_000, maxfun=200_000, maxcor=20, ftol=0, gtol=0)
    try:
        scipy.optimize.minimize(
            fun, task["w"], jac=True, method="L-BFGS-B", callback=callback, options=options
        )
    except TimeIsUp:
        pass
    return clock.rows


def ours(task, *modes, steps=STEPS):
    path = ROOT / "out" / "race.bin"
    path.parent.mkdir(exist_ok=True)
    write(task, path)
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    program = target / "release" / "examples" / "race"
    lines = subprocess.run(
        [program, path, str(steps), *modes], check=True, capture_output=True, text=True
    ).stdout
    return [[float(v) for v in line.split()] for line in lines.splitlines()]


# ---- the race ----------------------------------------------------------------------------------

PROGRAMS = {
    "ours": ours,
    "accelerated": lambda task: ours(task, "accelerate"),
    "warm": lambda task: ours(task, "accelerate", "warm"),
    "warm; f32 products": lambda task: ours(task, "accelerate", "warm", "single"),
    "plain; f32": lambda task: ours(task, "warm", "single"),
    # most steps take a quarter of a full one's time
    "matrices kept": lambda task: ours(task, "warm", "single", "reuse=8", steps=3 * STEPS),
    "accelerated; kept": lambda task: ours(task, "accelerate", "warm", "single", "reuse=8", steps=3 * STEPS),
    "numpy LM": numpy_lm,
    "scipy lm": scipy_lm,
    "jax Adam": jax_adam,
    "jax L-BFGS": jax_lbfgs,
}


def median(runs: list) -> list:
    """Step by step over runs cut to the shortest."""
    length = min(len(run) for run in runs)
    return np.median([run[:length] for run in runs], axis=0).tolist()


def seconds_to(rows: list, error: float) -> float | None:
    """CPU seconds until the training error is at most `error`."""
    return next((t for t, e, _ in rows if e <= error * (1 + 1e-9)), None)


def main(cell: str, out: str, rounds: str = "3", programs: str = "") -> None:
    task = problem(cell)
    named = [name for name in programs.split(",") if name]
    if unknown := set(named) - set(PROGRAMS):
        sys.exit(f"no such program: {', '.join(unknown)}; there are {', '.join(PROGRAMS)}")
    # the levels are numpy LM's
    chosen = {name: PROGRAMS[name] for name in [*named, "numpy LM"]} if named else PROGRAMS
    train, kept = 3 * task["train"], 3 * (len(task["x"]) - task["train"])
    runs = {name: [] for name in chosen}
    for _ in range(int(rounds)):
        for name, program in chosen.items():
            rows = program(task)
            runs[name].append([[t, (a / train) ** 0.5, (b / kept) ** 0.5] for t, a, b in rows])
    medians = {name: median(r) for name, r in runs.items()}
    goals = [medians["numpy LM"][step][1] for step in (20, 40, STEPS)]
    print(f"{task['train']} rows, net {task['sizes']}, {len(task['w'])} weights\n")
    named = " | ".join(f"s to {100 * goal:.2f} %" for goal in goals)
    print(f"| program | {named} | steps | CPU s | trained on % | kept back % | best % |")
    print("|---" * (len(goals) + 6) + "|")
    for name, rows in medians.items():
        times = [seconds_to(rows, goal) for goal in goals]
        shown = " | ".join("never" if t is None else f"{t:.2f}" for t in times)
        best = min(row[2] for row in rows)
        last = f"{len(rows) - 1} | {rows[-1][0]:.2f} | {100 * rows[-1][1]:.2f} | {100 * rows[-1][2]:.2f}"
        print(f"| {name} | {shown} | {last} | {100 * best:.2f} |")
    Path(out).write_text(json.dumps(dict(rows=task["train"], weights=len(task["w"]), medians=medians)))


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4, 5):
        sys.exit(__doc__)
    main(*sys.argv[1:])
