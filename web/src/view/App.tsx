import type { Session } from "../session";
import { SessionContext } from "./context";
import { DrivePanel } from "./DrivePanel";
import { Facts } from "./Facts";
import { LinkStatus } from "./LinkStatus";
import { Queue } from "./Queue";
import { Settings } from "./Settings";
import { Stage } from "./Stage";
import { Toast } from "./Toast";
import { TurnCard } from "./TurnCard";

/** The page. `cockpit` is what must be visible without scrolling. */
export function App({ session }: { session: Session }) {
  const isDriving = session.state.drivingTurn.value !== null;
  return (
    <SessionContext.Provider value={session}>
      <div class={isDriving ? "page is-driving" : "page"}>
        <div class="cockpit">
          <header class="bar">
            <h1 class="brand">WAX</h1>
            <LinkStatus />
            <Facts />
          </header>
          <Stage />
          <TurnCard />
          <DrivePanel />
        </div>
        <Queue />
        <Settings />
        <Toast />
      </div>
    </SessionContext.Provider>
  );
}
