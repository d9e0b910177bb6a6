from collections.abc import Callable, Iterable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypedDict, overload

import numpy
from numpy.typing import ArrayLike, DTypeLike, NDArray
from typing_extensions import Unpack

_Path = str | PathLike[str]
_Triple = Sequence[float]
_Progress = Callable[[str, int, int], object]
_Fill = Callable[[int, tuple[int, int, int], tuple[int, int, int]], ArrayLike]

class Error(RuntimeError):
    kind: Literal['input', 'request', 'memory', 'system']

class Cancelled(RuntimeError): ...

# The build fills in the keywords that the module takes (python/write_stubs.py).
class VolumeOptions(TypedDict, total=False): ...
class PictureOptions(TypedDict, total=False): ...

def open(
    path: _Path | Iterable[_Path],
    *,
    time: int = ...,
    whole_series: bool = ...,
    opens_soon: bool = ...,
    index_dir: _Path | None = ...,
    levels: Literal['auto', 'always', 'kept', 'none'] | None = ...,
    cache: int | str | None = ...,
    cache_dir: _Path | None = ...,
    block: int | None = ...,
    page: Sequence[int] | None = ...,
    memory: int | str | None = ...,
    threads: int | None = ...,
    progress: _Progress | None = ...,
    **options: Unpack[VolumeOptions],
) -> Volume: ...
def from_array(
    array: Any,
    *,
    spacing: _Triple = ...,
    origin: _Triple = ...,
    unit: str = ...,
    name: str = ...,
    memory: int | str | None = ...,
    threads: int | None = ...,
    progress: _Progress | None = ...,
) -> Volume: ...
def from_function(
    fill: _Fill,
    shape: Sequence[int],
    dtype: DTypeLike,
    *,
    spacing: _Triple = ...,
    origin: _Triple = ...,
    unit: str = ...,
    name: str = ...,
    memory: int | str | None = ...,
    threads: int | None = ...,
    progress: _Progress | None = ...,
) -> Volume: ...
def simulate(
    trace: _Path,
    *,
    policies: Sequence[str] | None = ...,
    sizes: Sequence[int] | None = ...,
    format: Literal['text', 'binary', 'csv', 'oracleGeneral', 'din'] | None = ...,
    page_bytes: int = ...,
    pin: bool = ...,
) -> dict[str, NDArray[Any]]: ...

class _Draws:
    @overload
    def render(
        self, *, depth: Literal[True], progress: _Progress | None = ..., **options: Unpack[PictureOptions]
    ) -> tuple[NDArray[numpy.uint8], NDArray[numpy.float32]]: ...
    @overload
    def render(
        self, *, depth: Literal[False] = ..., progress: _Progress | None = ..., **options: Unpack[PictureOptions]
    ) -> NDArray[numpy.uint8]: ...
    def save(
        self, path: _Path, *, progress: _Progress | None = ..., **options: Unpack[PictureOptions]
    ) -> None: ...
    def plan(self, *, progress: _Progress | None = ..., **options: Unpack[PictureOptions]) -> dict[str, Any]: ...
    def slice(
        self, axis: Literal['x', 'y', 'z'], at: int, *, time: int = ..., most: int = ...
    ) -> NDArray[numpy.float32]: ...
    def probe(self, right: float, down: float, **options: Unpack[PictureOptions]) -> dict[str, Any] | None: ...

class Volume(_Draws):
    @property
    def info(self) -> dict[str, Any]: ...
    @property
    def name(self) -> str: ...
    @property
    def dims(self) -> tuple[int, int, int]: ...
    @property
    def shape(self) -> tuple[int, ...]: ...
    @property
    def dtype(self) -> numpy.dtype[Any]: ...
    @property
    def spacing(self) -> tuple[float, float, float]: ...
    @property
    def time_steps(self) -> int: ...
    @property
    def value_range(self) -> tuple[float, float]: ...
    def widget(self, **options: Unpack[PictureOptions]) -> Any: ...
    def histogram(self, bins: int = ...) -> tuple[NDArray[numpy.uint64], NDArray[numpy.float64]]: ...

class Renderer(_Draws):
    def __init__(
        self,
        volume: Volume,
        *,
        device: Literal['auto', 'gl', 'cpu'] = ...,
        memory: int | str | None = ...,
        threads: int | None = ...,
        algorithm: Literal['conventional', 'clipped', 'trimmed', 'merged'] | None = ...,
        merge: Literal['paper', 'first-fit'] | None = ...,
        partition: Literal['blocks', 'boxes'] | None = ...,
        occlusion: Literal['off', 'map', 'cull', 'clip'] | None = ...,
        policy: str | None = ...,
        seed: int | None = ...,
        pages: int | None = ...,
        simd: Literal['auto', 'plain', 'sse4', 'avx2', 'avx512'] | None = ...,
        gl: Literal['auto', 'osmesa', 'egl'] | None = ...,
    ) -> None: ...
    @property
    def look(self) -> str: ...
    @property
    def device(self) -> str: ...
    def record_to(self, path: _Path | None) -> None: ...
    def report(self) -> dict[str, Any]: ...
