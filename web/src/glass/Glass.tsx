import "./glass.css";
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Session } from "../actions";
import { joinAddress } from "../bigScreen/facts";
import { problemOf } from "../bigScreen/parts";
import { keepRunning } from "../bigScreen/unattended";
import { SessionContext, useActions, useSession, useState } from "../view/context";
import { ageWords, msWords } from "../view/figures";
import { type Code, figure, t } from "../words/words";
import { type Delays, delaysOf, type Sight, withSight } from "./delays";
import { TimeCode } from "./TimeCode";
import { type Problem, watchCode } from "./watch";

const ONLY_CODE = "view=glass&only=code";
/** A hint is shown if no picture was read for this long. */
const PATIENCE_MS = 1500;
/** The host may keep what so many pictures say. */
const ENOUGH = 30;
/** The most that the server keeps (`CameraDelay` in host_switches.py). */
const MOST_KEPT_MS = 2000;
const HINTS = {
  dark: "glass.dark",
  nothing: "glass.nothing",
  cut_off: "glass.cut_off",
  unclear: "glass.unclear",
  late: "glass.late",
  other_time: "glass.other_time",
  blind: "glass.blind",
} as const satisfies Record<Problem | "blind", Code>;

/**
 * `wax glass`: measures the delay from the robot's camera to this screen, both included. The camera
 * films a time code, on this page or on another that shows nothing else, and this page reads it in the
 * picture. The screen that shows the code delays it as this one delays the picture.
 */
export function Glass({ session }: { session: Session }) {
  useEffect(() => keepRunning(session), [session]);
  const isOnlyCode = new URLSearchParams(window.location.search).get("only") === "code";
  return (
    <SessionContext.Provider value={session}>
      <main class={isOnlyCode ? "glass is-only-code" : "glass"}>
        {!isOnlyCode && <Measure />}
        <TimeCode />
      </main>
    </SessionContext.Provider>
  );
}

export { Glass as View };

function Measure() {
  const session = useSession();
  const { state } = session;
  const video = useRef<HTMLVideoElement>(null);
  const sights = useSignal<Sight[]>([]);
  const problem = useSignal<Problem | "blind" | null>(null);
  useEffect(() => {
    const element = video.current;
    if (!element) return;
    session.attachPicture(element);
    let readMs = performance.now();
    const end = watchCode(element, session, (what) => {
      const nowMs = performance.now();
      if (typeof what !== "string") {
        readMs = nowMs;
        sights.value = withSight(sights.peek(), what);
        problem.value = null;
      } else if (nowMs - readMs > PATIENCE_MS) problem.value = what;
    });
    if (!end) problem.value = "blind";
    return () => {
      end?.();
      session.attachPicture(null);
    };
  }, [session, sights, problem]);
  const address = `${joinAddress(window.location)}?${ONLY_CODE}`;
  // No picture, or an old one, says enough.
  const trouble = problemOf(state) ?? (problem.value && t(HINTS[problem.value]));
  return (
    <>
      <h1>{t("glass.title")}</h1>
      <video ref={video} class="glass-picture" muted autoplay playsinline />
      <section class="glass-said">
        <p class="glass-problem" role="status">
          {trouble}
        </p>
        <Figures delays={delaysOf(sights.value)} />
        <p class="quiet">
          {t("glass.how")} <a href={address}>{address}</a>
        </p>
      </section>
    </>
  );
}

function Figures({ delays }: { delays: Delays | null }) {
  const { facts, isHost } = useState();
  const { pictureMs, pictureErrorMs } = facts.value;
  const rows = [
    [t("glass.total"), msWords(delays?.p50Ms ?? null)],
    [t("glass.slow"), msWords(delays?.p95Ms ?? null)],
    [t("glass.count"), figure(delays?.count ?? 0)],
    [t("glass.known"), ageWords(pictureMs, pictureErrorMs)],
    [t("glass.rest"), msWords(delays?.restMs ?? null)],
  ];
  const isEnough = delays !== null && delays.count >= ENOUGH;
  return (
    <>
      <dl class="facts">
        {rows.map(([name, value]) => (
          <>
            <dt>{name}</dt>
            <dd>{value}</dd>
          </>
        ))}
      </dl>
      {isHost.value && <Keep restMs={isEnough ? delays.restMs : null} />}
    </>
  );
}

/** Lets the host keep what camera and screen add, which *Details* then shows to everybody. */
function Keep({ restMs }: { restMs: number | null }) {
  const { actAsHost } = useActions();
  const kept = useState().room.value?.host_settings.camera_delay_ms ?? null;
  const keep = (delay_ms: number | null) => actAsHost({ type: "keep_camera_delay", delay_ms });
  const ms = restMs === null ? null : Math.min(MOST_KEPT_MS, Math.max(0, Math.round(restMs)));
  return (
    <>
      {ms !== null && (
        <button type="button" class="main-button" onClick={() => keep(ms)}>
          {t("glass.keep", { ms: figure(ms) })}
        </button>
      )}
      {kept !== null && (
        <p>
          {t("glass.kept", { ms: figure(Math.round(kept)) })}{" "}
          <button type="button" onClick={() => keep(null)}>
            {t("glass.forget")}
          </button>
        </p>
      )}
    </>
  );
}
