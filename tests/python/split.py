"""Which rows of a run are held out."""

import numpy as np


def held_out(seed, index):
    """As pipeline/bake/src/policy/held_out.rs, by pipeline/sampling/src/hash.rs."""
    with np.errstate(over="ignore"):
        z = np.uint64(seed) ^ (index * np.uint64(0x9E3779B97F4A7C15))
        z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        return (z ^ (z >> np.uint64(31))) < np.uint64(((1 << 64) - 1) // 10 * 3)
