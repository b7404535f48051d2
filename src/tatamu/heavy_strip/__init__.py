"""The heavy strip: inextensible cloth in a vertical plane, bent only by its own weight.

Notation: B bending rigidity [N m], w = rho g weight per area [N/m^2], s arc length [m], theta slope [rad]. The strip
takes the shape of minimum energy per width

    E = int  B/2 (d theta/ds)^2 + w z  ds,

so shapes depend only on lengths divided by the bending length l_b = (B / w)^(1/3) (Peirce 1930).

- `cantilever`: clamped at one end, the other hanging free: the heavy elastica, a boundary-value problem.
- `crease`: the loop of a fold whose layers rest on each other, by sequential quadratic programming: 100 links, 40 ms;
  targets of folds are made from it.
- `chain`: the same loop with any number of links and any height between its ends, by augmented Lagrangians; the
  reference of validation, and the shape from which calibration's loop test starts.

The last two are separate on purpose. They discretise the clamps differently (to first and to second order) and find
their minimum by different methods, so each checks the other. With the same number of links they agree to 4e-5 of the
loop's height (tests/test_heavy_strip.py).
"""
