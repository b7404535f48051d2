"""Compilation of kernels by numba, without fast-math. A kernel is a compiled function. Compiled code is kept on disk.

Without fast-math, the compiler does not reorder or fuse products and sums. Therefore two rollouts of the same scene
have exactly equal bytes. Numpy's error model is used. With this model, a division by zero gives an infinity and not an
exception. Checks for exceptions would prevent loops from computing eight numbers at a time. The indices of arrays are
not checked either (`boundscheck` is off).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from types import ModuleType
from typing import Any

from numba import njit, typeof, types
from numba.extending import intrinsic

_KERNELS: list[Any] = []
"""All functions that numba compiles separately, as the dispatcher objects that numba makes of them."""
_EXPECTED: list[Any] = []
"""The kernels of `expect`."""


def _compiler(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator that compiles functions and records them in a list."""
    compiler = njit(cache=True, error_model="numpy", **options)

    def compiled(function: Callable[..., Any]) -> Any:
        _KERNELS.append(compiler(function))
        return _KERNELS[-1]

    return compiled


kernel = _compiler(_nrt=False)
"""Decorator that compiles a function that makes no arrays.

Such a function does not count references to arrays. Counting takes a third of the time for compiling, and simulations
in several threads would wait for one another's counts."""
allocating = _compiler(_nrt=True)
"""Decorator that compiles a function that makes arrays."""
inlined = njit(cache=True, error_model="numpy", inline="always")
"""Decorator that compiles a function and always inlines it.

There are two reasons for inlining. Some loops that call a function can be vectorised only if the function is inlined.
The other reason is the time for compiling. A function that is called at only one place, and has many records as
arguments, would be compiled twice if it were not inlined.
"""
unlocked = _compiler(nogil=True, _nrt=False)
"""Decorator that compiles the outermost loop of a simulation. Other Python threads can run during this loop."""


def address_of(kernel: Any, arguments: tuple[Any, ...]) -> int:
    """Return the address in memory of a kernel's compiled code for arguments of these types, for `call`."""
    signature = tuple(map(typeof, arguments))
    kernel.compile(signature)
    compiled = kernel.overloads[signature]
    return int(compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name))


def types_taken(arguments: Any) -> tuple[Any, ...]:
    """Return the types for which a kernel must be compiled that `call` calls with a tuple of this type."""
    return tuple(map(types.unliteral, arguments))


def _call(typing: Any, address: Any, result: Any, arguments: Any) -> Any:
    """Call the kernel at an address, with a tuple of arguments that have exactly the types it was compiled for.

    A kernel that is called by its name becomes a part of its caller, so the compiler works on it once more for each
    caller of callers. A kernel that is called by its address is compiled once, and only if a scene needs it.

    Args:
        typing: The context of numba.
        address: The address from `address_of`.
        result: The type of the result, such as `types.float64`, or None.
        arguments: The arguments.
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
"""Calls the kernel at an address, see `_call`."""


def for_types_of(kernel: Any, arguments: tuple[Any, ...]) -> Callable[..., Any]:
    """Return a kernel's compiled code for arguments of these types. The kernel is compiled if necessary.

    In every call, a kernel checks the types of all arguments. For a scene with its hundred arrays, this takes a hundred
    microseconds. The returned code does not check the types, so it must not be called with arguments of other types.
    """
    code: Callable[..., Any] = kernel.compile(tuple(map(typeof, arguments)))
    return code


def is_on_disk(kernel: Any) -> bool:
    """Return whether compiled code of a kernel is on disk. If it cannot be written to disk, it counts as on disk."""
    folder = kernel.stats.cache_path
    return folder is None or any(Path(folder).glob(f"{_name(kernel)}-*.nbi"))


def expect(kernels: Iterable[Any]) -> None:
    """Tell `compilation` that these kernels, and all that they call, are being compiled unless they are on disk."""
    found = list(kernels)
    for kernel in found:
        found += [each for each in _called(kernel.py_func) if each not in found]
    _EXPECTED[:] = found


def compilation() -> tuple[int, int]:
    """Return the progress of compilation: the number of kernels on disk, and of all that are needed.

    The first number is 0 if this process did not have to compile any kernel. Files on disk are counted, because other
    processes may compile kernels at the same time (`precompile`).
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


def _name(kernel: Any) -> str:
    """Return the beginning of the file name of a kernel on disk."""
    return f"{kernel.py_func.__module__.rpartition('.')[2]}.{kernel.__name__}"
