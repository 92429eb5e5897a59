"""Error against CPU seconds: this trainer and other people's on one net, one cell, one start.

    training.py CELL.f32 OUT.json [ROUNDS [PROGRAM,... [SECONDS]]]      (a cell from export_cells.py)

A 20-10 net, the cell's rows split 70 : 30, squared errors relative to the target's luminance, the
same first weights for all. Each program runs on one thread, its own CPU time is
counted, without the time for judging and for compiling. Programs take turns, ROUNDS times (3);
the medians are kept, step by step. Every program ends after its steps or SECONDS of CPU (5).

  ours          examples/race of rrf-train
  accelerated   the same with geodesic acceleration
  warm          the same, its first 12 steps on a quarter of the rows; also with JᵀJ multiplied from f32
  plain; f32    that without acceleration
  matrices kept that with a new matrix each eighth step, conjugate gradients between; also accelerated
  numpy LM      Jacobian by backpropagation, gemm, Cholesky, damping times or over ten
  scipy lm      scipy.optimize.least_squares(method="lm"), MINPACK, the same analytic Jacobian
  jax Adam      float32, batches of 256 in random order, rate 3e-3 falling to 0 as a cosine
  jax L-BFGS    scipy's L-BFGS-B on jax's float64 gradients, 20 pairs
  optimistix    its LevenbergMarquardt on jax's float64, normal equations by lineax's Cholesky; its default, QR,
                as "optimistix QR"
  torch LM      torch-levenberg-marquardt, float64, all rows a step, Cholesky, its defaults else
  torch SOAP    heavyball's SOAP, float32, batches of 256 in random order, rate 3e-3 falling to 0 as a cosine

The torch programs run only if they are named: tests/peers/requirements-torch.txt is a download of gigabytes.
"""

import json
import os
import subprocess
import sys
from pathlib import Path

from training_task import ROOT, STEPS, Clock, forward, jacobian, problem, residuals, write  # isort: skip

import jax
import jax.numpy as jnp
import numpy as np
import scipy.linalg
import scipy.optimize
from training_libraries import optimistix_cholesky, optimistix_lm, torch_lm, torch_soap


# ---- the programs ------------------------------------------------------------------------------


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
    "optimistix": optimistix_cholesky,
    "optimistix QR": optimistix_lm,
}
ON_DEMAND = {"torch LM": torch_lm, "torch SOAP": torch_soap}


def median(runs: list) -> list:
    """Step by step over runs cut to the shortest."""
    length = min(len(run) for run in runs)
    return np.median([run[:length] for run in runs], axis=0).tolist()


def seconds_to(rows: list, error: float) -> float | None:
    """CPU seconds until the training error is at most `error`."""
    return next((t for t, e, _ in rows if e <= error * (1 + 1e-9)), None)


def main(cell: str, out: str, rounds: str = "3", programs: str = "", seconds: str = "5") -> None:
    Clock.most = float(seconds)
    task = problem(cell)
    named = [name for name in programs.split(",") if name]
    known = PROGRAMS | ON_DEMAND
    if unknown := set(named) - set(known):
        sys.exit(f"no such program: {', '.join(unknown)}; there are {', '.join(known)}")
    # the levels are numpy LM's
    chosen = {name: known[name] for name in [*named, "numpy LM"]} if named else PROGRAMS
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
    if len(sys.argv) not in (3, 4, 5, 6):
        sys.exit(__doc__)
    main(*sys.argv[1:])
