import "./stats.css";
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import type { Session } from "../actions";
import { download } from "../download";
import { useSession } from "../view/context";
import { said } from "../words/said";
import { t } from "../words/words";
import { exported, fileName } from "./export";
import type { Mark } from "./history";
import { Plot } from "./Plot";
import { PLOTS } from "./plots";
import { type Why, why } from "./why";

/** The page measures this often. */
const DRAW_EVERY_MS = 1000;
/** More than anybody reads. */
const MOST_EVENTS = 50;

/** How it plays and why; loaded when the user opens it. */
export function StatsPage() {
  const session = useSession();
  const { history } = session;
  const nowMs = useSignal(performance.now());
  const isStill = useSignal(matchMedia("(prefers-reduced-motion: reduce)").matches);
  useEffect(() => {
    const drawing = setInterval(() => {
      if (!isStill.value && !document.hidden) nowMs.value = performance.now();
    }, DRAW_EVERY_MS);
    return () => clearInterval(drawing);
  }, [isStill, nowMs]);

  const now = nowMs.value;
  const found = whyNow(session, now);
  return (
    <div class="stats">
      <section aria-labelledby="stats-why">
        <h3 id="stats-why">{t("stats.why")}</h3>
        <p class="stats-why">{t(found.code, found.values)}</p>
      </section>
      <div class="stats-actions">
        <button
          type="button"
          class="plain-button"
          onClick={() => {
            isStill.value = !isStill.value;
          }}
        >
          {t(isStill.value ? "stats.go_on" : "stats.pause")}
        </button>
        <button
          type="button"
          class="plain-button"
          aria-describedby="stats-export"
          onClick={() => save(session)}
        >
          {t("stats.export")}
        </button>
        <p id="stats-export" class="quiet">
          {t("stats.export.what")}
        </p>
      </div>
      <section aria-labelledby="stats-plots">
        <h3 id="stats-plots">{t("stats.plots")}</h3>
        {history.length === 0 && <p class="quiet">{t("stats.empty")}</p>}
        <div class="stats-plots">
          {PLOTS.map((plot) => (
            <Plot key={plot.title} plot={plot} history={history} nowMs={now} />
          ))}
        </div>
      </section>
      <section aria-labelledby="stats-events">
        <h3 id="stats-events">{t("stats.events")}</h3>
        <Events marks={history.marks} nowMs={now} />
      </section>
    </div>
  );
}

/** The marks of the plots in words, newest first. */
function Events({ marks, nowMs }: { marks: readonly Mark[]; nowMs: number }) {
  const newest = marks.filter((mark) => mark.atMs <= nowMs).slice(-MOST_EVENTS);
  if (newest.length === 0) return <p class="quiet">{t("stats.events.none")}</p>;
  return (
    <ol class="stats-events">
      {newest.toReversed().map((mark) => (
        <li key={`${mark.atMs} ${mark.kind}`} class={`is-${mark.kind}`}>
          <span class="quiet">{agoWords(nowMs - mark.atMs)}</span> {mark.text}
        </li>
      ))}
    </ol>
  );
}

function agoWords(ms: number): string {
  const seconds = Math.round(ms / 1000);
  if (seconds === 0) return t("stats.ago.now");
  return seconds < 90
    ? t("stats.ago.seconds", { n: seconds })
    : t("stats.ago.minutes", { n: Math.round(seconds / 60) });
}

function whyNow({ state, history }: Session, nowMs: number): Why {
  return why(history, {
    nowMs,
    isConnected: state.isConnected.value && !state.isSilent.value,
    isHidden: document.hidden,
    isBlanked: state.isBlanked.value,
    wantsPicture: state.preferences.value.picture,
    driveReason: said(state.driveReason.value),
  });
}

function save(session: Session): void {
  const [nowMs, wallMs] = [performance.now(), Date.now()];
  const { state, history } = session;
  const content = exported(history, {
    nowMs,
    wallMs,
    version: state.hello.peek()?.version ?? null,
    userAgent: navigator.userAgent,
    role: state.me.peek()?.role ?? null,
    why: whyNow(session, nowMs),
  });
  const text = `${JSON.stringify(content, null, 1)}\n`;
  download(new Blob([text], { type: "application/json" }), fileName(wallMs));
}
