"""All tests on real cloth, in the order of the notes; a further one is a module of its own and a name here."""

from __future__ import annotations

from tatamu.validation.real.leeds import Leeds
from tatamu.validation.real.matsudaira import Matsudaira
from tatamu.validation.real.motion import SwungCloth
from tatamu.validation.real.test import RealTest
from tatamu.validation.real.towel import Towel

TESTS: dict[str, RealTest] = {test.name: test for test in (Matsudaira(), Leeds(), SwungCloth(), Towel())}
"""Name to test."""
