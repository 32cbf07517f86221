import { Fullscreen } from "./Fullscreen";
import { Headset } from "./Headset";
import { PictureInPicture } from "./PictureInPicture";
import { Snapshot } from "./Snapshot";

/** Other ways to keep or see the picture. */
export function WatchActs() {
  return (
    <div class="watch-acts">
      <Snapshot />
      <PictureInPicture />
      <Fullscreen />
      <Headset />
    </div>
  );
}
