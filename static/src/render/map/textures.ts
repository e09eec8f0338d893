/** The chunks' pyramids on the graphics card: made where they are looked at, kept up to date where they changed. */

import { TILE } from "../../wire/protocol";
import type { Chunk } from "./cells";
import { CHUNK, LEVELS, sideOf } from "./pyramid";

/** From this level on a chunk has a small texture of its own, so that a huge map seen whole needs few bytes. */
const COARSE = 3;
/** Large textures kept: 341 kB each. Those not drawn for longest go first. */
const MAX_FINE = 320;
/** With more changed tiles than this a level is sent whole. */
const MANY_TILES = 20;

interface Texture {
  readonly handle: WebGLTexture;
  drawn: number;
}

interface Located {
  readonly texture: WebGLTexture;
  /** Level of the texture that holds the pyramid's level asked for. */
  readonly mip: number;
}

export class ChunkTextures {
  readonly #gl: WebGL2RenderingContext;
  readonly #fine = new Map<Chunk, Texture>();
  readonly #coarse = new Map<Chunk, Texture>();

  constructor(gl: WebGL2RenderingContext) {
    this.#gl = gl;
  }

  /** Bind nothing, return the texture that holds `level` of a chunk, up to date. `draw` numbers the pictures drawn. */
  locate(chunk: Chunk, level: number, draw: number): Located {
    const isFine = level < COARSE;
    const kind = isFine ? this.#fine : this.#coarse;
    let texture = kind.get(chunk);
    if (!texture) {
      texture = { handle: this.#make(isFine), drawn: draw };
      kind.set(chunk, texture);
      const levels = isFine ? (1 << COARSE) - 1 : ((1 << LEVELS) - 1) & ~((1 << COARSE) - 1);
      for (let tile = 0; tile < chunk.stale.length; tile++) chunk.stale[tile] = (chunk.stale[tile] as number) | levels;
    }
    texture.drawn = draw;
    const mip = isFine ? level : level - COARSE;
    this.#refresh(chunk, level, texture.handle, mip);
    return { texture: texture.handle, mip };
  }

  #make(isFine: boolean): WebGLTexture {
    const gl = this.#gl;
    const handle = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, handle);
    const side = isFine ? CHUNK : sideOf(COARSE);
    gl.texStorage2D(gl.TEXTURE_2D, isFine ? COARSE : LEVELS - COARSE, gl.R8, side, side);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST_MIPMAP_NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    return handle;
  }

  #refresh(chunk: Chunk, level: number, handle: WebGLTexture, mip: number): void {
    const bit = 1 << level;
    const { stale } = chunk;
    let count = 0;
    for (const bits of stale) if (bits & bit) count++;
    if (count === 0) return;
    const gl = this.#gl;
    const side = sideOf(level);
    const data = chunk.pyramid[level] as Uint8Array;
    const part = TILE >> level;
    gl.bindTexture(gl.TEXTURE_2D, handle);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    if (count > MANY_TILES || part < 8) {
      gl.texSubImage2D(gl.TEXTURE_2D, mip, 0, 0, side, side, gl.RED, gl.UNSIGNED_BYTE, data);
    } else {
      gl.pixelStorei(gl.UNPACK_ROW_LENGTH, side);
      for (let tile = 0; tile < stale.length; tile++) {
        if (!((stale[tile] as number) & bit)) continue;
        const x = (tile & 7) * part;
        const y = (tile >> 3) * part;
        gl.texSubImage2D(gl.TEXTURE_2D, mip, x, y, part, part, gl.RED, gl.UNSIGNED_BYTE, data, y * side + x);
      }
      gl.pixelStorei(gl.UNPACK_ROW_LENGTH, 0);
    }
    for (let tile = 0; tile < stale.length; tile++) stale[tile] = (stale[tile] as number) & ~bit;
  }

  /** Drop large textures beyond what is kept; those of the picture `draw` stay. */
  trim(draw: number): void {
    if (this.#fine.size <= MAX_FINE) return;
    const oldest = [...this.#fine].filter(([, { drawn }]) => drawn < draw).sort((a, b) => a[1].drawn - b[1].drawn);
    for (const [chunk, { handle }] of oldest.slice(0, this.#fine.size - MAX_FINE)) {
      this.#gl.deleteTexture(handle);
      this.#fine.delete(chunk);
    }
  }

  clear(): void {
    for (const { handle } of [...this.#fine.values(), ...this.#coarse.values()]) this.#gl.deleteTexture(handle);
    this.#fine.clear();
    this.#coarse.clear();
  }
}
