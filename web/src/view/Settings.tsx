import { useActions, useState } from "./context";
import { sizeWords } from "./words";

/** What is sent to this page, and how large. */
export function Settings() {
  const { isSoundOn, preferences, hello } = useState();
  const { setSound, setPicture, setSize } = useActions();
  const sizes = hello.value?.sizes ?? [];
  const { picture, size } = preferences.value;
  return (
    <section class="settings" aria-label="Sound and picture">
      <Switch name="Sound" isOn={isSoundOn.value} onSwitch={setSound} />
      <Switch name="Picture" isOn={picture} onSwitch={setPicture} />
      <label class="field size-field">
        <span>Picture size</span>
        <select
          disabled={sizes.length === 0}
          value={sizes.includes(size) ? size : sizes[0]}
          onChange={(event) => setSize(event.currentTarget.value)}
        >
          {sizes.map((one) => (
            <option key={one} value={one}>
              {sizeWords(one)}
            </option>
          ))}
        </select>
      </label>
    </section>
  );
}

interface SwitchProps {
  name: string;
  isOn: boolean;
  onSwitch: (on: boolean) => void;
}

function Switch({ name, isOn, onSwitch }: SwitchProps) {
  return (
    <button
      type="button"
      class="switch"
      role="switch"
      aria-checked={isOn}
      onClick={() => onSwitch(!isOn)}
    >
      <span>{name}</span>
      <span class="track" aria-hidden="true" />
    </button>
  );
}
