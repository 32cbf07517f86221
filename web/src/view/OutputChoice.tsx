import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import {
  askForOutput,
  asksForOutput,
  choosesOutputs,
  devicesOf,
  listOutputs,
  type Output,
} from "../sound/outputs";
import { t } from "../words/words";
import { useActions, useState } from "./context";

/** The choice of sound output; hidden where the browser does not let a page choose. */
export function OutputChoice() {
  const { output } = useState();
  const { setOutput } = useActions();
  const found = useSignal<readonly Output[]>([]);
  const can = choosesOutputs();
  useEffect(() => {
    const devices = devicesOf();
    if (!can || !devices) return;
    const look = async () => {
      found.value = await listOutputs(devices).catch(() => []);
    };
    void look();
    const leaving = new AbortController();
    devices.addEventListener("devicechange", () => void look(), { signal: leaving.signal });
    return () => leaving.abort();
  }, [can, found]);
  if (!can) return null;

  const chosen = output.value;
  const isListed = chosen === null || found.value.some((one) => one.id === chosen.id);
  const all = isListed ? found.value : [...found.value, chosen];
  const ask = async () => {
    const devices = devicesOf();
    const wanted = devices && (await askForOutput(devices));
    if (wanted) setOutput(wanted);
  };
  return (
    <div class="output">
      {all.length > 0 && (
        <label class="field">
          <span>{t("watch.output")}</span>
          <select
            value={chosen?.id ?? ""}
            onChange={(event) => {
              const id = event.currentTarget.value;
              setOutput(all.find((one) => one.id === id) ?? null);
            }}
          >
            <option value="">{t("watch.output.default")}</option>
            {all.map((one) => (
              <option key={one.id} value={one.id}>
                {one.name}
              </option>
            ))}
          </select>
        </label>
      )}
      {asksForOutput() ? (
        <button type="button" class="plain-button" onClick={() => void ask()}>
          {t("watch.output.choose")}
        </button>
      ) : (
        all.length === 0 && <p class="quiet">{t("watch.output.unnamed")}</p>
      )}
    </div>
  );
}
