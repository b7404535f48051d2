"""Simulated instruments that measure cloth.

- `drapemeter` makes the scene of a disc of cloth that hangs over a round plate.
- `outline` reads the outline of a draped disc from above: drape coefficient and nodes.
- `oscillation` reads the periods and decrements of a signal that swings freely.

These modules do not depend on a simulator.
"""
