"""Trainers of other libraries for the race in training.py: optimistix, torch-levenberg-marquardt and heavyball's SOAP.

Each library is imported by its own function, because torch is a download of gigabytes.
"""

from training_task import STEPS, Clock, forward, unpack  # isort: skip

import jax
import jax.numpy as jnp
import numpy as np


def optimistix_lm(task, **solver):
    """Step by step, as `optimistix.least_squares` does it within one compiled loop."""
    import equinox as eqx
    import optimistix as optx

    part, sizes = slice(0, task["train"]), task["sizes"]
    x, y, s = (jnp.asarray(task[k][part]) for k in "xys")

    def residual(w, _):
        out = forward(w, x, sizes, jnp)[-1]
        return (s * (out - y)).ravel()

    def fn(w, _):
        return residual(w, None), None

    method = optx.LevenbergMarquardt(rtol=1e-12, atol=1e-12, **solver)
    w = jnp.asarray(task["w"])
    shape = jax.eval_shape(lambda: fn(w, None)[0])
    common = dict(args=None, options={}, tags=frozenset())
    state = method.init(fn, w, None, {}, shape, None, frozenset())
    step = eqx.filter_jit(lambda w, state: method.step(fn, w, state=state, **common)[:2])
    jax.block_until_ready(step(w, state)[0])
    clock = Clock(task)
    for _ in range(STEPS):
        w, state = step(w, state)
        jax.block_until_ready(w)
        # what it returns as the trial is the accepted point once the step is taken
        if not clock.lap(w):
            break
    return clock.rows


def optimistix_cholesky(task):
    import lineax

    return optimistix_lm(task, linear_solver=lineax.Normal(lineax.Cholesky()))


def torch_net(task, dtype):
    """The net as torch modules with the task's first weights, and its rows as tensors."""
    import torch

    torch.set_num_threads(1)
    layers = []
    for bias, matrix in unpack(task["w"], task["sizes"]):
        linear = torch.nn.Linear(matrix.shape[1], matrix.shape[0], dtype=dtype)
        with torch.no_grad():
            linear.weight.copy_(torch.from_numpy(matrix.copy()))
            linear.bias.copy_(torch.from_numpy(bias.copy()))
        layers += [linear, torch.nn.Tanh()]
    part = slice(0, task["train"])
    return torch.nn.Sequential(*layers[:-1]), [torch.tensor(task[k][part], dtype=dtype) for k in "xys"]


def torch_weights(net):
    """The net's weights in the task's order."""
    pairs = [[values.detach().numpy() for values in (layer.bias, layer.weight)] for layer in net[::2]]
    return np.concatenate([np.hstack([bias[:, None], matrix]).ravel() for bias, matrix in pairs])


def torch_lm(task):
    import torch
    import torch_levenberg_marquardt as tlm

    net, (x, y, s) = torch_net(task, torch.float64)

    class Weighed(torch.nn.Module):
        """The residuals' weights are part of the model: s Φ(x) is fitted to s y."""

        def __init__(self):
            super().__init__()
            self.net = net

        def forward(self, both):
            return both[:, -3:] * self.net(both[:, :-3])

    inputs, targets = torch.cat([x, s], 1), s * y
    module = tlm.training.LevenbergMarquardtModule(model=Weighed(), loss_fn=tlm.loss.MSELoss(), solve_method="cholesky")
    clock = Clock(task)
    for _ in range(STEPS):
        _, _, stop, _ = module.training_step(inputs, targets)
        if not clock.lap(torch_weights(net)) or bool(stop):
            break
    return clock.rows


def torch_soap(task, batch=256, rate=3e-3, epochs=1200):
    import heavyball
    import torch

    # compiling each small step takes longer than the race
    heavyball.utils.compile_mode = None
    torch.manual_seed(3)
    net, (x, y, s) = torch_net(task, torch.float32)
    optimizer = heavyball.SOAP(net.parameters(), lr=rate)
    batches = task["train"] // batch
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimizer, epochs * batches)
    clock = Clock(task)
    for epoch in range(epochs):
        for rows in torch.randperm(task["train"])[: batches * batch].reshape(batches, batch):
            loss = ((s[rows] * (net(x[rows]) - y[rows])) ** 2).mean()
            loss.backward()
            optimizer.step()
            optimizer.zero_grad()
            schedule.step()
        if epoch % 5 == 4 and not clock.lap(torch_weights(net)):
            break
    return clock.rows
