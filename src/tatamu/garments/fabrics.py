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

JERSEY = Material(
    areal_density=0.187,
    stretch_stiffness=93.0,
    poisson_ratio=0.25,
    bending_rigidity=2.4e-5,
    thickness=0.001,
    friction_table=0.8,
    friction_cloth=0.6,
    air_drag=0.1,
)
"""Cotton jersey of a T-shirt.

areal_density, bending_rigidity: interlock of a T-shirt, 187 g/m^2 and 23.2 and 24.7 uN m along and across at small
    curvature (Wang, O'Brien, Ramamoorthi 2011); bending length 2.4 cm.
stretch_stiffness: chosen within what the same interlock was measured at, 17 to 140 N/m along and 34 to 414 N/m across;
    the paper's Table II for its T-shirt amounts to 116 N/m (docs/reproduction.md).
poisson_ratio: as for woven cotton; knits have more, which no source gives.
thickness: assumed; the paper does not say.
friction_table: the paper's Table II, T-shirt: friction 80, that is mu = 0.8.
friction_cloth, air_drag: assumed, as for terry.
"""

DENIM = Material(
    areal_density=0.324,
    stretch_stiffness=210.0,
    poisson_ratio=0.25,
    bending_rigidity=7e-5,
    thickness=0.001,
    friction_table=0.8,
    friction_cloth=0.6,
    air_drag=0.1,
)
"""Denim of trousers.

areal_density, stretch_stiffness, bending_rigidity: 11 oz denim, 324 g/m^2, 205 to 232 N/m in its softer direction (five
    times that in the other), 64 to 97 uN m (Wang, O'Brien, Ramamoorthi 2011); bending length 2.8 cm.
poisson_ratio: as for woven cotton.
thickness: 0.80 to 1.19 mm (KES-F, Journal of Textiles 2016, 4614168).
friction_table: the paper's Table II, pants: friction 80, that is mu = 0.8.
friction_cloth, air_drag: assumed, as for terry.
"""

FABRICS = {"terry": TERRY, "jersey": JERSEY, "denim": DENIM}
"""Name of each fabric."""
