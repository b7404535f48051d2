/* Solids that are not cloth: tubes around paths, balls for hands, the sheet of the table. */

import { vector } from "./matrix.js";

export const shapes = {
  /* A tube around places of [m]; each point knows the time at which the hand was there. */
  tube(path, times, radius, sides = 12) {
    const kept = [0];
    for (let i = 1; i < path.length; i++) {
      const gap = Math.hypot(...vector.sub(path[i], path[kept[kept.length - 1]]));
      if (gap > radius) kept.push(i);
    }
    const solid = { points: [], normals: [], times: [], faces: [] };
    kept.forEach((at, ring) => {
      const before = path[kept[Math.max(ring - 1, 0)]];
      const after = path[kept[Math.min(ring + 1, kept.length - 1)]];
      const along = vector.unit(vector.sub(after, before));
      const side = vector.unit(vector.cross(along, Math.abs(along[1]) < 0.9 ? [0, 1, 0] : [1, 0, 0]));
      const up = vector.cross(side, along);
      for (let k = 0; k < sides; k++) {
        const angle = (2 * Math.PI * k) / sides;
        const out = vector.add(vector.scale(side, Math.cos(angle)), vector.scale(up, Math.sin(angle)));
        solid.points.push(...vector.add(path[at], vector.scale(out, radius)));
        solid.normals.push(...out);
        solid.times.push(times[at]);
        if (ring) {
          const [a, b] = [(ring - 1) * sides + k, (ring - 1) * sides + ((k + 1) % sides)];
          solid.faces.push(a, b, a + sides, b, b + sides, a + sides);
        }
      }
    });
    return solid;
  },

  /* A ball of radius 1. */
  ball(rows = 14, columns = 24) {
    const solid = { points: [], normals: [], times: [], faces: [] };
    for (let i = 0; i <= rows; i++) {
      for (let k = 0; k <= columns; k++) {
        const [tilt, turn] = [(Math.PI * i) / rows, (2 * Math.PI * k) / columns];
        const out = [Math.sin(tilt) * Math.cos(turn), Math.sin(tilt) * Math.sin(turn), Math.cos(tilt)];
        solid.points.push(...out);
        solid.normals.push(...out);
        solid.times.push(0);
        if (i && k) {
          const at = i * (columns + 1) + k;
          const above = at - columns - 1;
          solid.faces.push(above - 1, at - 1, at, above - 1, at, above);
        }
      }
    }
    return solid;
  },

  /* The table around a centre: z = height - x tan(tilt). */
  sheet(centre, reach, table) {
    const solid = { points: [], normals: [], times: [], faces: [0, 1, 2, 0, 2, 3] };
    for (const [dx, dy] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
      const [x, y] = [centre[0] + reach * dx, centre[1] + reach * dy];
      solid.points.push(x, y, table.height - x * Math.tan(table.tilt));
      solid.normals.push(Math.sin(table.tilt), 0, Math.cos(table.tilt));
      solid.times.push(0);
    }
    return solid;
  },
};
