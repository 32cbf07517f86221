/** Links that carry a secret: the host's, and invitations. */

import { post, RequestError } from "./link/http";
import { pageSentence, type Saying } from "./words/said";

/** A secret that the page's address carried. */
export interface Entry {
  kind: "host" | "invite";
  secret: string;
}

const LONGEST_MS = 10_000;

/** Returns the secret in the address, after removing it from there and from the history. */
export function takeEntry(window: Pick<Window, "location" | "history">): Entry | null {
  const { hash, pathname, search } = window.location;
  const [, kind, secret] = /^#(host|invite)=(.*)$/.exec(hash) ?? [];
  if (!kind) return null;
  window.history.replaceState(null, "", pathname + search);
  return secret ? { kind: kind as Entry["kind"], secret } : null;
}

/** The result as a sentence: what the user may do now, or why the link failed and what to do. */
export interface Entered {
  isGood: boolean;
  text: Saying;
}

/** Posts the secret to the server once; the answer sets a cookie that no script can read. */
export async function showEntry({ kind, secret }: Entry): Promise<Entered> {
  const signal = AbortSignal.timeout(LONGEST_MS);
  try {
    if (kind === "host") {
      await post("api/host", { secret }, { signal });
      return { isGood: true, text: pageSentence("entry.host") };
    }
    const { purpose } = await post("api/enter", { token: secret }, { signal });
    const text = purpose === "queue" ? pageSentence("entry.drive") : pageSentence("entry.watch");
    return { isGood: true, text };
  } catch (error) {
    const isRefusal = error instanceof RequestError && error.isRefusal;
    return { isGood: false, text: isRefusal ? error.saying : pageSentence("entry.unreachable") };
  }
}
