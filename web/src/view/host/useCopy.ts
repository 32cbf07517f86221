import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";

/** A field whose text is copied by the system's clipboard, or selected to be copied by hand. */
export function useCopy<Field extends HTMLInputElement | HTMLTextAreaElement>(text: string) {
  const field = useRef<Field>(null);
  const copied = useSignal("");
  const copy = async () => {
    field.current?.select();
    try {
      // Browsers have the clipboard only over HTTPS and on localhost.
      await navigator.clipboard.writeText(text);
      copied.value = text;
    } catch {
      copied.value = "";
    }
  };
  return { field, copy, isCopied: copied.value === text };
}
