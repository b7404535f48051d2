/* The replay's data: cloth and hands at any time, between frames by straight lines. Lengths in metres. */

class Motion {
  constructor(data) {
    const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer;
    Object.assign(this, { times: data.times, hands: data.hands, low: data.low, step: data.step });
    this.count = data.count;
    this.steps = new Uint16Array(bytes(data.positions));
    this.faces = new Uint32Array(bytes(data.faces));
    this.target = this.metres(new Uint16Array(bytes(data.target)), 0);
    this.errors = Float32Array.from(data.errors);
    this.flat = this.frame(0);
    this.points = new Float32Array(3 * this.count);
    this.borders = this.findBorders();
  }

  get duration() {
    return this.times[this.times.length - 1];
  }

  /* Whole steps to metres. */
  metres(steps, start) {
    const out = new Float32Array(3 * this.count);
    for (let i = 0; i < out.length; i++) out[i] = this.low[i % 3] + this.step * steps[start + i];
    return out;
  }

  frame(number) {
    return this.metres(this.steps, 3 * this.count * number);
  }

  /* The frame before `time`, and how far it is on the way to the next. */
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

  /* How far each vertex is from its place in the target, third of four numbers. */
  away() {
    const out = new Float32Array(4 * this.count);
    for (let i = 0; i < this.count; i++) {
      const at = 3 * i;
      const [a, b] = [this.points, this.target];
      out[4 * i + 2] = Math.hypot(a[at] - b[at], a[at + 1] - b[at + 1], a[at + 2] - b[at + 2]);
    }
    return out;
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
