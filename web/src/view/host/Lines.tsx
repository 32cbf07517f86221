import { t } from "../../words/words";
import { useCopy } from "./useCopy";

/** Lines for the configuration file, to be copied by the system's clipboard or by hand. */
export function Lines({ text }: { text: string }) {
  const { field, copy, isCopied } = useCopy<HTMLTextAreaElement>(text);
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
      <p role="status">{isCopied && t("path.copied")}</p>
    </div>
  );
}
