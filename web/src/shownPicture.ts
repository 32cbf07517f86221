/** Knows the elements that show pictures, and so the one that is large. */
export class ShownPicture {
  #driving: HTMLVideoElement | null = null;
  readonly #cameras: (HTMLVideoElement | null)[] = [];

  /** Sets the element of a camera, null for the driving view. */
  attach(camera: number | null, element: HTMLVideoElement | null): void {
    if (camera === null) this.#driving = element;
    else this.#cameras[camera] = element;
  }

  /** The element of the camera that is large, of the driving view for null. */
  get(large: number | null): HTMLVideoElement | null {
    return large === null ? this.#driving : (this.#cameras[large] ?? null);
  }
}
