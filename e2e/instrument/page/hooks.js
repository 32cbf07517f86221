// Finds every peer connection and every media element, even those that are in no document.
// Proxies keep names, prototypes and statics, so the page notices no difference.
const makeHooks = () => {
  const peers = [];
  const elements = [];
  const listeners = { element: [], send: [], state: [] };
  const tell = (kind, ...what) => {
    for (const listener of listeners[kind]) {
      try {
        listener(...what);
      } catch (error) {
        console.debug(error);
      }
    }
  };

  const meetElement = (element) => {
    if (elements.some((known) => known.deref() === element)) return;
    elements.push(new WeakRef(element));
    tell("element", element);
  };

  const wrap = (prototype, name, part, before) => {
    const property = Object.getOwnPropertyDescriptor(prototype, name);
    property[part] = new Proxy(property[part], {
      apply(target, self, args) {
        before(self, args);
        return Reflect.apply(target, self, args);
      },
    });
    Object.defineProperty(prototype, name, property);
  };
  wrap(HTMLMediaElement.prototype, "srcObject", "set", (element) => meetElement(element));

  // The page's window, or that of an empty frame in which it makes its peers.
  const watch = (scope) => {
    const proxy = new Proxy(scope.RTCPeerConnection, {
      construct(target, args, newTarget) {
        const peer = Reflect.construct(target, args, newTarget === proxy ? target : newTarget);
        peers.push(peer);
        peer.addEventListener("connectionstatechange", () => tell("state", peer.connectionState));
        return peer;
      },
    });
    const property = Object.getOwnPropertyDescriptor(scope, "RTCPeerConnection");
    Object.defineProperty(scope, "RTCPeerConnection", { ...property, value: proxy });
    const { prototype } = scope.RTCDataChannel;
    wrap(prototype, "send", "value", (channel, [data]) => tell("send", channel, data));
  };
  watch(window);

  // What came by markup, or before the page was ours; forgets what is gone.
  const look = () => {
    for (const element of document.querySelectorAll("video, audio")) {
      if (element.srcObject) meetElement(element);
    }
    for (let i = elements.length - 1; i >= 0; i--) if (!elements[i].deref()) elements.splice(i, 1);
    for (let i = peers.length - 1; i >= 0; i--) {
      if (peers[i].signalingState === "closed") peers.splice(i, 1);
    }
  };

  return {
    look,
    watch,
    peers,
    elements: () => elements.map((known) => known.deref()).filter(Boolean),
    on: (kind, listener) => listeners[kind].push(listener),
  };
};
