import type { Received, Units } from "../messages";
import { SoundUnits } from "./receipts";
import type { Arrival } from "./worker";

interface Transformable {
  transform: unknown;
}

type TransformConstructor = new (worker: Worker, options: Arrival["kind"]) => unknown;

/** Acknowledges every complete media unit, if the server asks for it. */
export class Acknowledger {
  readonly #units = new SoundUnits();
  #worker: Worker | null = null;

  constructor(private readonly send: (received: Received) => void) {}

  /** Whether to call `watch`: the server wants acknowledgements, and this browser can send them. */
  get isReady(): boolean {
    return this.#worker !== null;
  }

  /** Starts the worker; resolves to false if the browser does not report received frames. */
  start(): Promise<boolean> {
    if (!("RTCRtpScriptTransform" in globalThis)) return Promise.resolve(false);
    const worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module" });
    return new Promise((resolve) => {
      worker.onerror = () => resolve(false);
      worker.onmessage = ({ data }: MessageEvent<Arrival | "ready">) => {
        if (data === "ready") {
          this.#worker = worker;
          resolve(true);
        } else if (data.kind === "video" || this.#units.isLast(data.rtp)) {
          this.#acknowledge(data.kind, data.rtp);
        }
      };
    });
  }

  /** Watches a new peer's streams; call it only when their receivers have just been created. */
  watch(sound: RTCRtpReceiver, picture: RTCRtpReceiver): void {
    if (!this.#worker) return;
    this.#units.reset();
    const Transform = Reflect.get(globalThis, "RTCRtpScriptTransform") as TransformConstructor;
    (sound as Transformable).transform = new Transform(this.#worker, "audio");
    (picture as Transformable).transform = new Transform(this.#worker, "video");
  }

  /** Sets which packets end a unit of the sound. */
  units(units: Units): void {
    for (const rtp of this.#units.set(units)) this.#acknowledge("audio", rtp);
  }

  #acknowledge(kind: Arrival["kind"], rtp: number): void {
    this.send({ type: "received", kind, rtp });
  }
}
