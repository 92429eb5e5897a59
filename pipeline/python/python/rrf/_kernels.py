"""The kernels of the linear algebra library, which it chooses when it is loaded."""

import contextlib
import os
import platform


@contextlib.contextmanager
def fixed_kernels():
    """While the library is loaded: one thread and, where the processor has AVX2 and FMA, Haswell's kernels, as the
    program `rrf` uses. Bakes then have its bytes. A library that another package has loaded keeps what it has."""
    wanted = {"OPENBLAS_NUM_THREADS": "1"}
    if platform.machine() == "x86_64" and {"avx2", "fma"} <= _processor_flags():
        wanted["OPENBLAS_CORETYPE"] = "Haswell"
    own = {name: os.environ.get(name) for name in wanted}
    os.environ.update(wanted)
    try:
        yield
    finally:
        for name, value in own.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _processor_flags():
    """Instruction sets of the processor, as Linux names them; none on another system."""
    try:
        with open("/proc/cpuinfo", encoding="ascii", errors="replace") as lines:
            flags = next((line for line in lines if line.startswith("flags")), "")
    except OSError:
        return set()
    return set(flags.split())
