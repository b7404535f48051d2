"""Simulated instruments that measure cloth, which validation and calibration use.

- `drapemeter` makes the scene of a disc of cloth that hangs over a round plate.
- `outline` reads the outline of a draped disc from above: drape coefficient, nodes, amplitude, wavelength, harmonics.
- `oscillation` reads the periods and decrements of a signal that swings freely.

These modules do not depend on a simulator.
"""
