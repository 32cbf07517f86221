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

/** The page. `cockpit` is what must be in view without scrolling. */
export function App({ session }: { session: Session }) {
  const role = session.state.me.value?.role ?? "observer";
  return (
    <SessionContext.Provider value={session}>
      <div class={`page is-${role}`}>
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
