/** The shader programs of the grid renderer in GLSL ES 3.00, and functions to compile them. */

/** A chunk of cells: a rectangle of the lattice; each pixel reads the cell texture and the palette once. */
export const CELLS_VERTEX = `#version 300 es
uniform mat3 u_clip;   // lattice (column, row) -> clip space
uniform vec4 u_box;    // column, row, columns, rows
in vec2 a_corner;
out vec2 v_cell;       // cells from the chunk's own corner
void main() {
  v_cell = a_corner * u_box.zw;
  gl_Position = vec4((u_clip * vec3(u_box.xy + v_cell, 1.0)).xy, 0.0, 1.0);
}`;

export const CELLS_FRAGMENT = `#version 300 es
precision highp float;
precision highp int;
uniform highp sampler2D u_cells;
uniform highp sampler2D u_palette;
uniform int u_level;   // of the pyramid
uniform int u_mip;     // of the texture, which may begin at a higher level
uniform int u_stripe;  // binary logarithm of the width of a stripe in pixels
in vec2 v_cell;
out vec4 colour;
void main() {
  ivec2 cell = clamp(ivec2(v_cell), ivec2(0), ivec2(511)) >> u_level;
  int value = int(texelFetch(u_cells, cell, u_mip).r * 255.0 + 0.5);
  // A colour may be striped: the palette's rows are the sides of falling stripes and, twice as far apart, of rising ones.
  ivec2 at = ivec2(gl_FragCoord.xy);
  int row = ((at.x + at.y) >> u_stripe & 1) + 2 * ((at.x - at.y) >> u_stripe & 1);
  colour = texelFetch(u_palette, ivec2(value, row), 0);
}`;

/** The highlights of cells that have just changed: a fading square for each. */
export const HIGHLIGHT_VERTEX = `#version 300 es
uniform mat3 u_clip;
uniform float u_now;   // seconds
uniform float u_size;  // device pixels
in vec3 a_cell;        // column, row, seconds at which it changed
out float v_strength;
void main() {
  float age = (u_now - a_cell.z) / 0.6;
  v_strength = age < 0.0 || age > 1.0 ? 0.0 : (1.0 - age) * (1.0 - age);
  vec2 at = (u_clip * vec3(a_cell.xy + 0.5, 1.0)).xy;
  gl_Position = vec4(v_strength > 0.0 ? at : vec2(2.0), 0.0, 1.0);
  gl_PointSize = u_size;
}`;

export const HIGHLIGHT_FRAGMENT = `#version 300 es
precision mediump float;
uniform vec3 u_colour;
in float v_strength;
out vec4 colour;
void main() {
  colour = vec4(u_colour, 0.75 * v_strength);
}`;

/** The overlay of the map: an image of the size of the canvas with premultiplied alpha. */
export const OVERLAY_VERTEX = `#version 300 es
in vec2 a_corner;
out vec2 v_at;
void main() {
  v_at = vec2(a_corner.x, 1.0 - a_corner.y);
  gl_Position = vec4(2.0 * a_corner - 1.0, 0.0, 1.0);
}`;

export const OVERLAY_FRAGMENT = `#version 300 es
precision mediump float;
uniform sampler2D u_overlay;
in highp vec2 v_at;
out vec4 colour;
void main() {
  colour = texture(u_overlay, v_at);
}`;

/** Compile and link; throws with the driver's message if that fails. */
export function program(gl: WebGL2RenderingContext, vertex: string, fragment: string): WebGLProgram {
  const linked = gl.createProgram();
  for (const [type, source] of [
    [gl.VERTEX_SHADER, vertex],
    [gl.FRAGMENT_SHADER, fragment],
  ] as const) {
    const shader = gl.createShader(type);
    if (!shader) throw new Error("The graphics context is lost.");
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(linked, shader);
  }
  gl.linkProgram(linked);
  if (!gl.getProgramParameter(linked, gl.LINK_STATUS) && !gl.isContextLost()) {
    const logs = (gl.getAttachedShaders(linked) ?? []).map((shader) => gl.getShaderInfoLog(shader));
    throw new Error(`A shader does not compile: ${gl.getProgramInfoLog(linked) ?? ""} ${logs.join(" ")}`);
  }
  return linked;
}

/** The locations of a program's uniforms by name. */
export function uniforms<Name extends string>(
  gl: WebGL2RenderingContext,
  of: WebGLProgram,
  names: readonly Name[],
): Record<Name, WebGLUniformLocation | null> {
  return Object.fromEntries(names.map((name) => [name, gl.getUniformLocation(of, name)])) as Record<
    Name,
    WebGLUniformLocation | null
  >;
}
