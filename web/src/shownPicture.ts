/** Keeps the elements that show pictures, to find the large one. */
export class ShownPicture {
  #driving: HTMLVideoElement | null = null;
  readonly #cameras: (HTMLVideoElement | null)[] = [];

  /** Sets a camera's element; null for the driving view's. */
  attach(camera: number | null, element: HTMLVideoElement | null): void {
    if (camera === null) this.#driving = element;
    else this.#cameras[camera] = element;
  }

  /** The element of the large camera; for null, the driving view's. */
  get(large: number | null): HTMLVideoElement | null {
    return large === null ? this.#driving : (this.#cameras[large] ?? null);
  }
}
