import { useSignal } from "@preact/signals";
import type { TargetedEvent, TargetedKeyboardEvent } from "preact";
import { MAX_NAME_CHARS } from "../messages";
import { useActions, useState } from "./context";
import { inOrder, placeWords } from "./words";

/** Everybody who is here, and one's own name. */
export function Queue() {
  const { room, hello } = useState();
  return (
    <section class="queue">
      <h2 id="queue-title">Who is here</h2>
      {/* biome-ignore lint/a11y/noRedundantRoles: without its marks Safari takes it for no list */}
      <ol class="viewers" role="list" aria-label="Queue">
        {inOrder(room.value?.viewers ?? []).map((viewer) => (
          <li key={viewer.id} class={`viewer is-${viewer.role}${viewer.lost ? " is-lost" : ""}`}>
            <span class="viewer-name">{viewer.name}</span>
            {viewer.id === hello.value?.viewer && <span class="viewer-you"> (you)</span>}
            <span class="viewer-place"> {placeWords(viewer)}</span>
          </li>
        ))}
      </ol>
      <NameField />
    </section>
  );
}

function NameField() {
  const { preferences, me } = useState();
  const { setName } = useActions();
  // What is typed and not yet sent, which every news of the room would else overwrite.
  const draft = useSignal<string | null>(null);
  const onChange = (event: TargetedEvent<HTMLInputElement>) => {
    setName(event.currentTarget.value);
    draft.value = null;
  };
  const onKeyDown = (event: TargetedKeyboardEvent<HTMLInputElement>) => {
    // The keys belong to the robot again.
    if (event.key === "Enter") event.currentTarget.blur();
  };
  return (
    <label class="field name-field">
      <span>Your name</span>
      <input
        type="text"
        maxLength={MAX_NAME_CHARS}
        autocomplete="nickname"
        spellcheck={false}
        enterkeyhint="done"
        placeholder={preferences.value.name ? "" : (me.value?.name ?? "")}
        value={draft.value ?? preferences.value.name}
        onInput={(event) => {
          draft.value = event.currentTarget.value;
        }}
        onChange={onChange}
        onKeyDown={onKeyDown}
      />
    </label>
  );
}
