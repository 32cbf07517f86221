import type { Session } from "../session";
import { Banners } from "./Banners";
import { CallCard } from "./CallCard";
import { SessionContext } from "./context";
import { DrivePanel } from "./DrivePanel";
import { EndedPage } from "./EndedPage";
import { Facts } from "./Facts";
import { LinkStatus } from "./LinkStatus";
import { Queue } from "./Queue";
import { Settings } from "./Settings";
import { Stage } from "./Stage";
import { TapeBadge } from "./TapeBadge";
import { Toast } from "./Toast";
import { TurnCard } from "./TurnCard";

/** The page. `cockpit` is what must be visible without scrolling. */
export function App({ session }: { session: Session }) {
  const ended = session.state.ended.value;
  const isDriving = session.state.drivingTurn.value !== null;
  if (ended) {
    return (
      <SessionContext.Provider value={session}>
        <EndedPage ended={ended} />
      </SessionContext.Provider>
    );
  }
  return (
    <SessionContext.Provider value={session}>
      <div class={isDriving ? "page is-driving" : "page"}>
        <div class="cockpit">
          <header class="bar">
            <h1 class="brand">WAX</h1>
            <LinkStatus />
            <TapeBadge />
            <Facts />
          </header>
          <Banners />
          <Stage />
          <TurnCard />
          <DrivePanel />
        </div>
        <Queue />
        <Settings />
        <Toast />
        <CallCard />
      </div>
    </SessionContext.Provider>
  );
}
