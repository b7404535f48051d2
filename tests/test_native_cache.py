"""Compiled kernels are forgotten when a source that they contain has changed, and only then."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from numba import njit, typeof, types

import tatamu.simulation.native
from tatamu.simulation.native import among_bodies, compiled, precompile, prepare
from tatamu.simulation.native.addresses import Addresses
from tatamu.simulation.native.compiled import NATIVE, compilation, expect, forget_stale_kernels, types_taken
from tatamu.simulation.native.contact import broad_phase
from tatamu.simulation.native.kernels import Features, arguments, kernels
from tatamu.simulation.native.precompile import compile_beside, smallest_scene
from tatamu.simulation.native.simulation import Simulation
from tatamu.simulation.native.step import advance
from tatamu.simulation.native.system import Span


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Sources in two rooms, each with a compiled kernel."""
    (tmp_path / "step.py").write_text("calls = 'contact'")
    (tmp_path / "contact").mkdir()
    (tmp_path / "contact" / "table.py").write_text("friction = 1")
    forget_stale_kernels(tmp_path)
    for kernel in _kernels(tmp_path):
        kernel.parent.mkdir(exist_ok=True)
        kernel.write_text("compiled")
    return tmp_path


def _kernels(folder: Path) -> list[Path]:
    return [folder / "__pycache__" / "step.nbi", folder / "contact" / "__pycache__" / "table.1.nbc"]


def test_kernels_of_the_same_sources_are_kept(folder: Path) -> None:
    forget_stale_kernels(folder)
    assert all(kernel.exists() for kernel in _kernels(folder))


@pytest.mark.parametrize("source", ["step.py", "contact/table.py"])
def test_kernels_of_all_rooms_are_forgotten_when_a_file_of_any_changes(folder: Path, source: str) -> None:
    (folder / source).write_text("friction = 2")
    forget_stale_kernels(folder)
    assert not any(kernel.exists() for kernel in _kernels(folder))


def test_kernels_are_forgotten_when_a_file_moves_to_another_room(folder: Path) -> None:
    (folder / "contact" / "table.py").rename(folder / "contact.py")
    forget_stale_kernels(folder)
    assert not any(kernel.exists() for kernel in _kernels(folder))


def test_the_folder_that_is_looked_at_is_that_of_the_simulator() -> None:
    assert Path(tatamu.simulation.native.__file__).parent == NATIVE
    assert {"contact", "elastic", "bodies"} <= {file.parent.name for file in NATIVE.rglob("*.py")}


EVERYTHING = Features(friction=True, wrinkles=True, air=True, bodies=True)


@pytest.mark.slow
def test_kernels_are_compiled_for_the_types_with_which_the_time_steps_call_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Code at an address reads its arguments without a test of their types."""
    called = set()

    def taken(given: Any) -> tuple[Any, ...]:
        called.add(tuple(map(types.unliteral, given)))
        return types_taken(given)

    monkeypatch.setattr(compiled, "types_taken", taken)
    simulation = Simulation(smallest_scene())
    system = simulation.system
    contact = (system.mesh, system.contact, system.options, system.kernels)
    callers = {
        advance: (system, simulation._grippers.hands(), simulation._latest, Span(0, 0, 1)),
        broad_phase.refresh: (system.state.positions, *contact),
        broad_phase.search: (system.state.positions.x, *contact),
        among_bodies.meet: (system, 0, 0, 0),
    }
    for caller, given in callers.items():
        njit(error_model="numpy")(caller.py_func).compile(tuple(map(typeof, given)))
    assert called == {tuple(map(typeof, given)) for given in arguments(system).values()}


@pytest.mark.parametrize("feature", [None, *Features._fields])
def test_a_scene_needs_the_kernels_of_its_features_alone(feature: str | None) -> None:
    plain = set(kernels(Features(False, False, False, False)).values())
    needed = kernels(Features(*(name == feature for name in Features._fields)))
    assert (set(needed.values()) == plain) == (feature is None)
    assert not set(kernels(EVERYTHING)) - set(Addresses._fields)


def test_there_is_no_second_process_where_kernels_are_on_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    prepare()
    monkeypatch.setattr(precompile, "_loaded", set())
    monkeypatch.setattr(subprocess, "Popen", None)
    prepare()


def test_a_second_process_that_fails_is_made_up_for_here(monkeypatch: pytest.MonkeyPatch) -> None:
    prepare()
    monkeypatch.setattr(precompile, "COMMAND", "raise SystemExit(1)")
    monkeypatch.setattr(precompile, "processors", lambda: 2)
    monkeypatch.setattr(precompile, "is_on_disk", lambda kernel: False)
    monkeypatch.setattr(precompile, "_loaded", set())
    begun = []

    class Noted(subprocess.Popen[bytes]):
        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options)
            begun.append(self)

    monkeypatch.setattr(subprocess, "Popen", Noted)
    prepare()
    assert len(begun) == 1 and begun[0].returncode is not None


def test_the_share_of_another_process_is_all_kernels_in_another_order(monkeypatch: pytest.MonkeyPatch) -> None:
    share: list[Any] = []
    monkeypatch.setattr(precompile, "address_of", lambda kernel, arguments: share.append(kernel))
    shares = []
    for number in range(3):
        share.clear()
        compile_beside(*EVERYTHING, number, 3)
        shares.append(list(share))
    needed = list(kernels(EVERYTHING).values())
    assert shares[0] == needed[::-1]
    assert [set(each) for each in shares] == 3 * [set(needed)] and len({each[0] for each in shares}) == 3


def test_what_is_told_of_compiling_counts_what_is_on_disk_and_only_where_this_process_compiles(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    prepare()
    needed = [advance, *kernels(Features(False, False, False, False)).values()]
    expect([fake(each, misses=1) for each in needed])
    done, total = compilation()
    assert done == total > 50
    monkeypatch.setattr(compiled, "_EXPECTED", [fake(each, misses=0) for each in needed])
    assert compilation() == (0, len(needed))


def fake(kernel: Any, misses: int) -> Any:
    """A kernel that says that it was not on disk so many times."""
    stats = SimpleNamespace(cache_path=kernel.stats.cache_path, cache_misses={"signature": misses} if misses else {})
    return SimpleNamespace(py_func=kernel.py_func, __name__=kernel.__name__, stats=stats)


@pytest.mark.slow
@pytest.mark.parametrize("processor", ["x86-64-v3", "x86-64-v2"])
def test_kernels_for_other_processors_make_the_same_bytes(processor: str, tmp_path: Path) -> None:
    script = (
        "import hashlib; from tatamu.simulation.native import simulate;"
        "from tests.physics.checks.tangle import LIMP;"
        "from tests.physics.manipulations import RandomFold, scene_of;"
        "rollout = simulate(scene_of(RandomFold.random(300, True), LIMP, 0.012));"
        "print(hashlib.sha256(rollout.positions.tobytes()).hexdigest())"
    )

    def digest(**variables: str) -> str:
        done = subprocess.run(
            [sys.executable, "-c", script], env=os.environ | variables, capture_output=True, text=True, check=True
        )
        return done.stdout.strip()

    assert digest(NUMBA_CPU_NAME=processor, NUMBA_CACHE_DIR=str(tmp_path)) == digest() != ""
