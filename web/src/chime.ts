/** A quiet chime: two notes, the second higher. */

const NOTES_HZ = [660, 880] as const;
const NOTE_S = 0.22;
const LOUDNESS = 0.08;
const ATTACK_S = 0.02;

type Make = () => AudioContext;

export class Chime {
  #context: AudioContext | null = null;

  constructor(private readonly make: Make = () => new AudioContext()) {}

  /** Plays the chime; silent before the user's first touch, when browsers allow no sound. */
  ring(): void {
    try {
      this.#context ??= this.make();
      const context = this.#context;
      void context.resume().catch(() => {}); // during a call
      NOTES_HZ.forEach((hz, i) => {
        this.#note(context, hz, context.currentTime + i * NOTE_S);
      });
    } catch {
      // Without Web Audio, the title and the card must be enough.
    }
  }

  #note(context: AudioContext, hz: number, atS: number): void {
    const tone = context.createOscillator();
    const volume = context.createGain();
    tone.frequency.value = hz;
    volume.gain.setValueAtTime(0, atS);
    volume.gain.linearRampToValueAtTime(LOUDNESS, atS + ATTACK_S);
    volume.gain.linearRampToValueAtTime(0, atS + NOTE_S);
    tone.connect(volume).connect(context.destination);
    tone.start(atS);
    tone.stop(atS + NOTE_S);
  }
}
