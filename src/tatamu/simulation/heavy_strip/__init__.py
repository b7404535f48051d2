"""Computes the shape of a heavy strip: inextensible cloth in a vertical plane, bent only by its own weight.

The bending rigidity of the strip is B [N m], and its weight per area is w = rho g [N/m^2]. At the arc length s [m], the
strip has the slope theta [rad] and the height z [m]. Its shape has the minimum energy per width:

    E = int  B/2 (d theta/ds)^2 + w z  ds.

Therefore the shape depends only on lengths in units of the bending length l_b = (B / w)^(1/3) (Peirce 1930). The
modules compute different shapes:

- `cantilever`: The strip is clamped at one end, and the other end hangs free. This is a boundary-value problem.
- `crease`: The strip makes the loop of a fold whose layers rest on each other. The method is sequential quadratic
  programming, which takes 40 ms for 100 links. Targets of folds are made from this shape.
- `chain`: The strip makes the loop with any number of links and any height between its ends. The method is augmented
  Lagrangians. Validation compares simulations with this shape, and calibration's loop test starts from this shape.

The modules `crease` and `chain` are separate on purpose, because each module checks the other. `crease` discretises the
clamps to first order, `chain` to second order. The two modules also find the minimum by different methods. With the
same number of links, their loops agree to 4e-5 of the loop's height (tests/test_heavy_strip.py).
"""
