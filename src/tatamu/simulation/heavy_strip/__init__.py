"""Shapes of a heavy strip: inextensible cloth in a vertical plane, bent only by its own weight.

Let B be the bending rigidity [N m], w = rho g the weight per area [N/m^2], s the arc length, theta the slope and z the
height. The shape has the minimum energy per width, so it depends only on lengths in units of the bending length
l_b = (B / w)^(1/3) (Peirce 1930):

    E = int  B/2 (d theta/ds)^2 + w z  ds
"""
