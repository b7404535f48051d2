"""What to do with a ruler, a scale and a board, and the file that the readings go into."""

from __future__ import annotations

import numpy as np

from tatamu.calibration.advice import BEST, SHORTEST
from tatamu.errors import InputError
from tatamu.garments import Garment, make_garment

HUNG_BY = {
    "towel": ["bottom"],
    "tshirt": ["left_shoulder", "right_shoulder"],
    "trousers": ["waist"],
}
"""Edges by which a garment is hung."""
SAG_EDGE = {"towel": "bottom", "tshirt": "hem", "trousers": "waist"}
PRESET = {"towel": "terry", "tshirt": "interlock", "trousers": "denim"}
STEP = 0.005
"""Free lengths are proposed in steps of this [m]."""

INSTRUCTIONS = """\
Three measurements of your garment give a simulator its cloth; two more are for limp cloth. You need a ruler with
millimetres, a kitchen scale, a board longer than the garment, with the surface it will be folded on, and two more
rulers or flat strips as a grip. Let the cloth lie for a minute before each. Repeat what you can: write repeats as a
list, [0.804, 0.805].

0  Weigh and size the garment.                                                            [garment] mass, size
   On the scale, in kilograms. Width and length as it lies flat, in metres.

1  Hang it.                                                                               [elongation] L1, L2
   Clamp the whole named edge straight and level (two rulers and clips; for shoulders a hanger). Wait until it is
   still. L1: from the grip straight down to the end farthest from it. Then lay the garment down without pulling at
   it; L2: the same two places. A narrow pinch also works ({edge = "bottom", at = 0.5, width = 0.03}), but stretches
   the cloth unevenly, and the mesh then matters.

2  Let it slide.                                                                          [friction] L_t, H_s
   Lay it flat on the board, on the surface that it will be folded on. L_t: the board's length from the end that stays
   to the end you lift. Lift slowly, without jerks; H_s: how high that end is when the cloth starts to slide.

3  Let it sag.                                                                            [sag] free_length, sag
   Clamp one layer level between two rulers beside the named edge, parallel to it, so that free_length of cloth stands
   out in front of them. Lift it into the air; sag: from the grip vertically down to the lowest point, the edge.
   Good readings sag about half the free length: choose it so. Read free_length as carefully as the sag.

4  Let it loop, if you like: for cloth that hangs straight down in 3, or bends otherwise in a fold.  [loop] height
   Lay one layer (of a T-shirt the hem of one side) over itself on the table without pressing, edges parallel, until
   four times the height of the loop lies on either side. height: from the table to the top of the loop. With the
   sag it tells bending better than either does alone; where they disagree, cloth bends otherwise in a fold.

5  Push it, if you like: cloth that hands push along the table wrinkles or slides.     [push] length, pushed, moved
   Lay one layer flat on the surface of 2. Press a ruler on its whole near edge and push it 5 cm towards the far one,
   slowly. length: of the cloth ahead of the ruler before; pushed: how far the ruler went; moved: how far the far edge
   did, 0 where it stayed.

    tatamu measure --template towel            writes measurements.toml, to be filled in
    tatamu calibrate measurements.toml --out my-towel.toml
    tatamu learn towel --material my-towel.toml --out runs/my-towel
"""


def template(name: str) -> str:
    """The text of measurements.toml for a garment, readings left empty.

    Raises:
        InputError: There is no such garment.
    """
    garment = make_garment(name)
    hung, edge = HUNG_BY.get(name), SAG_EDGE.get(name)
    if hung is None or edge is None:
        hung, edge = _longest(garment), _longest(garment)[0]
    grasps = ", ".join(f'{{edge = "{each}"}}' for each in hung)
    free = max(SHORTEST, STEP * round(BEST * garment.material.bending_length / STEP))
    return f"""\
# Readings of one {name}. Metres and kilograms; a reading may be repeated: [0.804, 0.805].
# `tatamu measure` says how to read each. Leave out a whole table [..] if that test was not made.

[garment]
name = "{name}"
size = [{garment.size[0]:g}, {garment.size[1]:g}]    # width, length
mass = []
# material = "{PRESET.get(name, "cotton")}"    # optional: preset or file for what is not measured (`tatamu materials`)
# thickness = 0.001      # optional: of one layer

[elongation]             # paper, section IV-A
grasps = [{grasps}]    # hung by the whole edge; or {{edge = "..", at = 0.5, width = 0.03}}
L1 = []                  # hanging, from the grip straight down to the farthest end
L2 = []                  # lying

[friction]               # paper, section IV-B
L_t = []                 # length of the board
H_s = []                 # height of its lifted end when the cloth starts to slide

[sag]                    # paper, section IV-C
edge = "{edge}"
free_length = {free:g}      # from the front of the grip to the edge: set what you used
sag = []                 # from the grip vertically down to the edge

# [loop]                 # optional: cloth folded over itself; tells B too
# height = []            # from the table to the top of the loop

# [push]                 # optional: cloth pushed along the table by a ruler on its near edge
# length = []            # of the cloth ahead of the ruler
# pushed = []            # how far the ruler went
# moved = []             # how far the far edge did, 0 where it stayed

[errors]                 # standard deviation of one reading, all causes together
length = 0.001
mass = 0.001
H_s = 0.005
"""


def _longest(garment: Garment) -> list[str]:
    """The longest edge that is open, or of all."""
    names = [name for name in garment.edges if name in garment.openings] or list(garment.edges)
    if not names:
        raise InputError(f"garment: {garment.name} has no named edges to hold it by")
    flat = garment.vertices
    return [max(names, key=lambda name: np.linalg.norm(np.diff(flat[garment.edges[name]], axis=0), axis=1).sum())]
