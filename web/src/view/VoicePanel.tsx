import type { TargetedKeyboardEvent, TargetedPointerEvent } from "preact";
import { useCallback } from "preact/hooks";
import { codeOf } from "../drive/codeOf";
import { fingerHolder } from "../drive/inputState";
import { hindrance } from "../voice/microphone";
import { t } from "../words/words";
import { useActions, useState } from "./context";
import { PRESSING } from "./keys";
import { speakerWords, voiceProblem, voiceWords } from "./pageWords";
import { Switch } from "./Switch";
import { useKeysDown } from "./useHeld";

type Pointer = TargetedPointerEvent<HTMLButtonElement>;
type Key = TargetedKeyboardEvent<HTMLButtonElement>;

/** Speaking to the people beside the robot; nothing where it has no speaker. */
export function VoicePanel() {
  const { hello, room, voice, maySpeak } = useState();
  const { keepSpeaking } = useActions();
  if (!hello.value?.voice) return null;
  const speaking = speakerWords(room.value, hello.value.viewer);
  if (!maySpeak.value) return speaking && <p class="voice-words quiet">{speaking}</p>;
  const { isOn, isKept, isHeard, level } = voice.value;
  const lacks = hindrance();
  const problem = lacks ?? voiceProblem(voice.value, room.value);
  const words = isOn || !speaking ? voiceWords(voice.value, hello.value) : speaking;
  const kind = problem ? " is-problem" : isHeard ? " is-heard" : "";
  return (
    <section class="voice" aria-label={t("voice.title")}>
      <TalkButton isDisabled={lacks !== null} />
      {hello.value.voice.open_microphone && lacks === null && (
        <Switch name={t("voice.keep_open")} isOn={isKept} onSwitch={keepSpeaking} />
      )}
      <meter
        class={isOn ? "level voice-level" : "level voice-level is-off"}
        aria-label={t("voice.yours")}
        min={0}
        max={1}
        value={level}
      />
      <p class={`voice-words${kind}`} role="status">
        {problem ?? words}
      </p>
    </section>
  );
}

const HOLDER = "talk button";

/** Speaks while pressed by a finger, the mouse, or Enter with the focus. */
function TalkButton({ isDisabled }: { isDisabled: boolean }) {
  const { voice } = useState();
  const { speak, hush } = useActions();
  const finger = (event: Pointer) => fingerHolder(event.pointerId);
  const { keys, clear } = useKeysDown(useCallback(() => hush(HOLDER), [hush]));
  const onPointerDown = (event: Pointer) => {
    if (event.button !== 0) return;
    // Prevent the focus, which would give Space to this button, and a text selection.
    event.preventDefault();
    event.currentTarget.setPointerCapture(event.pointerId);
    speak(finger(event));
  };
  const onKeyDown = (event: Key) => {
    // Never Space, which stops the robot.
    if (!PRESSING.has(codeOf(event)) || codeOf(event) === "Space") return;
    event.preventDefault();
    if (keys.press(event) && keys.has(event)) speak(HOLDER);
  };
  const { isOn, isOpening, isKept } = voice.value;
  return (
    <button
      type="button"
      class={isOn ? "talk-button is-on" : "talk-button"}
      disabled={isDisabled}
      onPointerDown={onPointerDown}
      onPointerUp={(event) => hush(finger(event))}
      onPointerCancel={(event) => hush(finger(event))}
      onLostPointerCapture={(event) => hush(finger(event))}
      // A long touch opens a menu on some phones.
      onContextMenu={(event) => {
        event.preventDefault();
        event.stopPropagation();
      }}
      onMouseDown={(event) => event.preventDefault()}
      onKeyDown={onKeyDown}
      onKeyUp={(event) => keys.lift(event)}
      onBlur={clear}
    >
      {isOpening ? t("voice.opening") : isKept ? t("voice.is_open") : t("voice.hold")}
    </button>
  );
}
