/* An eye on a sphere around the scene, turned by pointer and keys. Angles in radians. */

import { matrix, vector } from "./matrix.js";

export class Camera {
  constructor(canvas, bounds, changed) {
    Object.assign(this, { canvas, bounds, changed, pointers: new Map() });
    this.set("three");
    canvas.addEventListener("pointerdown", (event) => this.press(event));
    canvas.addEventListener("pointermove", (event) => this.drag(event));
    for (const name of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(name, (event) => this.pointers.delete(event.pointerId));
    }
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
  }

  set(name) {
    const [turn, rise] = { three: [-1.12, 0.56], top: [-Math.PI / 2, 1.5707], side: [-Math.PI / 2, 0.03] }[name];
    Object.assign(this, { turn, rise, nearer: 1 });
    this.changed();
  }

  press(event) {
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, [event.clientX, event.clientY]);
  }

  drag(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const others = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
    const now = [event.clientX, event.clientY];
    const gap = (a) => Math.hypot(a[0] - others[0][0], a[1] - others[0][1]);
    if (others.length) this.zoom(gap(now) / Math.max(gap(before), 1));
    else this.orbit(-0.008 * (now[0] - before[0]), 0.008 * (now[1] - before[1]));
    this.pointers.set(event.pointerId, now);
  }

  /* A plain wheel scrolls the page unless the replay has been clicked. */
  wheel(event) {
    if (!event.ctrlKey && document.activeElement !== this.canvas) return;
    event.preventDefault();
    this.zoom(Math.exp(-0.0015 * event.deltaY));
  }

  orbit(turn, rise) {
    this.turn += turn;
    this.rise = Math.min(Math.max(this.rise + rise, 0.01), 1.5707);
    this.changed();
  }

  zoom(factor) {
    this.nearer = Math.min(Math.max(this.nearer * factor, 0.4), 12);
    this.changed();
  }

  /* Directions of the picture: right, up, towards the eye. */
  axes() {
    const [c, s] = [Math.cos(this.rise), Math.sin(this.rise)];
    const near = [c * Math.cos(this.turn), c * Math.sin(this.turn), s];
    const right = [-Math.sin(this.turn), Math.cos(this.turn), 0];
    return { right, up: vector.cross(near, right), near };
  }

  /* How far to stand so that the scene's box just fills the picture. */
  distance(angle, aspect, axes) {
    const { half } = this.bounds;
    const reach = (axis) => half.reduce((sum, size, k) => sum + size * Math.abs(axis[k]), 0);
    const slope = 0.9 * Math.tan(angle / 2);
    return reach(axes.near) * 0.6 + Math.max(reach(axes.right) / (slope * aspect), reach(axes.up) / slope);
  }

  look(aspect) {
    const angle = 0.5;
    const axes = this.axes();
    const away = this.distance(angle, aspect, axes) / this.nearer;
    const eye = vector.add(this.bounds.centre, vector.scale(axes.near, away));
    const radius = Math.hypot(...this.bounds.half);
    const near = Math.max(away - 3 * radius, 0.05 * away);
    const view = matrix.product(
      matrix.perspective(angle, aspect, near, away + 4 * radius),
      matrix.lookAt(eye, this.bounds.centre, axes.up),
    );
    return { view, eye };
  }
}
