"""Modules of version 0.2 are found under their former names for one version."""

from __future__ import annotations

import sys
from importlib import import_module

import pytest

from tatamu.base.moved import MOVED, RENAMED, present_name


@pytest.mark.filterwarnings("ignore:tatamu[.a-z]* is now")  # of the packages around it
@pytest.mark.parametrize("name", sorted({*MOVED, *RENAMED}))
def test_a_former_name_gives_the_present_module_with_a_warning(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    former = f"tatamu.{name}"
    monkeypatch.delitem(sys.modules, former, raising=False)
    import_module(former.rpartition(".")[0])
    with pytest.warns(FutureWarning, match=rf"{former} is now"):
        found = import_module(former)
    present = import_module(str(present_name(former)))
    assert all(getattr(found, name) is value for name, value in vars(present).items() if not name.startswith("__"))


def test_modules_inside_a_former_package_are_loaded_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "tatamu.disturbances.channels", raising=False)
    with pytest.warns(FutureWarning):
        former = import_module("tatamu.disturbances.channels")
    assert former.CHANNELS is import_module("tatamu.evaluation.disturbances.channels").CHANNELS


def test_a_module_that_never_was_is_not_found() -> None:
    with pytest.raises(ModuleNotFoundError, match="nothing"):
        import_module("tatamu.nothing")
