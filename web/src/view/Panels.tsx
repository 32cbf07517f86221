import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";
import type { Panel } from "../state";
import { type Code, t } from "../words/words";
import { useActions, useState } from "./context";
import { Gauges } from "./Gauges";
import { CloseIcon } from "./icons";
import { late } from "./late";
import { Queue } from "./Queue";
import { Settings } from "./Settings";
import { Stats } from "./Stats";

export const Facts = late(async () => (await import("./Facts")).Facts);
export const RulesPanel = late(async () => (await import("./RulesPanel")).RulesPanel);
export const HostPanel = late(async () => (await import("./host/HostPanel")).HostPanel);

/** The tab's text, and the panel's heading. */
const NAMES: Record<Panel, readonly [tab: Code, title: Code]> = {
  people: ["panels.people", "panels.people_title"],
  settings: ["panels.settings", "panels.settings_title"],
  details: ["panels.details", "panels.details"],
  rules: ["panels.rules", "panels.rules_title"],
  host: ["panels.host", "panels.host"],
};

/**
 * Everything besides watching and driving: one panel at a time, where it hides neither the picture
 * nor Stop.
 */
export function Panels() {
  const { panel, isHost } = useState();
  const { open } = useActions();
  const shown = panel.value === "host" && !isHost.value ? null : panel.value;
  const openTab = useRef<HTMLButtonElement>(null);
  const close = (isByKey: boolean) => {
    // Keyboard users continue from the tab; after a pointer the keys are for driving.
    if (isByKey) openTab.current?.focus();
    open(null);
  };
  const tabs: Panel[] = ["people", "settings", "details", "rules", ...(isHost.value ? HOST : [])];
  return (
    <section class="panels" aria-label={t("panels.name")}>
      <div class="tabs">
        {tabs.map((tab) => (
          <button
            key={tab}
            ref={shown === tab ? openTab : null}
            type="button"
            class="tab"
            aria-expanded={shown === tab}
            onClick={() => open(shown === tab ? null : tab)}
          >
            {t(NAMES[tab][0])}
          </button>
        ))}
      </div>
      {shown && (
        <Sheet
          key={shown}
          isLong={LONG.includes(shown)}
          name={t(NAMES[shown][0])}
          title={t(NAMES[shown][1])}
          onClose={close}
        >
          {content(shown)}
        </Sheet>
      )}
    </section>
  );
}

const HOST: Panel[] = ["host"];
/** The panels that get more room where there is some. */
const LONG: Panel[] = ["details", "host"];

function content(panel: Panel): ComponentChildren {
  switch (panel) {
    case "people":
      return <Queue />;
    case "settings":
      return <Settings />;
    case "details":
      return (
        <>
          <Gauges />
          <Facts />
          <Stats />
        </>
      );
    case "rules":
      return <RulesPanel />;
    case "host":
      return <HostPanel />;
  }
}

interface SheetProps {
  isLong: boolean;
  name: string;
  title: string;
  onClose: (isByKey: boolean) => void;
  children: ComponentChildren;
}

/** The open panel; Escape closes it from anywhere inside. */
function Sheet({ isLong, name, title, onClose, children }: SheetProps) {
  const sheet = useRef<HTMLElement>(null);
  useEffect(() => sheet.current?.scrollIntoView({ block: "nearest" }), []);
  return (
    <section
      ref={sheet}
      class={isLong ? "sheet is-long" : "sheet"}
      aria-label={name}
      onKeyDown={(event) => {
        if (event.key === "Escape") onClose(true);
      }}
    >
      <div class="sheet-head">
        <h2>{title}</h2>
        <button
          type="button"
          class="sheet-close"
          aria-label={t("panels.close")}
          onClick={(event) => onClose(event.detail === 0)}
        >
          <CloseIcon />
        </button>
      </div>
      <div class="sheet-body">{children}</div>
    </section>
  );
}
