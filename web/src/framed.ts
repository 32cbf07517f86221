/** Whether the server made this page for a frame on another site: `?view=embed`. */
export function isFramed(): boolean {
  return globalThis.document?.documentElement.dataset.view === "embed";
}
