"""Fabrics that garments are made of unless told otherwise."""

from tatamu.material import Material

TERRY = Material(
    areal_density=0.35,
    stretch_stiffness=260.0,
    poisson_ratio=0.25,
    bending_rigidity=6e-5,
    thickness=0.002,
    friction_table=0.55,
    friction_cloth=0.6,
    air_drag=0.1,
)
"""Terry cotton of a light towel.

areal_density: light terry is sold at 300 to 400 g/m^2 (retail pages).
stretch_stiffness: woven cotton, 0.821 MPa x 0.318 mm = 261 N/m (Penava 2014); terry itself: no figure
    found, assumed alike.
poisson_ratio: the same woven cotton, 0.243, rounded.
bending_rigidity: assumed. Measured blankets and towels-like fabrics span 36 to 299 uN m (Wang et al. 2011, polyester
    blanket); 60 uN m gives a bending length of 2.6 cm, within the 1.7 to 3.4 cm of measured fabrics.
thickness: assumed, pile pressed flat.
friction_table: the paper's Table II, towel: friction 55, that is mu = 0.55.
friction_cloth: assumed, between the 0.4 and 1.0 used for cloth on cloth.
air_drag: assumed, small: a wave on the towel dies out within a few seconds.
"""
