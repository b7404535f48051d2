/* Play, pause, slide: time runs in the viewer as it ran for the hands. */

export class Player {
  constructor(viewer, root) {
    this.viewer = viewer;
    this.rate = 1;
    const part = (name) => root.querySelector(`[data-part="${name}"]`);
    Object.assign(this, { slider: part("slider"), button: part("play"), clock: part("clock") });
    this.slider.max = Math.round(1000 * viewer.motion.duration);
    this.slider.addEventListener("input", () => this.hold(Number(this.slider.value) / 1000));
    this.button.addEventListener("click", () => this.toggle());
    part("rate").addEventListener("change", (event) => (this.rate = Number(event.target.value)));
    root.querySelectorAll("[data-view]").forEach((button) =>
      button.addEventListener("click", () => viewer.camera.set(button.dataset.view)));
    root.querySelectorAll("[data-show]").forEach((box) =>
      box.addEventListener("change", () => viewer.toggle(box.dataset.show, box.checked)));
    viewer.canvas.addEventListener("keydown", (event) => this.key(event));
    this.seek(0);
  }

  get duration() {
    return this.viewer.motion.duration;
  }

  seek(time) {
    this.viewer.seek(time);
    const now = this.viewer.time;
    this.slider.value = Math.round(1000 * now);
    this.slider.style.setProperty("--share", now / this.duration);
    const text = `${now.toFixed(2)} s`;
    this.slider.setAttribute("aria-valuetext", text);
    this.clock.textContent = `${text} / ${this.duration.toFixed(2)} s`;
  }

  hold(time) {
    this.pause();
    this.seek(time);
  }

  toggle() {
    if (this.running) this.pause();
    else this.play();
  }

  play() {
    if (this.viewer.time >= this.duration - 1e-6) this.seek(0);
    this.label(true);
    let last = performance.now();
    const step = (now) => {
      if (!this.running) return;
      this.seek(this.viewer.time + (this.rate * (now - last)) / 1000);
      last = now;
      if (this.viewer.time >= this.duration) this.pause();
      else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  pause() {
    this.label(false);
  }

  label(running) {
    this.running = running;
    this.button.setAttribute("aria-label", running ? "Pause" : "Play");
    this.button.dataset.running = running;
  }

  key(event) {
    const { camera } = this.viewer;
    const actions = {
      " ": () => this.toggle(),
      ",": () => this.hold(this.viewer.time - 1 / 30),
      ".": () => this.hold(this.viewer.time + 1 / 30),
      Home: () => this.hold(0),
      End: () => this.hold(this.duration),
      ArrowLeft: () => camera.orbit(-0.1, 0),
      ArrowRight: () => camera.orbit(0.1, 0),
      ArrowUp: () => camera.orbit(0, 0.1),
      ArrowDown: () => camera.orbit(0, -0.1),
      "+": () => camera.zoom(1.15),
      "-": () => camera.zoom(1 / 1.15),
      0: () => camera.set("three"),
    };
    if (!actions[event.key] || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    actions[event.key]();
  }
}
