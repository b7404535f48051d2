/* The replay's data: cloth and hands at any time, between frames by straight lines. Lengths in metres. */

import { vector } from "./matrix.js";
import { packing } from "./packing.js";

export class Motion {
  static async unpack(data) {
    const [steps, faces] = [await packing.bytes(data.positions), await packing.bytes(data.faces)];
    return new Motion(data, packing.motion(steps, 3 * data.count), new Uint32Array(faces.buffer));
  }

  constructor({ times, hands, low, step, count }, steps, faces) {
    Object.assign(this, { times, hands, low, step, count, steps, faces });
    this.flat = this.frame(0);
    this.target = this.frame(times.length);
    this.points = new Float32Array(3 * count);
    this.borders = this.findBorders();
    this.errors = this.distances(this.frame(times.length - 1));
  }

  get duration() {
    return this.times[this.times.length - 1];
  }

  /* A frame's positions; the one after the last is the target. */
  frame(number) {
    const out = new Float32Array(3 * this.count);
    const start = out.length * number;
    for (let i = 0; i < out.length; i++) out[i] = this.low[i % 3] + this.step * this.steps[start + i];
    return out;
  }

  /* The frame before `time`, the one after it, and the part of the step between them that has passed. */
  locate(time) {
    let low = 0;
    let high = this.times.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= time) low = middle;
      else high = middle;
    }
    const span = this.times[high] - this.times[low];
    return [low, high, span > 0 ? Math.min(Math.max((time - this.times[low]) / span, 0), 1) : 0];
  }

  cloth(time) {
    const [low, high, u] = this.locate(time);
    const size = 3 * this.count;
    for (let i = 0, a = low * size, b = high * size; i < size; i++, a++, b++) {
      this.points[i] = this.low[i % 3] + this.step * (this.steps[a] + (this.steps[b] - this.steps[a]) * u);
    }
    return this.points;
  }

  hand(which, time) {
    const [low, high, u] = this.locate(time);
    const path = this.hands[which].path;
    return vector.mix(path[low], path[high], u);
  }

  /* Area-weighted normals, not yet of unit length. */
  normals(points) {
    const out = new Float32Array(points.length);
    const faces = this.faces;
    for (let f = 0; f < faces.length; f += 3) {
      const [i, j, k] = [3 * faces[f], 3 * faces[f + 1], 3 * faces[f + 2]];
      const [ux, uy, uz] = [points[j] - points[i], points[j + 1] - points[i + 1], points[j + 2] - points[i + 2]];
      const [vx, vy, vz] = [points[k] - points[i], points[k + 1] - points[i + 1], points[k + 2] - points[i + 2]];
      const [x, y, z] = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
      for (const at of [i, j, k]) {
        out[at] += x;
        out[at + 1] += y;
        out[at + 2] += z;
      }
    }
    return out;
  }

  /* How far each vertex of a shape is from its place in the target. */
  distances(points) {
    const { target } = this;
    return Float32Array.from({ length: this.count }, (_, i) => {
      const at = 3 * i;
      return Math.hypot(points[at] - target[at], points[at + 1] - target[at + 1], points[at + 2] - target[at + 2]);
    });
  }

  /* Edges that belong to one triangle only, as pairs of vertices. */
  findBorders() {
    const seen = new Map();
    for (let f = 0; f < this.faces.length; f += 3) {
      for (let k = 0; k < 3; k++) {
        const [a, b] = [this.faces[f + k], this.faces[f + ((k + 1) % 3)]];
        const key = Math.min(a, b) * this.count + Math.max(a, b);
        if (seen.has(key)) seen.delete(key);
        else seen.set(key, [a, b]);
      }
    }
    return Uint32Array.from([...seen.values()].flat());
  }

  centroid() {
    const sum = [0, 0, 0];
    this.points.forEach((value, i) => (sum[i % 3] += value / this.count));
    return sum;
  }

  /* The box around all frames and the hands: centre and half of its sizes. */
  bounds() {
    const low = [Infinity, Infinity, Infinity];
    const high = [-Infinity, -Infinity, -Infinity];
    const grow = (value, axis) => {
      low[axis] = Math.min(low[axis], value);
      high[axis] = Math.max(high[axis], value);
    };
    for (let i = 0; i < this.steps.length; i++) grow(this.low[i % 3] + this.step * this.steps[i], i % 3);
    this.hands.forEach((hand) => hand.path.forEach((place) => place.forEach(grow)));
    return { centre: vector.mix(low, high, 0.5), half: vector.scale(vector.sub(high, low), 0.5) };
  }
}
