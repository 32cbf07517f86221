// Runs in a Chromium's page before the page's own script: takes away what a version of Safari lacks.
// `LACKED` are pairs of an interface and its member as MDN names it, or of an interface and null.
((LACKED) => {
  const { setHeaderExtensionsToNegotiate, getHeaderExtensionsToNegotiate } =
    RTCRtpTransceiver.prototype;
  for (const [owner, member] of LACKED) {
    const found = owner === "Window" ? { prototype: window } : window[owner];
    if (member === null) delete window[owner];
    else if (member.endsWith("_static")) delete found?.[member.replace("_static", "")];
    else if (member.endsWith("_event")) delete found?.prototype?.[`on${member.slice(0, -6)}`];
    else if (found?.prototype && Object.hasOwn(found.prototype, member)) {
      delete found.prototype[member];
    } else delete found?.[member]; // JavaScript's own
  }

  // --- what it offers: H.264 first, nothing redundant, and no wish for how soon to show ----------
  const rank = ({ mimeType }) => (/h264/i.test(mimeType) ? 0 : 1);
  const shaped = (codecs) =>
    codecs
      .filter(({ mimeType }) => !/\/red$/i.test(mimeType))
      .sort((one, other) => rank(one) - rank(other));
  for (const end of [RTCRtpSender, RTCRtpReceiver]) {
    const native = end.getCapabilities.bind(end);
    end.getCapabilities = (kind) => {
      const found = native(kind);
      return found && { ...found, codecs: shaped(found.codecs) };
    };
  }
  const { addTransceiver } = RTCPeerConnection.prototype;
  RTCPeerConnection.prototype.addTransceiver = function (...args) {
    const made = addTransceiver.apply(this, args);
    made.setCodecPreferences(RTCRtpReceiver.getCapabilities(made.receiver.track.kind).codecs);
    const known = getHeaderExtensionsToNegotiate.call(made);
    const offered = known.map((one) =>
      one.uri.endsWith("/playout-delay") ? { ...one, direction: "stopped" } : one,
    );
    setHeaderExtensionsToNegotiate.call(made, offered);
    return made;
  };

  // --- nothing sounds before a touch; a call pauses all, and nothing is played on afterwards -----
  let isTouched = false;
  window.addEventListener("click", ({ isTrusted }) => (isTouched ||= isTrusted), true);
  let isCalled = false;
  const held = () => new Promise(() => {});
  const contexts = new Set();
  const Native = AudioContext;
  window.AudioContext = class extends Native {
    constructor(options) {
      super(options);
      contexts.add(this);
      if (!isTouched) void super.suspend();
    }
    get state() {
      return isCalled && super.state !== "closed" ? "interrupted" : super.state;
    }
    resume() {
      return isCalled || !isTouched ? held() : super.resume();
    }
  };
  const { play } = HTMLMediaElement.prototype;
  HTMLMediaElement.prototype.play = function () {
    if (!isTouched && !this.muted) return Promise.reject(new DOMException("", "NotAllowedError"));
    return isCalled ? held() : play.call(this);
  };
  window.waxSafari = {
    call: () => {
      isCalled = true;
      for (const one of contexts) if (one.state !== "closed") void one.suspend();
      for (const one of document.querySelectorAll("audio, video")) one.pause();
    },
    hangUp: () => {
      isCalled = false;
      for (const one of contexts) one.dispatchEvent(new Event("statechange"));
    },
  };
})(LACKED);
