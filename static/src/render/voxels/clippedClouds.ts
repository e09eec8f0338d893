/**
 * Point clouds that are clipped while they are drawn: the points outside of a box are discarded in the vertex shader, so
 * that another box takes two uniforms, and no point is copied.
 */

/** A message of viser about a node of the scene; only what concerns clipped clouds. */
export interface NodeMessage {
  readonly type?: string;
  readonly name?: string;
  readonly position?: readonly number[];
  readonly props?: { readonly points?: unknown };
}

/** The corners of a box, metres in the frame of the cloud; points on its faces are inside. */
export interface ClipCorners {
  readonly low: readonly number[];
  readonly high: readonly number[];
}

const CORNER = /^(.*)\/clip_(low|high)$/;

/** The clip boxes of a scene, and their clouds. */
export class ClippedClouds {
  readonly #corners = new Map<string, Partial<ClipCorners>>();
  readonly #paths = new WeakMap<Float32Array, string>();

  /** Note the clouds and the corners of boxes in messages of viser; return whether a box has changed. */
  take(messages: readonly NodeMessage[]): boolean {
    let isChanged = false;
    for (const { type, name, position, props } of messages) {
      if (name === undefined) continue;
      const corner = type === "SetPositionMessage" && position ? CORNER.exec(name) : null;
      if (corner) {
        const [, path = "", end = ""] = corner;
        this.#corners.set(path, { ...this.#corners.get(path), [end]: position });
        isChanged = true;
      } else if (type === "PointCloudMessage" && props?.points instanceof Float32Array) {
        this.#paths.set(props.points, name.slice(0, name.lastIndexOf("/")));
      } else if (type === "RemoveSceneNodeMessage") this.#corners.delete(name);
    }
    return isChanged;
  }

  /** The path of the node whose cloud has these points; undefined for other numbers. */
  pathOf(points: unknown): string | undefined {
    return points instanceof Float32Array ? this.#paths.get(points) : undefined;
  }

  /** The box of the cloud at a path; null without one. */
  boxOf(path: string): ClipCorners | null {
    const { low, high } = this.#corners.get(path) ?? {};
    return low && high ? { low, high } : null;
  }
}

/** The vertex shader with which viser's client draws clouds, with the test of the box at its end; any other as it is. */
export function clippingShader(source: string): string {
  const end = source.lastIndexOf("}");
  if (!/gl_PointSize\s*=/.test(source) || !/void\s+main\s*\(\s*\)/.test(source) || end < 0) return source;
  const main = source.search(/void\s+main\s*\(\s*\)/);
  return `${source.slice(0, main)}uniform highp vec3 clip_low;
uniform highp vec3 clip_high;
${source.slice(main, end)}
  if (any(lessThan(position, clip_low)) || any(greaterThan(position, clip_high))) gl_Position = vec4(0.0, 0.0, 2.0, 1.0);
}${source.slice(end + 1)}`;
}

/** Of a program that draws clouds. */
interface Places {
  readonly low: WebGLUniformLocation;
  readonly high: WebGLUniformLocation;
  readonly position: number;
}

const WHOLE: ClipCorners = { low: [-3e38, -3e38, -3e38], high: [3e38, 3e38, 3e38] };

/** Sets the box of each cloud before it is drawn. */
export class PointClipper {
  readonly #clouds: ClippedClouds;
  readonly #places = new WeakMap<WebGLProgram, Places | null>();
  readonly #paths = new WeakMap<WebGLBuffer, string>();

  constructor(clouds: ClippedClouds) {
    this.#clouds = clouds;
  }

  /** `data` is written to the array buffer that is bound. */
  wrote(gl: WebGL2RenderingContext, data: unknown): void {
    const path = this.#clouds.pathOf(data);
    const buffer: WebGLBuffer | null = path === undefined ? null : gl.getParameter(gl.ARRAY_BUFFER_BINDING);
    if (buffer && path !== undefined) this.#paths.set(buffer, path);
  }

  /** The points of the vertex array that is bound are about to be drawn. */
  prepare(gl: WebGL2RenderingContext): void {
    const program: WebGLProgram | null = gl.getParameter(gl.CURRENT_PROGRAM);
    const places = program && this.#placesOf(gl, program);
    if (!places) return;
    const buffer: WebGLBuffer | null = gl.getVertexAttrib(places.position, gl.VERTEX_ATTRIB_ARRAY_BUFFER_BINDING);
    const path = buffer ? this.#paths.get(buffer) : undefined;
    const { low, high } = (path === undefined ? null : this.#clouds.boxOf(path)) ?? WHOLE;
    gl.uniform3fv(places.low, low);
    gl.uniform3fv(places.high, high);
  }

  #placesOf(gl: WebGL2RenderingContext, program: WebGLProgram): Places | null {
    const known = this.#places.get(program);
    if (known !== undefined) return known;
    const low = gl.getUniformLocation(program, "clip_low");
    const high = gl.getUniformLocation(program, "clip_high");
    const places = low && high ? { low, high, position: gl.getAttribLocation(program, "position") } : null;
    this.#places.set(program, places);
    return places;
  }
}
