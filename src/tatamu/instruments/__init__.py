"""Instruments that measure cloth, as scenes and readings; validation and calibration share them.

- `outline`: a draped disc seen from above: drape coefficient, nodes, amplitude, wavelength, harmonics;
- `drapemeter`: the drapemeter: a disc of cloth over a round plate;
- `oscillation`: periods and decrements of a signal that swings freely.

They do not depend on a simulator.
"""
