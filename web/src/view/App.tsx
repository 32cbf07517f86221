import type { Session } from "../actions";
import { Banners } from "./Banners";
import { SessionContext } from "./context";
import { DrivePanel } from "./DrivePanel";
import { EndedPage } from "./EndedPage";
import { Panels } from "./Panels";
import { Picture } from "./Picture";
import { StopAlarm } from "./StopAlarm";
import { TaskField } from "./TaskField";
import { TurnCard } from "./TurnCard";
import { Welcome } from "./Welcome";

/** The page: the picture, and beside or below it whose turn it is, the controls and the rest. */
export function App({ session }: { session: Session }) {
  return (
    <SessionContext.Provider value={session}>
      <Page session={session} />
    </SessionContext.Provider>
  );
}

function Page({ session: { state } }: { session: Session }) {
  const ended = state.ended.value;
  if (ended) return <EndedPage ended={ended} />;
  const isDriving = state.drivingTurn.value !== null;
  const isStopped = state.stopNumber.value !== null && state.isConnected.value;
  const kinds = [
    "page",
    ...(isDriving ? ["is-driving"] : []),
    ...(isStopped ? ["is-stopped"] : []),
  ];
  return (
    <main class={kinds.join(" ")}>
      <StopAlarm />
      <Picture />
      <div class="rail">
        <Banners />
        <TurnCard />
        <DrivePanel />
        <div class="more">
          {!isDriving && <Welcome />}
          <TaskField />
          <Panels />
        </div>
      </div>
    </main>
  );
}
