/** Renders a part of the page alone, for its tests. */
import { type ComponentChildren, render } from "preact";
import { act } from "preact/test-utils";
import type { Session } from "../actions";
import { SessionContext } from "../view/context";

/** Renders the part as the document's body. */
export function draw(session: Session, part: ComponentChildren): void {
  act(() => {
    render(
      <SessionContext.Provider value={session}>{part}</SessionContext.Provider>,
      document.body,
    );
  });
}

/** Removes what was drawn. */
export function undraw(): void {
  act(() => render(null, document.body));
}
