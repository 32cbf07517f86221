/** Draws pictures on screens around the head, by WebGL; where they stand: `mesh.ts`. */

import { product } from "./mesh";
import fragment from "./screen.frag?raw";
import vertex from "./screen.vert?raw";

const FLOATS = 5;
const BYTES = 4;

/** One screen: the picture on it, and its shape. */
export class Sheet {
  isLive = true;
  /** Whether the picture is a stereo pair: its left half for the left eye, the right for the right. */
  isPair = false;
  readonly texture: WebGLTexture;
  readonly places: WebGLBuffer;
  #vertices = 0;

  constructor(private readonly gl: WebGLRenderingContext) {
    this.texture = gl.createTexture();
    this.places = gl.createBuffer();
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    // As WebGL demands of pictures whose sides are no powers of two.
    for (const [name, value] of [
      [gl.TEXTURE_MIN_FILTER, gl.LINEAR],
      [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE],
      [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE],
    ] as const)
      gl.texParameteri(gl.TEXTURE_2D, name, value);
  }

  /** The number of its vertices, 0 while it is not to be drawn. */
  get vertices(): number {
    return this.#vertices;
  }

  /** Takes a mesh; null hides it. */
  shape(mesh: Float32Array | null): void {
    const { gl } = this;
    this.#vertices = mesh ? mesh.length / FLOATS : 0;
    if (!mesh) return;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.places);
    gl.bufferData(gl.ARRAY_BUFFER, mesh, gl.STATIC_DRAW);
  }

  show(picture: TexImageSource): void {
    const { gl } = this;
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, picture);
  }
}

export class Scene {
  readonly #place: number;
  readonly #spot: number;
  readonly #eye: WebGLUniformLocation | null;
  readonly #part: WebGLUniformLocation | null;
  readonly #live: WebGLUniformLocation | null;

  /** Throws where the shaders cannot be built. */
  constructor(private readonly gl: WebGLRenderingContext) {
    const program = gl.createProgram();
    for (const [kind, text] of [
      [gl.VERTEX_SHADER, vertex],
      [gl.FRAGMENT_SHADER, fragment],
    ] as const) {
      const shader = gl.createShader(kind);
      if (!shader) throw new Error("no shader");
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS)) {
      throw new Error(gl.getProgramInfoLog(program) ?? "the shaders do not link");
    }
    gl.useProgram(program);
    this.#place = gl.getAttribLocation(program, "place");
    this.#spot = gl.getAttribLocation(program, "spot");
    gl.enableVertexAttribArray(this.#place);
    gl.enableVertexAttribArray(this.#spot);
    this.#eye = gl.getUniformLocation(program, "eye");
    this.#part = gl.getUniformLocation(program, "part");
    this.#live = gl.getUniformLocation(program, "live");
  }

  /** Draws the sheets for each eye, later ones over earlier ones. */
  draw(layer: XRWebGLLayer, views: readonly XRView[], sheets: readonly Sheet[]): void {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, layer.framebuffer);
    gl.clearColor(0.05, 0.06, 0.07, 1);
    gl.clear(gl.COLOR_BUFFER_BIT);
    for (const view of views) {
      const port = layer.getViewport(view);
      if (!port) continue;
      gl.viewport(port.x, port.y, port.width, port.height);
      const eye = product(view.projectionMatrix, view.transform.inverse.matrix);
      gl.uniformMatrix4fv(this.#eye, false, eye);
      for (const sheet of sheets) {
        if (sheet.vertices > 0) this.#drawSheet(sheet, view.eye);
      }
    }
  }

  #drawSheet({ places, texture, vertices, isPair, isLive }: Sheet, eye: XREye): void {
    const { gl } = this;
    gl.bindBuffer(gl.ARRAY_BUFFER, places);
    gl.vertexAttribPointer(this.#place, 3, gl.FLOAT, false, FLOATS * BYTES, 0);
    gl.vertexAttribPointer(this.#spot, 2, gl.FLOAT, false, FLOATS * BYTES, 3 * BYTES);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.uniform2f(this.#part, isPair && eye === "right" ? 0.5 : 0, isPair ? 0.5 : 1);
    gl.uniform1f(this.#live, Number(isLive));
    gl.drawArrays(gl.TRIANGLE_STRIP, 0, vertices);
  }
}
