import { t } from "../../words/words";
import { useCopy } from "./useCopy";

/** A text to be copied by the system's clipboard or by hand. */
export function ToCopy({ name, text }: { name: string; text: string }) {
  const { field, copy, isCopied } = useCopy<HTMLInputElement>(text);
  return (
    <>
      <div class="host-row">
        <input
          ref={field}
          type="text"
          readOnly
          dir="ltr"
          aria-label={name}
          value={text}
          onFocus={(event) => event.currentTarget.select()}
        />
        <button type="button" class="main-button" onClick={() => void copy()}>
          {t("invitation.copy")}
        </button>
      </div>
      <p role="status" aria-label={t("invitation.copied_label")}>
        {isCopied && t("invitation.copied")}
      </p>
    </>
  );
}
