import { useSignal } from "@preact/signals";
import { t } from "../../words/words";
import { late } from "../late";

const Calibrate = late(async () => (await import("./Calibrate")).Calibrate);

/** Opens the camera's calibration, which is loaded only then. */
export function Calibration() {
  const isOpen = useSignal(false);
  return (
    <section class="host-section" aria-labelledby="path-title">
      <h3 id="path-title">{t("path.title")}</h3>
      {isOpen.value ? (
        <Calibrate />
      ) : (
        <button
          type="button"
          class="plain-button"
          onClick={() => {
            isOpen.value = true;
          }}
        >
          {t("path.calibrate")}
        </button>
      )}
    </section>
  );
}
