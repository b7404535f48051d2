/* The four programs of the replay. Light is added up linearly and brought to the screen's gamma at the end. */

export const shaders = (() => {
  const head = `#version 300 es
    precision highp float;
    precision highp sampler2DShadow;`;

  const light = `
    uniform vec3 u_sun, u_eye;
    uniform sampler2DShadow u_shadow;
    vec3 linear(vec3 colour) { return pow(colour, vec3(2.2)); }
    vec3 screen(vec3 colour) { return pow(colour, vec3(1.0 / 2.2)); }
    float sunlit(vec4 place, float slack) {
      vec3 at = place.xyz / place.w * 0.5 + 0.5;
      if (any(greaterThan(abs(at - 0.5), vec3(0.5)))) return 1.0;
      float texel = 1.5 / float(textureSize(u_shadow, 0).x), sum = 0.0;
      for (int i = -2; i <= 2; i++)
        for (int j = -2; j <= 2; j++)
          sum += texture(u_shadow, vec3(at.xy + texel * vec2(i, j), at.z - slack));
      return sum / 25.0;
    }
    vec3 lit(vec3 colour, vec3 n, vec3 place, float sun) {
      float sky = 0.45 + 0.18 * n.z;
      vec3 half_way = normalize(u_sun + normalize(u_eye - place));
      float sheen = 0.05 * pow(max(dot(n, half_way), 0.0), 18.0) * sun;
      return colour * (sky + 0.62 * sun * max(dot(n, u_sun), 0.0)) + sheen;
    }`;

  const vertex = `${head}
    layout(location = 0) in vec3 a_point;
    layout(location = 1) in vec3 a_normal;
    layout(location = 2) in vec4 a_extra;
    uniform mat4 u_camera, u_sunlight;
    uniform vec4 u_place;
    uniform float u_back;
    out vec3 v_point, v_normal;
    out vec4 v_extra, v_sunlight;
    void main() {
      v_point = a_point * u_place.w + u_place.xyz;
      v_normal = a_normal;
      v_extra = a_extra;
      v_sunlight = u_sunlight * vec4(v_point, 1.0);
      gl_Position = u_camera * vec4(v_point, 1.0);
      gl_Position.z += u_back * gl_Position.w;
    }`;

  const inputs = `
    in vec3 v_point, v_normal;
    in vec4 v_extra, v_sunlight;
    out vec4 colour;`;

  /* a_extra: flat x, flat y [m], e_i [m], 1 at the border. */
  const cloth = `${head}${light}${inputs}
    uniform vec3 u_front, u_behind, u_scale[5];
    uniform float u_largest, u_by_error;
    vec3 ramp(float share) {
      float at = clamp(share, 0.0, 1.0) * 4.0;
      int stop = min(int(at), 3);
      return mix(u_scale[stop], u_scale[stop + 1], at - float(stop));
    }
    float thread(vec2 flat_place) {
      vec2 cell = flat_place / 0.05, width = fwidth(cell);
      vec2 off = abs(fract(cell - 0.5) - 0.5) / max(width, vec2(1e-4));
      float fine = clamp(1.0 - 2.5 * max(width.x, width.y), 0.0, 1.0);
      return fine * (1.0 - min(min(off.x, off.y), 1.0));
    }
    void main() {
      vec3 n = normalize(v_normal);
      if (!gl_FrontFacing) n = -n;
      vec3 sides = gl_FrontFacing ? u_front : u_behind;
      vec3 dye = linear(mix(sides, ramp(v_extra.z / u_largest), u_by_error));
      dye *= 1.0 - 0.16 * thread(v_extra.xy);
      dye *= 1.0 - 0.14 * smoothstep(0.45, 0.5, v_extra.w) * (1.0 - smoothstep(0.6, 0.65, v_extra.w));
      colour = vec4(screen(lit(dye, n, v_point, sunlit(v_sunlight, 0.0025))), 1.0);
    }`;

  /* a_extra.x: the time at which the hand passes; later parts of a path are pale. */
  const solid = `${head}${light}${inputs}
    uniform vec3 u_colour;
    uniform float u_time, u_alpha;
    void main() {
      float ahead = smoothstep(0.0, 0.02, v_extra.x - u_time);
      float alpha = u_alpha * mix(1.0, 0.28, ahead);
      colour = vec4(screen(lit(linear(u_colour), normalize(v_normal), v_point, 1.0)) * alpha, alpha);
    }`;

  /* a_extra.z: how far the cloth is from here; the ghost goes where the cloth has come. */
  const ghost = `${head}${inputs}
    uniform vec3 u_colour, u_eye;
    uniform float u_alpha, u_fade;
    void main() {
      float away = smoothstep(0.004, 0.05, v_extra.z);
      if (u_fade * (1.0 - away) > 0.98) discard;
      float edge = 1.0 - abs(dot(normalize(v_normal), normalize(u_eye - v_point)));
      float alpha = u_alpha * (0.42 + 0.3 * edge * edge) * mix(1.0, away, u_fade);
      colour = vec4(u_colour * alpha, alpha);
    }`;

  /* The sheet has lines every 10 cm and dissolves into the page. */
  const table = `${head}${light}${inputs}
    uniform vec3 u_colour, u_line, u_middle;
    uniform float u_reach;
    void main() {
      vec2 cell = v_point.xy / 0.1, width = fwidth(cell);
      vec2 off = abs(fract(cell - 0.5) - 0.5) / width;
      float line = 0.55 * (1.0 - min(min(off.x, off.y), 1.0));
      float fade = 1.0 - smoothstep(0.45, 1.0, length(v_point.xy - u_middle.xy) / u_reach);
      float shade = 1.0 - sunlit(v_sunlight, 0.001);
      vec3 sheet = linear(mix(u_colour, u_line, line)) * (1.0 - 0.55 * shade);
      colour = vec4(screen(sheet) * fade, fade);
    }`;

  const depth = `${head}
    void main() {}`;

  return { vertex, cloth, solid, ghost, table, depth };
})();
