/** Long enough for any browser to start reading the file. */
const READ_MS = 60_000;

/** Gives a file to the browser, which saves it or asks where. */
export function download(content: Blob, name: string): void {
  const address = URL.createObjectURL(content);
  const link = document.createElement("a");
  link.href = address;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), READ_MS);
}
