/**
 * Identifies this page to the server after a reload or reconnect: a random UUID for each tab.
 */

const KEY = "wax-client";
const CHANNEL = "wax-clients";

/** A version 4 UUID; `crypto.randomUUID` exists only on pages loaded by https. */
function randomUuid(): string {
  const bytes = crypto.getRandomValues(new Uint8Array(16));
  bytes[6] = ((bytes[6] ?? 0) & 0x0f) | 0x40;
  bytes[8] = ((bytes[8] ?? 0) & 0x3f) | 0x80;
  const hex = Array.from(bytes, (byte) => byte.toString(16).padStart(2, "0")).join("");
  return hex.replace(/^(.{8})(.{4})(.{4})(.{4})(.{12})$/, "$1-$2-$3-$4-$5");
}

export class Identity {
  #client: string;

  /** `storage` is the tab's session storage; null if there is none. */
  constructor(private readonly storage: Pick<Storage, "getItem" | "setItem"> | null) {
    this.#client = storage?.getItem(KEY) ?? this.#renew();
  }

  get client(): string {
    return this.#client;
  }

  /**
   * Ensures that no two pages share an identity, since each would keep disconnecting the other: a
   * duplicated tab starts with a copy of the storage. The first page keeps the identity; the other
   * gets a new one and calls `onRenewed`.
   */
  share(channel: BroadcastChannel, onRenewed: () => void): void {
    channel.onmessage = ({ data }) => {
      if (data?.client !== this.#client) return;
      if (data.says === "who") {
        channel.postMessage({ says: "mine", client: this.#client });
      } else {
        this.#client = this.#renew();
        onRenewed();
      }
    };
    channel.postMessage({ says: "who", client: this.#client });
  }

  #renew(): string {
    const client = randomUuid();
    this.storage?.setItem(KEY, client);
    return client;
  }
}

/** The channel between the pages of this browser. */
export function openIdentityChannel(): BroadcastChannel {
  return new BroadcastChannel(CHANNEL);
}
