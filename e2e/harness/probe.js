// Runs in the page before the page's own script: keeps hold of every peer connection and reads
// what is presented. By itself it changes nothing that the page sees.
(() => {
  // The page makes its peers in an empty frame of its own, in which this runs, too.
  const home = window.frameElement ? window.parent : window;
  const peers = (home.waxPeers ??= []);
  const Native = window.RTCPeerConnection;
  window.RTCPeerConnection = class extends Native {
    constructor(...args) {
      super(...args);
      peers.push(this);
      this.addEventListener("connectionstatechange", () => {
        if (this.connectionState === "connected") home.waxConnectedMs ??= home.performance.now();
      });
    }
  };

  // When the first picture was shown, however late somebody asks.
  const firstPictureMs = new Promise((shown) => {
    const listen = ({ target }) =>
      target.requestVideoFrameCallback?.((_now, frame) => shown(frame.presentationTime));
    document.addEventListener("loadstart", listen, { capture: true });
  });

  const peer = () => peers.filter((p) => p.connectionState !== "closed").at(-1) ?? null;
  const media = () => [...document.querySelectorAll("video, audio")];
  // The driving view, or one of the cameras beside it.
  const video = (at = 0) => media().filter((m) => m.tagName === "VIDEO")[at] ?? null;

  // --- the test card: 3 rows of 16 cells, 40 bits of Unix ms and CRC-8 -------------------
  const canvas = document.createElement("canvas");
  const context = canvas.getContext("2d", { willReadFrequently: true });

  const crc8 = (bytes) => {
    let crc = 0;
    for (const byte of bytes) {
      crc ^= byte;
      for (let i = 0; i < 8; i++) crc = crc & 0x80 ? ((crc << 1) ^ 0x07) & 0xff : (crc << 1) & 0xff;
    }
    return crc;
  };

  const readCells = (element, width, height) => {
    const cellWidth = width / 16;
    const cellHeight = height / 15;
    canvas.width = width;
    canvas.height = Math.ceil(cellHeight * 3);
    context.drawImage(element, 0, 0);
    const bytes = [0, 0, 0, 0, 0, 0];
    for (let cell = 0; cell < 48; cell++) {
      const left = Math.round(((cell % 16) + 0.25) * cellWidth);
      const top = Math.round((Math.floor(cell / 16) + 0.25) * cellHeight);
      const wide = Math.max(1, Math.round(cellWidth / 2));
      const high = Math.max(1, Math.round(cellHeight / 2));
      const { data } = context.getImageData(left, top, wide, high);
      let sum = 0;
      for (let i = 0; i < data.length; i += 4) sum += data[i] + data[i + 1] + data[i + 2];
      if (sum / (data.length / 4) / 3 > 127) bytes[cell >> 3] |= 0x80 >> (cell & 7);
    }
    let stamp_ms = 0;
    for (const byte of bytes.slice(0, 5)) stamp_ms = stamp_ms * 256 + byte;
    return { stamp_ms, valid: crc8(bytes.slice(0, 5)) === bytes[5] };
  };

  // The next `count` presented frames: what the card says and how old it is by the wall clock.
  const cards = async (count, at = 0) => {
    while (video(at) === null) await new Promise((resolve) => requestAnimationFrame(resolve));
    return readFrames(count, video(at));
  };

  const readFrames = (count, element) =>
    new Promise((resolve) => {
      const found = [];
      const onFrame = (_now, metadata) => {
        const now_ms = Date.now();
        const { width, height } = metadata;
        const read = readCells(element, width, height);
        const age_ms = (now_ms % 2 ** 40) - read.stamp_ms;
        found.push({ ...read, age_ms, now_ms, width, height });
        if (found.length >= count) resolve(found);
        else element.requestVideoFrameCallback(onFrame);
      };
      element.requestVideoFrameCallback(onFrame);
    });

  // When the first picture was presented that was taken after that time; Unix milliseconds.
  const sees = async (sinceMs) => {
    for (;;) {
      const [card] = await cards(1);
      if (card.valid && card.stamp_ms >= sinceMs % 2 ** 40) return card.now_ms;
    }
  };

  // The longest time without a new picture, from now on for so long.
  const longestPause = async (forMs) => {
    const shownMs = [performance.now()];
    const note = () => {
      shownMs.push(performance.now());
      if (shownMs.at(-1) < shownMs[0] + forMs) video().requestVideoFrameCallback(note);
    };
    video().requestVideoFrameCallback(note);
    await after(forMs);
    shownMs.push(performance.now());
    return Math.max(...shownMs.slice(1).map((ms, at) => ms - shownMs[at]));
  };

  // Keeps the newest picture: while it seeks, a slow browser may show earlier ones first.
  let newest = null;
  const keepNewest = () => {
    const look = async () => {
      [newest] = await cards(1);
      void look();
    };
    void look();
  };

  // --- what the browser itself counts ----------------------------------------------------
  const inbound = async (kind) =>
    [...((await peer()?.getStats())?.values() ?? [])].find(
      (one) => one.type === "inbound-rtp" && one.kind === kind,
    ) ?? null;

  const codec = async (kind) => {
    const report = await inbound(kind);
    return report && (await peer().getStats()).get(report.codecId).mimeType;
  };

  // By which way the media come: the type of our end, how the relay is reached, the other end.
  const path = async () => {
    const all = new Map([...((await peer()?.getStats()) ?? [])]);
    const transport = [...all.values()].find((one) => one.type === "transport");
    const pair = all.get(transport?.selectedCandidatePairId);
    if (!pair) return null;
    const [local, remote] = [all.get(pair.localCandidateId), all.get(pair.remoteCandidateId)];
    const relay = local.relayProtocol ?? null;
    return { type: local.candidateType, relay, to: `${remote.address}:${remote.port}` };
  };

  // --- what is seen of the page ------------------------------------------------------------
  // By the page's own timers, which a busy machine delays alike.
  const after = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

  // Until three frames have everything in the same place; what goes on moving is not waited for.
  const liesStill = () =>
    new Promise((still) => {
      let before = "";
      let frames = 0;
      const endsMs = performance.now() + 2000;
      const look = () => {
        const now = [...document.querySelectorAll("section, button, select, input, video")]
          .flatMap((one) => {
            const { x, y, width, height } = one.getBoundingClientRect();
            return [x, y, width, height];
          })
          .join();
        frames = now === before ? frames + 1 : 0;
        before = now;
        if (frames >= 3 || performance.now() > endsMs) still();
        else requestAnimationFrame(look);
      };
      look();
    });

  // The brightest of what the page's picture shows, 0…255.
  const luma = () => {
    const small = new OffscreenCanvas(16, 16).getContext("2d");
    small.drawImage(video(), 0, 0, 16, 16);
    const { data } = small.getImageData(0, 0, 16, 16);
    return Math.max(...data.filter((_, index) => index % 4 !== 3));
  };

  // What was asked for before the first picture was shown, or the page had been connected for 4 s
  // without one; told once `last` was loaded, too, which the page asks for only then.
  const loadedFirst = async (last) => {
    const untilMs = Math.min(await firstPictureMs, (window.waxConnectedMs ?? Infinity) + 4000);
    const loaded = () =>
      ["navigation", "resource"].flatMap((type) => performance.getEntriesByType(type));
    while (!loaded().some((one) => one.name.includes(last)))
      await new Promise((resolve) => setTimeout(resolve, 50));
    return loaded()
      .filter((one) => one.startTime <= untilMs && !one.name.includes("/api/"))
      .map(({ name, encodedBodySize }) => ({ name, encodedBodySize }));
  };

  // Where an element is in the window, and half its height, after it was scrolled to.
  const middle = (selector) => {
    const one = document.querySelector(selector);
    one.scrollIntoView({ block: "nearest" });
    const { left, top, width, height } = one.getBoundingClientRect();
    return { x: left + width / 2, y: top + height / 2, half: height / 2 };
  };

  const places = (...selectors) =>
    selectors.map((one) => document.querySelector(one).getBoundingClientRect().toJSON());

  // Whether anything is drawn on each canvas.
  const inked = () =>
    [...document.querySelectorAll("figure canvas")].map((canvas) => {
      const { width, height } = canvas;
      const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
      return data.some((value, at) => at % 4 === 3 && value > 0);
    });

  // Whether it is behind, where a browser draws hardly a frame.
  const isBehind = async () => {
    let frames = 0;
    const count = () => {
      frames++;
      requestAnimationFrame(count);
    };
    count();
    await after(1000);
    return frames < 5;
  };

  // The controls of which a part lies outside of what holds them, or of the page.
  const cutOff = () => {
    const isCut = (one) => {
      const { left, right, width } = one.getBoundingClientRect();
      if (width === 0) return false;
      for (let around = one.parentElement; around; around = around.parentElement) {
        const box = around.getBoundingClientRect();
        const isOpen =
          around !== document.documentElement && getComputedStyle(around).overflowX === "visible";
        if (!isOpen && (left < box.left - 1 || right > box.right + 1)) return true;
      }
      return false;
    };
    const all = [...document.querySelectorAll("button, input, select")];
    return all.filter(isCut).map((one) => one.outerHTML);
  };

  // What the page says next of the connection, and when, as Unix time; that it calls it not live.
  let said = null;
  let notLive = null;
  const noteChange = () => {
    const watch = (what, seen) =>
      new MutationObserver(seen).observe(what, {
        characterData: true,
        childList: true,
        subtree: true,
      });
    const status = document.querySelector('[role="status"]');
    said = new Promise((resolve) => {
      watch(status, () => resolve([Date.now(), status.textContent]));
    });
    notLive = new Promise((resolve) => {
      watch(document.body, () => {
        const words = document.body.textContent;
        if (words.includes("Not live: the server is not answering.")) resolve();
      });
    });
  };

  window.waxProbe = {
    after,
    cards,
    codec,
    cutOff,
    inbound,
    inked,
    isBehind,
    isGrey: () => getComputedStyle(video()).filter.includes("grayscale"),
    keepNewest,
    liesStill,
    loadedFirst,
    longestPause,
    luma,
    middle,
    newest: () => newest,
    noteChange,
    notLive: () => notLive,
    path,
    places,
    said: () => said,
    sees,
    playing: () => {
      const v = video();
      return v !== null && !v.paused && v.readyState >= 2 && v.videoWidth > 0;
    },
    peers: () => peers.length,
    offer: () => peer()?.localDescription?.sdp ?? "",
    answer: () => peer()?.remoteDescription?.sdp ?? "",
  };
})();
