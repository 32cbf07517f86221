import { useSignal } from "@preact/signals";
import type { TargetedEvent, TargetedKeyboardEvent } from "preact";

interface Props {
  label: string;
  maxLength: number;
  autocomplete: "nickname" | "off";
  placeholder: string;
  value: string;
  onSet: (text: string) => void;
}

/** A line of text, which is set by Enter or by leaving it. */
export function LineField({ label, value, onSet, ...more }: Props) {
  // Text not sent yet, which the next room state would otherwise overwrite.
  const draft = useSignal<string | null>(null);
  const onChange = (event: TargetedEvent<HTMLInputElement>) => {
    onSet(event.currentTarget.value);
    draft.value = null;
  };
  const onKeyDown = (event: TargetedKeyboardEvent<HTMLInputElement>) => {
    // Return the keyboard to driving.
    if (event.key === "Enter") event.currentTarget.blur();
  };
  return (
    <label class="field">
      <span>{label}</span>
      <input
        type="text"
        dir="auto"
        spellcheck={false}
        enterkeyhint="done"
        {...more}
        value={draft.value ?? value}
        onInput={(event) => {
          draft.value = event.currentTarget.value;
        }}
        onChange={onChange}
        onKeyDown={onKeyDown}
      />
    </label>
  );
}
