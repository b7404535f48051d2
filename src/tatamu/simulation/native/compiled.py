"""Compilation of kernels by numba. Their code is kept on disk.

Without fast-math, products and sums are not reordered or fused, so two rollouts of a scene have equal bytes. With
numpy's error model, a division by zero gives an infinity, because checks for exceptions would prevent vectorised loops.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from hashlib import blake2b
from pathlib import Path
from types import ModuleType
from typing import Any

from numba import njit, typeof, types
from numba.extending import intrinsic

NATIVE = Path(__file__).parent
"""Folder of all kernels."""
_KERNELS: list[Any] = []
"""All functions that numba compiles separately, as its dispatchers."""
_EXPECTED: list[Any] = []
"""The kernels of `expect`."""


def _compiler(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles functions and records them."""
    compiler = njit(cache=True, error_model="numpy", **options)

    def compiled(function: Callable[..., Any]) -> Any:
        _KERNELS.append(compiler(function))
        return _KERNELS[-1]

    return compiled


kernel = _compiler(_nrt=False)
"""Decorator of a function that makes no arrays, and so does not count references to arrays. Counting takes a third of
the time for compiling, and makes simulations in several threads wait for one another."""
allocating = _compiler(_nrt=True)
"""Decorator of a function that makes arrays."""
inlined = njit(cache=True, error_model="numpy", inline="always")
"""Decorator of a function that is always inlined: a loop may be vectorised only then, and a function with many records
as arguments and a single caller would otherwise be compiled twice."""
unlocked = _compiler(nogil=True, _nrt=False)
"""Decorator of the outermost loop of a simulation, during which other Python threads can run."""


def address_of(kernel: Any, arguments: tuple[Any, ...]) -> int:
    """Return the address of a kernel's compiled code for arguments of these types, for `call`."""
    signature = tuple(map(typeof, arguments))
    kernel.compile(signature)
    compiled = kernel.overloads[signature]
    return int(compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name))


def types_taken(arguments: Any) -> tuple[Any, ...]:
    """Return the types for which a kernel must be compiled that `call` calls with a tuple of this type."""
    return tuple(map(types.unliteral, arguments))


def _call(typing: Any, address: Any, result: Any, arguments: Any) -> Any:
    """Call the kernel at an address, with arguments that have exactly the types it was compiled for.

    A kernel that is called by its name is compiled again for each caller of callers. By its address, it is compiled
    once, and only if a scene needs it. `result` is the type of the result, such as `types.float64`, or None.
    """
    returned = result.instance_type if isinstance(result, types.NumberClass) else types.none
    taken = types_taken(arguments)

    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        convention = context.call_conv
        pointer = convention.get_function_type(returned, taken).as_pointer()
        given = [builder.extract_value(values[2], number) for number in range(len(taken))]
        kernel = builder.inttoptr(values[0], pointer)
        return convention.call_function(builder, kernel, returned, taken, given)[1]

    return returned(types.int64, result, arguments), generate


call: Any = intrinsic(_call)


def for_types_of(kernel: Any, arguments: tuple[Any, ...]) -> Callable[..., Any]:
    """Return a kernel's compiled code for arguments of these types, which does not check the types.

    For a scene with its hundred arrays, the checks of a kernel take a hundred microseconds in every call.
    """
    code: Callable[..., Any] = kernel.compile(tuple(map(typeof, arguments)))
    return code


def is_on_disk(kernel: Any) -> bool:
    """Return whether compiled code of a kernel is on disk, or cannot be written to disk."""
    folder = kernel.stats.cache_path
    name = f"{kernel.py_func.__module__.rpartition('.')[2]}.{kernel.__name__}-*.nbi"
    return folder is None or any(Path(folder).glob(name))


def expect(kernels: Iterable[Any]) -> None:
    """Tell `compilation` that these kernels, and all that they call, are being compiled unless they are on disk."""
    found = list(kernels)
    for kernel in found:
        found += [each for each in _called(kernel.py_func) if each not in found]
    _EXPECTED[:] = found


def compilation() -> tuple[int, int]:
    """Return the number of kernels on disk, 0 if this process had to compile none, and of all that are needed.

    Files on disk are counted, because other processes may compile kernels at the same time (`precompile`).
    """
    expected = list(_EXPECTED)
    if not any(each.stats.cache_misses for each in expected):
        return 0, len(expected)
    return sum(map(is_on_disk, expected)), len(expected)


def _called(function: Any) -> list[Any]:
    """Return the kernels whose names a function uses, for example `sweep` or `table.sweep`."""
    own = function.__globals__
    others = [vars(each) for each in own.values() if isinstance(each, ModuleType) and "tatamu" in each.__name__]
    names = function.__code__.co_names
    found = [own[name] for name in names if name in own]
    found += [other[name] for other in others for name in names if name in other and not name.startswith("_")]
    return [each for each in found if each in _KERNELS]


def forget_stale_kernels(folder: Path = NATIVE) -> None:
    """Remove compiled functions if a source file in a folder has changed since; leave a read-only folder as it is.

    Numba only checks the file of a function, but compiled code also contains functions of other files that it calls.
    The topmost `__pycache__` therefore has a digest of the paths and contents of all source files.
    """
    digest = blake2b(digest_size=16)
    for source in sorted(folder.rglob("*.py")):
        digest.update(source.relative_to(folder).as_posix().encode() + source.read_bytes())
    stamp = digest.hexdigest()
    mark = folder / "__pycache__" / "kernels.txt"
    try:
        if mark.exists() and mark.read_text() == stamp:
            return
        for cache in folder.rglob("__pycache__"):
            for kernel in [*cache.glob("*.nbi"), *cache.glob("*.nbc")]:
                kernel.unlink(missing_ok=True)
        mark.parent.mkdir(exist_ok=True)
        mark.write_text(stamp)
    except OSError:
        return
