/** One picture as a file. */

import { stamp } from "./stamp";

/** The video element's current picture as PNG; null if the browser cannot encode it. */
export async function pictureOf(video: HTMLVideoElement): Promise<Blob | null> {
  const canvas = document.createElement("canvas");
  canvas.width = video.videoWidth;
  canvas.height = video.videoHeight;
  const context = canvas.getContext("2d");
  if (!context || canvas.width === 0) return null;
  context.drawImage(video, 0, 0);
  return new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
}

/** `marvin-2026-05-04-13-30-00.png`: the robot's name, fit for any file system, and the time. */
export function photoName(robot: string, at: Date): string {
  const letters = robot
    .normalize("NFKC")
    .toLowerCase()
    .replace(/[^\p{L}\p{N}]+/gu, "-")
    .replace(/^-+|-+$/g, "")
    .slice(0, 40);
  return `${letters || "robot"}-${stamp(at)}.png`;
}
