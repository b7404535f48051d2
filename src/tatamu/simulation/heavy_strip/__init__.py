"""Computes the shape of a heavy strip: inextensible cloth in a vertical plane, bent only by its own weight.

The bending rigidity of the strip is B [N m], and its weight per area is w = rho g [N/m^2]. At the arc length s [m], the
strip has the slope theta [rad] and the height z [m]. Its shape has the minimum energy per width:

    E = int  B/2 (d theta/ds)^2 + w z  ds.

So the shape depends only on lengths in units of the bending length l_b = (B / w)^(1/3) (Peirce 1930).

- `cantilever`: one end is clamped, and the other hangs free: a boundary-value problem.
- `crease`: the loop of a fold whose layers rest on each other, by sequential quadratic programming in 40 ms. Targets of
  folds are made from it. `tests/physics/chain.py` finds the same loop to 4e-5 of its height by another method.
"""
