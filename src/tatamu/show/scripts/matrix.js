/* Vectors of 3 and matrices of 4 x 4 in column order, as WebGL takes them. */

export const vector = {
  add: (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]],
  sub: (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]],
  scale: (a, s) => [a[0] * s, a[1] * s, a[2] * s],
  dot: (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2],
  cross: (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]],
  unit(a) {
    const length = Math.hypot(...a) || 1;
    return [a[0] / length, a[1] / length, a[2] / length];
  },
  mix: (a, b, u) => [a[0] + (b[0] - a[0]) * u, a[1] + (b[1] - a[1]) * u, a[2] + (b[2] - a[2]) * u],
};

export const matrix = {
  product(a, b) {
    const out = new Float32Array(16);
    for (let column = 0; column < 4; column++) {
      for (let row = 0; row < 4; row++) {
        let sum = 0;
        for (let k = 0; k < 4; k++) sum += a[4 * k + row] * b[4 * column + k];
        out[4 * column + row] = sum;
      }
    }
    return out;
  },

  perspective(angle, aspect, near, far) {
    const f = 1 / Math.tan(angle / 2);
    const out = new Float32Array(16);
    out[0] = f / aspect;
    out[5] = f;
    out[10] = (far + near) / (near - far);
    out[11] = -1;
    out[14] = (2 * far * near) / (near - far);
    return out;
  },

  parallel(half, near, far) {
    const out = new Float32Array(16);
    out[0] = 1 / half;
    out[5] = 1 / half;
    out[10] = -2 / (far - near);
    out[14] = -(far + near) / (far - near);
    out[15] = 1;
    return out;
  },

  lookAt(eye, centre, up) {
    const back = vector.unit(vector.sub(eye, centre));
    const right = vector.unit(vector.cross(up, back));
    const above = vector.cross(back, right);
    const out = new Float32Array(16);
    [right, above, back].forEach((axis, row) => {
      for (let k = 0; k < 3; k++) out[4 * k + row] = axis[k];
      out[12 + row] = -vector.dot(axis, eye);
    });
    out[15] = 1;
    return out;
  },
};
