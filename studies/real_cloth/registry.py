"""Lists all tests on real cloth, in the order of the notes. To add a test, write a module and add it to this list."""

from __future__ import annotations

from studies.real_cloth.leeds import Leeds
from studies.real_cloth.matsudaira import Matsudaira
from studies.real_cloth.motion import SwungCloth
from studies.real_cloth.test import RealTest
from studies.real_cloth.towel import Towel

TESTS: dict[str, RealTest] = {test.name: test for test in (Matsudaira(), Leeds(), SwungCloth(), Towel())}
"""Tests on real cloth, by their names."""
