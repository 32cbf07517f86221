import { useSignal } from "@preact/signals";
import { useRef } from "preact/hooks";

/** A field whose text is copied: with the system's clipboard, or by hand, since it is selected. */
export function useCopy<Field extends HTMLInputElement | HTMLTextAreaElement>(text: string) {
  const field = useRef<Field>(null);
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
  return { field, copy, isCopied: copied.value === text };
}
