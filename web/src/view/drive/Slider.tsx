interface Props {
  name: string;
  value: number;
  range: { min: number; max: number; step: number };
  /** The value in words. */
  said: string;
  onSlide: (value: number) => void;
}

/** A slider for a number that the user sets, with its value in words. */
export function Slider({ name, value, range, said, onSlide }: Props) {
  return (
    <label class="ways-slider">
      <span>{name}</span>
      <input
        type="range"
        {...range}
        value={value}
        aria-valuetext={said}
        onChange={(event) => onSlide(event.currentTarget.valueAsNumber)}
      />
      <output>{said}</output>
    </label>
  );
}
