import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { t } from "../../words/words";

/** Lines for the configuration file, to be copied: with the system's clipboard, or by hand. */
export function Lines({ text }: { text: string }) {
  const field = useRef<HTMLTextAreaElement>(null);
  const copied = useSignal("");
  const copy = async () => {
    field.current?.select();
    try {
      // Browsers have it under HTTPS and on this machine only.
      await navigator.clipboard.writeText(text);
      copied.value = text;
    } catch {
      copied.value = "";
    }
  };
  return (
    <div class="made-link">
      <p class="quiet">{t("path.write")}</p>
      <textarea
        ref={field}
        class="calibrate-lines"
        readOnly
        rows={text.split("\n").length}
        aria-label={t("path.lines")}
        value={text}
        onFocus={(event) => event.currentTarget.select()}
      />
      <button type="button" class="main-button" onClick={() => void copy()}>
        {t("path.copy")}
      </button>
      <p role="status">{copied.value === text && t("path.copied")}</p>
    </div>
  );
}
