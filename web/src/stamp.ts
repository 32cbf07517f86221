/** A time in a file's name: it sorts, and every file system takes it. By the reader's clock. */
export function stamp(at: Date): string {
  const parts = [
    at.getFullYear(),
    at.getMonth() + 1,
    at.getDate(),
    at.getHours(),
    at.getMinutes(),
    at.getSeconds(),
  ];
  return parts.map((part) => String(part).padStart(2, "0")).join("-");
}
