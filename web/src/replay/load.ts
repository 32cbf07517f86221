import type { TapeContent, TapeListing } from "../messages";
import { t } from "../words/words";

/** Loads the list of parts; throws an `Error` with a sentence. */
export function loadListing(): Promise<TapeListing> {
  return load("api/tape");
}

/** Loads one part without picture and sound; throws an `Error` with a sentence. */
export function loadPart(name: string): Promise<TapeContent> {
  return load(`api/tape/${encodeURIComponent(name)}`);
}

async function load<T>(url: string): Promise<T> {
  let response: Response;
  try {
    response = await fetch(url);
  } catch {
    throw new Error(t("replay.problem.silent"));
  }
  const answer: unknown = await response.json().catch(() => null);
  if (response.ok && answer !== null) return answer as T;
  const said = (answer as { error?: unknown } | null)?.error;
  throw new Error(typeof said === "string" ? said : t("replay.problem.failed"));
}
