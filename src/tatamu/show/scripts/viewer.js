/* What is seen at a time: table, cloth, hands, their paths, a robot, the target as a ghost. */

import { Camera } from "./camera.js";
import { matrix, vector } from "./matrix.js";
import { shapes } from "./shapes.js";
import { Stage } from "./stage.js";

export class Viewer {
  constructor(canvas, motion, settings, robot) {
    Object.assign(this, { canvas, motion, settings, robot, time: 0, draws: 0 });
    this.show = { target: true, paths: true, error: false, robot: true };
    this.stage = new Stage(canvas);
    this.bounds = motion.bounds();
    this.radius = Math.hypot(...this.bounds.half);
    this.camera = new Camera(canvas, this.scope(), () => this.request());
    this.build();
    this.recolour();
    new ResizeObserver(() => this.request()).observe(canvas);
  }

  build() {
    const { motion, stage } = this;
    const border = new Float32Array(motion.count);
    motion.borders.forEach((vertex) => (border[vertex] = 1));
    const extra = [];
    for (let i = 0; i < motion.count; i++) {
      extra.push(motion.flat[3 * i], motion.flat[3 * i + 1], motion.errors[i], border[i]);
    }
    const mesh = (points, faces) =>
      stage.mesh({ points, normals: motion.normals(points), extra, faces });
    this.cloth = mesh(motion.flat, motion.faces);
    this.ghost = mesh(motion.target, motion.faces);
    this.ghostExtra = new Float32Array(4 * motion.count);
    this.ghostBorder = mesh(motion.target, motion.borders);
    this.paths = motion.hands.map((hand) =>
      stage.solid(shapes.tube(hand.path, motion.times, 0.005 * this.radius)));
    this.ball = stage.solid(shapes.ball());
    this.links = this.robot && this.solidOf(this.robot);
    const table = this.settings.table;
    this.table = table && stage.solid(shapes.sheet(this.bounds.centre, 2.6 * this.radius, table));
  }

  /* The box that the camera keeps in sight: with the robot, where there is one. */
  scope() {
    if (!this.robot) return this.bounds;
    const boxes = [this.bounds, this.robot.bounds()];
    const end = (sign, pick) =>
      [0, 1, 2].map((axis) => pick(...boxes.map(({ centre, half }) => centre[axis] + sign * half[axis])));
    const [low, high] = [end(-1, Math.min), end(1, Math.max)];
    return { centre: vector.mix(low, high, 0.5), half: vector.scale(vector.sub(high, low), 0.5) };
  }

  /* The mesh of something stiff that moves. */
  solidOf({ flat, faces, count }) {
    return this.stage.solid({ points: flat, normals: flat, times: Array(count).fill(0), faces });
  }

  /* Take the colours from the page, which knows day from night. */
  recolour() {
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => {
      const code = style.getPropertyValue(`--${name}`).trim();
      return [1, 3, 5].map((at) => parseInt(code.slice(at, at + 2), 16) / 255);
    };
    const names = ["front", "rear", "back", "target", "left", "right", "table", "table-line", "robot"];
    this.colours = Object.fromEntries(names.map((name) => [name, colour(name)]));
    this.scale = [0, 1, 2, 3, 4].map((stop) => colour(`scale-${stop}`));
    this.request();
  }

  seek(time) {
    this.time = Math.min(Math.max(time, 0), this.motion.duration);
    this.request();
  }

  toggle(name, on) {
    this.show[name] = on;
    this.request();
  }

  request() {
    if (this.pending) return;
    this.pending = requestAnimationFrame(() => {
      this.pending = 0;
      this.draw();
    });
  }

  resize() {
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const size = [this.canvas.clientWidth, this.canvas.clientHeight].map((side) => Math.round(side * ratio));
    if (!size[0] || !size[1]) return false;
    if (this.canvas.width !== size[0]) this.canvas.width = size[0];
    if (this.canvas.height !== size[1]) this.canvas.height = size[1];
    return true;
  }

  draw() {
    if (!this.resize()) return;
    const points = this.motion.cloth(this.time);
    this.stage.move(this.cloth, points, this.motion.normals(points));
    if (this.links) this.moveRobot();
    const sun = this.sun();
    this.stage.target("shadow");
    this.stage.draw("depth", this.cloth, { u_camera: sun.view });
    this.eachHand((at, size) => this.stage.draw("depth", this.ball, { u_camera: sun.view, u_place: [...at, size] }));
    this.stage.target("screen");
    const { view, eye } = this.camera.look(this.canvas.width / this.canvas.height);
    const common = { u_camera: view, u_eye: eye, u_sun: sun.towards, u_sunlight: sun.view, u_time: this.time };
    this.drawTable(common);
    this.drawCloth(common);
    if (this.links && this.show.robot) this.drawRobot(common);
    if (this.show.target) this.drawGhost(common);
    if (this.show.paths) this.drawPaths(common);
    this.drawHands(common);
    this.draws += 1;
  }

  sun() {
    const towards = vector.unit([-0.42, -0.36, 1.0]);
    const { centre } = this.bounds;
    const look = matrix.lookAt(vector.add(centre, vector.scale(towards, 2 * this.radius)), centre, [0, 1, 0]);
    const box = matrix.parallel(1.08 * this.radius, 0.5 * this.radius, 3.5 * this.radius);
    return { towards, view: matrix.product(box, look) };
  }

  drawTable(common) {
    if (!this.table || common.u_eye[2] < this.settings.table.height) return;
    this.stage.draw("table", this.table, {
      ...common,
      u_colour: this.colours.table,
      u_line: this.colours["table-line"],
      u_middle: this.bounds.centre,
      u_reach: 2.5 * this.radius,
      u_back: 2e-5,
    });
  }

  /* The front of a garment, then its back: their outsides differ in colour. */
  drawCloth(common) {
    const front = 3 * this.settings.upper;
    this.drawPanel(common, this.colours.front, 0, front);
    if (front < this.cloth.count) this.drawPanel(common, this.colours.rear, front, this.cloth.count - front);
  }

  drawPanel(common, outside, first, count) {
    this.stage.draw("cloth", { ...this.cloth, first, count }, {
      ...common,
      u_front: outside,
      u_behind: this.colours.back,
      ...Object.fromEntries(this.scale.map((stop, k) => [`u_scale[${k}]`, stop])),
      u_largest: this.settings.largest,
      u_by_error: this.show.error ? 1 : 0,
    });
  }

  moveRobot() {
    const points = this.robot.cloth(this.time);
    this.stage.move(this.links, points, this.robot.normals(points));
  }

  drawRobot(common) {
    const look = { ...common, u_colour: this.colours.robot, u_alpha: 1, u_time: Infinity };
    this.stage.draw("solid", this.links, look);
  }

  /* First its depth alone, then the nearest layer's colour: a folded ghost is not darker than a flat one. */
  drawGhost(common) {
    const { gl } = this.stage;
    const look = { ...common, u_colour: this.colours.target, u_alpha: 1, u_back: -5e-5, u_fade: 1 };
    const away = this.motion.distances(this.motion.points);
    away.forEach((distance, i) => (this.ghostExtra[4 * i + 2] = distance));
    this.stage.extra(this.ghost, this.ghostExtra);
    gl.colorMask(false, false, false, false);
    this.stage.draw("ghost", this.ghost, look);
    gl.colorMask(true, true, true, true);
    this.stage.draw("ghost", this.ghost, look);
    this.stage.draw("ghost", this.ghostBorder, { ...look, u_alpha: 2.5, u_fade: 0 }, gl.LINES);
  }

  drawPaths(common) {
    this.motion.hands.forEach((hand, which) => {
      const u_colour = this.colours[hand.colour];
      this.stage.draw("solid", this.paths[which], { ...common, u_colour, u_alpha: 1 });
    });
  }

  eachHand(visit) {
    this.motion.hands.forEach((hand, which) => {
      const closed = hand.holds.some(([closes, opens]) =>
        this.time >= closes && (opens === null || this.time < opens));
      visit(this.motion.hand(which, this.time), (closed ? 0.018 : 0.024) * this.radius, hand, closed);
    });
  }

  drawHands(common) {
    this.eachHand((at, size, hand, closed) =>
      this.stage.draw("solid", this.ball, {
        ...common,
        u_place: [...at, size],
        u_colour: this.colours[hand.colour],
        u_alpha: closed ? 1 : 0.45,
        u_time: Infinity,
      }));
  }
}
