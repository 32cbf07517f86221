import { useSignal } from "@preact/signals";
import type { FunctionComponent } from "preact";
import { t } from "../../words/words";

/** The way to the camera's calibration, which is loaded only when the host asks for it. */
export function Calibration() {
  const tool = useSignal<FunctionComponent | null>(null);
  const state = useSignal<"closed" | "loading" | "failed">("closed");
  const open = async () => {
    state.value = "loading";
    try {
      const { Calibrate } = await import("./Calibrate");
      tool.value = Calibrate;
    } catch {
      state.value = "failed";
    }
  };
  const Tool = tool.value;
  return (
    <section class="host-section" aria-labelledby="path-title">
      <h3 id="path-title">{t("path.title")}</h3>
      {Tool ? (
        <Tool />
      ) : (
        <button type="button" class="plain-button" onClick={() => void open()}>
          {t("path.calibrate")}
        </button>
      )}
      <p role="status">
        {!Tool && state.value === "loading" && t("path.loading")}
        {state.value === "failed" && t("path.not_loaded")}
      </p>
    </section>
  );
}
