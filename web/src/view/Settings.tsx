import { POLICIES, type Preferences } from "../preferences";
import { useActions, useState } from "./context";
import { sizeWords } from "./figures";
import { HostPanel } from "./host/HostPanel";
import { LossPanel } from "./LossPanel";
import { SoundMeter } from "./SoundMeter";
import { Switch } from "./Switch";
import { silenceWords } from "./words";

/** The user's choices of streams, size and policy; and the panels about the robot. */
export function Settings() {
  const { isSoundOn, preferences, hello, cameras } = useState();
  const silence = silenceWords(hello.value);
  const { setSound, setPicture, setCameras } = useActions();
  return (
    <section class="settings" aria-label="Settings">
      {silence === null ? (
        <div class="sound">
          <Switch name="Sound" isOn={isSoundOn.value} onSwitch={setSound} />
          <SoundMeter />
        </div>
      ) : (
        <p class="quiet no-sound">{silence}</p>
      )}
      <Switch name="Picture" isOn={preferences.value.picture} onSwitch={setPicture} />
      {cameras.value.length > 0 && (
        <Switch name="Other cameras" isOn={preferences.value.cameras} onSwitch={setCameras} />
      )}
      <Size />
      <Policy />
      <LossPanel />
      <HostPanel />
    </section>
  );
}

/** The largest size to send; the link decides the actual one. */
function Size() {
  const { preferences, hello } = useState();
  const { setSize } = useActions();
  const sizes = hello.value?.sizes ?? [];
  const { size } = preferences.value;
  return (
    <label class="field">
      <span>Picture size</span>
      <select
        disabled={sizes.length === 0}
        value={sizes.includes(size) ? size : sizes[0]}
        onChange={(event) => setSize(event.currentTarget.value)}
      >
        {sizes.map((one, i) => (
          <option key={one} value={one}>
            {i === 0 ? `Largest, ${sizeWords(one)}` : `Up to ${sizeWords(one)}`}
          </option>
        ))}
      </select>
    </label>
  );
}

const POLICY_NAMES = { "audio-master": "In step", "video-first": "Picture first" };

/** The synchronisation policy; no choice if the server has one for everybody. */
function Policy() {
  const { preferences, playout } = useState();
  const { setPolicy } = useActions();
  if (playout.value && !(playout.value.policy in POLICY_NAMES)) return null;
  return (
    <label class="field">
      <span>Timing</span>
      <select
        value={preferences.value.policy ?? ""}
        onChange={(event) =>
          setPolicy((event.currentTarget.value || null) as Preferences["policy"])
        }
      >
        {POLICIES.map((one) => (
          <option key={one} value={one ?? ""}>
            {one ? POLICY_NAMES[one] : "Automatic"}
          </option>
        ))}
      </select>
    </label>
  );
}
