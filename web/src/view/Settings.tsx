import { t } from "../words/words";
import { useActions, useState } from "./context";
import { sizeWords } from "./figures";
import { LanguageChoice } from "./LanguageChoice";
import { late } from "./late";
import { silenceWords } from "./pageWords";
import { Switch } from "./Switch";

/** On a thin link, too, an operator may need its choice of timing. */
export const Watching = late(async () => (await import("./Watching")).Watching, {
  isForDriving: true,
});
export const WaysPanel = late(async () => (await import("./drive/WaysPanel")).WaysPanel);

/** The user's choices of streams, size, timing and sound, and the tools for watching. */
export function Settings() {
  const { preferences, hello, cameras } = useState();
  const silence = silenceWords(hello.value);
  const { setPicture, setCameras, keep } = useActions();
  return (
    <div class="settings">
      {silence !== null && <p class="quiet">{silence}</p>}
      <Switch name={t("panels.picture")} isOn={preferences.value.picture} onSwitch={setPicture} />
      {cameras.value.length > 0 && (
        <Switch
          name={t("panels.other_cameras")}
          isOn={preferences.value.cameras}
          onSwitch={setCameras}
        />
      )}
      {hello.value?.robot.camera && (
        <Switch
          name={t("panels.path")}
          isOn={preferences.value.path}
          onSwitch={(on) => keep({ path: on })}
        />
      )}
      <Size />
      <Watching />
      <LanguageChoice />
      <WaysPanel />
    </div>
  );
}

/** The largest size to send; the link and the window determine the actual one. */
function Size() {
  const { preferences, hello } = useState();
  const { setSize } = useActions();
  const sizes = hello.value?.sizes ?? [];
  const { size } = preferences.value;
  return (
    <label class="field">
      <span>{t("panels.size")}</span>
      <select
        disabled={sizes.length === 0}
        value={sizes.includes(size) ? size : sizes[0]}
        onChange={(event) => setSize(event.currentTarget.value)}
      >
        {sizes.map((one, i) => (
          <option key={one} value={one}>
            {t(i === 0 ? "panels.size_largest" : "panels.size_up_to", { size: sizeWords(one) })}
          </option>
        ))}
      </select>
    </label>
  );
}
