import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";
import { t } from "../../words/words";

/** A text to be copied: with the system's clipboard, or by hand. */
export function ToCopy({ name, text }: { name: string; text: string }) {
  const field = useRef<HTMLInputElement>(null);
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
        {copied.value === text && t("invitation.copied")}
      </p>
    </>
  );
}
