import { ownPage } from "../own/page";
import { useState } from "./context";

/** Whose robot this is, and what for. */
export function OwnHeader() {
  const { name, sentence } = ownPage(useState());
  return (
    <div class="own-header">
      <h1 class="own-name">
        <bdi>{name}</bdi>
      </h1>
      <p class="own-sentence">
        <bdi>{sentence}</bdi>
      </p>
    </div>
  );
}
