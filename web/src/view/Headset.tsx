import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { STEP_MS } from "../within";
import { t } from "../words/words";
import { useSession } from "./context";

type Module = typeof import("../headset/enter");

/** A button to see and drive the robot in a headset; hidden where none is connected. */
export function Headset() {
  const session = useSession();
  const part = useSignal<Module | null>(null);
  const isRefused = useSignal(false);
  const { xr } = navigator;
  useEffect(() => {
    if (!xr) return;
    const look = async () => {
      const isThere = await xr.isSessionSupported("immersive-vr").catch(() => false);
      // Before the click, whose permission to enter would be over once it is loaded.
      part.value = isThere ? await import("../headset/enter").catch(() => null) : null;
    };
    void look();
    xr.addEventListener("devicechange", look);
    return () => xr.removeEventListener("devicechange", look);
  }, [xr, part]);
  if (!xr || !part.value) return null;
  const { enterHeadset, inHeadset } = part.value;

  const toggle = async () => {
    isRefused.value = false;
    const refuse = () => {
      isRefused.value = true;
    };
    // It may still start: the browser may be asking whoever has it on.
    const waiting = setTimeout(refuse, STEP_MS);
    try {
      if (inHeadset.peek()) await inHeadset.peek()?.end();
      else await enterHeadset(session, xr);
      isRefused.value = false;
    } catch {
      refuse();
    } finally {
      clearTimeout(waiting);
    }
  };
  return (
    <div class="watch-act">
      <button type="button" class="plain-button" onClick={() => void toggle()}>
        {t(inHeadset.value ? "headset.leave" : "headset.enter")}
      </button>
      {isRefused.value && (
        <p role="alert" class="quiet">
          {t("headset.refused")}
        </p>
      )}
    </div>
  );
}
