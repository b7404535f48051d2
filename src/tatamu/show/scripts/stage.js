/* WebGL 2 without the ceremony: programs, meshes, the shadow map. */

import { shaders } from "./shaders.js";

export class Stage {
  constructor(canvas) {
    this.canvas = canvas;
    this.gl = canvas.getContext("webgl2", { antialias: true, premultipliedAlpha: true, preserveDrawingBuffer: true });
    if (!this.gl) throw new Error("WebGL 2 is not available");
    this.programs = Object.fromEntries(
      ["cloth", "solid", "ghost", "table", "depth"].map((name) => [name, this.program(shaders[name])]),
    );
    this.shadow = this.shadowMap(1024);
  }

  shader(kind, source) {
    const gl = this.gl;
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    return shader;
  }

  program(fragment) {
    const gl = this.gl;
    const program = gl.createProgram();
    gl.attachShader(program, this.shader(gl.VERTEX_SHADER, shaders.vertex));
    gl.attachShader(program, this.shader(gl.FRAGMENT_SHADER, fragment));
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
    return program;
  }

  /* Buffers of a mesh; `extra` has four numbers a point. */
  mesh({ points, normals, extra, faces }) {
    const gl = this.gl;
    const mesh = { array: gl.createVertexArray(), count: faces.length, buffers: [] };
    gl.bindVertexArray(mesh.array);
    [[points, 3], [normals, 3], [extra, 4]].forEach(([values, width], location) => {
      const buffer = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      gl.bufferData(gl.ARRAY_BUFFER, Float32Array.from(values), gl.DYNAMIC_DRAW);
      gl.enableVertexAttribArray(location);
      gl.vertexAttribPointer(location, width, gl.FLOAT, false, 0, 0);
      mesh.buffers.push(buffer);
    });
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, Uint32Array.from(faces), gl.STATIC_DRAW);
    return mesh;
  }

  /* A solid of shapes.js, whose only extra is a time. */
  solid({ points, normals, times, faces }) {
    return this.mesh({ points, normals, faces, extra: times.flatMap((time) => [time, 0, 0, 0]) });
  }

  move(mesh, points, normals) {
    [points, normals].forEach((values, location) => {
      this.gl.bindBuffer(this.gl.ARRAY_BUFFER, mesh.buffers[location]);
      this.gl.bufferSubData(this.gl.ARRAY_BUFFER, 0, values);
    });
  }

  extra(mesh, values) {
    this.gl.bindBuffer(this.gl.ARRAY_BUFFER, mesh.buffers[2]);
    this.gl.bufferSubData(this.gl.ARRAY_BUFFER, 0, values);
  }

  shadowMap(size) {
    const gl = this.gl;
    const texture = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, size, size);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    const frame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, texture, 0);
    gl.drawBuffers([gl.NONE]);
    gl.readBuffer(gl.NONE);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return { texture, frame, size };
  }

  /* Draw onto the shadow map (target "shadow") or the screen. */
  target(name) {
    const gl = this.gl;
    const size = name === "shadow" ? [this.shadow.size, this.shadow.size] : [this.canvas.width, this.canvas.height];
    gl.bindTexture(gl.TEXTURE_2D, name === "shadow" ? null : this.shadow.texture);
    gl.bindFramebuffer(gl.FRAMEBUFFER, name === "shadow" ? this.shadow.frame : null);
    gl.viewport(0, 0, ...size);
    gl.enable(gl.DEPTH_TEST);
    gl.depthFunc(gl.LEQUAL);
    if (name === "shadow") return gl.clear(gl.DEPTH_BUFFER_BIT);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  draw(name, mesh, uniforms, mode = this.gl.TRIANGLES) {
    const gl = this.gl;
    const program = this.programs[name];
    gl.useProgram(program);
    const all = { u_place: [0, 0, 0, 1], u_back: 0, ...uniforms };
    for (const [key, value] of Object.entries(all)) this.set(gl.getUniformLocation(program, key), value);
    gl.bindVertexArray(mesh.array);
    gl.drawElements(mode, mesh.count, gl.UNSIGNED_INT, 4 * (mesh.first ?? 0));
  }

  set(where, value) {
    const gl = this.gl;
    if (!where) return;
    if (typeof value === "number") gl.uniform1f(where, value);
    else if (value.length === 16) gl.uniformMatrix4fv(where, false, value);
    else if (value.length === 4) gl.uniform4fv(where, value);
    else gl.uniform3fv(where, value);
  }
}
