from collections.abc import Callable
from os import PathLike
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ._native import BadInput as BadInput
from ._native import RrfError as RrfError
from ._native import Table as Table

__version__: str

class ArrowStream(Protocol):
    def __arrow_c_stream__(self, requested_schema: Any = None) -> Any: ...

def bake(
    scene: str | PathLike[str],
    run: str | PathLike[str],
    *,
    progress: Callable[[dict[str, Any]], object] | None = None,
    **settings: Any,
) -> dict[str, Any]: ...
def open(run: str | PathLike[str], *, trust_error: float = 0.5) -> Run: ...

class Run:
    path: str
    def __init__(self, run: str | PathLike[str], trust_error: float = 0.5) -> None: ...
    @property
    def manifest(self) -> dict[str, Any]: ...
    @property
    def cells(self) -> Table: ...
    @property
    def metrics(self) -> Table: ...
    def query(self, table: ArrowStream, *, blend: bool = False) -> Table: ...
    def trace(self, table: ArrowStream, *, spp: int = 256, **options: Any) -> Table: ...
    def render(self, **options: Any) -> npt.NDArray[np.float32]: ...
